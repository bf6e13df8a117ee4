"""Tables of a TOML manifest, read strictly: unknown keys, wrong types and ranges are refused.

A `Section` is any of them; from those of a board, a camera and loose markers values are made,
also where one stands in a file of its own or on the command line.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path

from motorcade.ga.names import did_you_mean, one_line
from motorcade.replays.io.files import RecordingError, read_bounded, refusal, refusing
from motorcade.replays.io.readers.calibration import (
    make_camera,
    read_matrix,
    read_numbers,
    yaml_camera,
)
from motorcade.replays.io.readers.frames.held import ROTATIONS_DEG
from motorcade.replays.io.readers.kalibr import read_target
from motorcade.replays.io.recording import LooseMarkers
from motorcade.tracking.boards import (
    Board,
    CharucoBoard,
    Checkerboard,
    CircleGrid,
    MarkerGrid,
    SingleMarker,
    board_named,
)
from motorcade.tracking.boards.names import kalibr_grid
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.families import FAMILIES
from motorcade.tracking.markers.marker_map import MarkerMap

TOML_LIMIT = 2**16
_MOST_KEY_PARTS = 64
_KEY_PART = re.compile(r"\s*(?:[\w-]+|\"[^\"]*\"|'[^']*')\s*")
_WHOLE_LIMIT = 1_000_000
FILE_KNOBS = {"placed.character": "mannequin", "placed.cast": "none", "placed.scene": "none"}
"""Knobs that name a file, and the word by which each names none; a test asks the stages."""


def setting_from(setting: str, file: Callable[[str], Path]) -> str:
    """A setting, `stage.knob=value`, as it stands in a file, which says where others lie."""
    name, equals, value = setting.partition("=")
    no_file = FILE_KNOBS.get(name.strip())
    if no_file is None or not equals or value.strip() in ("", no_file):
        return setting
    return f"{name}={file(value.strip())}"


def load_toml(path: Path) -> dict[str, object]:
    """Read a TOML file of at most 64 KiB.

    Raises:
        RecordingError: missing, too large, not UTF-8, or not TOML (with the line).
    """
    data = read_bounded(path, TOML_LIMIT)
    try:
        text = data.decode("utf-8")
        deepest = max(map(_deepest_key, text.splitlines()), default=0)
        if deepest > _MOST_KEY_PARTS:
            raise refusal(path, f"expected keys of at most {_MOST_KEY_PARTS} parts, got {deepest}")
        return tomllib.loads(text)
    except RecordingError:
        raise
    except (ValueError, RecursionError) as fault:
        reason = "nested too deeply" if isinstance(fault, RecursionError) else str(fault)
        raise refusal(path, f"expected TOML: {reason}") from fault


def _deepest_key(line: str) -> int:
    """How many parts between dots a key of a line may have; TOML's parser takes their square."""
    longest = run = 1
    for part in line.split("."):
        run = run + 1 if _KEY_PART.fullmatch(part) else 1
        longest = max(longest, run)
    return longest


