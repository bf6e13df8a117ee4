"""Skinning by four methods in double precision, and posing in real time in single.

Each vertex is carried by the weighted sum of its joints' palette entries, taken to the nearest
motion. ``linear`` sums matrices, which shrinks a surface where its joints differ by a large turn
(an elbow that twists narrows like a sweet's wrapper). ``dual_quaternion`` and ``motor`` stay rigid,
and are one and the same by theory; they bulge a little where joints bend. ``similarity`` grows as
well. `Skinner` is the compiled path, in single precision, for one pose after another in real time.
Sources: Magnenat-Thalmann, Laperrière, Thalmann (1988) for linear; Kavan, Collins, Zara, O'Sullivan
(2007) for dual quaternions, whose signs are taken from a vertex's heaviest joint.

A palette is what every joint does to the vertices bound to it, written as a method wants it:

========================  =====  =================================================================
``linear``                12     3×4 matrices by rows
``dual_quaternion``       8      Hamilton's dual quaternions, real wxyz, dual wxyz
``motor``                 8      CGA motors
``similarity``            12     CGA similarities, which grow as well
========================  =====  =================================================================

A `PoseField` carries a mesh between control motors: every vertex moves by its own blend of their
logarithms. Motors at a few control points say how the mesh moves there; in between, the weighted
sum of their logarithms says it. There is no skeleton. Near the points a mesh turns and shifts
rigidly, between them it bends and twists along screws.
Source: Wareham and Lasenby, "Mesh vertex pose and position interpolation using geometric algebra"
(2008); weights after Shepard (1968). Logarithms are taken the short way, so motors that differ by
close to half a turn must not stand side by side.

`PoseRuntime` does what `Clip.at`, `blend_poses` and `palette` do one after another, compiled: two
clips sampled, blended and posed take a few microseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.native._runtime import Mesh, Rig, Skinning
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity, kernels
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive, frozen

__all__ = ["SKIN_METHODS", "PoseField", "SkinMethod", "Skinner", "palette", "skin"]


SkinMethod = Literal["linear", "dual_quaternion", "motor", "similarity"]
SKIN_METHODS: tuple[SkinMethod, ...] = get_args(SkinMethod)


def checked_method(method: str) -> SkinMethod:
    """The method, if it is one.

    Raises:
        ValueError: an unknown method.
    """
    for known in SKIN_METHODS:
        if method == known:
            return known
    raise ValueError(f"skin(method): expected one of {', '.join(SKIN_METHODS)}, got {method!r}")


def palette(
    skeleton: Skeleton, local_pose: Motor | Similarity, method: SkinMethod
) -> tuple[FloatArray, FloatArray | None]:
    """What each joint does to points in character space.

    Args:
        skeleton: with J joints.
        local_pose: ``(*, J)``, poses `parent_T_joint`.
        method: how it is written.

    Returns:
        entries ``(*, J, 8 or 12)``; and, where joints grow under a rigid method, their scales
        ``(*, J)``: a vertex is first grown about the character's origin, then carried rigidly.

    Raises:
        ValueError: an unknown method, a last dimension other than the number of joints.
    """
    checked_method(method)
    world, back = skeleton.world(local_pose), skeleton.rest_world_inverse
    if isinstance(world, Motor):
        motion = world @ back
        if method == "similarity":
            return Similarity.from_motor_scale(motion).coefficients, None
        return _rigid(motion, method), None
    grown = world @ Similarity.from_motor_scale(back)
    if method == "similarity":
        return grown.coefficients, None
    if method == "linear":
        return _rows(grown.as_matrix()), None
    rigid, scale = grown.as_motor_scale()
    return _rigid(rigid, method), scale


def _rigid(motion: Motor, method: SkinMethod) -> FloatArray:
    if method == "linear":
        return _rows(motion.as_matrix())
    if method == "dual_quaternion":
        return motion.as_dual_quaternion()
    return np.asarray(motion.coefficients, dtype=np.float64)


def _rows(matrices: FloatArray) -> FloatArray:
    return matrices[..., :3, :].reshape(*matrices.shape[:-2], 12)


SKIN_KERNELS: dict[SkinMethod, str] = {
    "linear": "carry_matrix",
    "dual_quaternion": "carry_dual_quaternion",
    "motor": "carry_motor",
    "similarity": "carry_similarity",
}
"""The generated kernel that carries a vertex by a method."""


def skin(
    character: Character, local_pose: Motor | Similarity, method: SkinMethod = "linear"
) -> tuple[FloatArray, FloatArray]:
    """Positions and normals of a character's mesh in a pose.

    Normals are turned with the surface and are unit; under ``linear`` that is exact only where a
    vertex is carried rigidly.

    Args:
        character: mesh, skeleton and weights.
        local_pose: Motor or Similarity ``(*, J)``, poses `parent_T_joint`.
        method: one of `SKIN_METHODS`.

    Returns:
        vertices ``(*, V, 3)`` in character space, metres, and unit normals ``(*, V, 3)``.

    Raises:
        ValueError: an unknown method, or a last dimension other than the number of joints.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton, skin
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> raised = Motor.from_translation([[0, 0, 0.5]])  # parent_T_joint
    >>> vertices, normals = skin(flag, raised)
    >>> vertices
    array([[0. , 0. , 0.5],
           [1. , 0. , 0.5],
           [0. , 0. , 2.5]])
    """
    entries, scale = palette(character.skeleton, local_pose, method)
    sums = _sums(character, entries, with_signs=method != "linear")
    rest = character.vertices
    if scale is not None:
        share = np.sum(scale[..., character.joints] * character.weights, axis=-1)
        rest = rest * share[..., None]
    skinned = np.empty((*sums.shape[:-1], 6))
    batch = sums.shape[:-1]
    kernels.function(SKIN_KERNELS[method])(
        np.ascontiguousarray(sums).reshape(-1, sums.shape[-1]),
        np.ascontiguousarray(np.broadcast_to(rest, (*batch, 3))).reshape(-1, 3),
        np.ascontiguousarray(np.broadcast_to(character.normals, (*batch, 3))).reshape(-1, 3),
        skinned.reshape(-1, 6),
    )
    return skinned[..., :3], skinned[..., 3:]


def _sums(character: Character, entries: FloatArray, with_signs: bool) -> FloatArray:
    """Weighted sums of palette entries ``(*, V, 8 or 12)``."""
    joints, weights = character.influences
    first = entries[..., joints[:, 0], :]
    total: FloatArray = first * weights[:, 0, None]
    for k in range(1, weights.shape[1]):
        held = np.flatnonzero(weights[:, k])
        other, share = entries[..., joints[held, k], :], weights[held, k, None]
        if with_signs:
            dot = np.sum(first[..., held, :4] * other[..., :4], axis=-1, keepdims=True)
            share = np.where(dot < 0.0, -share, share)
        total[..., held, :] += other * share
    return total


Floats32 = NDArray[np.float32]

_METHODS = {
    "linear": Skinning.matrix,
    "dual_quaternion": Skinning.dual_quaternion,
    "motor": Skinning.motor,
    "similarity": Skinning.similarity,
}


class Skinner:
    """A character's mesh prepared for skinning by one method.

    It does what `skin` does, in float32 (positions to about 1e-6 of the character's height) and
    without validation of what is fixed. Large meshes are shared among `kernels.threads()` threads;
    one of these is not for two threads at once.

    Args:
        character: mesh, skeleton and weights.
        method: one of `SKIN_METHODS`.

    Raises:
        ValueError: an unknown method, or more than 65536 joints.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton
    >>> from motorcade.animation.skin import Skinner
    >>> from motorcade.ga import Motor
    >>> flag = Character(
    ...     Skeleton(("pole",), np.array([-1]), Motor.identity((1,))),
    ...     vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2.0]]),
    ...     normals=np.tile([0.0, -1.0, 0.0], (3, 1)),
    ...     triangles=np.array([[0, 1, 2]]),
    ...     colors=np.full((3, 3), 0.5),
    ...     joints=np.zeros((3, 4), int),
    ...     weights=np.tile([1.0, 0, 0, 0], (3, 1)),
    ... )

    >>> vertices, normals = Skinner(flag, "motor").skin(Motor.from_translation([[0, 0, 0.5]]))
    >>> vertices.dtype, vertices[2]
    (dtype('float32'), array([0. , 0. , 2.5], dtype=float32))
    """

    def __init__(self, character: Character, method: SkinMethod = "motor") -> None:
        self.method = checked_method(method)
        self._character, self._skeleton = character, character.skeleton
        self._weights: FloatArray | None = None
        if len(self._skeleton) > 65536:
            raise ValueError(f"Skinner: expected up to 65536 joints, got {len(self._skeleton)}")
        self._shape = character.vertices.shape
        joints, weights = character.influences
        self._mesh = Mesh(
            np.ascontiguousarray(character.vertices),
            np.ascontiguousarray(character.normals),
            np.ascontiguousarray(joints),
            np.ascontiguousarray(weights),
        )

    def skin(
        self, local_pose: Motor | Similarity, weights: ArrayLike | None = None
    ) -> tuple[Floats32, Floats32]:
        """Vertices and unit normals ``(V, 3)`` of one pose ``(J,)``, metres.

        Args:
            local_pose: Motor or Similarity, poses `parent_T_joint`.
            weights: (W,) of the character's morph targets, mixed in before; the mesh as it is by
                default. They are mixed anew only where they differ from the last.

        Raises:
            ValueError: another number of joints or weights, or joints that grow under a rigid
                method: use ``linear`` or ``similarity`` for these.
        """
        self._shape_by(weights)
        entries, scale = palette(self._skeleton, local_pose, self.method)
        if scale is not None and np.ptp(scale) > 1e-6:
            raise ValueError(
                f"Skinner.skin(local_pose): expected rigid joints under '{self.method}', got "
                f"scales from {scale.min():.4g} to {scale.max():.4g}; use 'similarity' or 'linear'"
            )
        return self.skin_palette(np.ascontiguousarray(entries, dtype=np.float32))

    def _shape_by(self, weights: ArrayLike | None) -> None:
        values = None if weights is None else np.array(weights, dtype=np.float64)
        if values is None and self._weights is None:
            return
        if (
            values is not None
            and self._weights is not None
            and np.array_equal(values, self._weights)
        ):
            return
        character = self._character if values is None else self._character.shaped(values)
        self._mesh.reshape(
            np.ascontiguousarray(character.vertices), np.ascontiguousarray(character.normals)
        )
        self._weights = values

    def skin_palette(self, entries: Floats32) -> tuple[Floats32, Floats32]:
        """The same from a palette ``(J, 8 or 12)`` as `palette` or `PoseRuntime` gives it.

        Raises:
            ValueError: another shape than the method's.
            TypeError: another type than float32 in C order.
        """
        positions, normals = np.empty(self._shape, np.float32), np.empty(self._shape, np.float32)
        self._mesh.skin(_METHODS[self.method], entries, positions, normals, kernels.threads())
        return positions, normals


@dataclass(frozen=True, eq=False)
class PoseField:
    """Motors at control points, and the motion of everything between them.

    Args:
        points_m: ``(K, 3)`` control points on the mesh at rest, all different.
        motors: Motor ``(K,)``, what happens to the mesh there.
        sharpness: power of the inverse distance by which a point counts; 2 is smooth, more keeps
            the surroundings of each point stiffer.

    Raises:
        ValueError: shapes that do not fit, points at one place, a sharpness that is not positive.

    >>> import numpy as np
    >>> from motorcade.animation.skin import PoseField
    >>> from motorcade.ga import Motor
    >>> ends = np.array([[0, 0, 0], [1.0, 0, 0]])
    >>> lift = PoseField(ends, Motor.from_translation([[0, 0, 0], [0, 0, 1.0]]))
    >>> lift.at([0.5, 0, 0]).translation_m + 0.0
    array([0. , 0. , 0.5])
    """

    points_m: FloatArray
    motors: Motor
    sharpness: float = 2.0

    def __post_init__(self) -> None:
        points = checked_floats(self.points_m, "PoseField.points_m", (3,))
        if points.ndim != 2 or self.motors.shape != (len(points),) or not len(points):
            raise ValueError(
                "PoseField: expected K points (K, 3) and K motors (K,), got shapes "
                f"{points.shape} and {self.motors.shape}"
            )
        if len(np.unique(points, axis=0)) != len(points):
            raise ValueError("PoseField.points_m: expected points that all differ")
        checked_positive(self.sharpness, "PoseField.sharpness")
        object.__setattr__(self, "points_m", frozen(points))

    def weights(self, points_m: ArrayLike) -> FloatArray:
        """Shares ``(*, K)`` of the control points at points ``(*, 3)``; they sum to one."""
        at = checked_floats(points_m, "PoseField.weights(points_m)", (3,))
        apart = np.linalg.norm(at[..., None, :] - self.points_m, axis=-1)
        nearest = np.min(apart, axis=-1, keepdims=True)
        # Divided by the nearest first: no power overflows, and at a point itself it alone counts.
        ratio = np.where(nearest > 0.0, nearest / np.where(apart > 0.0, apart, 1.0), apart == 0.0)
        share = ratio**self.sharpness
        total: FloatArray = share / np.sum(share, axis=-1, keepdims=True)
        return total

    def at(self, points_m: ArrayLike, fraction: ArrayLike = 1.0) -> Motor:
        """Motors ``(*)`` at points ``(*, 3)``, a share of the way from rest: 0 nothing, 1 all."""
        part = checked_floats(fraction, "PoseField.at(fraction)", ())
        logs = self.weights(points_m) @ self.motors.log()
        return Motor.exp(part[..., None] * logs)

    def deform(
        self, vertices_m: ArrayLike, normals: ArrayLike, fraction: ArrayLike = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals ``(V, 3)`` of the deformed mesh.

        Normals turn with their vertex; where the field changes fast they are off by its shear.
        """
        vertices = checked_floats(vertices_m, "PoseField.deform(vertices_m)", (3,))
        directions = checked_floats(normals, "PoseField.deform(normals)", (3,))
        motion = self.at(vertices, fraction)
        return motion.apply(vertices), motion.rotor.apply(directions)


