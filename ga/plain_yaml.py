"""YAML of plain values from files that others made: no objects, no aliases, nothing deep.

A few lines of aliases and merges can stand for more than the memory holds, and the parser's time
grows with the square of open brackets; both are refused before anything is built.
"""

from __future__ import annotations

import yaml

MAX_DEPTH = 32


class YamlError(ValueError):
    """A text is no plain YAML; `line` (from 1) is where, or None."""

    def __init__(self, problem: str, line: int | None = None) -> None:
        super().__init__(problem)
        self.line = line


def parse_yaml(text: str) -> object:
    r"""The value that a YAML text stands for; OpenCV's `%YAML:1.0` and its matrices are allowed.

    Raises:
        YamlError: no YAML, an alias, or lists and tables of more than `MAX_DEPTH` levels.

    >>> from motorcade.ga.plain_yaml import parse_yaml
    >>> parse_yaml("%YAML:1.0\n---\nrate_hz: 200.0")
    {'rate_hz': 200.0}
    >>> parse_yaml("a: &a [1]\nb: *a")
    Traceback (most recent call last):
    motorcade.ga.plain_yaml.YamlError: expected plain values, got a YAML alias
    """
    if text.startswith("%YAML:"):  # no directive of YAML's; an empty line keeps the count
        text = "\n" + text.partition("\n")[2].removeprefix("---")
    try:
        return _PlainLoader(text.replace("!!opencv-matrix", "")).get_single_data()
    except YamlError:
        raise
    except (yaml.YAMLError, ValueError, RecursionError) as fault:  # also dates of no calendar
        mark = getattr(fault, "problem_mark", None)
        problem = getattr(fault, "problem", None) or str(fault) or type(fault).__name__
        line = None if mark is None else mark.line + 1
        raise YamlError(f"expected YAML: {' '.join(problem.split())}", line) from fault


class _PlainLoader(yaml.SafeLoader):
    """Stops at the first alias, and where lists nest too deeply."""

    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise YamlError("expected plain values, got a YAML alias", self._line())
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise YamlError(f"expected at most {MAX_DEPTH} levels, got more", self._line())
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def _line(self) -> int:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        return int(event.start_mark.line) + 1
