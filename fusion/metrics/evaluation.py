"""The whole comparison of an estimated trajectory with a reference, as one value.

Keys carry their units: errors in metres and degrees, lag in milliseconds (positive is late);
ratios and logarithms have none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import degrees
from typing import TypeVar

import numpy as np

from motorcade.fusion.metrics.artifacts import (
    GimbalIndex,
    gimbal_index,
    position_overshoot_m,
    rotation_overshoot_rad,
)
from motorcade.fusion.metrics.jitter import (
    EnergyExcess,
    Jitter,
    Smoothness,
    energy_excess_above,
    jitter,
    log_dimensionless_jerk,
)
from motorcade.fusion.metrics.lag import angular_rate_lag_s, position_lag_s
from motorcade.fusion.metrics.pose_error import (
    Align,
    Pairs,
    Statistics,
    absolute_translation_m,
    alignment_of,
    associate,
    log_scales,
    relative_errors,
    rotation_rad,
    tilt_rad,
    without_scale,
)
from motorcade.fusion.metrics.relative_by_length import relative_errors_by_length
from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray

T = TypeVar("T")

_ERRORS = (
    "ape_m",
    "rotation_deg",
    "tilt_deg",
    "rpe_trans_m",
    "rpe_rot_deg",
    "rpe_by_length_trans_m",
    "rpe_by_length_rot_deg",
)


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
        log_scale: logarithm of the ratio of the scales; None where both are rigid.
        rpe_trans_m, rpe_rot_deg: error of the motion over one frame; None from a single pair.
        rpe_length_m: length of path for the next two.
        rpe_by_length_trans_m, rpe_by_length_rot_deg: error of the motion over that length; None
            where the path is shorter.
        jitter: acceleration that the reference does not have; None where fewer than three
            consecutive stamps lie within the reference.
        energy_above_hz: cut-off for the next.
        energy_excess: mean square acceleration above it, less the reference's; None where no 16
            poses stand together within the reference.
        log_jerk: log dimensionless jerk of the estimate itself; None for fewer than five poses.
        lag_ms: lag of the positions; None where they do not move enough to tell.
        angular_rate_lag_ms: lag of the angular rates; None likewise.
        overshoot_m, rotation_overshoot_deg: largest overshoot at stops and turns; None where the
            reference has none.
        gimbal: turning beside the reference's; None where that does not turn.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import evaluate
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> figures = evaluate(noisy, true).as_dict()
        >>> figures["pairs"], round(figures["ape_rmse_m"], 3), figures["spurious_turns"]
        (121, 0.017, 0)
    """

    align: Align
    pairs: int
    scale: float
    ape_m: Statistics
    rotation_deg: Statistics
    tilt_deg: Statistics
    log_scale: Statistics | None
    rpe_trans_m: Statistics | None
    rpe_rot_deg: Statistics | None
    rpe_length_m: float
    rpe_by_length_trans_m: Statistics | None
    rpe_by_length_rot_deg: Statistics | None
    jitter: Jitter | None
    energy_above_hz: float
    energy_excess: EnergyExcess | None
    log_jerk: Smoothness | None
    lag_ms: float | None
    angular_rate_lag_ms: float | None
    overshoot_m: float | None
    rotation_overshoot_deg: float | None
    gimbal: GimbalIndex | None

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
        for name in _ERRORS:
            error, _, unit = name.rpartition("_")
            found = getattr(self, name)
            for statistic in Statistics.names():
                flat[f"{error}_{statistic}_{unit}"] = getattr(found, statistic, None)
        for statistic in Statistics.names():
            flat[f"log_scale_{statistic}"] = getattr(self.log_scale, statistic, None)
        flat["rpe_length_m"] = self.rpe_length_m
        flat["linear_jitter_m_s2"] = getattr(self.jitter, "linear_m_s2", None)
        flat["angular_jitter_rad_s2"] = getattr(self.jitter, "angular_rad_s2", None)
        flat["energy_above_hz"] = self.energy_above_hz
        excess = self.energy_excess
        flat["linear_energy_excess_m2_s4"] = getattr(excess, "linear_m2_s4", None)
        flat["angular_energy_excess_rad2_s4"] = getattr(excess, "angular_rad2_s4", None)
        flat["linear_log_jerk"] = getattr(self.log_jerk, "linear", None)
        flat["angular_log_jerk"] = getattr(self.log_jerk, "angular", None)
        for name in ("lag_ms", "angular_rate_lag_ms", "overshoot_m", "rotation_overshoot_deg"):
            flat[name] = getattr(self, name)
        flat["rotation_path_ratio"] = getattr(self.gimbal, "path_ratio", None)
        flat["peak_rate_ratio"] = getattr(self.gimbal, "peak_rate_ratio", None)
        flat["spurious_turns"] = getattr(self.gimbal, "spurious_turns", None)
        return flat


