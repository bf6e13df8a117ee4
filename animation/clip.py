"""Clip: local poses of a skeleton and weights of morph targets over time.

Between samples every joint follows the screw from one pose to the next, or the path of constant
growth where its scale changes. A looped clip ends in the
pose it began with and repeats; any other clip holds its first and last pose outside its span.

A face smiles by adding a share of what lies between its rest and a smile. Weights act on the rest
pose, before joints carry the vertices.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.vectors import UP, unit
from motorcade.ga import Motor, Similarity, Versor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen


def between(keys: FloatArray, times: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """The keys (*) of (K,) at or before times (*) and after them, and fractions (*) of the way.

    Times outside are held at the ends.
    """
    if len(keys) == 1:
        alone = np.zeros(np.shape(times), dtype=np.int64)
        return alone, alone, np.zeros(np.shape(times))
    before = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    fraction = (times - keys[before]) / (keys[before + 1] - keys[before])
    return before, before + 1, np.clip(fraction, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class MorphTarget:
    """What one weight adds to a mesh in its rest pose.

    Attributes:
        name: what it is called; names may repeat.
        rows: (R,) different vertex numbers.
        positions: (R, 3) m, added in full at weight 1.
        normals: (R, 3), added to unit normals before these are made unit again.
        weight: at rest.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity.

    >>> import numpy as np
    >>> from motorcade.animation.clip import MorphTarget
    >>> MorphTarget("smile", np.array([3, 8]), np.ones((2, 3)), np.zeros((2, 3))).weight
    0.0
    """

    name: str
    rows: IntArray
    positions: FloatArray
    normals: FloatArray
    weight: float = 0.0

    def __post_init__(self) -> None:
        for name in ("positions", "normals"):
            values = checked_floats(getattr(self, name), f"MorphTarget.{name}", (3,))
            if values.shape != (len(self.rows), 3):
                raise ValueError(
                    f"MorphTarget.{name}: expected shape ({len(self.rows)}, 3), got {values.shape}"
                )
            object.__setattr__(self, name, frozen(values))


@dataclass(frozen=True, eq=False)
class MorphTrack:
    """Weights of W targets over time, on straight lines between its times.

    Attributes:
        time_s: (K,) strictly increasing, on the clock of its clip.
        weights: (K, W).

    Raises:
        ValueError: times that do not increase, another number of rows, NaN or infinity.

    >>> import numpy as np
    >>> from motorcade.animation.clip import MorphTrack
    >>> track = MorphTrack(np.array([0.0, 1.0]), np.array([[0.0], [0.8]]))
    >>> track.at([0.5, 7.0])
    array([[0.4],
           [0.8]])
    """

    time_s: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        times = checked_floats(self.time_s, "MorphTrack.time_s", ())
        weights = np.asarray(self.weights, dtype=np.float64)
        if times.ndim != 1 or not times.size or np.any(np.diff(times) <= 0.0):
            raise ValueError(
                f"MorphTrack.time_s: expected (K,) strictly increasing seconds, got {times.shape}"
            )
        if weights.ndim != 2 or len(weights) != len(times) or not np.all(np.isfinite(weights)):
            raise ValueError(
                f"MorphTrack.weights: expected finite numbers ({len(times)}, W), got "
                f"{weights.shape}"
            )
        object.__setattr__(self, "time_s", frozen(times))
        object.__setattr__(self, "weights", frozen(weights))

    def at(self, time_s: ArrayLike) -> FloatArray:
        """Weights (*, W) at times (*); the first and last are held outside of the track."""
        wanted = checked_floats(time_s, "MorphTrack.at(time_s)", ())
        columns = [np.interp(wanted, self.time_s, one) for one in self.weights.T]
        return np.stack(columns, axis=-1) if columns else np.zeros((*wanted.shape, 0))


def morphed(
    vertices: FloatArray,
    normals: FloatArray,
    targets: tuple[MorphTarget, ...],
    weights: ArrayLike | None = None,
) -> tuple[FloatArray, FloatArray]:
    """A mesh in its rest pose with targets mixed in.

    Args:
        vertices: (V, 3) m.
        normals: (V, 3) unit.
        targets: W of them.
        weights: (W,); by default those at rest.

    Returns:
        vertices (V, 3) and unit normals (V, 3).

    Raises:
        ValueError: another number of weights.

    >>> import numpy as np
    >>> from motorcade.animation.clip import MorphTarget, morphed
    >>> raise_it = MorphTarget("up", np.array([1]), np.array([[0, 0, 2.0]]), np.zeros((1, 3)))
    >>> normals = np.tile([0, 0, 1.0], (2, 1))
    >>> morphed(np.zeros((2, 3)), normals, (raise_it,), [0.25])[0]
    array([[0. , 0. , 0. ],
           [0. , 0. , 0.5]])
    """
    mixed = [one.weight for one in targets] if weights is None else weights
    shares = checked_floats(mixed, "morphed(weights)", ())
    if shares.shape != (len(targets),):
        raise ValueError(f"morphed(weights): expected {len(targets)}, got shape {shares.shape}")
    if not shares.any():
        return vertices, normals
    places, facing = vertices.copy(), normals.copy()
    for target, share in zip(targets, shares.tolist(), strict=True):
        if share:
            places[target.rows] += share * target.positions
            facing[target.rows] += share * target.normals
    return places, unit(facing, UP)


Poses = TypeVar("Poses", bound=Versor)

# How far, in metres and radians, the ends of a loop may lie apart.
LOOP_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Clip:
    """A named motion of a skeleton with J joints.

    Args:
        name: what it is called.
        time_s: (F,) strictly increasing, F at least 1.
        poses: Motor (F, J), local poses `parent_T_joint`; Similarity (F, J) only where joints
            grow or shrink over time, relative to the rest pose of the skeleton.
        looped: whether the motion repeats; its last pose must then equal its first.
        key_count: how many keys the fullest channel of its file had, where the motion is sampled
            more finely; by default the number of samples.
        morphs: weights of morph targets over the same clock, or None where they stay at rest.

    Raises:
        ValueError: an empty name, times that do not increase, shapes that do not fit, a count of
            keys outside 1 to F, or a loop whose ends differ by more than 1e-6 m, rad or in the
            logarithm of scale.

    >>> import numpy as np
    >>> from motorcade.animation import Clip
    >>> from motorcade.ga import Motor
    >>> # two samples of one joint
    >>> parent_T_joint = Motor.from_translation([[[0, 0, 1.0]], [[0, 0, 2.0]]])
    >>> rise = Clip("rise", np.array([0.0, 0.5]), parent_T_joint)
    >>> rise.at([0.25, 9.0]).translation_m[:, 0] + 0.0
    array([[0. , 0. , 1.5],
           [0. , 0. , 2. ]])
    """

    name: str
    time_s: FloatArray
    poses: Motor | Similarity
    looped: bool = False
    key_count: int = 0
    morphs: MorphTrack | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("Clip.name: expected a name, got an empty string")
        times = checked_floats(self.time_s, "Clip.time_s", ())
        if times.ndim != 1 or times.size == 0 or np.any(np.diff(times) <= 0.0):
            raise ValueError(
                f"Clip.time_s of '{self.name}': expected (F,) strictly increasing seconds, got "
                f"shape {times.shape}"
            )
        if len(self.poses.shape) != 2 or self.poses.shape[0] != times.size:
            raise ValueError(
                f"Clip.poses of '{self.name}': expected shape ({times.size}, J), got "
                f"{self.poses.shape}"
            )
        if self.looped:
            self._check_loop(times)
        if not 0 <= self.key_count <= times.size:
            raise ValueError(
                f"Clip.key_count of '{self.name}': expected 1 to {times.size}, got {self.key_count}"
            )
        object.__setattr__(self, "key_count", self.key_count or times.size)
        object.__setattr__(self, "time_s", frozen(times))

    def _check_loop(self, times: FloatArray) -> None:
        if times.size < 2:
            raise ValueError(f"Clip '{self.name}': a loop needs two samples or more, got one")
        gap = 2.0 * float(np.max(np.abs((self.poses[0].inverse() @ self.poses[-1]).log())))
        if gap > LOOP_TOLERANCE:
            raise ValueError(
                f"Clip.poses of '{self.name}': expected the last pose of a loop to equal the "
                f"first, got {gap:.3g} m or rad apart"
            )

    @property
    def duration_s(self) -> float:
        """Seconds from the first sample to the last; the period of a loop."""
        return float(self.time_s[-1] - self.time_s[0])

    def at(self, time_s: ArrayLike) -> Motor | Similarity:
        """Local poses (*, J) at times (*) in seconds on the clip's own clock.

        Raises:
            ValueError: NaN or infinite times.
        """
        wanted = checked_floats(time_s, "Clip.at(time_s)", ())
        if len(self.time_s) == 1:
            return self.poses[np.zeros(wanted.shape, dtype=np.int64)]
        clock = self._clock(wanted)
        return _between(self.poses, *between(self.time_s, clock))

    def morph_weights(self, time_s: ArrayLike) -> FloatArray | None:
        """Weights of the morph targets (*, W) at times (*); None where they stay at rest.

        Raises:
            ValueError: NaN or infinite times.
        """
        if self.morphs is None:
            return None
        return self.morphs.at(self._clock(checked_floats(time_s, "Clip.morph_weights", ())))

    def _clock(self, wanted: FloatArray) -> FloatArray:
        """Times within the span: repeated in a loop, else held at its ends."""
        first, last = self.time_s[0], self.time_s[-1]
        if self.looped:
            return np.asarray(first + np.mod(wanted - first, last - first))
        return np.clip(wanted, first, last)


def _between(poses: Poses, before: IntArray, after: IntArray, fraction: FloatArray) -> Poses:
    return poses[before].interpolate(poses[after], fraction[..., None])
