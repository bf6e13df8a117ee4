"""Programs that run: as NumPy source at once, as compiled C as soon as there is some.

`evaluator` runs a tape on arrays or on coefficients, and says which way; `sources` writes it for
either way; `compiler` runs the machine's C compiler and `cache` keeps what it made, by content, on
disk. The compiled functions are called by the module ``_trampoline`` (``native``). `interpret` runs
a tape as it is, for checks.
"""
