"""What a manifest says of an IMU, `[imu]`, and of the ground truth, `[truth]`.

`motorcade calibrate --imu` writes the first: how the sensor sits beside a camera, errs and keeps
time; it holds for every recording by the same camera and IMU. The truth has a file format, a
convention and a world, and is made `world_T_camera`.

=================== ======================================================== ====================
format              one pose                                                 stamps
=================== ======================================================== ====================
``tum``             stamp tx ty tz qx qy qz qw                               in the file, s
``euroc``           stamp, px, py, pz, qw, qx, qy, qz                        in the file, ns
``kitti``           12 numbers, a 3 by 4 matrix row by row                   none
``matrix4``         4 by 4 matrix: 16 numbers a row, or 4 rows of 4; or a    none
                    pattern such as ``poses/*.txt``, one matrix a file
``rotation_vector`` rx ry rz (rad) tx ty tz (m), as OpenCV's rvec and tvec   none
``bag``             a message of a ROS bag's `topic`, or frames that its tf joins in the bag
=================== ======================================================== ====================

Poses without stamps take those of a `times` file, of a `rate_hz`, or else row by row those of the
frames, whose count must then be the poses' (or `rows`, the leading ones that apply).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import MOST_CORRECTION, ImuStream
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import refusal
from motorcade.replays.io.imu import read_noise
from motorcade.replays.io.readers.calibration import read_numbers
from motorcade.replays.io.readers.frames.names import natural
from motorcade.replays.io.readers.kalibr import MOST_OFFSET_S
from motorcade.replays.io.readers.manifest.section import Section, load_toml
from motorcade.replays.io.readers.tables import read_table
from motorcade.replays.io.trajectories import even_stamps, is_bag, read_times, read_trajectory
from motorcade.replays.io.transforms import as_float, is_number, transform

if TYPE_CHECKING:
    from motorcade.replays.io.recording import Recording


TRUTH_KEYS = ("file", "format", "topic", "convention", "board_frame", "rate_hz", "times", "rows")
_FORMATS = ("tum", "euroc", "kitti", "matrix4", "rotation_vector", "bag")
_CONVENTIONS = ("world_T_camera", "camera_T_world", "world_T_imu")
_VECTOR = ("rx", "ry", "rz", "tx", "ty", "tz")

OPENCV_BOARD = Motor.from_rotor_translation(
    Rotor.from_rotation_vector(np.array([np.pi, 0.0, 0.0])), np.zeros(3)
)
"""Board coordinates as OpenCV has them (y down, z into the face) to ours (y up, z out of it)."""


def read_truth(
    section: Section,
    recording: Recording,
    file_of: Callable[[Section, str], Path],
    stated_T_upright: Motor | None = None,
) -> Trajectory:
    """Read the ground truth that a manifest names.

    Args:
        section: the manifest's truth table.
        recording: what is read so far: frames, board and IMU pose are used.
        file_of: finds the file that a key names.
        stated_T_upright: how far the camera was turned with its images; None: it was not.

    Raises:
        RecordingError: an unknown key, a file that cannot be read, counts that differ, or a
            convention that needs a board or an IMU that is not described.
    """
    fmt = section.text("format", _FORMATS)
    if "topic" in section and fmt != "bag":
        raise section.fault("topic", f"for bags alone, got format {fmt}")
    if fmt in ("tum", "euroc", "bag"):
        for key in ("rate_hz", "times", "rows"):
            if key in section:
                raise section.fault(key, f"not for {fmt} files, which hold their own stamps")
        truth = _stamped(section, fmt, file_of(section, "file"))
        time_ns, poses = truth.time_ns, truth.motors
    else:
        poses = _unstamped(section, fmt, file_of)
        if "rows" in section:
            poses = poses[: section.whole("rows", 1, len(poses))]
        time_ns = _stamps(section, len(poses), recording, file_of)
    poses = _as_camera_poses(section, poses, recording, stated_T_upright)
    if "board_frame" in section:
        if recording.board is None:
            raise section.fault("board_frame", "expected a [board] that it refers to")
        frame = section.text("board_frame", ("opencv", "motorcade"))
        turned = OPENCV_BOARD @ poses if frame == "opencv" else poses
        poses = recording.world_T_board @ turned
    return Trajectory(time_ns, poses)


def _stamped(section: Section, fmt: str, file: Path) -> Trajectory:
    """Poses of a format with stamps."""
    if fmt != "bag":
        return read_trajectory(file, "tum" if fmt == "tum" else "euroc")
    if not is_bag(file):
        raise section.fault("file", f"expected a bag, got {one_line(file.name)}")
    return read_trajectory(f"{file}:{section.text('topic')}")


def _unstamped(section: Section, fmt: str, file_of: Callable[[Section, str], Path]) -> Motor:
    """Poses of a format without stamps."""
    if fmt == "matrix4":
        return _matrices(section, file_of)
    path = file_of(section, "file")
    if fmt == "kitti":
        return read_trajectory(path, "kitti", rate_hz=1.0).motors
    table = read_table(path, _VECTOR)
    reach = np.abs(table.values).max(axis=1)
    if reach.max() > 1e9:
        line = int(table.lines[int(np.argmax(reach))])
        raise refusal(path, f"expected numbers within 1e9, got {reach.max():g}", line=line)
    rotor = Rotor.from_rotation_vector(table.values[:, :3])
    return Motor.from_rotor_translation(rotor, table.values[:, 3:])


def _matrices(section: Section, file_of: Callable[[Section, str], Path]) -> Motor:
    pattern = file_of(section, "file")
    if "*" not in pattern.name:
        values = read_numbers(pattern, most=20_000_000)
        if len(values) == 0 or len(values) % 16:
            raise refusal(pattern, f"expected 16 numbers a pose, got {len(values)} in all")
        blocks = values.reshape(-1, 4, 4)
        return Motor.stack(
            [transform(block, pattern, f"pose {index}") for index, block in enumerate(blocks)]
        )
    files = sorted(pattern.parent.glob(pattern.name), key=natural)
    if not files:
        raise section.fault("file", f"expected files {pattern.name}, got none")
    return Motor.stack([transform(read_numbers(path, (16,)), path, "pose") for path in files])


def _stamps(
    section: Section, count: int, recording: Recording, file_of: Callable[[Section, str], Path]
) -> IntArray:
    """Stamps for poses that have none."""
    section.only_one("rate_hz", "times")
    if "rate_hz" in section:
        return even_stamps(count, section.number("rate_hz", 1e-3, 1e5))
    if "times" in section:
        path = file_of(section, "times")
        _, time_ns = read_times(path)
        if len(time_ns) != count:
            raise refusal(path, f"expected {count} stamps for as many poses, got {len(time_ns)}")
        return time_ns
    if count != len(recording.frames):
        advice = "say how many of its first rows apply with rows, or give rate_hz or times"
        raise section.fault(
            "file",
            f"expected a pose for each of {len(recording.frames)} frames, got {count}",
            advice if count > len(recording.frames) else "is an image or a pose missing?",
        )
    return recording.frames.time_ns


def _as_camera_poses(
    section: Section, poses: Motor, recording: Recording, stated_T_upright: Motor | None
) -> Motor:
    """Turn poses of the stated convention into `world_T_camera`."""
    convention = section.text("convention", _CONVENTIONS)
    if convention == "world_T_imu":
        if recording.imu_T_camera is None:
            raise section.fault("convention", "world_T_imu needs imu_T_camera in [imu]")
        return poses @ recording.imu_T_camera
    stated = poses if convention == "world_T_camera" else poses.inverse()
    return stated if stated_T_upright is None else stated @ stated_T_upright


IMU_KEYS = (
    "file",
    "noise_file",
    "imu_T_camera",
    "clock_offset_s",
    "gyro_correction",
    "accel_correction",
)


@dataclass(frozen=True, eq=False)
class ImuCalibration:
    """What a table says of an IMU; None: nothing.

    Fields:
        noise: its densities and bias walks.
        imu_T_camera: pose of the camera on it.
        offset_s: what its clock shows at an event minus what the camera's shows.
        gyro_correction, accel_correction: ``(3, 3)``; times a reading, they give the true rate
            plus a bias, the true force plus a bias.
    """

    noise: ImuNoise | None
    imu_T_camera: Motor | None
    offset_s: float
    gyro_correction: FloatArray
    accel_correction: FloatArray

    def corrected(self, imu: ImuStream) -> ImuStream:
        """The readings with the corrections, on the IMU's own clock."""
        return imu.corrected(self.gyro_correction, self.accel_correction)

    def on_camera_clock(self, imu: ImuStream) -> ImuStream:
        """The corrected readings with the stamps that the camera's clock shows."""
        stamps = imu.time_ns - round(1e9 * self.offset_s)
        return replace(self.corrected(imu), time_ns=stamps)


