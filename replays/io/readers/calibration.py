"""Calibration files: EuRoC/OpenCV YAML, matrices in text, transforms; made into checked values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.ga.plain_yaml import YamlError, parse_yaml
from motorcade.replays.io.files import read_bounded, refusal, refusing
from motorcade.replays.io.readers.tables import data_rows
from motorcade.replays.io.transforms import as_float, is_number, transform
from motorcade.tracking.cameras.camera import Camera, CameraModel

YAML_LIMIT = 2**18
_MODELS = {
    "radial-tangential": "radtan",
    "radtan": "radtan",
    "plumb_bob": "radtan",
    "equidistant": "equidistant",
    "equi": "equidistant",
    "none": "pinhole",
    "pinhole": "pinhole",
}


def read_yaml(path: Path) -> dict[str, object]:
    """Read a YAML file of named values, such as `sensor.yaml`.

    Raises:
        RecordingError: missing, larger than 256 KiB, not plain YAML (`ga.plain_yaml`), or not a
            table of names.
    """
    text = read_bounded(path, YAML_LIMIT).decode("utf-8", "replace")
    try:
        content = parse_yaml(text)
    except YamlError as fault:
        raise refusal(path, str(fault), line=fault.line) from fault
    if not isinstance(content, dict):
        raise refusal(path, f"expected named values, got {type(content).__name__}")
    return {str(key): value for key, value in content.items()}


def yaml_camera(path: Path) -> Camera:
    """Read a camera from a `sensor.yaml` as EuRoC writes it.

    Raises:
        RecordingError: a key that is missing or of another kind, an unknown model, a wrong count
            of intrinsics or distortion coefficients.
    """
    content = read_yaml(path)
    size = yaml_floats(path, content, "resolution", 2)
    fx, fy, cx, cy = yaml_floats(path, content, "intrinsics", 4)
    model, distortion = yaml_model(path, content), tuple[float, ...]()
    if model != "pinhole":
        distortion = yaml_floats(path, content, "distortion_coefficients", None)
    return make_camera(path, size, (fx, fy, cx, cy), model, distortion)


def yaml_model(path: Path, content: Mapping[str, object]) -> str:
    """The camera model that a calibration's `distortion_model` stands for.

    Raises:
        RecordingError: an unknown one.
    """
    name = str(content.get("distortion_model", "none")).strip().lower()
    if name not in _MODELS:
        problem = f"expected one of {', '.join(_MODELS)}, got {one_line(name)}"
        raise refusal(path, problem, field="distortion_model")
    return _MODELS[name]


def yaml_transform(path: Path, key: str = "T_BS") -> Motor:
    """Read a 4 by 4 transform, `T_BS: {rows: 4, cols: 4, data: [...]}` or a list of rows.

    Raises:
        RecordingError: missing, not 16 numbers, or not a rigid motion.
    """
    value = read_yaml(path).get(key)
    if isinstance(value, Mapping):
        value = value.get("data")
    return transform(value, path, key)


def make_camera(
    path: Path,
    size: Sequence[float],
    intrinsics: Sequence[float],
    model: str,
    distortion: Sequence[float],
) -> Camera:
    """Make a camera of (width, height), (fx, fy, cx, cy); what is wrong is said of the file `path`.

    Raises:
        RecordingError: whatever `Camera` refuses.
    """
    if not all(math.isfinite(side) and side == int(side) for side in size):
        raise refusal(path, f"expected whole pixels, got {tuple(size)}", field="width, height")
    width, height = (int(side) for side in size)
    fx, fy, cx, cy = intrinsics
    with refusing(path):
        known = cast("CameraModel", model)  # Camera itself refuses any other
        return Camera(width, height, fx, fy, cx, cy, known, tuple(distortion))


def read_numbers(
    path: Path, counts: Sequence[int] | None = None, most: int = 100_000
) -> FloatArray:
    """Read all numbers of a small text file, whatever its lines, commas or spaces.

    Args:
        path: the file.
        counts: how many there may be; None for any.
        most: refuse more than these.

    Raises:
        RecordingError: something that is no finite number, or another count.
    """
    numbers: list[float] = []
    for line, row in data_rows(path, None):
        for token in b" ".join(row).replace(b",", b" ").split():
            try:
                numbers.append(float(token))
            except ValueError as fault:
                problem = f"expected a number, got {one_line(token)}"
                raise refusal(path, problem, line=line) from fault
        if len(numbers) > most:
            raise refusal(path, f"expected at most {most} numbers, got more", line=line)
    if counts is not None and len(numbers) not in counts:
        expected = " or ".join(map(str, counts))
        raise refusal(path, f"expected {expected} numbers, got {len(numbers)}")
    values = np.array(numbers, dtype=np.float64)
    if not np.isfinite(values).all():
        raise refusal(path, "expected finite numbers, got NaN or infinity")
    return values


def read_matrix(path: Path) -> tuple[float, float, float, float]:
    """Read a 3 by 3 intrinsic matrix: fx, fy, cx, cy.

    Raises:
        RecordingError: not nine numbers, skew, or a last row that is not 0 0 1.
    """
    matrix = read_numbers(path, (9,)).reshape(3, 3)
    if not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0):
        raise refusal(path, f"expected focal lengths above 0, got {matrix[0, 0]}, {matrix[1, 1]}")
    if np.any(matrix[[1, 2, 2, 2], [0, 0, 1, 2]] != (0.0, 0.0, 0.0, 1.0)) or matrix[0, 1] != 0.0:
        raise refusal(path, "expected fx 0 cx / 0 fy cy / 0 0 1 without skew, got other numbers")
    return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2])


def yaml_floats(
    path: Path, content: Mapping[str, object], key: str, count: int | None
) -> tuple[float, ...]:
    """Read the numbers of a list in a YAML file.

    Args:
        path: the file, for messages.
        content: what holds the list.
        key: its name.
        count: how many there must be; None for any.

    Raises:
        RecordingError: no list, something that is no finite number, or another count.
    """
    value = content.get(key)
    expected = f"expected {'' if count is None else f'{count} '}numbers"
    if not isinstance(value, list):
        raise refusal(path, f"{expected}, got {one_line(value)}", field=key)
    if count is not None and len(value) != count:
        raise refusal(path, f"{expected}, got {len(value)}", field=key)
    if not all(map(is_number, value)):
        raise refusal(path, f"{expected}, got {one_line(value)}", field=key)
    return tuple(map(as_float, value))
