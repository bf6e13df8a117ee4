"""From geometric algebra programs to code: tracer, tape, optimiser, and what writes the tape out.

`programs` compiles CLUScripts and `functions` Python functions, which `program` decorates:
`recording` runs them on symbols and leaves a `tape` of scalar operations, `passes` makes it
shorter, `targets` writes it in a language, `runtime` compiles and runs it, and `strategies` writes
it as other generators would.
``python -m motorcade.ga.codegen`` writes the library's own kernels again with `library_kernels`.
Derivatives and the kernels' definitions need CasADi, and mpmath; what is written does not.
"""

from __future__ import annotations

from motorcade.ga.codegen.functions import program

__all__ = [
    "program",
]