def read_imu_calibration(path: Path) -> ImuCalibration:
    """Read the `[imu]` table of a TOML file, as `motorcade calibrate --imu` writes it.

    Raises:
        RecordingError: what the table lacks or gets wrong, or the noise file that it names.
    """
    tables = load_toml(path)
    if "imu" not in tables:
        raise Section(path, "", {}, ()).fault("imu", "the table is missing")
    section = Section(path, "imu", tables["imu"], IMU_KEYS)
    imu_calibration = section_imu(section, lambda part, key: path.parent / part.text(key))
    if imu_calibration.imu_T_camera is None:
        raise section.fault("imu_T_camera", "the key is missing", "give a 4 by 4 matrix")
    return imu_calibration


def section_imu(section: Section, file: Callable[[Section, str], Path]) -> ImuCalibration:
    """What a manifest's table says of the sensor.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    noise = read_noise(file(section, "noise_file")) if "noise_file" in section else None
    pose, offset_s = None, 0.0
    if "imu_T_camera" in section:
        pose = transform(section["imu_T_camera"], section.path, "[imu] imu_T_camera")
    if "clock_offset_s" in section:
        offset_s = section.number("clock_offset_s", -MOST_OFFSET_S, MOST_OFFSET_S)
    matrices = (_correction(section, key) for key in ("gyro_correction", "accel_correction"))
    return ImuCalibration(noise, pose, offset_s, *matrices)


def _correction(section: Section, key: str) -> FloatArray:
    """A matrix ``(3, 3)`` close to the identity, which it is where nothing is said."""
    if key not in section:
        return np.eye(3)
    rows = section[key]
    numbers = []
    if isinstance(rows, list) and len(rows) == 3:
        numbers = [one for row in rows if isinstance(row, list) for one in row]
    if len(numbers) != 9 or not all(map(is_number, numbers)):
        raise section.fault(key, f"expected 3 rows of 3 numbers, got {one_line(rows)}")
    matrix = np.array([as_float(one) for one in numbers]).reshape(3, 3)
    if not np.abs(matrix - np.eye(3)).max() <= MOST_CORRECTION:
        expected = f"expected entries within {MOST_CORRECTION:g} of the identity's"
        raise section.fault(key, f"{expected}, got {one_line(rows)}")
    return matrix
