"""Algebras as files: basis vectors, null pairs, names of other vectors, macros in CLUScript.

Each folder here holds one: ``definition.toml`` and, where it has macros, ``macros.clu``. Files of
users' own look the same; `read_definition` reads them.
"""

from __future__ import annotations

from motorcade.ga.script.algebras.definitions import (
    AlgebraDefinition,
    definition_of,
    definitions,
    read_definition,
)

__all__ = ["AlgebraDefinition", "definition_of", "definitions", "read_definition"]