def evaluate(
    estimate: Trajectory,
    reference: Trajectory,
    align: Align = "none",
    max_difference_s: float = 0.01,
    rpe_length_m: float = 1.0,
    energy_above_hz: float = 5.0,
) -> Evaluation:
    """Compare an estimate with a reference of the same moving frame.

    Args:
        estimate: the trajectory to judge, at any rate; of similarities the rigid part is judged,
            and the scale apart.
        reference: the ground truth, at any rate; stamps are paired as in `associate`.
        align: "none", "se3" (turn and shift the estimate's world) or "sim3" (and scale it).
        max_difference_s: how far apart paired stamps may be, in seconds.
        rpe_length_m: length of path for the relative error by length, above zero.
        energy_above_hz: cut-off of the spectral energy, above zero; for slow estimates a quarter
            of their rate takes its place.

    Raises:
        ValueError: an unknown alignment, no stamps near enough, positions that cannot be aligned
            (fewer than three, or on one line), or a length or cut-off that is not positive.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import evaluate
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> found = evaluate(noisy, true)
        >>> print(f"{found.ape_m.rmse:.3f} m, {found.rotation_deg.rmse:.1f}°")
        0.017 m, 1.9°
        >>> print(f"{found.jitter.linear_m_s2:.0f} m/s²")
        36 m/s²
    """
    sized = estimate, reference
    estimate, reference = without_scale(estimate), without_scale(reference)
    pairs = associate(estimate, reference, max_difference_s)
    alignment = alignment_of(pairs, align)
    ours = alignment.apply(pairs.estimate)
    trans, rot = _relative(lambda: relative_errors(ours, pairs.reference), len(pairs))
    by_length = partial(relative_errors_by_length, ours, pairs.reference, rpe_length_m)
    far_trans, far_rot = _relative(by_length, len(pairs))
    aligned = alignment.apply_to(estimate)
    above_hz = _cutoff_hz(energy_above_hz, estimate)
    return Evaluation(
        align=align,
        pairs=len(pairs),
        scale=alignment.scale,
        ape_m=Statistics.of(absolute_translation_m(ours, pairs.reference)),
        rotation_deg=Statistics.of(np.rad2deg(rotation_rad(ours, pairs.reference))),
        tilt_deg=Statistics.of(np.rad2deg(tilt_rad(ours, pairs.reference))),
        log_scale=_log_scale(*sized, pairs, alignment.scale),
        rpe_trans_m=trans,
        rpe_rot_deg=rot,
        rpe_length_m=rpe_length_m,
        rpe_by_length_trans_m=far_trans,
        rpe_by_length_rot_deg=far_rot,
        jitter=_if_observable(lambda: jitter(aligned, reference)),
        energy_above_hz=above_hz,
        energy_excess=_if_observable(lambda: energy_excess_above(aligned, reference, above_hz)),
        log_jerk=_if_observable(lambda: log_dimensionless_jerk(aligned)),
        lag_ms=_if_observable(lambda: 1e3 * position_lag_s(aligned, reference)),
        angular_rate_lag_ms=_if_observable(lambda: 1e3 * angular_rate_lag_s(aligned, reference)),
        overshoot_m=_if_observable(lambda: position_overshoot_m(aligned, reference)),
        rotation_overshoot_deg=_if_observable(
            lambda: degrees(rotation_overshoot_rad(aligned, reference))
        ),
        gimbal=_if_observable(lambda: gimbal_index(aligned, reference)),
    )


def _log_scale(
    estimate: Trajectory, reference: Trajectory, pairs: Pairs, scale: float
) -> Statistics | None:
    if isinstance(estimate.poses, Motor) and isinstance(reference.poses, Motor):
        return None
    ours = log_scales(estimate.poses)[pairs.estimate_index] + np.log(scale)
    return Statistics.of(np.abs(ours - log_scales(reference.poses)[pairs.reference_index]))


def _relative(
    errors: Callable[[], tuple[FloatArray, FloatArray]], pairs: int
) -> tuple[Statistics | None, Statistics | None]:
    found = _if_observable(errors) if pairs > 1 else None
    if found is None:
        return None, None
    return Statistics.of(found[0]), Statistics.of(np.rad2deg(found[1]))


def _cutoff_hz(wanted_hz: float, estimate: Trajectory) -> float:
    if not 0.0 < wanted_hz < np.inf:
        raise ValueError(f"energy_above_hz: expected a number above 0, got {wanted_hz}")
    if len(estimate) < 2:
        return wanted_hz
    return min(wanted_hz, 0.25 / float(np.median(np.diff(estimate.time_s))))


def _if_observable(figure: Callable[[], T]) -> T | None:
    """The figure, or None where the trajectories cannot tell it."""
    try:
        return figure()
    except NotObservableError:
        return None
