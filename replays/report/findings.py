"""What a report tells of: outputs of a run's stages in one value, and its paths as drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.recording import Recording
from motorcade.replays.values.camera_poses import CameraPoses
from motorcade.replays.values.convergence import Convergence
from motorcade.replays.values.errors import PathErrors
from motorcade.replays.values.imu import UsedImu
from motorcade.replays.values.integrity import Integrity
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
    integrity: Integrity
    convergence: Convergence
    errors: PathErrors
    placed: PlacedCharacter
    overlay: OverlayVideo | None

    @property
    def nis_per_dimension(self) -> float | None:
        """Mean normalised innovation squared over its 6 dimensions: 1 where the noise fits.

        None without a filter.
        """
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


@dataclass(frozen=True)
class Drawn:
    """Paths in one frame whose z is up, the unit of their lengths, and which up was taken."""

    paths: dict[str, Trajectory]
    unit: str
    note: str


def map_unit(findings: Findings) -> str:
    """What lengths of the tracked path are in."""
    return "m" if findings.camera_poses.metric else "units"


def as_drawn(findings: Findings, paths: dict[str, Trajectory]) -> Drawn:
    """Paths in the ground truth's world, aligned as the first path's errors are; z upwards.

    The ground truth is taken from the first to the last stamp at which a pose was looked for. The
    world of SLAM may be the first camera's, whose z looks ahead: there, up is the normal of what
    the character stands on, and all is turned about the origin by the least rotation that takes it
    to z. Elsewhere z of the world is up.
    """
    poses, truth = findings.camera_poses, findings.recording.truth
    up = findings.placed.placement.world_T_character.rotor.apply([0.0, 0.0, 1.0])
    unit = map_unit(findings)
    if truth is not None:
        fit = alignment_of(associate(next(iter(paths.values())), truth), findings.errors.align)
        paths = {name: fit.apply_to(one) for name, one in paths.items()}
        up = fit.rotor.apply(up)
        times_ns = poses.frame_times_ns
        inside = (truth.time_ns >= times_ns.min()) & (truth.time_ns <= times_ns.max())
        if np.any(inside):
            paths = paths | {"truth": truth[inside]}
        unit = "m"
    if poses.origin != "slam":
        return Drawn(paths, unit, "Up is z of the world.")
    turn = Motor.from_rotor_translation(_to_z(up), np.zeros(3))
    turned = {name: one.transformed_by(left=turn) for name, one in paths.items()}
    return Drawn(turned, unit, f"Up is the normal of {findings.placed.stands_on}.")


def _to_z(up: FloatArray) -> Rotor:
    """The least rotation that takes a direction ``(3,)`` to z; about x where it points down."""
    up = up / np.linalg.norm(up)
    axis = np.array([up[1], -up[0], 0.0])  # up x z
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    return Rotor.from_rotation_vector(float(np.arctan2(sine, up[2])) * axis)
