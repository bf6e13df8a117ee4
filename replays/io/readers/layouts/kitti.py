"""KITTI odometry layout: `image_2` (colour), `image_0` or `image_l`, `calib.txt`, `poses.txt`.

Images are rectified, so the camera is a pinhole. Rows of `calib.txt` are projections K [I | t],
named (`P2:`) or not (then in the order of the cameras); `t` shifts camera 0, whose poses are
given, to the one that is read. Where the folder of its right neighbour is there too (`image_3`,
`image_1` or `image_r`), its images make pairs. Stamps come from `times.txt`, or else from the
set's 10 Hz. KITTI's world is the first pose of camera 0 with y down; it is turned on reading, so
that z is up and x points where the car drove first.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.names import one_line
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.calibration import make_camera
from motorcade.replays.io.readers.frames.files import ImageFrames, image_glob
from motorcade.replays.io.readers.frames.names import refuse_gaps
from motorcade.replays.io.readers.tables import data_rows
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import even_stamps, read_times, read_trajectory

RATE_HZ = 10.0
_CAMERAS = {"image_2": 2, "image_0": 0, "image_l": 0}
_RIGHT = {"image_2": "image_3", "image_0": "image_1", "image_l": "image_r"}
_SHORTEST_PX = 1e-3
_REACH = 1e9
_UPRIGHT = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def recognise(root: Path) -> bool:
    """Whether the folder holds `calib.txt` beside a folder of images."""
    return (root / "calib.txt").is_file() and any((root / name).is_dir() for name in _CAMERAS)


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read a KITTI odometry sequence, colour where there is any.

    Raises:
        RecordingError: a gap in the numbers, counts that differ, or whatever cannot be read.
    """
    folder = next(root / name for name in _CAMERAS if (root / name).is_dir())
    files = image_glob(root, f"{folder.name}/*.*")
    refuse_gaps(files, "copy the missing image again")
    time_ns = _stamps(root, len(files))
    calibration, row = _projection(root / "calib.txt", _CAMERAS[folder.name])
    size = ImageFrames(files, time_ns).first_size()
    fx, fy, cx, cy = (float(row[i]) for i in (0, 5, 2, 6))
    camera = make_camera(calibration, size, (fx, fy, cx, cy), "pinhole", ())
    frames, baseline_m = ImageFrames(files, time_ns, size), None
    right = root / _RIGHT[folder.name]
    if right.is_dir():
        _, other = _projection(calibration, _CAMERAS[folder.name] + 1)
        baseline_m = float(row[3] / row[0] - other[3] / other[0])
        frames = replace(frames, right_files=_partners(root, right, files))
    return Recording(
        name=root.resolve().name,
        root=root,
        layout="kitti",
        frames=frames,
        camera=camera,
        baseline_m=baseline_m,
        truth=_truth(root, time_ns, row) if own_truth else None,
    )


def _partners(root: Path, right: Path, files: tuple[Path, ...]) -> tuple[Path, ...]:
    """The right images of the same names as the left ones."""
    partners = image_glob(root, f"{right.name}/*.*")
    if [path.name for path in partners] != [path.name for path in files]:
        raise refusal(right, f"expected the {len(files)} names of the left images, got others")
    return partners


def _stamps(root: Path, count: int) -> IntArray:
    if not (root / "times.txt").is_file():
        return even_stamps(count, RATE_HZ)
    _, time_ns = read_times(root / "times.txt")
    if len(time_ns) != count:
        problem = f"expected {count} stamps for as many images, got {len(time_ns)}"
        raise refusal(root / "times.txt", problem)
    return time_ns


def _projection(path: Path, camera: int) -> tuple[Path, FloatArray]:
    """The row of `calib.txt` for a camera: twelve numbers."""
    rows: dict[str, FloatArray] = {}
    for line, tokens in data_rows(path, None):
        named = tokens[0].endswith(b":")
        name = tokens[0].decode("ascii", "replace") if named else f"P{len(rows)}:"
        numbers = tokens[1:] if named else tokens
        try:
            rows[name] = np.array([float(token) for token in numbers])
        except ValueError as fault:
            raise refusal(path, "expected numbers", line=line, field=one_line(name)) from fault
        if name.startswith("P") and (len(numbers) != 12 or not np.isfinite(rows[name]).all()):
            problem = f"expected 12 finite numbers, got {len(numbers)}"
            raise refusal(path, problem, line=line, field=one_line(name))
    wanted = f"P{camera}:"
    if wanted not in rows:
        raise refusal(path, f"expected a row {wanted}, got {one_line(', '.join(rows))}")
    _check_projection(path, wanted, rows[wanted])
    return path, rows[wanted]


def _check_projection(path: Path, name: str, row: FloatArray) -> None:
    """Refuse what is no K [I | t] of a camera, so that what is computed from it stays finite."""
    if np.abs(row).max() > _REACH:
        problem = f"expected numbers within {_REACH:g}, got {np.abs(row).max():g}"
        raise refusal(path, problem, field=name)
    if row[[0, 5]].min() < _SHORTEST_PX:
        problem = f"expected focal lengths from {_SHORTEST_PX:g} pixels, got {row[0]:g}, {row[5]:g}"
        raise refusal(path, problem, field=name)
    if np.any(row[[1, 4, 8, 9, 10]] != (0.0, 0.0, 0.0, 0.0, 1.0)):
        problem = "expected fx 0 cx t / 0 fy cy t / 0 0 1 t without skew, got other numbers"
        raise refusal(path, problem, field=name)
    if np.abs(_shift_m(row)).max() > _REACH:
        problem = f"expected a shift within {_REACH:g} m, got {np.abs(_shift_m(row)).max():g}"
        raise refusal(path, problem, field=name)


def _shift_m(row: FloatArray) -> FloatArray:
    """The `t` of a row K [I | t]."""
    intrinsic = row.reshape(3, 4)
    return np.asarray(np.linalg.solve(intrinsic[:, :3], intrinsic[:, 3]), dtype=np.float64)


def _truth(root: Path, time_ns: IntArray, row: FloatArray) -> Trajectory | None:
    """Poses of camera 0, moved to the camera that is read, in a world with z up."""
    beside = root / "poses.txt"
    official = root.resolve().parent.parent / "poses" / f"{root.resolve().name}.txt"
    path = beside if beside.is_file() else official
    if not path.is_file():
        return None
    poses = read_trajectory(path, "kitti", rate_hz=RATE_HZ).motors
    if len(poses) != len(time_ns):
        raise refusal(path, f"expected {len(time_ns)} poses for as many images, got {len(poses)}")
    camera0_T_camera = Motor.from_translation(-_shift_m(row))
    world_T_kitti = Motor.from_rotor_translation(Rotor.from_matrix(_UPRIGHT), np.zeros(3))
    return Trajectory(time_ns, world_T_kitti @ poses @ camera0_T_camera)
