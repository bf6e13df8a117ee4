"""Anchors: what a character hangs on while tracking goes on correcting where that is.

A tracker that closes a loop or sees its marker again moves a plane, a marker or a remembered pose
at once; a character that jumped along would give it away. The anchor shows the old place and lets
the difference die away along the screw between the two, whatever the frame rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import FloatArray, Motor, Rotor, Similarity

__all__ = ["Anchor", "plane_anchor"]


@dataclass(frozen=True, eq=False)
class Anchor:
    """A place that follows its corrections without popping; every verb returns a new anchor.

    Args:
        target: `world_T_anchor` as tracking knows it now, batch shape (); a pose, a marker's or a
            plane's (see `plane_anchor`), with a scale where characters shall grow with it.
        time_s: when that was.
        settle_s: the difference to what is shown falls to 1/e in this time; 0 follows at once.
        offset: what is shown as the target sees it; none at first.

    Raises:
        ValueError: a batch, a time that is not finite, a settling time that is negative.
    """

    target: Similarity
    time_s: float = 0.0
    settle_s: float = 0.25
    offset: Similarity | None = None

    def __post_init__(self) -> None:
        if self.target.shape != ():
            raise ValueError(
                f"Anchor.target: expected one similarity, got a batch of shape {self.target.shape}"
            )
        if not np.isfinite(self.time_s):
            raise ValueError(f"Anchor.time_s: expected seconds, got {self.time_s}")
        if not (np.isfinite(self.settle_s) and self.settle_s >= 0.0):
            raise ValueError(f"Anchor.settle_s: expected 0 or more seconds, got {self.settle_s}")

    def at(self, time_s: float) -> Similarity:
        """`world_T_anchor` as it is shown at a time, not before the last correction.

        Raises:
            ValueError: a time before the last correction.
        """
        passed = time_s - self.time_s
        if not passed >= 0.0:
            raise ValueError(f"Anchor.at(time_s): expected {self.time_s} s or later, got {time_s}")
        if self.offset is None or self.settle_s == 0.0:
            return self.target
        left = float(np.exp(-passed / self.settle_s))
        return self.target @ Similarity.exp(left * self.offset.log())

    def corrected(self, target: Similarity, time_s: float) -> Anchor:
        """The anchor after tracking has moved it: what is shown does not change at that moment.

        Raises:
            ValueError: a batch, or a time before the last correction.
        """
        shown = self.at(time_s)
        offset = Similarity.normalize((target.inverse() @ shown).coefficients)
        return replace(self, target=target, time_s=time_s, offset=offset)


def plane_anchor(
    normal: FloatArray, point_m: FloatArray, ahead: FloatArray, scale: float = 1.0
) -> Similarity:
    """`world_T_anchor` on a plane: z along its normal, x as near to `ahead` as lies in it.

    Args:
        normal: ``(3,)`` out of the plane.
        point_m: ``(3,)`` of the plane, where the anchor stands.
        ahead: ``(3,)`` where the anchor's x looks.
        scale: of what hangs on it.

    Raises:
        ValueError: a normal of no length, or `ahead` along it.
    """
    up = np.asarray(normal, dtype=np.float64)
    size = float(np.linalg.norm(up))
    if not size > 0.0:
        raise ValueError("plane_anchor(normal): expected a direction, got none")
    up = up / size
    x = np.asarray(ahead, dtype=np.float64)
    x = x - (x @ up) * up
    length = float(np.linalg.norm(x))
    if not length > 1e-9:
        raise ValueError(f"plane_anchor(ahead): expected a direction off the normal, got {ahead}")
    x = x / length
    rotor = Rotor.from_matrix(np.stack([x, np.cross(up, x), up], axis=1))
    return Similarity.from_motor_scale(Motor.from_rotor_translation(rotor, point_m), scale)
