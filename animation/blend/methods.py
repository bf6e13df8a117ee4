"""Ways to blend poses behind one interface, and layers of poses over one another.

Each takes K motors and their shares, and goes its own way through the algebra that it is named
after, there and back:

=========================  =========================================================================
``motor``                  CGA motors by logarithms (paper 4.7, 4.8): the screw, at constant speed
``motor_linear``           CGA motors summed and projected (paper 4.6)
``similarity``             similarities by logarithms: a spiral where a pose grows
``similarity_linear``      similarities summed and projected
``rotor``                  EGA rotors by logarithms beside weighted translations (paper 4.2)
``rotor_linear``           EGA rotors summed and normalised beside weighted translations
``dual_quaternion``        dual quaternions by logarithms (ScLERP; of more than two DIB)
``dual_quaternion_linear`` dual quaternions summed and normalised (DLB)
``quaternion``             slerp beside weighted translations (of more than two the mean rotation)
``quaternion_linear``      quaternions summed and normalised (nlerp) beside weighted translations
``euler``                  angles, intrinsic x-y'-z'', and translations summed as they are
=========================  =========================================================================

Theory predicts ties, which the tests hold: of rigid poses ``motor``, ``similarity`` and
``dual_quaternion`` are one blend, and so are the three linear ones; ``rotor`` and ``quaternion``
too, and their linear twins. All but ``euler`` go the short way round, signs taken from the first.
Sources: the paper, equations 4.2 to 4.8; Kavan, Collins, Zara, O'Sullivan (2007) for DLB and DIB.

What a runtime blends: several layers by weight (each joint by itself where a layer has a mask),
down to the rest pose where hardly anything weighs on a joint, then what is to be added. A cycle
that does not quite close is closed by an additive pose as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeVar, cast, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.clip import Clip
from motorcade.ga import (
    DualQuaternion,
    EulerPose,
    Motor,
    QuaternionPose,
    Similarity,
    Versor,
    blend,
    mean,
)
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen
from motorcade.ga.classical.dual_quaternion import dual_quaternion_mean
from motorcade.ga.classical.quaternion import quaternion_mean
from motorcade.ga.names import check_word

BlendMethod = Literal[
    "motor",
    "motor_linear",
    "similarity",
    "similarity_linear",
    "rotor",
    "rotor_linear",
    "dual_quaternion",
    "dual_quaternion_linear",
    "quaternion",
    "quaternion_linear",
    "euler",
]
BLEND_METHODS: tuple[BlendMethod, ...] = get_args(BlendMethod)

Poses = Motor | Similarity
V = TypeVar("V", bound=Versor)


@overload
def blend_poses(poses: Motor, weights: ArrayLike, method: BlendMethod = ...) -> Motor: ...


@overload
def blend_poses(poses: Similarity, weights: ArrayLike, method: BlendMethod = ...) -> Similarity: ...


def blend_poses(poses: Poses, weights: ArrayLike, method: BlendMethod = "motor") -> Poses:
    """Blend K poses of a skeleton's J joints.

    Args:
        poses: Motor or Similarity ``(*, K, J)``, local poses.
        weights: ``(*, K)``, or ``(*, K, J)`` for a share of every joint; not negative, and for
            every joint not all zero. Only their ratios count.
        method: one of `BLEND_METHODS`. Those of rigid poses blend the scale of similarities
            beside the rest, as one more number.

    Returns:
        ``(*, J)``, of the type given.

    Raises:
        ValueError: an unknown method, shapes that do not fit, weights that are negative, not
            finite or all zero, or poses that cancel (rotations half a turn apart under a
            linear method).

    >>> import numpy as np
    >>> from motorcade.animation import blend_poses
    >>> from motorcade.ga import Motor
    >>> heights = Motor.from_translation([[[0, 0, 1.0]], [[0, 0, 3.0]]])  # (K, J) = (2, 1)
    >>> blend_poses(heights, [0.25, 0.75]).translation_m + 0.0
    array([[0. , 0. , 2.5]])
    """
    check_word(method, BLEND_METHODS, "blend_poses(method)")
    shares = _shares(poses.shape, weights)
    # The K to blend over go last: (*, J, K).
    coefficients = np.swapaxes(poses.coefficients, -2, -3)
    if isinstance(poses, Motor):
        return _rigid(method, Motor(coefficients), shares)
    grown = Similarity(coefficients)
    if method in ("similarity", "similarity_linear"):
        return _similarities(method, grown, shares)
    motors, scale = grown.as_motor_scale()
    rigid = _rigid(method, motors, shares)
    return Similarity.from_motor_scale(rigid, np.sum(shares * scale, axis=-1))


def stacked(poses: Sequence[Poses]) -> Poses:
    """Poses ``(*, J)`` side by side, ``(*, K, J)``; similarities where one of them is.

    Raises:
        ValueError: no poses, or poses of different joints.
    """
    joints = [pose.shape[-1:] for pose in poses]
    if not joints or joints != [joints[0]] * len(joints) or not joints[0]:
        raise ValueError(f"blend: expected poses (*, J) of the same joints, got {joints} of them")
    grow = any(isinstance(pose, Similarity) for pose in poses)
    alike = [
        Similarity.from_motor_scale(pose) if grow and isinstance(pose, Motor) else pose
        for pose in poses
    ]
    shape = np.broadcast_shapes(*(pose.coefficients.shape for pose in alike))
    spread = np.stack([np.broadcast_to(pose.coefficients, shape) for pose in alike], axis=-3)
    return Similarity(spread) if grow else Motor(spread)


def _shares(shape: tuple[int, ...], weights: ArrayLike) -> FloatArray:
    """Weights as ``(*, J, K)`` that sum to one."""
    if len(shape) < 2 or shape[-2] == 0:
        raise ValueError(f"blend_poses(poses): expected shape (*, K, J), got {shape}")
    values = checked_floats(weights, "blend_poses(weights)", ())
    if values.shape == shape[:-1] or (values.ndim == 1 and values.shape == shape[-2:-1]):
        values = values[..., None]
    elif values.ndim < 2 or values.shape[-2:] != shape[-2:]:
        raise ValueError(
            f"blend_poses(weights): expected shape (*, {shape[-2]}) or (*, {shape[-2]}, "
            f"{shape[-1]}) for poses of shape {shape}, got {values.shape}"
        )
    if np.any(values < 0.0):
        raise ValueError(f"blend_poses(weights): expected shares >= 0, got {values.min():g}")
    most = np.max(values, axis=-2, keepdims=True)
    if not np.all(most > 0.0):
        raise ValueError("blend_poses(weights): expected a share above 0 for every joint")
    ratios = values / most  # first, so that no sum overflows
    shares = ratios / np.sum(ratios, axis=-2, keepdims=True)
    return np.swapaxes(np.broadcast_to(shares, shape), -1, -2)


def _rigid(method: BlendMethod, motors: Motor, shares: FloatArray) -> Motor:
    if method in ("similarity", "similarity_linear"):
        grown = Similarity.from_motor_scale(motors)
        return _similarities(method, grown, shares).rigid
    return _RIGID[method](motors, shares)


def _similarities(method: BlendMethod, poses: Similarity, shares: FloatArray) -> Similarity:
    return blend(poses, shares) if method == "similarity_linear" else _on_path(poses, shares)


def _on_path(versors: V, shares: FloatArray) -> V:
    """By logarithms: between two along the path of one parameter, of more their mean."""
    if versors.shape[-1] == 2:
        return versors[..., 0].interpolate(versors[..., 1], shares[..., 1])
    return mean(versors, shares)


def _beside(motors: Motor, shares: FloatArray) -> FloatArray:
    """Weighted translations ``(*, J, 3)`` in metres."""
    weighted: FloatArray = np.sum(shares[..., None] * motors.translation_m, axis=-2)
    return weighted


def _rotor(motors: Motor, shares: FloatArray) -> Motor:
    turned = _on_path(motors.rotor, shares)
    return Motor.from_rotor_translation(turned, _beside(motors, shares))


def _rotor_linear(motors: Motor, shares: FloatArray) -> Motor:
    turned = blend(motors.rotor, shares)
    return Motor.from_rotor_translation(turned, _beside(motors, shares))


def _dual_quaternion(motors: Motor, shares: FloatArray) -> Motor:
    values = motors.as_dual_quaternion()
    return Motor.from_dual_quaternion(dual_quaternion_mean(values, shares))


def _dual_quaternion_linear(motors: Motor, shares: FloatArray) -> Motor:
    blended = DualQuaternion(motors.as_dual_quaternion()).blend(shares)
    return Motor.from_dual_quaternion(blended.coefficients)


def _quaternion(motors: Motor, shares: FloatArray) -> Motor:
    wxyz, _ = motors.as_quaternion_translation()
    return Motor.from_quaternion_translation(quaternion_mean(wxyz, shares), _beside(motors, shares))


def _quaternion_linear(motors: Motor, shares: FloatArray) -> Motor:
    quaternion_pose = QuaternionPose.from_quaternion_translation(
        *motors.as_quaternion_translation()
    )
    return Motor.from_quaternion_translation(
        *quaternion_pose.blend(shares).as_quaternion_translation()
    )


def _euler(motors: Motor, shares: FloatArray) -> Motor:
    angles, translation = motors.as_euler_translation()
    euler_pose = EulerPose(np.concatenate([angles, translation], axis=-1))
    blended = euler_pose.blend(shares)
    return Motor.from_euler_translation(blended.angles_rad, blended.translation_m)


_RIGID: dict[BlendMethod, Callable[[Motor, FloatArray], Motor]] = {
    "motor": _on_path,
    "motor_linear": blend,
    "rotor": _rotor,
    "rotor_linear": _rotor_linear,
    "dual_quaternion": _dual_quaternion,
    "dual_quaternion_linear": _dual_quaternion_linear,
    "quaternion": _quaternion,
    "quaternion_linear": _quaternion_linear,
    "euler": _euler,
}


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

    >>> from motorcade.animation.blend import PoseLayer, blend_layers
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

    >>> from motorcade.animation.blend import PoseLayer, blend_layers
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
