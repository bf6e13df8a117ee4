"""What a figure stands on: its soles in the bind pose, and the height on which its clips stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.formats.rig.binding import Binding
from motorcade.animation.formats.rig.joints import JointPoses
from motorcade.animation.formats.rig.stance import Stance
from motorcade.animation.formats.rig.surfaces import BoundMesh
from motorcade.animation.formats.rig.transforms import scaled_matrices
from motorcade.animation.formats.rig.values import Rig
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import turn_z, unit
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray

# Of a foot's vertices the lowest so many are sole enough to find the ground by.
SOLE_VERTICES = 100
FEWEST_VERTICES = 3
# The share of a clip's moments, the lowest, below which its feet are taken to stand.
LOW_SHARE = 0.1
# Heights that differ by less, as a share of the figure's, are one ground; clips farther off fly.
ONE_GROUND, FLYING = 0.01, 0.25
# Joints of soles lie over them: only clips farther off their file's zero are put on the ground.
IN_THE_AIR = 0.03
# The trunk and the legs of a rest in which one can stand, against up.
UPRIGHT = np.cos(np.radians(50.0))


@dataclass(frozen=True, eq=False)
class Soles:
    """Vertices of the feet, or of the whole mesh where no feet are known.

    Args:
        bound_m: height of the lowest in the bind pose, not lifted.
        rows: their numbers.
        mesh, binding, stage: of the figure.
        settled: whether the bind pose is known to stand where clips do.
    """

    bound_m: float
    rows: IntArray
    mesh: BoundMesh
    binding: Binding
    stage: Stance
    settled: bool = False

    @staticmethod
    def of(stage: Stance, mesh: BoundMesh, binding: Binding, settled: bool = False) -> Soles:
        """The vertices that mostly follow feet or toes (of an animal, forefeet too)."""
        heaviest = mesh.joints[np.arange(len(mesh.joints)), np.argmax(mesh.weights, axis=1)]
        found: list[IntArray] = []
        for foot in _feet(stage):
            below = _below(stage, foot)
            rows = np.flatnonzero(below[heaviest])
            if len(rows) < FEWEST_VERTICES:
                found = []
                break
            found.append(rows[np.argsort(mesh.vertices[rows, 2], kind="stable")[:SOLE_VERTICES]])
        if found:
            rows = np.concatenate(found)
            lowest = float(mesh.vertices[rows, 2].min())
            return Soles(lowest, rows, mesh, binding, stage, settled)
        rows = np.argsort(mesh.vertices[:, 2], kind="stable")[:SOLE_VERTICES]
        return Soles(float(mesh.vertices[:, 2].min()), rows, mesh, binding, stage, settled)

    def heights(self, poses: JointPoses) -> FloatArray:
        """Height (F,) of the lowest of the vertices, skinned linearly, in the file's own world."""
        joints = self.stage.joints
        skeleton = Skeleton(joints.names, joints.parents, poses.motors()[0])
        growth = np.abs(poses.scale / self.binding.scale)
        world = scaled_matrices(skeleton.world(poses.motors()), growth)
        rows = (world @ self.binding.world.inverse().as_matrix())[:, :, 2]
        each = rows[:, self.mesh.joints[self.rows]]
        vertices = self.mesh.vertices[self.rows]
        heights = np.einsum("fvki,vi->fvk", each[..., :3], vertices) + each[..., 3]
        lowest: FloatArray = np.sum(heights * self.mesh.weights[self.rows], axis=2).min(axis=1)
        return lowest

    def ground_m(
        self, found: JointPoses, clips: list[JointPoses], height_m: float
    ) -> tuple[float, list[str]]:
        """Height of the ground in the file's world, and a notice where clips tell another.

        Clips tell, where most of them stand on one height; else the bind pose, or the pose in
        which the nodes stand if that is another.

        Args:
            found: the nodes' pose (1, J).
            clips: some poses (F, J) of each.
            height_m: of the figure.
        """
        own = self.bound_m
        if not self.binding.agrees or float(self.stage.axes.standing.angle()) > 0.0:
            own = float(self.heights(found)[0])
        levels = [float(np.quantile(self.heights(one), LOW_SHARE)) for one in clips]
        if self.binding.agrees:
            levels = [one for one in levels if abs(one - own) < FLYING * height_m]
        if not levels or self.settled:
            return own, []
        near = [[b for b in levels if abs(b - a) <= ONE_GROUND * height_m] for a in levels]
        most = max(near, key=lambda one: (len(one), -abs(one[0] - own)))
        ground = float(np.median(most))
        if 2 * len(most) < len(levels) or (
            self.binding.agrees and abs(ground - own) <= ONE_GROUND * height_m
        ):
            return own, []
        if not self.binding.agrees:
            return ground, []
        return ground, [
            f"its clips stand {100.0 * (ground - own) / height_m:+.1f} % of its height over the "
            "soles of its bind pose: put on the ground by the clips"
        ]


