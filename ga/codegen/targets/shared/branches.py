"""Choices of a tape as branches: what only one side of a choice needs is computed on that side.

Code for many rows computes both sides, as SIMD code must; code for one row need not.
"""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.ga.codegen.tape import Node, Tape

# Sides with fewer operations than this are computed and chosen from, without a jump.
_WORTH_A_JUMP = 4

# A group of choices: their condition, and how many groups by it one after the other they end.
_Group = tuple[int, int]
_Path = tuple[tuple[_Group, bool], ...]


@dataclass(frozen=True)
class Branch:
    """``if (condition) … else …``; each choice gets its value at the end of either side."""

    condition: int
    choices: tuple[int, ...]
    chosen: Plan
    otherwise: Plan


Plan = tuple[int | Branch, ...]
"""Nodes in the order in which they are computed, some of them inside branches."""


def branched(tape: Tape) -> Plan:
    """The nodes with branches wherever a side of choices by one condition is worth a jump."""
    groups = _groups(tape)
    paths = _paths(tape, groups)
    members: dict[tuple[_Group, _Path], list[int]] = {}
    for index, group in groups.items():
        members.setdefault((group, paths[index]), []).append(index)
    sizes = _sizes(tape, paths)
    jumps = {
        (group, path): tuple(choices)
        for (group, path), choices in members.items()
        if max(sizes.get((*path, (group, side)), 0) for side in (True, False)) >= _WORTH_A_JUMP
    }
    return _Planner(tape, groups, [_kept(path, jumps) for path in paths], jumps).plan(
        (), _all(tape)
    )


def _groups(tape: Tape) -> dict[int, _Group]:
    """The group of each choice: no choice of a group depends on another of it."""
    groups: dict[int, _Group] = {}
    depths: list[dict[int, int]] = []
    for index, node in enumerate(tape.nodes):
        below: dict[int, int] = {}
        for argument in node.args:
            for condition, depth in depths[argument].items():
                below[condition] = max(depth, below.get(condition, 0))
        if node.op == "select":
            groups[index] = node.args[0], below.get(node.args[0], 0)
            below[node.args[0]] = groups[index][1] + 1
        depths.append(below)
    return groups


def _all(tape: Tape) -> list[int]:
    return [index for row in tape.results for index in row]


def _paths(tape: Tape, groups: dict[int, _Group]) -> list[_Path]:
    """For each node the sides of choices on which alone it is needed, outermost first."""
    paths: list[_Path | None] = [None] * len(tape.nodes)

    def need(index: int, path: _Path) -> None:
        known = paths[index]
        paths[index] = path if known is None else _common(known, path)

    for index in _all(tape):
        need(index, ())
    for index in reversed(range(len(tape.nodes))):
        node, path = tape.nodes[index], paths[index] or ()
        for place, argument in enumerate(node.args):
            inner = index in groups and place > 0
            need(argument, (*path, (groups[index], place == 1)) if inner else path)
    return [path or () for path in paths]


def _common(one: _Path, other: _Path) -> _Path:
    length = 0
    while length < min(len(one), len(other)) and one[length] == other[length]:
        length += 1
    return one[:length]


def _kept(path: _Path, jumps: dict[tuple[_Group, _Path], tuple[int, ...]]) -> _Path:
    """The part of a path on which all choices are branches."""
    for length, (group, _) in enumerate(path):
        if (group, path[:length]) not in jumps:
            return path[:length]
    return path


def _sizes(tape: Tape, paths: list[_Path]) -> dict[_Path, int]:
    """How many operations each side has for itself, those of its own branches included."""
    sizes: dict[_Path, int] = {}
    for node, path in zip(tape.nodes, paths, strict=True):
        if _computed(node):
            for length in range(1, len(path) + 1):
                sizes[path[:length]] = sizes.get(path[:length], 0) + 1
    return sizes


def _computed(node: Node) -> bool:
    return node.op not in ("input", "const")


class _Planner:
    """Puts nodes in order from the results backwards, so that a branch finds what it needs."""

    def __init__(
        self,
        tape: Tape,
        groups: dict[int, _Group],
        paths: list[_Path],
        jumps: dict[tuple[_Group, _Path], tuple[int, ...]],
    ) -> None:
        self._nodes = tape.nodes
        self._groups = groups
        self._paths = paths
        self._jumps = jumps
        self._placed: set[int] = set()

    def plan(self, path: _Path, wanted: list[int]) -> Plan:
        """The nodes on a side of a choice that the wanted ones need."""
        made: list[int | Branch] = []
        for index in wanted:
            self._place(index, path, made)
        return tuple(made)

    def _place(self, index: int, path: _Path, made: list[int | Branch]) -> None:
        if index in self._placed or self._paths[index] != path:
            return
        node = self._nodes[index]
        group = self._groups.get(index)
        choices = self._jumps.get((group, path)) if group else None
        if group is None or choices is None:
            for argument in node.args:
                self._place(argument, path, made)
            self._placed.add(index)
            made.append(index)
            return
        for needed in self._outside(choices, path):
            self._place(needed, path, made)
        self._placed.update(choices)
        sides = [
            self.plan((*path, (group, side)), [self._nodes[k].args[place] for k in choices])
            for side, place in ((True, 1), (False, 2))
        ]
        made.append(Branch(node.args[0], choices, *sides))

    def _outside(self, choices: tuple[int, ...], path: _Path) -> list[int]:
        """What branches need of the side that they stand on, their condition included."""
        found: set[int] = set()
        seen: set[int] = set()
        waiting = [argument for k in choices for argument in self._nodes[k].args]
        while waiting:
            index = waiting.pop()
            if index in seen:
                continue
            seen.add(index)
            if self._paths[index] == path:
                found.add(index)
            elif len(self._paths[index]) > len(path):
                waiting.extend(self._nodes[index].args)
        return sorted(found)
