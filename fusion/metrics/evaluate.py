"""The whole comparison of an estimated trajectory with a reference, as one value.

Keys carry their units: errors in metres and degrees, lag in milliseconds (positive is late).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TypeVar

import numpy as np

from motorcade.fusion.metrics.jitter import Jitter, jitter
from motorcade.fusion.metrics.lag import angular_rate_lag_s, position_lag_s
from motorcade.fusion.metrics.pose_error import (
    Align,
    Pairs,
    Statistics,
    absolute_translation_m,
    alignment_of,
    associate,
    relative_errors,
    rotation_rad,
    tilt_rad,
)
from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor, Trajectory

__all__ = ["Evaluation", "evaluate"]

T = TypeVar("T")


@dataclass(frozen=True)
class Evaluation:
    """Figures of one estimate against one reference, after the alignment named in `align`.

    Fields:
        align: "none", "se3" or "sim3".
        pairs: how many poses were compared.
        scale: the factor that the alignment put on the estimate (1 unless sim3).
        ape_m: distance between positions.
        rotation_deg: angle between orientations.
        tilt_deg: angle between the two directions of up.
        rpe_trans_m, rpe_rot_deg: error of the motion over one frame; None from a single pair.
        jitter: acceleration that the reference does not have; None where fewer than three
            consecutive stamps lie within the reference.
        lag_ms: lag of the positions; None where they do not move enough to tell.
        angular_rate_lag_ms: lag of the angular rates; None likewise.
    """

    align: Align
    pairs: int
    scale: float
    ape_m: Statistics
    rotation_deg: Statistics
    tilt_deg: Statistics
    rpe_trans_m: Statistics | None
    rpe_rot_deg: Statistics | None
    jitter: Jitter | None
    lag_ms: float | None
    angular_rate_lag_ms: float | None

    def as_dict(self) -> dict[str, float | int | str | None]:
        """Flat figures ready for JSON: ``ape_rmse_m``, ``rpe_rot_rmse_deg``, ``lag_ms``, …

        Each error gives ``rmse``, ``mean``, ``median``, ``std``, ``min`` and ``max`` as
        ``<error>_<statistic>_<unit>``. Every key is always there; what could not be told is None.
        """
        flat: dict[str, float | int | str | None] = {
            "align": self.align,
            "pairs": self.pairs,
            "scale": self.scale,
        }
        for name in ("ape_m", "rotation_deg", "tilt_deg", "rpe_trans_m", "rpe_rot_deg"):
            error, _, unit = name.rpartition("_")
            found = getattr(self, name)
            for statistic in Statistics.names():
                value = None if found is None else getattr(found, statistic)
                flat[f"{error}_{statistic}_{unit}"] = value
        shake = {} if self.jitter is None else asdict(self.jitter)
        flat["linear_jitter_m_s2"] = shake.get("linear_m_s2")
        flat["angular_jitter_rad_s2"] = shake.get("angular_rad_s2")
        flat["lag_ms"] = self.lag_ms
        flat["angular_rate_lag_ms"] = self.angular_rate_lag_ms
        return flat


def evaluate(
    estimate: Trajectory,
    reference: Trajectory,
    align: Align = "none",
    max_difference_s: float = 0.01,
) -> Evaluation:
    """Compare an estimate with a reference of the same moving frame.

    Args:
        estimate: the trajectory to judge, at any rate.
        reference: the truth, at any rate; stamps are paired as in `associate`.
        align: "none", "se3" (turn and shift the estimate's world) or "sim3" (and scale it).
        max_difference_s: how far apart paired stamps may be, in seconds.

    Raises:
        ValueError: an unknown alignment, no stamps near enough, or positions that cannot be
            aligned (fewer than three, or on one line).
    """
    pairs = associate(estimate, reference, max_difference_s)
    alignment = alignment_of(pairs, align)
    ours = alignment.apply(pairs.estimate)
    trans, rot = _relative(ours, pairs)
    moved = alignment.apply_to(estimate)
    return Evaluation(
        align=align,
        pairs=len(pairs),
        scale=alignment.scale,
        ape_m=Statistics.of(absolute_translation_m(ours, pairs.reference)),
        rotation_deg=Statistics.of(np.rad2deg(rotation_rad(ours, pairs.reference))),
        tilt_deg=Statistics.of(np.rad2deg(tilt_rad(ours, pairs.reference))),
        rpe_trans_m=trans,
        rpe_rot_deg=rot,
        jitter=_where_observable(lambda: jitter(moved, reference)),
        lag_ms=_where_observable(lambda: 1e3 * position_lag_s(moved, reference)),
        angular_rate_lag_ms=_where_observable(lambda: 1e3 * angular_rate_lag_s(moved, reference)),
    )


def _relative(ours: Motor, pairs: Pairs) -> tuple[Statistics | None, Statistics | None]:
    if len(pairs) < 2:
        return None, None
    steps_m, steps_rad = relative_errors(ours, pairs.reference)
    return Statistics.of(steps_m), Statistics.of(np.rad2deg(steps_rad))


def _where_observable(figure: Callable[[], T]) -> T | None:
    try:
        return figure()
    except NotObservableError:
        return None
