"""Everything that a report tells of: the outputs of a run's stages, in one value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.replays.recording import Recording
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.convergence import Convergence
from motorcade.replays.values.errors import PathErrors
from motorcade.replays.values.imu import UsedImu
from motorcade.replays.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.values.view import OverlayVideo, PlacedCharacter

Spans = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Findings:
    """Stage outputs under their stages' names; `overlay` is None where nothing could be drawn."""

    recording: Recording
    camera_poses: CameraPoses
    imu: UsedImu
    fused: FusedPath
    smoothed: SmoothedPaths
    convergence: Convergence
    errors: PathErrors
    placed: PlacedCharacter
    overlay: OverlayVideo | None

    @property
    def frames_per_second(self) -> float | None:
        """Rate of tracking, reading included; None where nothing was tracked."""
        poses = self.camera_poses
        return len(poses.frame_times_ns) / poses.seconds if poses.seconds > 0 else None

    @property
    def nis_per_dimension(self) -> float | None:
        """Mean normalised innovation squared over its 6 dimensions: 1 where the noise fits.

        None without a filter, and where the IMU was simulated along the tracked path, which it
        then foretells.
        """
        if self.imu.origin == "tracked":
            return None
        nis = self.fused.nis[np.isfinite(self.fused.nis)]
        return float(np.mean(nis)) / 6 if nis.size else None

    def unmeasured_spans_s(self) -> Spans:
        """Where a pose was looked for and none was found: from the last one before to the next one.

        Seconds after the first measured pose.
        """
        times_ns = self.camera_poses.frame_times_ns
        stamps = self.camera_poses.measurements.trajectory.time_ns
        missing = ~np.isin(times_ns, stamps)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
        seconds = (times_ns - stamps[0]) * 1e-9
        last = len(times_ns) - 1
        return tuple(
            (float(seconds[max(first - 1, 0)]), float(seconds[min(end, last)]))
            for first, end in zip(edges[::2], edges[1::2], strict=True)
        )

    def worst_m(self, path: str, span_s: tuple[float, float]) -> float | None:
        """Largest position error of a path within a span; None without a ground truth there."""
        series = self.errors.against_truth.get(path)
        if series is None:
            return None
        inside = (series.time_s >= span_s[0]) & (series.time_s <= span_s[1])
        return float(series.position_m[inside].max()) if np.any(inside) else None
