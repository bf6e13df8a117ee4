"""Clips sampled so finely that screws between samples follow what the file means.

Between keys files interpolate turns and translations apart, or angles, or curves; a `Clip`
follows the screw. Where the two would part by more than a share of the figure's height, samples
are set between the keys.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.formats.limits import MAX_POSES, FormatError
from motorcade.animation.formats.rig.joints import JointPoses, Joints, World, joint_poses
from motorcade.animation.formats.rig.values import JUMP_S, NodeTree, RigClip, Transforms
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.classical.quaternion import quaternion_slerp

PARTING_TOLERANCE = 1e-5
"""How far screws and the file may part between samples, as a share of the figure's height."""
MOST_PARTS = 256


@dataclass(frozen=True, eq=False)
class Sampled:
    """Clips of one rig, sampled one after the other.

    Args:
        times: for each clip its (F,) seconds.
        poses: of all clips, in the same order.
        starts: (C + 1,) where each clip begins among the poses.
    """

    times: list[FloatArray]
    poses: JointPoses
    starts: IntArray


@dataclass(frozen=True, eq=False)
class Sampler:
    """Samples clips on the nodes of one rig.

    Args:
        height_m: of the figure; tolerances are shares of it.
        watched: (J,) whether a joint carries anything: controls that carry nothing may part
            further.
    """

    tree: NodeTree
    joints: Joints
    world: World
    height_m: float
    watched: NDArray[np.bool_]

    def __call__(self, clips: tuple[RigClip, ...]) -> Sampled:
        """Sample at the keys, then between them where that is needed.

        Raises FormatError: no clips, or more poses than the limit.
        """
        times = [clip.key_times for clip in clips]
        poses = self._poses(clips, times)
        starts = np.cumsum([0, *map(len, times)])
        tolerance = PARTING_TOLERANCE * self.height_m
        parts = self._parts(clips, times, poses, starts, tolerance)
        if parts.max(initial=1) == 1:
            return Sampled(times, poses, starts)
        finer = [
            divided(at, parts[start : start + len(at) - 1])
            for at, start in zip(times, starts, strict=False)
        ]
        self._check(finer)
        whole = _straight(poses, parts)
        ends = np.cumsum([0, *map(len, finer)])
        for number in self._curved(clips):
            if len(finer[number]) == len(times[number]):
                continue
            own = self._poses((clips[number],), [finer[number]])
            where = slice(ends[number], ends[number + 1])
            whole.wxyz[where], whole.translation_m[where] = own.wxyz, own.translation_m
            whole.scale[where] = own.scale
        return Sampled(finer, whole, ends)

    def _curved(self, clips: tuple[RigClip, ...]) -> list[int]:
        """Clips whose joints do not go straight between keys."""
        curved = []
        long = [chain for chain in self.joints.chains if len(chain) > 1]
        for number, clip in enumerate(clips):
            moving = set(clip.nodes.tolist())
            if not clip.straight or any(len(moving.intersection(chain)) > 1 for chain in long):
                curved.append(number)
        return curved

    def _parts(
        self,
        clips: tuple[RigClip, ...],
        times: list[FloatArray],
        poses: JointPoses,
        starts: IntArray,
        tolerance: float,
    ) -> IntArray:
        """Into how many parts (F,) the step after each sample must go; 1 at the ends of clips."""
        parts = np.ones(len(poses.scale), dtype=np.int64)
        if len(parts) > 1:
            for held, allowed in ((self.watched, tolerance), (~self.watched, 4.0 * tolerance)):
                some = np.flatnonzero(held)
                own = parts_of_steps(
                    poses.wxyz[:, some],
                    poses.translation_m[:, some],
                    poses.scale[:, some],
                    self.height_m,
                    allowed,
                )
                np.maximum(parts[:-1], own, out=parts[:-1])
        for number in self._curved(clips):
            if len(times[number]) > 1:
                where = slice(starts[number], starts[number + 1] - 1)
                parts[where] = self._measured(clips[number], times[number], tolerance)
        brief = np.diff(np.concatenate(times)) <= 2.0 * JUMP_S
        parts[:-1][brief] = 1
        parts[starts[1:] - 1] = 1
        return parts

    def _measured(self, clip: RigClip, times: FloatArray, tolerance: float) -> IntArray:
        """Parts (F - 1,) for each step, from how far quarters of it lie off screws and even growth.

        The middle alone would not tell: a curve that eases in and out crosses the screw there;
        see `_bulge` for the rest of it.
        """
        shares = np.arange(4) / 4.0
        inside = (times[:-1, None] + np.diff(times)[:, None] * shares).reshape(-1)
        poses = self._poses((clip,), [np.concatenate([inside, times[-1:]])])
        motors = poses.motors()[:, self.watched]
        steps = motors[:-1].reshape(len(times) - 1, 4, motors.shape[1])
        screw = motors[:-1:4].interpolate(motors[4::4], shares[1:, None, None])
        off = screw.inverse() @ Motor(np.moveaxis(steps.coefficients[:, 1:], 1, 0))
        shift = 2.0 * off.log()
        apart = _bulge(shift[..., :3]) * self.height_m + _bulge(shift[..., 3:])
        growth = np.log(np.abs(poses.scale[:, self.watched]))
        if np.ptp(growth, axis=0).max(initial=0.0) > 1e-4:
            even = growth[:-1:4] + shares[1:, None, None] * (growth[4::4] - growth[:-1:4])
            inside = np.moveaxis(growth[:-1].reshape(len(times) - 1, 4, -1)[:, 1:], 1, 0)
            apart += _bulge((inside - even)[..., None]) * self.height_m
        return _parts_for(apart.max(axis=-1, initial=0.0), tolerance)

    def _check(self, times: list[FloatArray]) -> None:
        total = sum(map(len, times))
        if total * len(self.tree.names) > MAX_POSES:
            raise FormatError(
                f"animations: expected at most {MAX_POSES} samples times nodes, got "
                f"{total} times {len(self.tree.names)}"
            )

    def _poses(self, clips: tuple[RigClip, ...], times: list[FloatArray]) -> JointPoses:
        """Poses of all clips at their times, computed together."""
        self._check(times)
        nodes = Transforms.concatenate([clip.at(at) for clip, at in zip(clips, times, strict=True)])
        return joint_poses(self.tree, self.joints, nodes, self.world)


