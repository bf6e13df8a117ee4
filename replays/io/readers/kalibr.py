"""Kalibr's camera chains, as Kalibr, OpenVINS and TUM-VI keep them: `cam0`, `cam1`, ... in a file.

`T_cam_imu` maps IMU coordinates to the camera's; OpenVINS may give its inverse, `T_imu_cam`. To an
image's stamp `timeshift_cam_imu` is added to make it the IMU's.

`read_extrinsics` tells where a camera sits on an IMU, from files of several programs.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.ga import Motor
from motorcade.ga.names import one_line
from motorcade.replays.io.files import read_bounded, refusal, refusing
from motorcade.replays.io.readers.calibration import make_camera, read_yaml, yaml_floats, yaml_model
from motorcade.replays.io.transforms import (
    TRANSFORM_LIMIT,
    as_float,
    is_number,
    read_transform,
    transform,
)

if TYPE_CHECKING:
    from motorcade.fusion.imu import ImuStream
    from motorcade.tracking.boards import Board
    from motorcade.tracking.cameras.camera import Camera


CHAIN_NAMES = ("kalibr_imucam_chain.yaml", "camchain-imucam.yaml", "camchain.yaml")
IMU_NAMES = ("kalibr_imu_chain.yaml", "imu_config.yaml", "imu.yaml")
"""What the files are called beside a recording."""

MOST_OFFSET_S = 1e6


@dataclass(frozen=True)
class ChainCamera:
    """One camera of a chain: its topic where the file names one, and where it sits on the IMU.

    `offset_s` is what the IMU's clock shows at an event minus what the camera's shows; None: the
    file does not say.
    """

    camera: Camera
    imu_T_camera: Motor | None
    topic: str | None
    offset_s: float | None

    def on_camera_clock(self, imu: ImuStream | None) -> ImuStream | None:
        """The IMU's readings with the stamps that the camera's clock shows."""
        if imu is None or not self.offset_s:
            return imu
        return replace(imu, time_ns=imu.time_ns - round(1e9 * self.offset_s))


def find(folder: Path, names: tuple[str, ...]) -> Path | None:
    """The first file of these names in a folder."""
    return next((folder / name for name in names if (folder / name).is_file()), None)


def read_chain(path: Path) -> tuple[ChainCamera, ...]:
    """Read all cameras of a chain, `cam0` first.

    Raises:
        RecordingError: no cameras, a key that is missing or of another kind, a camera model other
            than pinhole (omni), or an unknown distortion.
    """
    content = read_yaml(path)
    cameras = []
    for name in sorted(key for key in content if key.startswith("cam") and key[3:].isdecimal()):
        table = content[name]
        if not isinstance(table, Mapping):
            raise refusal(path, f"expected a table, got {one_line(table)}", field=name)
        cameras.append(_camera({str(key): value for key, value in table.items()}, path, name))
    if not cameras:
        raise refusal(path, f"expected cam0, got {one_line(list(content))}")
    return tuple(cameras)


TARGET_KEYS = {
    "aprilgrid": ("tagCols", "tagRows", "tagSize", "tagSpacing"),
    "checkerboard": ("targetCols", "targetRows", "rowSpacingMeters", "colSpacingMeters"),
    "circlegrid": ("targetCols", "targetRows", "spacingMeters"),
}
_DIAMETER = 0.5
"""Of the spacing: Kalibr's circles have no diameter, and only drawings need one."""


def read_target(path: Path) -> Board:
    """Read the board of Kalibr's target file, as its ``--target`` takes it.

    ``tagSpacing`` is the gap between tags over ``tagSize``. Of circles the file tells no diameter;
    half of their spacing is taken, which matters for prints alone.

    Raises:
        RecordingError: a key that is missing or of another kind, squares that are oblong, or
            numbers that the board refuses.

    Source: Kalibr's wiki, "Calibration targets".
    """
    from motorcade.tracking.boards import Checkerboard, CircleGrid
    from motorcade.tracking.boards.names import kalibr_grid

    content = read_yaml(path)
    kind = str(content.get("target_type"))
    if kind not in TARGET_KEYS:
        expected = f"expected one of {', '.join(TARGET_KEYS)}, got {one_line(kind)}"
        raise refusal(path, expected, field="target_type")
    for key in TARGET_KEYS[kind]:
        if not is_number(content.get(key)):
            raise refusal(path, f"expected a number, got {one_line(content.get(key))}", field=key)
    columns, rows, unit_m, *others = (as_float(content[key]) for key in TARGET_KEYS[kind])
    if not (columns.is_integer() and rows.is_integer()):
        raise refusal(path, "expected whole numbers", field=" and ".join(TARGET_KEYS[kind][:2]))
    counts = int(columns), int(rows)
    with refusing(path, kind):
        if kind == "aprilgrid":
            first = content.get("codeOffset", 0)
            return kalibr_grid(*counts, unit_m, round(others[0] * unit_m, 9), int(as_float(first)))
        if kind == "circlegrid":
            shifted = content.get("asymmetricGrid", False)
            return CircleGrid(*counts, unit_m, _DIAMETER * unit_m, shifted is True)
        if others[0] != unit_m:
            raise ValueError(f"expected square cells, got {unit_m:g} by {others[0]:g} m")
        return Checkerboard(*counts, unit_m)