class Section:
    """A table of a manifest and the keys it may hold.

    Args:
        path: the manifest.
        title: name of the table, "" for the top.
        table: what stands in the file.
        keys: all keys allowed.

    Raises:
        RecordingError: not a table, or a key that is not allowed (the nearest valid one is named).
    """

    def __init__(self, path: Path, title: str, table: object, keys: tuple[str, ...]) -> None:
        self.path = path
        self.title = f"[{title}]" if title else ""
        if not isinstance(table, Mapping):
            raise refusal(path, f"expected a table, got {one_line(table)}", field=self.title)
        self._table = table
        for key in table:
            if key not in keys:
                raise self.fault(one_line(key), "unknown key", did_you_mean(key, keys))

    def __contains__(self, key: str) -> bool:
        return key in self._table

    def __getitem__(self, key: str) -> object:
        if key not in self._table:
            raise self.fault(key, "the key is missing")
        return self._table[key]

    def fault(self, key: str, problem: str, advice: str | None = None) -> RecordingError:
        """Make the error for a key of this table."""
        field = f"{self.title} {key}".strip()
        return refusal(self.path, problem, field=field, advice=advice)

    def refusing(self, key: str) -> AbstractContextManager[None]:
        """What turns a ValueError of its block into the error for a key of this table."""
        return refusing(self.path, f"{self.title} {key}".strip())

    def text(self, key: str, choices: tuple[str, ...] = ()) -> str:
        """A string, one of `choices` where they are given."""
        value = self[key]
        if not isinstance(value, str) or not value or len(value) > 1000:
            raise self.fault(key, f"expected text, got {one_line(value)}")
        if choices and value not in choices:
            expected = f"expected one of {', '.join(choices)}, got {one_line(value)}"
            raise self.fault(key, expected, did_you_mean(value, choices))
        return value

    def number(self, key: str, low: float, high: float) -> float:
        """A finite number from `low` to `high`."""
        return self._number(key, self[key], low, high)

    def whole(self, key: str, low: int = 0, high: int = _WHOLE_LIMIT) -> int:
        """A whole number from `low` to `high`."""
        value = self[key]
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            expected = f"expected a whole number from {low} to {high}"
            raise self.fault(key, f"{expected}, got {one_line(value)}")
        return value

    def numbers(self, key: str, most: int = 100) -> tuple[float, ...]:
        """A list of at most `most` finite numbers."""
        value = self[key]
        if not isinstance(value, list) or len(value) > most:
            raise self.fault(key, f"expected a list of numbers, got {one_line(value)}")
        return tuple(self._number(key, item, -1e12, 1e12) for item in value)

    def truth(self, key: str, otherwise: bool) -> bool:
        """True or false; `otherwise` where the key is missing."""
        value = self._table.get(key, otherwise)
        if not isinstance(value, bool):
            raise self.fault(key, f"expected true or false, got {one_line(value)}")
        return value

    def texts(self, key: str, most: int = 100) -> tuple[str, ...]:
        """A list of at most `most` strings."""
        value = self[key]
        if not isinstance(value, list) or len(value) > most:
            raise self.fault(key, f"expected a list of texts, got {one_line(value)}")
        for item in value:
            if not isinstance(item, str) or len(item) > 1000:
                raise self.fault(key, f"expected texts, got {one_line(item)}")
        return tuple(value)

    def holds_only(self, key: str) -> bool:
        """Whether nothing but one key stands in the table."""
        return set(self._table) == {key}

    def only_one(self, first: str, second: str) -> None:
        """Refuse two keys that say the same thing."""
        if first in self and second in self:
            raise self.fault(second, f"expected either {first} or {second}, got both")

    def _number(self, key: str, value: object, low: float, high: float) -> float:
        if isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high:
            return float(value)
        expected = f"expected a number from {low:g} to {high:g}"
        raise self.fault(key, f"{expected}, got {one_line(value)}")


_OPTIONAL = ("first_id", "order", "turned_deg", "corner_squares", "legacy", "asymmetric")
BOARD_KEYS = {
    "checkerboard": ("columns", "rows", "square_m"),
    "marker_grid": ("family", "columns", "rows", "marker_m", "gap_m", *_OPTIONAL[:4]),
    "aprilgrid": ("columns", "rows", "marker_m", "gap_m", "first_id"),
    "marker": ("family", "marker_id", "side_m"),
    "charuco": ("family", "columns", "rows", "square_m", "marker_m", "legacy"),
    "circles": ("columns", "rows", "spacing_m", "diameter_m", "asymmetric"),
}
_BOARD_COMMON = ("type", "world_T_board", "metric")
_BOARDS: dict[str, Callable[..., Board]] = {
    "checkerboard": Checkerboard,
    "marker_grid": MarkerGrid,
    "aprilgrid": kalibr_grid,
    "marker": SingleMarker,
    "charuco": CharucoBoard,
    "circles": CircleGrid,
}


