"""Stage `camera_poses`: where the camera was, by its board, by SLAM, or simulated."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.fusion.simulate_poses import simulate_camera_poses
from motorcade.ga import FloatArray, IntArray
from motorcade.replays.artifacts import ASIDE, new_file
from motorcade.replays.progress import track
from motorcade.replays.recording import Recording
from motorcade.replays.stages.slam_poses import slam_poses
from motorcade.tracking import PoseMeasurements, track_board

Origin = Literal["board", "slam", "simulated"]


@dataclass(frozen=True)
class CameraPoses:
    """Measured poses `world_T_camera`, and every stamp at which one was sought.

    `reprojection_px` (N,) belongs to the measurements; it is NaN where nothing was reprojected.
    `board_track` holds the corners and both planar candidates of every frame (read it with
    `tracking.BoardTrack.load`); simulated poses have none. `seconds` is what tracking took,
    reading and decoding the images included. `metric` is False where the unit of length is free
    (SLAM by one camera alone).
    """

    measurements: PoseMeasurements
    sought_ns: IntArray
    reprojection_px: FloatArray
    origin: Origin
    board_track: Path | None
    seconds: float = field(metadata=ASIDE)
    metric: bool = True


def camera_poses(
    recording: Recording,
    *,
    source: Literal["auto", "board", "slam", "simulated"] = "auto",
    rate_hz: float = 20.0,
    sigma_m: float = 0.01,
    sigma_deg: float = 0.5,
    blackouts_s: tuple[float, ...] = (),
    seed: int = 0,
) -> CameraPoses:
    """Track the recording's board; where it has none, simulate measurements from its truth.

    `source=slam` needs neither: the world is then the first camera that has a pose.

    `rate_hz`, `sigma_m` and `sigma_deg` (an axis) and `seed` shape the simulation. `blackouts_s`
    (start, end, start, end, … in seconds after the first stamp) are spans in which no pose is
    measured, whatever the source. Raises ValueError where the recording has neither.
    """
    spans = _spans(blackouts_s)
    if source == "board" or (source == "auto" and recording.board is not None):
        return _tracked(recording, spans)
    if source == "slam":
        return _mapped(recording, spans)
    if recording.truth is None:
        raise ValueError(
            f"{recording.name}: no board to track and no truth to simulate poses from; "
            "describe the board in a manifest ([board] type = ...), or set camera_poses.source=slam"
        )
    simulated = simulate_camera_poses(
        recording.truth, rate_hz, sigma_m, np.deg2rad(sigma_deg), np.random.default_rng(seed)
    )
    sought = simulated.trajectory.time_ns
    seen = ~_inside(sought, spans)
    nothing_reprojected = np.full(np.count_nonzero(seen), np.nan)
    return CameraPoses(
        _chosen(simulated, seen), sought, nothing_reprojected, "simulated", None, seconds=0.0
    )


def _tracked(recording: Recording, spans: FloatArray) -> CameraPoses:
    if recording.board is None or recording.camera is None:
        missing = "camera" if recording.camera is None else "board"
        raise ValueError(f"{recording.name}: no {missing} known; describe it in a manifest")
    frames = recording.frames
    start = time.perf_counter()
    tracked = track_board(
        ((frame.time_ns, frame.gray()) for frame in track(frames, "tracking", len(frames))),
        recording.camera,
        recording.board,
    )
    seconds = time.perf_counter() - start
    on_board = tracked.measurements
    seen = ~_inside(on_board.trajectory.time_ns, spans)
    in_world = PoseMeasurements(
        on_board.trajectory.transformed_by(left=recording.world_T_board), on_board.covariance
    )
    board_track = new_file("board_track.npz")
    tracked.save(board_track)
    return CameraPoses(
        _chosen(in_world, seen),
        frames.time_ns,
        tracked.error_px[seen],
        "board",
        board_track,
        seconds,
    )


def _mapped(recording: Recording, spans: FloatArray) -> CameraPoses:
    found = slam_poses(recording)
    seen = ~_inside(found.measurements.trajectory.time_ns, spans)
    return CameraPoses(
        _chosen(found.measurements, seen),
        recording.frames.time_ns,
        np.full(np.count_nonzero(seen), np.nan),
        "slam",
        None,
        found.seconds,
        found.metric,
    )


def _chosen(measurements: PoseMeasurements, seen: NDArray[np.bool_]) -> PoseMeasurements:
    if not np.any(seen):
        raise ValueError("camera_poses.blackouts_s: no measured pose is left; shorten the spans")
    return PoseMeasurements(measurements.trajectory[seen], measurements.covariance[seen])


def _spans(blackouts_s: tuple[float, ...]) -> FloatArray:
    if len(blackouts_s) % 2:
        raise ValueError(
            f"camera_poses.blackouts_s: expected start, end pairs, came {len(blackouts_s)} numbers"
        )
    spans = np.array(blackouts_s, dtype=np.float64).reshape(-1, 2)
    if np.any(spans[:, 1] <= spans[:, 0]):
        raise ValueError("camera_poses.blackouts_s: expected every end after its start")
    return spans


def _inside(time_ns: IntArray, spans: FloatArray) -> NDArray[np.bool_]:
    seconds = (time_ns - time_ns[0]) * 1e-9
    inside = np.zeros(seconds.shape, dtype=np.bool_)
    for start, end in spans:
        inside |= (seconds >= start) & (seconds < end)
    return inside
