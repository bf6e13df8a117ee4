"""What a report tells of: outputs of a run's stages in one value, and its paths as drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import Integrity, PathErrors
from motorcade.replays.stages.values.inertial import Convergence, UsedImu
from motorcade.replays.stages.values.paths import FusedPath, SmoothedPaths
from motorcade.replays.stages.values.view import OverlayVideo, PlacedCharacter

LABELS = {
    "measured": "Measured",
    "fused": "Fused",
    "truth": "Ground truth",
    "motor": "Smoothed, motors",
    "similarity": "Smoothed, similarities",
    "rotor": "Smoothed, rotors",
    "dual_quaternion": "Smoothed, dual quaternions",
    "quaternion": "Smoothed, quaternions",
    "euler": "Smoothed, Euler angles",
    "euler_unwrapped": "Smoothed, Euler angles unwrapped",
}
"""Paths in words."""

ALIKE_DEG, ALIKE_M, ALIKE_SHARE = 0.01, 1e-4, 1e-4
"""Paths are alike that are nowhere farther apart than so many degrees and, in metres or as a share
of how far the path reaches, so much: a tenth of a pixel for most cameras, which nobody sees."""

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

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is not sure of the recording, and of what the character stands on."""
        standing = (self.placed.doubt,) if self.placed.doubt else ()
        film = self.overlay
        seen = () if film is None else film.checks
        drawn = [doubt for one in seen if film for doubt in one.doubts(film.height_px)]
        return (*self.recording.doubts, *standing, *drawn)

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


def told_paths(findings: Findings) -> dict[str, str]:
    """Paths that are worth telling apart, in order, each by its name in words.

    Of representations whose paths are alike, the first stands for all. The fused path is left out
    where nothing was fused, or where it was not smoothed any further.
    """
    smoothed, fused = findings.smoothed, findings.fused.by != "nothing"
    labels = {"measured": LABELS["measured"]}
    if fused and smoothed.method is not None:
        labels["fused"] = LABELS["fused"]
    groups = alike(smoothed, metric=findings.camera_poses.metric)
    for first, names in groups.items():
        labels[first] = _label(names)
    if len(groups) == 1:
        left = "Fused, not smoothed further" if fused else "Not smoothed: as measured"
        labels[next(iter(groups))] = "Smoothed" if smoothed.method is not None else left
    return labels


def _label(names: tuple[str, ...]) -> str:
    first, *others = (LABELS.get(name, f"Smoothed, {name.replace('_', ' ')}") for name in names)
    shorter = [one.removeprefix("Smoothed, ") for one in others]
    if not shorter:
        return first
    return ", ".join([first, *shorter[:-1]]) + f" and {shorter[-1]}"


def alike(smoothed: SmoothedPaths, *, metric: bool) -> dict[str, tuple[str, ...]]:
    """Representations by the first of those whose paths nobody could tell from theirs."""
    groups: dict[str, tuple[str, ...]] = {}
    for name, path in smoothed.trajectories.items():
        for first in groups:
            if _is_alike(smoothed.trajectories[first], path, metric):
                groups[first] = (*groups[first], name)
                break
        else:
            groups[name] = (name,)
    return groups


def _is_alike(trajectory: Trajectory, other: Trajectory, metric: bool) -> bool:
    if not np.array_equal(trajectory.time_ns, other.time_ns):
        return False
    apart = trajectory.motors.inverse() @ other.motors
    reach = float(np.linalg.norm(np.ptp(trajectory.motors.translation_m, axis=0)))
    limit = max(ALIKE_SHARE * reach, ALIKE_M if metric else 0.0)
    turned = np.rad2deg(np.linalg.norm(apart.rotor.as_rotation_vector(), axis=-1))
    moved = np.linalg.norm(apart.translation_m, axis=-1)
    return bool(turned.max() <= ALIKE_DEG and moved.max() <= limit)


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
