"""Closing a cycle: a clip that ends about where it began, made to end there."""

from __future__ import annotations

import numpy as np

from motorcade.animation.blend.layers import added, additive
from motorcade.animation.clip import Clip

__all__ = ["closed"]


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
    return Clip(clip.name, clip.time_s, type(poses)(coefficients), True, clip.key_count)
