"""Stage `camera_poses`: where the camera was, by its board, loose markers, SLAM, or simulated."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.simulate_poses import simulate_camera_poses
from motorcade.ga import FloatArray, IntArray
from motorcade.replays.engine.artifacts import ASIDE, new_file
from motorcade.replays.engine.progress import track
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.replays.stages.camera.board_check import warn_of_size, warn_of_wrong_board
from motorcade.replays.stages.camera.marker_poses import Refine, marker_poses
from motorcade.replays.stages.camera.slam_poses import slam_poses
from motorcade.tracking import PoseMeasurements, TrackingError, track_board

log = logging.getLogger("motorcade.camera_poses")

Origin = Literal["board", "tags", "slam", "simulated"]
_Way = Callable[[Recording], "CameraPoses"]


@dataclass(frozen=True)
class CameraPoses:
    """Measured poses `world_T_camera`, and every stamp at which one was sought.

    `reprojection_px` (N,) belongs to the measurements; it is NaN where nothing was reprojected.
    `board_track` holds the corners and both planar candidates of every frame (read it with
    `tracking.BoardTrack.load`), `marker_map` where loose markers stand (`MarkerMap.load`),
    `slam_map` what SLAM mapped (`MapSnapshot.load`) and `points` (p, 3) where that is; each is
    there for its own origin only. `metric` is False where the unit of length is free (SLAM by one
    camera alone, where no IMU tells it); where an IMU did, `metres_a_unit` is what the map's unit
    was found to be, and `scale_sigma` the relative deviation of that. `account` says in one line
    how the poses were found, and `passed_over` what was tried before, with the reason. `seconds` is
    what tracking took, reading and decoding the images included.
    """

    measurements: PoseMeasurements
    sought_ns: IntArray
    reprojection_px: FloatArray
    origin: Origin
    account: str
    board_track: Path | None = None
    marker_map: Path | None = None
    slam_map: Path | None = None
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    metric: bool = True
    metres_a_unit: float | None = None
    scale_sigma: float | None = None
    passed_over: tuple[str, ...] = ()
    seconds: float = field(default=0.0, metadata=ASIDE)


def camera_poses(
    recording: Recording,
    *,
    source: Literal["auto", "board", "tags", "slam", "simulated"] = "auto",
    refine: Refine = "none",
    moving: tuple[int, ...] = (),
    slam_adjust: bool = True,
    slam_close_loops: bool = True,
    slam_threads: bool = False,
    rate_hz: float = 20.0,
    sigma_m: float = 0.01,
    sigma_deg: float = 0.5,
    blackouts_s: tuple[float, ...] = (),
    seed: int = 0,
) -> CameraPoses:
    """Find the camera's poses by what the recording offers.

    `source=auto` tries in turn, and says what it passed over: the board, if the recording names
    one and it is seen; loose markers, if a family is named or corners were recorded; visual SLAM,
    with depth where there is some, else by one camera, whose scale is free unless a recorded IMU
    tells it; last a simulation from the truth. The world is the board's, the marker's that was
    seen most, the first camera's, or an upright one where an IMU gave the metres.

    `refine=photometric` sharpens the poses of loose markers in pictures on their whole print; it
    needs torch and kornia (the extra `photometric`), and pays on small markers and for steadiness
    (`make bench SUITE=tracking` says how much), at 30 to 150 ms a marker on one core.

    `moving` names loose markers that do not stand still: they neither map nor track.

    `slam_adjust` and `slam_close_loops` switched off show what the map's adjustment and its loops
    are worth; `slam_threads` maps in a second thread, after which two runs may differ.

    A simulation measures `rate_hz` poses a second, with standard deviations of `sigma_m` and
    `sigma_deg` an axis, its errors drawn by `seed`. `blackouts_s` (start, end, start, end, … in
    seconds after the first stamp) are spans in which no pose is measured, whatever the source.

    Raises ValueError where the source asked for is not there, and where nothing gives a pose.
    """
    spans = _spans(blackouts_s)
    sigma_rad = float(np.deg2rad(sigma_deg))
    ways: dict[str, _Way] = {
        "board": _by_board,
        "tags": partial(_by_markers, refine=refine, moving=moving),
        "slam": partial(
            _by_slam, adjust=slam_adjust, close_loops=slam_close_loops, threads=slam_threads
        ),
        "simulated": partial(
            _simulated, rate_hz=rate_hz, sigma_m=sigma_m, sigma_rad=sigma_rad, seed=seed
        ),
    }
    found = _first_that_works(recording, ways) if source == "auto" else ways[source](recording)
    return _without(found, spans)


def _first_that_works(recording: Recording, ways: Mapping[str, _Way]) -> CameraPoses:
    passed_over: list[str] = []
    for name in _offered(recording):
        try:
            found = ways[name](recording)
        except TrackingError as nothing:
            log.warning("camera_poses: %s passed over: %s", name, nothing)
            passed_over.append(f"{name}: {nothing}")
            continue
        return replace(found, passed_over=tuple(passed_over))
    if recording.camera is None:
        raise ValueError(
            f"{recording.name}: no camera known, so its poses cannot be tracked; describe it in a "
            "manifest: [camera] with fx, fy, cx, cy as `motorcade calibrate` finds them, or with "
            "fov_deg = 65 where only a guess of how wide it sees can be had"
        )
    raise ValueError(f"{recording.name}: no camera pose found; {'; '.join(passed_over)}")


def _offered(recording: Recording) -> list[str]:
    """The ways that a recording offers, the surest first."""
    pictures = not isinstance(recording.frames, CornerFrames)
    tracked = recording.camera is not None
    offered = {
        "board": tracked and pictures and recording.board is not None,
        "tags": tracked and (not pictures or recording.markers is not None),
        "slam": tracked and pictures,
        "simulated": recording.truth is not None,
    }
    return [name for name, here in offered.items() if here]


def _by_board(recording: Recording) -> CameraPoses:
    if recording.board is None or recording.camera is None:
        missing = "camera" if recording.camera is None else "board"
        raise ValueError(f"{recording.name}: no {missing} known; describe it in a manifest")
    frames = recording.frames
    warn_of_size(recording.board)
    start = time.perf_counter()
    tracked = track_board(
        ((frame.time_ns, frame.gray()) for frame in track(frames, "tracking", len(frames))),
        recording.camera,
        recording.board,
    )
    seconds = time.perf_counter() - start
    warn_of_wrong_board(recording, recording.board, tracked)
    on_board = tracked.measurements
    board_track = new_file("board_track.npz")
    tracked.save(board_track)
    return CameraPoses(
        PoseMeasurements(
            on_board.trajectory.transformed_by(left=recording.world_T_board), on_board.covariance
        ),
        frames.time_ns,
        tracked.error_px,
        "board",
        f"tracked by the {recording.board.name} in the images",
        board_track=board_track,
        seconds=seconds,
    )


def _by_markers(recording: Recording, *, refine: Refine, moving: tuple[int, ...]) -> CameraPoses:
    found = marker_poses(recording, refine, moving)
    recorded = isinstance(recording.frames, CornerFrames)
    known = recording.markers is not None and recording.markers.marker_map is not None
    where = "where a map places them" if known else "mapped from this recording alone"
    marker_map = new_file("marker_map.json")
    found.marker_map.save(marker_map)
    return CameraPoses(
        found.measurements,
        found.sought_ns,
        found.error_px,
        "tags",
        f"tracked by the {'recorded corners' if recorded else 'images'} of "
        f"{len(found.marker_map)} loose markers, {where}"
        + (", refined on their prints" if refine == "photometric" else "")
        + (f"; {len(found.left_out)} markers never seen beside them" if found.left_out else ""),
        marker_map=marker_map,
        seconds=found.seconds,
    )


def _by_slam(
    recording: Recording, *, adjust: bool, close_loops: bool, threads: bool
) -> CameraPoses:
    found = slam_poses(recording, adjust=adjust, close_loops=close_loops, threads=threads)
    slam_map = new_file("slam_map.npz")
    found.map.save(slam_map)
    return CameraPoses(
        found.measurements,
        recording.frames.time_ns,
        np.full(len(found.measurements), np.nan),
        "slam",
        f"tracked by visual SLAM {'in a saved map, ' if recording.slam_map else ''}{found.account}",
        slam_map=slam_map,
        points=found.points,
        metric=found.metric,
        metres_a_unit=found.metres_a_unit,
        scale_sigma=found.scale_sigma,
        seconds=found.seconds,
    )


def _simulated(
    recording: Recording, *, rate_hz: float, sigma_m: float, sigma_rad: float, seed: int
) -> CameraPoses:
    if recording.truth is None:
        raise ValueError(f"{recording.name}: no truth to simulate camera poses from")
    simulated = simulate_camera_poses(
        recording.truth, rate_hz, sigma_m, sigma_rad, np.random.default_rng(seed)
    )
    return CameraPoses(
        simulated,
        simulated.trajectory.time_ns,
        np.full(len(simulated), np.nan),
        "simulated",
        "simulated from the truth, with noise",
    )


def _without(found: CameraPoses, spans: FloatArray) -> CameraPoses:
    """The poses less those measured within the spans, counted from the first stamp sought."""
    seen = ~_inside(found.measurements.trajectory.time_ns, spans, int(found.sought_ns[0]))
    if not np.any(seen):
        raise ValueError("camera_poses.blackouts_s: no measured pose is left; shorten the spans")
    left = PoseMeasurements(
        found.measurements.trajectory[seen], found.measurements.covariance[seen]
    )
    return replace(found, measurements=left, reprojection_px=found.reprojection_px[seen])


def _spans(blackouts_s: tuple[float, ...]) -> FloatArray:
    if len(blackouts_s) % 2:
        raise ValueError(
            f"camera_poses.blackouts_s: expected start, end pairs, came {len(blackouts_s)} numbers"
        )
    spans = np.array(blackouts_s, dtype=np.float64).reshape(-1, 2)
    if np.any(spans[:, 1] <= spans[:, 0]):
        raise ValueError("camera_poses.blackouts_s: expected every end after its start")
    return spans


def _inside(time_ns: IntArray, spans: FloatArray, first_ns: int) -> NDArray[np.bool_]:
    seconds = (time_ns - first_ns) * 1e-9
    inside = np.zeros(seconds.shape, dtype=np.bool_)
    for start, end in spans:
        inside |= (seconds >= start) & (seconds < end)
    return inside