def _camera(table: dict[str, object], path: Path, name: str) -> ChainCamera:
    kind = str(table.get("camera_model", "pinhole"))
    if kind != "pinhole":
        raise refusal(path, f"expected pinhole, got {one_line(kind)}", field=f"{name} camera_model")
    size = yaml_floats(path, table, "resolution", 2)
    intrinsics = yaml_floats(path, table, "intrinsics", 4)
    model = yaml_model(path, table)
    distortion: tuple[float, ...] = ()
    if model != "pinhole":
        distortion = yaml_floats(path, table, "distortion_coeffs", None)
    place = None
    if "T_imu_cam" in table:
        place = transform(table["T_imu_cam"], path, f"{name} T_imu_cam")
    elif "T_cam_imu" in table:
        place = transform(table["T_cam_imu"], path, f"{name} T_cam_imu").inverse()
    topic = table.get("rostopic")
    camera = make_camera(path, size, intrinsics, model, distortion)
    named = topic if isinstance(topic, str) else None
    return ChainCamera(camera, place, named, _offset_s(table, path, name))


def _offset_s(table: dict[str, object], path: Path, name: str) -> float | None:
    if "timeshift_cam_imu" not in table:
        return None
    offset = table["timeshift_cam_imu"]
    if not is_number(offset) or not abs(as_float(offset)) <= MOST_OFFSET_S:
        problem = f"expected seconds within {MOST_OFFSET_S:g}, got {one_line(offset)}"
        raise refusal(path, problem, field=f"{name} timeshift_cam_imu")
    return as_float(offset)


_EXTRINSIC_KEYS = ("imu_T_camera_wxyz", "imu_T_camera_translation_m")


def read_extrinsics(path: Path) -> Motor:
    """Read ``imu_T_camera``: camera coordinates to the IMU's.

    Args:
        path: what `motorcade sync --json` or `motorcade fuse --json` wrote, a Kalibr chain (YAML,
            its first camera), a transform as evo writes it (JSON with x to qw), or 4 by 4 numbers.

    Raises:
        RecordingError: missing, none of these, or with a scale.
    """
    if path.suffix.lower() in (".yaml", ".yml"):
        place = read_chain(path)[0].imu_T_camera
        if place is None:
            raise refusal(path, "expected T_cam_imu or T_imu_cam of cam0, got neither")
        return place
    data = read_bounded(path, TRANSFORM_LIMIT)
    if data.lstrip().startswith(b"{") and all(key.encode() in data for key in _EXTRINSIC_KEYS):
        return _of_sync(path, data)
    extrinsics = read_transform(path)
    if not isinstance(extrinsics, Motor):
        raise refusal(path, "expected a rigid motion, got one with a scale")
    return extrinsics


def read_offset(path: Path) -> float | None:
    """What a Kalibr chain says that the IMU's clock is ahead of its first camera's, in seconds.

    None: a chain without `timeshift_cam_imu`, or another file: both say nothing of clocks.

    Raises:
        RecordingError: as of `read_extrinsics`.
    """
    if path.suffix.lower() not in (".yaml", ".yml"):
        return None

    return read_chain(path)[0].offset_s


def _of_sync(path: Path, data: bytes) -> Motor:
    try:
        document = json.loads(data)
        turn, place = ([float(one) for one in document[key]] for key in _EXTRINSIC_KEYS)
        if len(turn) != 4 or len(place) != 3 or not abs(sum(q * q for q in turn) - 1.0) < 1e-3:
            raise ValueError(f"a unit quaternion and a place, got {turn}, {place}")
        return Motor.from_quaternion_translation(turn, place)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as fault:
        reason = one_line(fault, 100)
        raise refusal(path, f"expected {' and '.join(_EXTRINSIC_KEYS)}: {reason}") from fault