def read_board(text: str) -> Board:
    """Take a board's name (`boards.board_named`), a TOML file's `[board]`, or Kalibr's target.

    Raises:
        ValueError: neither; or what the table or the board refuses.
    """
    path = Path(text)
    if path.suffix.lower() in (".yaml", ".yml"):
        return read_target(path)
    if path.suffix.lower() != ".toml":
        return board_named(text)
    tables = load_toml(path)
    if "board" not in tables:
        raise Section(path, "", {}, ()).fault("board", "the table is missing")
    return section_board(path, tables["board"])


def section_board(path: Path, table: object) -> Board:
    """Make the board of a manifest's table; the board's own refusals are said of the table.

    Raises:
        RecordingError: naming table and key.
    """
    every = (*_BOARD_COMMON, *{key for keys in BOARD_KEYS.values() for key in keys})
    kind = Section(path, "board", table, every).text("type", tuple(BOARD_KEYS))
    section = Section(path, "board", table, (*_BOARD_COMMON, *BOARD_KEYS[kind]))
    with section.refusing(kind):
        keys = [key for key in BOARD_KEYS[kind] if key in section or key not in _OPTIONAL]
        return _BOARDS[kind](**{key: _board_value(section, key) for key in keys})


def _board_value(section: Section, key: str) -> object:
    if key in ("columns", "rows"):
        return section.whole(key, 0, 1000)
    if key.endswith("_m"):
        return section.number(key, 1e-6, 1e3)
    if key in ("family", "order"):
        return section.text(key, tuple(FAMILIES) if key == "family" else ("down", "up"))
    if key in ("corner_squares", "legacy", "asymmetric"):
        return section.truth(key, otherwise=False)
    return section.whole(key)


CAMERA_KEYS = (
    "model",
    "width",
    "height",
    "fx",
    "fy",
    "cx",
    "cy",
    "matrix_file",
    "fov_deg",
    "distortion",
    "distortion_file",
    "rotation_deg",
    "readout_s",
    "focal_sigma",
    "zoom_s",
    "zoom",
)


def stated_rotation(path: Path) -> int | None:
    """The `rotation_deg` of a `.toml` file's camera; None without. Raises as `read_camera`."""
    if path.suffix.lower() != ".toml":
        return None
    return section_rotation(Section(path, "camera", load_toml(path).get("camera"), CAMERA_KEYS))


def section_rotation(section: Section) -> int | None:
    """The `rotation_deg` of a camera's table; None where it does not say.

    Raises:
        RecordingError: another number than 0, 90, 180 or 270.
    """
    if "rotation_deg" not in section:
        return None
    rotation = section.whole("rotation_deg")
    if rotation not in ROTATIONS_DEG:
        expected = "expected 0, 90, 180 or 270 degrees clockwise"
        raise section.fault("rotation_deg", f"{expected}, got {rotation}")
    return rotation


def read_camera(path: Path) -> Camera:
    r"""Read the camera of a `.toml` file's `[camera]` table, or of an EuRoC `sensor.yaml`.

    Raises:
        RecordingError: what the table or the YAML file lacks or gets wrong.

    >>> import tempfile
    >>> from pathlib import Path
    >>> from motorcade.replays import read_camera
    >>> keys = {"width": 640, "height": 480, "fx": 510.0, "fy": 510.0, "cx": 319.5, "cy": 239.5}
    >>> lines = ["[camera]", *(f"{key} = {value}" for key, value in keys.items())]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "camera.toml")
    ...     _ = path.write_text("\n".join(lines))
    ...     camera = read_camera(path)
    >>> camera.width, camera.fx
    (640, 510.0)
    """
    if path.suffix.lower() != ".toml":
        return yaml_camera(path)
    tables = load_toml(path)
    if "camera" not in tables:
        raise Section(path, "", {}, ()).fault("camera", "the table is missing")
    section = Section(path, "camera", tables["camera"], CAMERA_KEYS)
    return section_camera(path, section, None, lambda key: path.parent / section.text(key))


