"""Names that Rust, JavaScript, WGSL, Julia and C++ keep for themselves, or that code calls.

The words themselves are in ``reserved.toml``.

Tapes for languages in which true is no number: conditions and numbers are kept apart.
"""

from __future__ import annotations

from dataclasses import replace

from motorcade.ga.codegen.tape import BOOLEANS, Node, Tape
from motorcade.ga.codegen.targets.names import C_NAMES, Reserved, reserved_words
from motorcade.ga.codegen.targets.shared.text import SAME_NAMES

_FUNCTIONS = frozenset(SAME_NAMES) | {"abs", "min", "max"}


# Parameters are patterns in Rust: those named as a constructor of its prelude would match it.
RUST_NAMES = Reserved("Rust", reserved_words("rust"), frozenset({"main"}))
JAVASCRIPT_NAMES = Reserved("JavaScript", reserved_words("javascript"))
JULIA_NAMES = Reserved("Julia", _FUNCTIONS | reserved_words("julia"))
WGSL_NAMES = Reserved(
    "WGSL", _FUNCTIONS | reserved_words("wgsl"), frozenset({"main"}), underscores=True
)
CPP_NAMES = replace(C_NAMES, words=C_NAMES.words | {"std"})


_LOGIC = frozenset({"and", "or", "not"})


def typed(tape: Tape) -> Tape:
    """The same tape where choices and logic take conditions only, and all else takes numbers.

    A condition that is used as a number becomes the choice of 1 or 0, a number that is used as a
    condition is compared with 0.
    """
    nodes: list[Node] = []
    numbers: list[int] = []
    conditions: dict[int, int] = {}
    known: dict[Node, int] = {}

    def add(node: Node) -> int:
        if node not in known:
            known[node] = len(nodes)
            nodes.append(node)
        return known[node]

    def condition(old: int) -> int:
        if old not in conditions:
            zero = add(Node("const", value=0.0))
            conditions[old] = add(Node("ne", (numbers[old], zero)))
        return conditions[old]

    def number(old: int) -> int:
        if numbers[old] < 0:
            ends = add(Node("const", value=1.0)), add(Node("const", value=0.0))
            numbers[old] = add(Node("select", (conditions[old], *ends)))
        return numbers[old]

    for old, node in enumerate(tape.nodes):
        args = tuple(
            condition(k) if node.op in _LOGIC or (place == 0 and _chooses(node)) else number(k)
            for place, k in enumerate(node.args)
        )
        new = add(Node(node.op, args, node.value, node.source))
        numbers.append(new)
        if node.op in BOOLEANS:
            conditions[old], numbers[old] = new, -1
    results = tuple(tuple(number(k) for k in row) for row in tape.results)
    return Tape(tape.inputs, tape.outputs, tuple(nodes), results)


def _chooses(node: Node) -> bool:
    return node.op in ("select", "keep")
