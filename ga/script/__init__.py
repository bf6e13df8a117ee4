"""CLUScript: the small language of geometric algebra programs that Gaalop and CLUCalc read.

`parse` reads a text, `evaluate` runs what it read over numbers, batches or symbols. The language:
`reading` has the operators, statements, macros and pragmas, `functions` the functions and macros
that are always there, `algebras` the named algebras with their macros.
"""

from __future__ import annotations

from motorcade.ga.script.errors import ScriptError
from motorcade.ga.script.meaning import evaluate
from motorcade.ga.script.parser import parse
from motorcade.ga.script.syntax import Script

__all__ = ["Script", "ScriptError", "evaluate", "parse"]