def parts_of_steps(
    wxyz: FloatArray,
    translation_m: FloatArray,
    scale: FloatArray,
    reach_m: float,
    tolerance: float,
) -> IntArray:
    """Into how many parts (F - 1,) steps between poses (F, J) must go.

    A screw that turns by θ while it moves by d leaves the straight line by d θ / 8 at most, and
    even growth by a factor e^λ leaves a line by λ² / 8 of the reach; n parts divide both by n².
    """
    cosine = np.abs(np.einsum("fji,fji->fj", wxyz[1:], wxyz[:-1]))
    step = np.diff(translation_m, axis=0)
    # d² θ² with θ² < 9.9 (1 - cos(θ/2)) up to θ = π.
    squares = np.einsum("fji,fji->fj", step, step) * 9.9 * (1.0 - np.minimum(cosine, 1.0))
    apart = np.sqrt(squares.max(axis=-1, initial=0.0))
    growth = np.diff(np.log(np.abs(scale)), axis=0)
    if np.abs(growth).max(initial=0.0) > 1e-4:
        lengths = np.sqrt(np.einsum("fji,fji->fj", step, step))
        apart += ((reach_m * np.abs(growth) + lengths) * np.abs(growth)).max(axis=-1)
    return _parts_for(apart / 8.0, tolerance)


def divided(times: FloatArray, parts: IntArray) -> FloatArray:
    """Times (F,) with every step divided into so many (F - 1,) equal parts."""
    step = np.repeat(np.diff(times) / parts, parts)
    first = np.repeat(times[:-1], parts)
    return np.concatenate([first + _counts(parts) * step, times[-1:]])


def _straight(poses: JointPoses, parts: IntArray) -> JointPoses:
    """Poses with steps divided: great arcs of turns, lines of translations and scales."""
    before = np.repeat(np.arange(len(parts)), parts)
    counts = _counts(parts)
    wxyz, places = poses.wxyz[before], poses.translation_m[before]
    scale = poses.scale[before]
    new = np.flatnonzero(counts)
    start, end = before[new], before[new] + 1
    share = (counts[new] / parts[start])[:, None]
    wxyz[new] = quaternion_slerp(poses.wxyz[start], poses.wxyz[end], share)
    places[new] += share[..., None] * (poses.translation_m[end] - places[new])
    scale[new] += share * (poses.scale[end] - scale[new])
    return JointPoses(wxyz, places, scale, None)


def _bulge(off: FloatArray) -> FloatArray:
    """How far (*) a curve leaves the line between its ends, by how far quarters (3, *, n) do.

    Parts of a step leave theirs by less as the square of their number. So does a parabola; of a
    cubic u (1 - u) (a + b u), which eases in and out, the parts at its ends bend most: they leave
    theirs by an eighth of its second derivative there.
    """
    b = 32.0 / 3.0 * (off[2] - off[0])
    a = 16.0 / 3.0 * off[0] - 0.25 * b
    ends = [np.linalg.norm(one, axis=-1) for one in (2.0 * a - 2.0 * b, 2.0 * a + 4.0 * b)]
    seen = np.linalg.norm(off, axis=-1).max(axis=0)
    return np.asarray(np.maximum(seen, 0.125 * np.maximum(*ends)))


def _counts(parts: IntArray) -> IntArray:
    """0, 1, ... up to each number of parts, one after the other."""
    return np.arange(int(parts.sum())) - np.repeat(np.cumsum(parts) - parts, parts)


def _parts_for(apart: FloatArray, tolerance: float) -> IntArray:
    wanted = np.ceil(np.sqrt(apart / max(tolerance, 1e-12)))
    return np.clip(wanted, 1, MOST_PARTS).astype(np.int64)
