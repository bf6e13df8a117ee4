"""Programs that run: as NumPy source at once, as compiled C as soon as there is some.

`evaluator` runs a tape on arrays or on coefficients, says which way, and keeps what the machine's C
compiler made, by content, on disk; the module ``_trampoline`` (``native``) calls it. `by_numpy`
writes and runs NumPy.
"""