Layers = Sequence[tuple[int, float, float]]

_WIDTHS = {"matrix": 12, "motor": 8}


class PoseRuntime:
    """A skeleton and its clips, ready to be posed. One is not for two threads at once.

    Args:
        skeleton: with J joints.
        clips: rigid motions of it; layers name them by their number.
        method: "motor_linear", or "motor" by the screw for up to two layers.

    Raises:
        ValueError: an unknown method, a clip of another skeleton or with joints that grow.

    >>> import numpy as np
    >>> from motorcade.animation import Clip, Skeleton
    >>> from motorcade.animation.skin import PoseRuntime
    >>> from motorcade.ga import Motor
    >>> one = Skeleton(("root",), np.array([-1]), Motor.identity((1,)))
    >>> low, high = (
    ...     Clip(name, np.zeros(1), Motor.from_translation([[[0, 0, z]]]))
    ...     for name, z in (("low", 1.0), ("high", 3.0))
    ... )
    >>> runtime = PoseRuntime(one, [low, high])
    >>> runtime.local([(0, 0.0, 1.0), (1, 0.0, 1.0)]).translation_m + 0.0  # both, half each
    array([[0., 0., 2.]], dtype=float32)
    """

    def __init__(
        self,
        skeleton: Skeleton,
        clips: Sequence[Clip],
        method: Literal["motor", "motor_linear"] = "motor_linear",
    ) -> None:
        if method not in ("motor", "motor_linear"):
            raise ValueError(
                f"PoseRuntime(method): expected 'motor' or 'motor_linear', got {method!r}"
            )
        self._by_screw = method == "motor"
        self._count = len(skeleton)
        self._rig = Rig(
            np.ascontiguousarray(skeleton.parents), _coefficients(skeleton.rest_world_inverse)
        )
        for clip in clips:
            if not isinstance(clip.poses, Motor) or clip.poses.shape[1] != len(skeleton):
                raise ValueError(
                    f"PoseRuntime(clips): expected rigid poses of {len(skeleton)} joints, got "
                    f"{type(clip.poses).__name__} of {clip.poses.shape[1]} in '{clip.name}'"
                )
            self._rig.add(np.ascontiguousarray(clip.time_s), _coefficients(clip.poses), clip.looped)

    def palette(
        self,
        layers: Layers,
        kind: Literal["matrix", "motor"] = "matrix",
        out: Floats32 | None = None,
    ) -> Floats32:
        """What each joint does to points in character space, for `Skinner.skin_palette`.

        Args:
            layers: (number of the clip, seconds on its clock, weight) of each; only the ratios
                of weights count.
            kind: 3×4 matrices by rows ``(J, 12)``, or motors ``(J, 8)``.
            out: an array to write into, float32 in C order.

        Raises:
            ValueError: no layer, more than two under "motor", no such clip, a number of a clip
                that is no integer, a time that is not finite, weights that are negative or all
                zero, an unknown kind, another array to write into.
        """
        if kind not in _WIDTHS:
            raise ValueError(f"palette(kind): expected 'matrix' or 'motor', got {kind!r}")
        entries = np.empty((self._count, _WIDTHS[kind]), np.float32) if out is None else out
        self._rig.pose(layers, self._by_screw, kind, entries)
        return entries

    def local(self, layers: Layers) -> Motor:
        """The blended local poses, Motor ``(J,)`` in float32; arguments as for `palette`."""
        coefficients = np.empty((self._count, 8), np.float32)
        self._rig.pose(layers, self._by_screw, "local", coefficients)
        return Motor.normalize(coefficients)

    def repeat(
        self, layers: Layers, times: int, kind: Literal["matrix", "motor"] = "matrix"
    ) -> float:
        """Seconds that one palette takes without Python's share, over `times` of them, for
        measurements; the clocks of the layers go on by 1/60 s each time.

        Raises:
            ValueError: as for `palette`, or a number of times below 1.
        """
        if times < 1:
            raise ValueError(f"repeat(times): expected 1 or more, got {times}")
        entries = self.palette(layers, kind)
        return self._rig.repeat(layers, self._by_screw, kind, entries, times) / times


def _coefficients(motors: Motor) -> NDArray[np.float64]:
    return np.ascontiguousarray(motors.coefficients, dtype=np.float64)
