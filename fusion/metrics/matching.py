"""An estimate and its ground truth made comparable: in time, in space, and in a plane where asked.

The order is evo's: the window on the ground truth, pairs by stamps, alignment by the pairs,
projection of both.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.metrics.poses.alignment import (
    Align,
    Alignment,
    Pairs,
    Plane,
    alignment_of,
    associate,
    checked_offset_ns,
    cropped,
    folded,
    projected,
)
from motorcade.fusion.metrics.poses.pose_error import log_scales
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

log = logging.getLogger("motorcade.metrics")


@dataclass(frozen=True, eq=False)
class Matched:
    """An estimate beside its ground truth: by one clock, in one world, of rigid poses.

    Fields:
        estimate: the estimate at its own stamps; where a window was given, within it.
        reference: the ground truth, within the window.
        pairs: what belongs together of both, as errors compare it.
        alignment: what moved the estimate into the reference's world.
        align: its name.
        log_scale: logarithm of the ratio of the scales ``(P,)``; None where both are rigid.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import absolute_errors, match
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.ga import Motor
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> map_T_world = Motor.from_euler_translation([0.0, 0.0, 0.5], [1.0, 2.0, 0.0])
        >>> found = match(true.transformed_by(map_T_world)[10:], true, "se3")
        >>> bool(absolute_errors(found.pairs.estimate, found.pairs.reference).max() < 1e-9)
        True
    """

    estimate: Trajectory
    reference: Trajectory
    pairs: Pairs
    alignment: Alignment
    align: Align
    log_scale: FloatArray | None


def match(
    estimate: Trajectory,
    reference: Trajectory,
    align: Align = "none",
    *,
    max_difference_s: float = 0.01,
    offset_s: float = 0.0,
    start_s: float | None = None,
    end_s: float | None = None,
    interpolate: bool = False,
    max_gap_s: float | None = None,
    n_to_align: int | None = None,
    plane: Plane | None = None,
) -> Matched:
    """Pair, align and project an estimate and its ground truth, as evo does.

    Args:
        estimate: the trajectory to judge, at any rate.
        reference: the ground truth, at any rate.
        align: how the estimate is brought into the reference's world; see `alignment_of`.
        max_difference_s: how far apart paired stamps may be; see `associate`.
        offset_s: what to add to the estimate's stamps to have the reference's clock.
        start_s: where the part of the reference that is compared begins, by its clock.
        end_s: where it ends.
        interpolate: take the longer trajectory at the stamps of the shorter one.
        max_gap_s: over how much time poses may be interpolated; see `associate`.
        n_to_align: how many pairs, counted from the first, are aligned (all).
        plane: project both after alignment; see `projected`.

    Raises:
        ValueError: as `cropped`, `associate`, `alignment_of` and `projected`.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import match
        >>> from motorcade.fusion.motions import handheld
        >>> true = handheld(np.random.default_rng(0)).sampled(rate_hz=30.0, duration_s=2.0)
        >>> found = match(true, true, start_s=0.5, end_s=1.5, plane="xy")
        >>> len(found.pairs), float(np.ptp(found.pairs.estimate.translation_m[:, 2]))
        (31, 0.0)
    """
    windowed = start_s is not None or end_s is not None
    if windowed:
        reference = cropped(reference, start_s, end_s)
    ours, true = estimate.rigid, reference.rigid
    pairs = associate(
        ours,
        true,
        max_difference_s,
        offset_s=offset_s,
        interpolate=interpolate,
        max_gap_s=max_gap_s,
    )
    alignment = alignment_of(pairs, align, n_to_align)
    log_scale = _log_scale(estimate, reference, pairs, alignment.scale)
    offset_ns = checked_offset_ns(offset_s)
    if offset_ns:
        ours = replace(ours, time_ns=ours.time_ns + offset_ns)
    ours = alignment.apply_to(ours)
    if windowed:
        ours = ours[int(pairs.estimate_index.min()) : int(pairs.estimate_index.max()) + 1]
    pairs = replace(pairs, estimate=alignment.apply(pairs.estimate))
    if plane is not None:
        _say_folded(pairs.estimate, plane)
        ours, true = (replace(path, poses=projected(path.motors, plane)) for path in (ours, true))
        both = projected(pairs.estimate, plane), projected(pairs.reference, plane)
        pairs = replace(pairs, estimate=both[0], reference=both[1])
    return Matched(ours, true, pairs, alignment, align, log_scale)


def _say_folded(poses: Motor, plane: Plane) -> None:
    count = int(np.count_nonzero(folded(poses, plane)))
    if count:
        log.warning(
            "%d of %d poses face backwards in the plane %s: turns beyond 90° are folded back "
            "there, as in evo; rotation and relative errors mean little, positions are right",
            count,
            poses.shape[0],
            plane,
        )


def _log_scale(
    estimate: Trajectory, reference: Trajectory, pairs: Pairs, scale: float
) -> FloatArray | None:
    if isinstance(estimate.poses, Motor) and isinstance(reference.poses, Motor):
        return None
    ours = log_scales(estimate.poses)[pairs.estimate_index] + np.log(scale)
    ratio: FloatArray = ours - log_scales(reference.poses)[pairs.reference_index]
    return ratio
