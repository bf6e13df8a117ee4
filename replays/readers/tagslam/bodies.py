"""Sizes of tags as `tagslam.yaml` gives them: listed one by one, by boards, or by a default.

TagSLAM attaches tags to bodies. A tag that no body lists belongs to `default_body`; where there is
none it is ignored.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from motorcade.replays.errors import one_line, refusal
from motorcade.replays.readers.calibration import read_yaml, yaml_floats

_MOST_TAGS = 100_000
_LARGEST_M = 100.0


@dataclass(frozen=True)
class MarkerSides:
    """How large tags are.

    Args:
        listed_m: side of the black square, metres, by id.
        others_m: of every tag that is not listed; None where such tags are ignored.
    """

    listed_m: Mapping[int, float]
    others_m: float | None

    def side_m(self, marker_id: int) -> float | None:
        """The side of a tag, metres; None for one that is to be ignored."""
        return self.listed_m.get(marker_id, self.others_m)


def read_marker_sides(path: Path) -> MarkerSides:
    """Read the sizes of all tags.

    Raises:
        RecordingError: not such a file, sizes that are not above 0 and up to 100 m, a tag that
            two bodies list, or a default body that is not there.
    """
    content = read_yaml(path)
    bodies = dict(_bodies(path, content.get("bodies")))
    listed: dict[int, float] = {}
    for name, body in bodies.items():
        for marker, size in _tags(path, name, body):
            if marker in listed:
                raise refusal(path, f"expected tag {marker} once, got it twice", field=name)
            listed[marker] = size
            if len(listed) > _MOST_TAGS:
                raise refusal(path, f"expected at most {_MOST_TAGS} tags, got more", field=name)
    default, others = content.get("default_body"), None
    if default is not None:
        if str(default) not in bodies:
            problem = f"expected the name of a body, got {one_line(default)}"
            raise refusal(path, problem, field="default_body")
        if "default_tag_size" in bodies[str(default)]:
            others = _size(path, str(default), bodies[str(default)], "default_tag_size")
    return MarkerSides(listed, others)


def _bodies(path: Path, value: object) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Name and content of each body: a list of tables with one key each."""
    if not isinstance(value, list):
        raise refusal(path, f"expected a list, got {one_line(value)}", field="bodies")
    for entry in value:
        if not isinstance(entry, dict) or len(entry) != 1:
            raise refusal(path, f"expected one name a body, got {one_line(entry)}", field="bodies")
        name, body = next(iter(entry.items()))
        if not isinstance(body, dict):
            raise refusal(path, f"expected a table, got {one_line(body)}", field=str(name))
        yield str(name), body


def _tags(path: Path, name: str, body: Mapping[str, object]) -> Iterator[tuple[int, float]]:
    """Id and size of each tag that a body lists."""
    kind = str(body.get("type"))
    if kind in ("board", "staggered_board"):
        board = body.get(kind)
        if not isinstance(board, dict):
            raise refusal(path, f"expected a table, got {one_line(board)}", field=f"{name}.{kind}")
        rows, columns, first = (
            _count(path, name, board, key) for key in ("tag_rows", "tag_columns", "tag_start_id")
        )
        places = rows * columns
        # Staggered boards leave every other place empty, as a chessboard does.
        count = places if kind == "board" else (places + 1) // 2
        size = _size(path, name, board, "tag_size")
        yield from ((first + offset, size) for offset in range(count))
        return
    tags = body.get("tags") or []
    if not isinstance(tags, list):
        raise refusal(path, f"expected a list, got {one_line(tags)}", field=f"{name}.tags")
    for tag in tags:
        if not isinstance(tag, dict):
            raise refusal(path, f"expected a table, got {one_line(tag)}", field=f"{name}.tags")
        sized = "size" in tag
        owner, key = (tag, "size") if sized else (body, "default_tag_size")
        yield _count(path, name, tag, "id"), _size(path, name, owner, key)


def _size(path: Path, name: str, content: Mapping[str, object], key: str) -> float:
    (size,) = yaml_floats(path, {key: [content.get(key)]}, key, 1)
    if not 0.0 < size <= _LARGEST_M:
        problem = f"expected metres above 0 and up to {_LARGEST_M:g}, got {size:g}"
        raise refusal(path, problem, field=f"{name}.{key}")
    return size


def _count(path: Path, name: str, content: Mapping[str, object], key: str) -> int:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST_TAGS:
        problem = f"expected a whole number of 0 to {_MOST_TAGS}, got {one_line(value)}"
        raise refusal(path, problem, field=f"{name}.{key}")
    return value
