"""Character: a skinned mesh, the skeleton it is bound to, and its clips.

Character space: metres, z up, facing +x, soles at z = 0. Triangles run counter-clockwise seen
from outside; vertex colours are sRGB from 0 to 1.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.appearance import Appearance
from motorcade.animation.clip import Clip, MorphTarget, morphed
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen

WEIGHT_TOLERANCE = 1e-6
NORMAL_TOLERANCE = 1e-4


@dataclass(frozen=True, eq=False)
class Character:
    """A mesh of V vertices and T triangles in its rest pose, carried by up to four joints each.

    Args:
        skeleton: with J joints.
        vertices: (V, 3) m.
        normals: (V, 3) unit vectors that point outwards.
        triangles: (T, 3) vertex numbers.
        colors: (V, 3) sRGB, 0 to 1.
        joints: (V, 4 or 8) joint numbers.
        weights: (V, 4 or 8) shares of these joints, not negative, summing to 1.
        clips: motions of this skeleton with different names.
        notices: what was left out or assumed when it was read from a file.
        character_T_file: from the axes and unit of the file's scene to character space.
        found_pose: Motor or Similarity (J,), the pose in which the nodes of the file stand; by
            default the rest pose.
        appearance: materials with their textures, which `colors` stand in for where a renderer
            samples none; None where there are only colours.
        morphs: targets that weights mix into the rest pose.

    Raises:
        ValueError: a shape, an index or a weight out of range, or a clip for another skeleton.

    >>> import numpy as np
    >>> from motorcade.animation import Character, Skeleton
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

    >>> flag.height_m
    2.0
    """

    skeleton: Skeleton
    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    colors: FloatArray
    joints: IntArray
    weights: FloatArray
    clips: tuple[Clip, ...] = ()
    notices: tuple[str, ...] = ()
    character_T_file: Similarity = field(default_factory=Similarity.identity)
    found_pose: Motor | Similarity | None = None
    appearance: Appearance | None = None
    morphs: tuple[MorphTarget, ...] = ()

    def __post_init__(self) -> None:
        count = len(np.asarray(self.vertices))
        most = 8 if np.shape(self.weights)[-1:] == (8,) else 4
        for name, width in (("vertices", 3), ("normals", 3), ("colors", 3), ("weights", most)):
            values = checked_floats(getattr(self, name), f"Character.{name}", (width,))
            if values.shape != (count, width):
                raise ValueError(
                    f"Character.{name}: expected shape ({count}, {width}), got {values.shape}"
                )
            object.__setattr__(self, name, frozen(values))
        if not count:
            raise ValueError("Character.vertices: expected one vertex or more, got none")
        for name, shape, limit in (
            ("triangles", (len(np.asarray(self.triangles)), 3), count),
            ("joints", (count, most), len(self.skeleton)),
        ):
            given_numbers = _numbers(getattr(self, name), f"Character.{name}", shape, limit)
            object.__setattr__(self, name, given_numbers)
        self._check_ranges()
        self._check_clips()
        if self.appearance is not None:
            self.appearance.check(self.vertices, self.triangles, "Character")
        if self.found_pose is None:
            object.__setattr__(self, "found_pose", self.skeleton.rest)
        elif self.found_pose.shape != (len(self.skeleton),):
            raise ValueError(
                f"Character.found_pose: expected poses of {len(self.skeleton)} joints, got "
                f"{self.found_pose.shape}"
            )

    def _check_ranges(self) -> None:
        length = np.linalg.norm(self.normals, axis=1)
        if np.any(np.abs(length - 1.0) > NORMAL_TOLERANCE):
            raise ValueError(
                "Character.normals: expected unit vectors, got lengths from "
                f"{length.min():.4g} to {length.max():.4g}"
            )
        if self.colors.min() < 0.0 or self.colors.max() > 1.0:
            raise ValueError(
                "Character.colors: expected sRGB from 0 to 1, got "
                f"{self.colors.min():.4g} to {self.colors.max():.4g}"
            )
        total = self.weights.sum(axis=1)
        worst = int(np.argmax(np.abs(total - 1.0)))
        if self.weights.min() < 0.0 or abs(total[worst] - 1.0) > WEIGHT_TOLERANCE:
            raise ValueError(
                "Character.weights: expected shares of 0 or more that sum to 1, got a sum of "
                f"{total[worst]:.6g} at vertex {worst} and a smallest share of "
                f"{self.weights.min():.3g}"
            )

    def _check_clips(self) -> None:
        names = [clip.name for clip in self.clips]
        if len(set(names)) != len(names):
            raise ValueError(f"Character.clips: expected different names, got {names}")
        for target in self.morphs:
            _numbers(target.rows, "Character.morphs", target.rows.shape[:1], len(self.vertices))
        for clip in self.clips:
            if clip.morphs is not None and clip.morphs.weights.shape[1] != len(self.morphs):
                raise ValueError(
                    f"Character.clips: expected weights of {len(self.morphs)} morph targets, got "
                    f"{clip.morphs.weights.shape[1]} in '{clip.name}'"
                )
            if clip.poses.shape[1] != len(self.skeleton):
                raise ValueError(
                    f"Character.clips: expected poses of {len(self.skeleton)} joints, got "
                    f"{clip.poses.shape[1]} in '{clip.name}'"
                )

    @cached_property
    def height_m(self) -> float:
        """Height of the rest pose above z = 0."""
        return float(self.vertices[:, 2].max())

    def shaped(self, weights: ArrayLike | None = None) -> "Character":
        """The same with morph targets mixed into its rest pose, by weights (W,) or those at rest.

        Raises:
            ValueError: another number of weights.
        """
        vertices, normals = morphed(self.vertices, self.normals, self.morphs, weights)
        if vertices is self.vertices:
            return self
        return replace(self, vertices=vertices, normals=normals)

    @cached_property
    def influences(self) -> tuple[IntArray, FloatArray]:
        """Joints and weights ``(V, 4 or 8)``, the heaviest of each vertex first.

        Sums of versors take their signs from the first: no sum can then cancel.
        """
        order = np.argsort(-self.weights, axis=1, kind="stable")
        joints = np.take_along_axis(self.joints, order, axis=1)
        return joints, np.take_along_axis(self.weights, order, axis=1)

    def clip(self, name: str) -> Clip:
        """The clip of that name.

        Raises:
            ValueError: no such clip; the message lists those there are.
        """
        for clip in self.clips:
            if clip.name == name:
                return clip
        listed = ", ".join(f"'{clip.name}'" for clip in self.clips) or "none"
        raise ValueError(f"clip: expected one of {listed}, got {name!r}")


def _numbers(value: IntArray, name: str, shape: tuple[int, int], limit: int) -> IntArray:
    """A read-only int64 copy, checked for shape and range."""
    values = np.asarray(value)
    if values.shape != shape or values.dtype.kind not in "iu":
        raise ValueError(
            f"{name}: expected integers of shape {shape}, got {values.dtype} {values.shape}"
        )
    if values.size and (values.min() < 0 or values.max() >= limit):
        raise ValueError(
            f"{name}: expected numbers from 0 to {limit - 1}, got {values.min()} to {values.max()}"
        )
    own = values.astype(np.int64)
    own.setflags(write=False)
    return own