def section_camera(
    path: Path, section: Section, size: tuple[int, int] | None, file: Callable[[str], Path]
) -> Camera:
    """Make the camera of a manifest's table.

    Args:
        path: the manifest.
        section: its table.
        size: of the images, where the table does not say it.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    if size is None or "width" in section or "height" in section:
        size = (section.whole("width", 1), section.whole("height", 1))
    intrinsics = _intrinsics(section, size, file)
    section.only_one("distortion", "distortion_file")
    source, distortion = path, tuple[float, ...]()
    if "distortion" in section:
        distortion = section.numbers("distortion")
    elif "distortion_file" in section:
        source = file("distortion_file")
        distortion = tuple(float(value) for value in read_numbers(source))
    models = ("pinhole", "radtan", "equidistant")
    lensless = "model" not in section and not distortion
    model = "pinhole" if lensless else section.text("model", models)
    return make_camera(source, size, intrinsics, model, distortion)


def _intrinsics(
    section: Section, size: tuple[int, int], file: Callable[[str], Path]
) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy in pixels: as given, of a matrix, or of a lens that is known by its view."""
    section.only_one("matrix_file", "fx")
    section.only_one("fov_deg", "fx")
    section.only_one("fov_deg", "matrix_file")
    if "matrix_file" in section:
        return read_matrix(file("matrix_file"))
    if "fov_deg" in section:
        half_rad = math.radians(0.5 * section.number("fov_deg", 1.0, 170.0))
        focal = 0.5 * size[0] / math.tan(half_rad)
        return focal, focal, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)
    fx, fy = (section.number(key, 1e-3, 1e9) for key in ("fx", "fy"))
    return fx, fy, section.number("cx", -1e9, 1e9), section.number("cy", -1e9, 1e9)


def camera_toml(camera: Camera, rotation_deg: int = 0) -> str:
    """Write a camera as the `[camera]` table that `read_camera` and manifests read.

    `rotation_deg` says by how many degrees clockwise its images were turned to be shown.
    """
    lines = ["[camera]", f'model = "{camera.model}"']
    lines += [f"{key} = {getattr(camera, key)!r}" for key in ("width", "height")]
    lines += [f"{key} = {getattr(camera, key)!r}" for key in ("fx", "fy", "cx", "cy")]
    if camera.distortion:
        lines.append(f"distortion = [{', '.join(map(repr, camera.distortion))}]")
    if rotation_deg:
        lines.append(f"rotation_deg = {rotation_deg}")
    return "\n".join(lines) + "\n"


def board_toml(board: Board) -> str:
    """Write a board as the `[board]` table that `read_board` and manifests read."""
    kind = next(kind for kind, made in _BOARDS.items() if made is type(board))
    lines = ["[board]", f'type = "{kind}"']
    for key in BOARD_KEYS[kind]:
        value = getattr(board, key)
        if key not in _OPTIONAL[1:] or value != getattr(type(board), key):  # its default
            shown = f'"{value}"' if isinstance(value, str) else str(value).lower()
            lines.append(f"{key} = {shown}")
    return "\n".join(lines) + "\n"


MARKERS_KEYS = ("family", "side_m", "metric", "map_file")


def markers_toml(family: str, side_m: float) -> str:
    """Write loose markers as the `[markers]` table that manifests read."""
    return f'[markers]\nfamily = "{family}"\nside_m = {side_m!r}\n'


def section_markers(section: Section, file: Callable[[Section, str], Path]) -> LooseMarkers:
    """Make the markers of a manifest's table.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key, or the map's file.
    """
    known = None
    if "map_file" in section:
        try:
            known = MarkerMap.load(file(section, "map_file"))
        except RecordingError:
            raise
        except (ValueError, OSError) as fault:
            raise section.fault("map_file", str(fault)) from fault
    family = section.text("family", tuple(FAMILIES))
    return LooseMarkers(family, section.number("side_m", 1e-6, 1e3), known)
