"""Layers: poses over one another with weights, masks of joints, and additive poses on top.

What a runtime blends: several layers by weight (each joint by itself where a layer has a mask),
down to the rest pose where hardly anything weighs on a joint, then what is to be added. A cycle
that does not quite close is closed by an additive pose as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from motorcade.animation.blend.methods import BlendMethod, Poses, blend_poses, stacked
from motorcade.animation.clip import Clip
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen


@dataclass(frozen=True, eq=False)
class PoseLayer:
    """A pose that takes part in a blend.

    Args:
        pose: local poses ``(*, J)``; of an additive layer what `additive` gives.
        weight: its share beside the other layers', not negative.
        mask: ``(J,)`` factors on the weight, 0 to 1 a joint; None for the whole body.

    Raises:
        ValueError: a weight that is negative or not finite, a mask out of range or of another
            number of joints.

    >>> from motorcade.animation import PoseLayer, blend_layers
    >>> from motorcade.ga import Motor
    >>> rest = Motor.identity((2,))
    >>> lifted = Motor.from_translation([[0, 0, 1.0], [0, 0, 1.0]])
    >>> arm_alone = PoseLayer(lifted, mask=[0.0, 1.0])
    >>> blend_layers([arm_alone], rest).translation_m + 0.0
    array([[0., 0., 0.],
           [0., 0., 1.]])
    """

    pose: Poses
    weight: float = 1.0
    mask: FloatArray | None = None

    def __post_init__(self) -> None:
        if not self.pose.shape:
            raise ValueError("PoseLayer.pose: expected shape (*, J), got ()")
        if not (np.isfinite(self.weight) and self.weight >= 0.0):
            raise ValueError(f"PoseLayer.weight: expected a number from 0 up, got {self.weight}")
        if self.mask is None:
            return
        mask = checked_floats(self.mask, "PoseLayer.mask", ())
        if mask.shape != self.pose.shape[-1:] or mask.min() < 0.0 or mask.max() > 1.0:
            raise ValueError(
                f"PoseLayer.mask: expected {self.pose.shape[-1]} factors from 0 to 1, got shape "
                f"{mask.shape} from {mask.min(initial=0):g} to {mask.max(initial=0):g}"
            )
        object.__setattr__(self, "mask", frozen(mask))

    @property
    def joint_weights(self) -> FloatArray:
        """The weight of every joint ``(J,)``."""
        mask = np.ones(self.pose.shape[-1]) if self.mask is None else self.mask
        return self.weight * mask


def blend_layers(
    layers: Sequence[PoseLayer],
    rest: Motor,
    *,
    additive_layers: Sequence[PoseLayer] = (),
    method: BlendMethod = "motor",
    threshold: float = 0.1,
) -> Poses:
    """Blend layers joint by joint, then add the additive ones in their order.

    Args:
        layers: poses of the same J joints; none gives the rest pose.
        rest: Motor ``(J,)``, local rest pose.
        additive_layers: differences, each added by its weight along the screw.
        method: see `motorcade.animation.blend.methods`.
        threshold: where the weights on a joint sum to less than this, the rest pose makes up for
            what is missing, so that a layer fades in and out without a jump.

    Returns:
        local poses ``(*, J)``.

    Raises:
        ValueError: another number of joints, a threshold that is not positive, or what
            `blend_poses` refuses.

    >>> from motorcade.animation import PoseLayer, blend_layers
    >>> from motorcade.ga import Motor
    >>> rest = Motor.identity((2,))
    >>> low, high = (Motor.from_translation([[0, 0, z]] * 2) for z in (0.2, 1.0))
    >>> both = [PoseLayer(low, weight=1.0), PoseLayer(high, weight=3.0)]
    >>> blend_layers(both, rest).translation_m[:, 2].round(6)
    array([0.8, 0.8])
    >>> raised = blend_layers(both, rest, additive_layers=[PoseLayer(low, mask=[0.0, 1.0])])
    >>> raised.translation_m[:, 2].round(6)
    array([0.8, 1. ])
    """
    checked_positive(threshold, "blend_layers(threshold)")
    for layer in (*layers, *additive_layers):
        if layer.pose.shape[-1:] != rest.shape:
            raise ValueError(
                f"blend_layers: expected poses of {rest.shape} joints as the rest pose has, got "
                f"{layer.pose.shape}"
            )
    # A layer of no weight would still lend the blend its signs.
    present = [layer for layer in layers if np.any(layer.joint_weights > 0.0)]
    weights = [layer.joint_weights for layer in present]
    missing = np.maximum(0.0, threshold - np.sum(weights, axis=0)) if weights else np.ones(1)
    poses: list[Poses] = [layer.pose for layer in present]
    if np.any(missing > 0.0):
        poses, weights = [*poses, rest], [*weights, np.broadcast_to(missing, rest.shape)]
    blended = blend_poses(stacked(poses), np.stack(weights), method)
    for layer in additive_layers:
        blended = added(blended, layer.pose, layer.joint_weights)
    return blended


def additive(pose: Poses, reference: Poses) -> Poses:
    """What a pose adds to a reference, in each joint's own axes: ``~reference pose``."""
    base, other = _alike(reference, pose)
    return base.inverse() @ other


def added(base: Poses, difference: Poses, weights: FloatArray | float = 1.0) -> Poses:
    """A base with a share of a difference on top, ``base difference^weight``, along the screw.

    Args:
        base: poses ``(*, J)``.
        difference: poses ``(*, J)``, from `additive`.
        weights: a number or one a joint; 1 adds all of it, negative ones take it away.
    """
    share = checked_floats(weights, "added(weights)", ())
    first, other = _alike(base, difference)
    return first @ type(other).exp(share[..., None] * other.log())


def _alike(first: Poses, second: Poses) -> tuple[Motor, Motor]:
    """Both of one type. (The verbs used on them are those that motors and similarities share.)"""
    pair = stacked([first, second])
    return cast(Motor, pair[..., 0, :]), cast(Motor, pair[..., 1, :])


def closed(clip: Clip, tolerance: float = 0.1) -> Clip:
    """The clip as a loop: what its last pose lacks to the first is spread over the cycle.

    Exported cycles rarely close to rounding. Split root motion off first: a walk that travels
    does not end where it began.

    Args:
        clip: of two poses or more.
        tolerance: the largest gap of a joint, in metres and radians, that is spread.

    Raises:
        ValueError: a single pose, or a gap beyond the tolerance; the message names it.
    """
    if len(clip.time_s) < 2:
        raise ValueError(f"closed: expected two poses or more, got one in '{clip.name}'")
    if clip.looped:
        return clip
    gap = additive(clip.poses[0], clip.poses[-1])
    size = np.abs(gap.as_twist()).max(axis=-1)
    worst = int(np.argmax(size))
    if size[worst] > tolerance:
        raise ValueError(
            f"closed: expected '{clip.name}' to end within {tolerance:g} m and rad of its start, "
            f"got {size[worst]:.3g} at joint {worst}"
        )
    passed = (clip.time_s - clip.time_s[0]) / clip.duration_s
    poses = added(clip.poses, gap, np.repeat(passed[:, None], clip.poses.shape[1], axis=1))
    coefficients = poses.coefficients.copy()
    coefficients[-1] = coefficients[0]
    return replace(clip, poses=type(poses)(coefficients), looped=True)
