"""The paths as they are drawn: beside the ground truth, in its time, and with up at the top."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.fusion.metrics import alignment_of, associate
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.report.findings import Findings

__all__ = ["Drawn", "as_drawn", "map_unit"]


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
