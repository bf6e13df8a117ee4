"""From geometric algebra programs to code: tracer, tape, optimiser, and what writes the tape out.

`programs` compiles CLUScripts and `functions` Python functions, which `program` decorates: `trace`
runs them on CasADi symbols and reads a `tape` of scalar operations, which a `recorder` writes of
scripts where CasADi is not installed, `passes` makes it shorter, `targets` writes it in a language,
`runtime` compiles and runs it, and `strategies` writes it as other generators would.
``python -m motorcade.ga.codegen`` writes the library's own kernels again with `library_kernels`.
Only this folder needs CasADi and mpmath; what it wrote does not.
"""

from __future__ import annotations

from motorcade.ga.codegen.derivatives import Jacobian
from motorcade.ga.codegen.functions import CompiledFunction, compile_function, program
from motorcade.ga.codegen.programs import Program, compile_script

__all__ = [
    "CompiledFunction",
    "Jacobian",
    "Program",
    "compile_function",
    "compile_script",
    "program",
]
