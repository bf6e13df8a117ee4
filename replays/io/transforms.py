"""Transforms in files: 4 by 4 matrices in calibrations, and files of one transform alone.

The latter are evo's: JSON, text of 16 numbers, or NumPy's `.npy`.
"""

from __future__ import annotations

import io
import json
import math
from pathlib import Path
from tokenize import TokenError

import numpy as np

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import read_bounded, refusal
from motorcade.replays.io.readers.tables import UNIT_TOLERANCE

TRANSFORM_LIMIT = 2**16
_KEYS = ("x", "y", "z", "qx", "qy", "qz", "qw")
_UNIT = 1e-3
_RIGID = 1e-6
_NPY = b"\x93NUMPY"


def transform(value: object, path: Path, field: str) -> Motor:
    """Make a motor of a 4 by 4 matrix: four rows of four, or sixteen numbers row by row.

    Rounded rotations are made orthonormal, within `readers.tables.UNIT_TOLERANCE`.

    Raises:
        RecordingError: not sixteen finite numbers, or not a rigid motion.
    """
    expected = "expected 4 rows of 4 numbers"
    rows = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(rows, list) and len(rows) == 4:
        rows = [item for row in rows if isinstance(row, list) for item in row]
    if not isinstance(rows, list) or len(rows) != 16 or not all(map(is_number, rows)):
        raise refusal(path, f"{expected}, got {one_line(value)}", field=field)
    matrix = np.array([as_float(item) for item in rows]).reshape(4, 4)
    if np.abs(matrix).max() > 1e9:
        raise refusal(path, f"{expected} within 1e9, got {np.abs(matrix).max():g}", field=field)
    rotation = matrix[:3, :3]
    excess = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if excess > UNIT_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise refusal(
            path,
            f"expected a rotation (R^T R within {UNIT_TOLERANCE} of 1, determinant 1), got a "
            f"difference of {excess:.3g}, determinant {np.linalg.det(rotation):.3g}",
            field=field,
        )
    if np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > 1e-6:
        raise refusal(path, f"expected the last row 0 0 0 1, got {matrix[3]}", field=field)
    left, _, right = np.linalg.svd(rotation)
    return Motor.from_rotor_translation(Rotor.from_matrix(left @ right), matrix[:3, 3])


def read_transform(path: Path) -> Motor | Similarity:
    """Read a rigid motion, or a similarity where the file has a scale other than 1.

    Args:
        path: JSON with x, y, z, qx, qy, qz, qw and perhaps scale; or a 4 by 4 matrix as text or as
            NumPy's `.npy`. At most 64 KiB.

    Raises:
        RecordingError: missing, too large, or no such transform.
    """
    data = read_bounded(path, TRANSFORM_LIMIT)
    if data.lstrip().startswith(b"{"):
        return _of_json(path, data)
    return _of_matrix(path, _npy(path, data) if data.startswith(_NPY) else _text(path, data))


def _of_json(path: Path, data: bytes) -> Motor | Similarity:
    try:
        document = json.loads(data)
        *place, x, y, z, w = (float(document[key]) for key in _KEYS)
        scale = float(document.get("scale", 1.0))
    except (
        ValueError,
        TypeError,
        KeyError,
        AttributeError,
        OverflowError,
        RecursionError,
    ) as fault:
        reason = one_line(fault, 100)
        raise refusal(path, f"expected JSON of numbers {', '.join(_KEYS)}: {reason}") from fault
    norm = math.hypot(w, x, y, z)
    if not abs(norm - 1.0) < _UNIT or not np.isfinite(place).all():
        raise refusal(path, f"expected a unit quaternion and a place, got norm {norm:g}, {place}")
    motor = Motor.from_quaternion_translation(np.array([w, x, y, z]) / norm, place)
    return _scaled(path, motor, scale)


def _text(path: Path, data: bytes) -> FloatArray:
    try:
        rows = [line.partition(b"#")[0] for line in data.splitlines()]
        numbers = [float(word) for word in b" ".join(rows).replace(b",", b" ").split()]
    except ValueError as fault:
        raise refusal(path, f"expected 16 numbers or JSON: {one_line(fault)}") from fault
    if len(numbers) != 16:
        raise refusal(path, f"expected 16 numbers, got {len(numbers)}")
    return np.array(numbers).reshape(4, 4)


def _npy(path: Path, data: bytes) -> FloatArray:
    """The matrix of a `.npy`, whose head is read before its numbers are."""
    file = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(file)
        head = np.lib.format.read_array_header_1_0 if version == (1, 0) else None
        if head is None:
            raise ValueError(f"version {version}")
        shape, by_column, kind = head(file)
        if shape != (4, 4) or kind.kind not in "fiu":
            raise ValueError(f"shape {shape} of {kind}")
        numbers = np.frombuffer(data[file.tell() :], kind, 16).astype(np.float64)
    except (ValueError, TypeError, SyntaxError, TokenError) as fault:
        raise refusal(path, f"expected 4 by 4 numbers, got {one_line(fault, 100)}") from fault
    return numbers.reshape(4, 4, order="F" if by_column else "C")


def _of_matrix(path: Path, matrix: FloatArray) -> Motor | Similarity:
    with np.errstate(all="ignore"):
        scale = float(np.cbrt(np.linalg.det(matrix[:3, :3])))
    if not 0.0 < scale < np.inf:
        raise refusal(path, f"expected a rotation times a scale, got determinant {scale**3:g}")
    rigid = np.array(matrix)
    rigid[:3, :3] /= scale
    return _scaled(path, transform(rigid, path, "matrix"), scale)


def _scaled(path: Path, motor: Motor, scale: float) -> Motor | Similarity:
    if abs(scale - 1.0) < _RIGID:
        return motor
    if not 1e-9 < scale < 1e9:
        raise refusal(path, f"expected a scale from 1e-9 to 1e9, got {scale:g}")
    return Similarity.from_motor_scale(motor, scale)


def is_number(value: object) -> bool:
    """Whether this is a number, or text that YAML should have read as one."""
    return math.isfinite(as_float(value))


def as_float(value: object) -> float:
    """The number, or NaN. YAML 1.1 reads 1e-05, which has no dot, as text."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return math.nan
    try:
        return float(value)
    except (ValueError, OverflowError):
        return math.nan