def standing_joints_m(stage: Stance, rig: Rig, height_m: float) -> float:
    """Height on which the joints of feet stand in clips without a mesh; 0 where near zero."""
    feet = [joint for foot in _feet(stage) for joint in np.flatnonzero(_below(stage, foot))]
    lows = [
        np.quantile(_places(stage, one)[:, feet, 2].min(axis=1), LOW_SHARE)
        for one in (stage.seen(rig) if feet else [])
    ]
    lowest = float(np.median(lows)) if lows else 0.0
    return lowest if abs(lowest) > IN_THE_AIR * height_m else 0.0


def resting(stage: Stance, rig: Rig) -> tuple[Motor, list[str]]:
    """Motor (J,) `character_T_joint` of a rest pose to stand in, and a notice if it is a clip's."""
    joints = stage.joints
    skeleton = Skeleton(joints.names, joints.parents, stage.rest.motors()[0])
    turned = Motor.from_rotor_translation(stage.axes.standing, np.zeros(3)) @ skeleton.rest_world
    likeness = _standing_likeness(stage, turned.translation_m[None])
    if likeness is None or likeness[0] > UPRIGHT or not rig.clips:
        return turned, []
    best, most = None, -np.inf
    for poses in stage.seen(rig):
        world = skeleton.world(poses.motors())
        found = _standing_likeness(stage, world.translation_m)
        assert found is not None  # the same joints as above
        number = int(np.argmax(found))
        if found[number] > most:
            best, most = world[number], float(found[number])
    if best is None or most <= UPRIGHT:
        return turned, []
    across, _ = _across(stage, best.translation_m[None])
    heading = turn_z(np.arctan2(across[0, 0], across[0, 1]))
    foot = best.translation_m[stage.axes.body.roles["hips"]] * [1.0, 1.0, 0.0]
    made = Motor.from_rotor_translation(heading, -heading.apply(foot)) @ best
    return made, ["nobody can stand as its joints rest: a moment of its clips is its rest pose"]


def _standing_likeness(stage: Stance, at: FloatArray) -> FloatArray | None:
    """The least cosine (F,) of trunk and legs against up; None where they are not known."""
    evidence = stage.axes.body.evidence
    if evidence is None or evidence.legs is None or "hips" not in stage.axes.body.roles:
        return None
    if stage.axes.body.four_legged:
        return None
    _, trunk = evidence.axes(at)
    hip, knee, ankle = (at[:, joints] for joints in evidence.legs)
    parts = [trunk[:, None], unit(hip - knee), unit(knee - ankle)]
    made: FloatArray = np.concatenate([one[..., 2] for one in parts], axis=1).min(axis=1)
    return made


def _across(stage: Stance, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """From right to left, and along the trunk."""
    body = stage.axes.body
    assert body.evidence is not None  # looked at before
    across, trunk = body.evidence.axes(at)
    legs = body.evidence.legs
    first = legs is None or int(legs[0, 0]) == body.roles["left_thigh"]
    return across if first else -across, trunk


def _places(stage: Stance, poses: JointPoses) -> FloatArray:
    joints = stage.joints
    skeleton = Skeleton(joints.names, joints.parents, poses.motors()[0])
    made: FloatArray = skeleton.world(poses.motors()).translation_m
    return made


def _feet(stage: Stance) -> list[int]:
    body = stage.axes.body
    wanted = ["left_foot", "right_foot"]
    if body.four_legged:
        wanted += ["left_hand", "right_hand"]
    return [body.roles[role] for role in wanted if role in body.roles]


def _below(stage: Stance, joint: int) -> FloatArray:
    """Whether each joint (J,) is another or hangs below it."""
    made = np.zeros(len(stage.joints.nodes), dtype=bool)
    made[joint] = True
    for one, parent in enumerate(stage.joints.parents.tolist()):
        if parent >= 0:
            made[one] |= made[parent]
    return made
