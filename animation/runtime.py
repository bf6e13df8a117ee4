"""Posing in real time: clips sampled, blended and turned into a palette by compiled code, float32.

It does what `Clip.at`, `blend_poses` and `palette` do one after another, without the values between
them: two clips sampled, blended and posed take a few microseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.clip import Clip
from motorcade.animation.native._runtime import Rig
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor

Floats32 = NDArray[np.float32]
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
    >>> from motorcade.animation import Clip, PoseRuntime, Skeleton
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
        self._rig = Rig(np.ascontiguousarray(skeleton.parents), _rows(skeleton.rest_world_inverse))
        for clip in clips:
            if not isinstance(clip.poses, Motor) or clip.poses.shape[1] != len(skeleton):
                raise ValueError(
                    f"PoseRuntime(clips): expected rigid poses of {len(skeleton)} joints, got "
                    f"{type(clip.poses).__name__} of {clip.poses.shape[1]} in '{clip.name}'"
                )
            self._rig.add(np.ascontiguousarray(clip.time_s), _rows(clip.poses), clip.looped)

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


def _rows(motors: Motor) -> NDArray[np.float64]:
    return np.ascontiguousarray(motors.coefficients, dtype=np.float64)
