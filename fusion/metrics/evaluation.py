"""The whole comparison of an estimated trajectory with a reference, as one value.

Keys carry their units: errors in metres and degrees, lag in milliseconds (positive is late);
ratios and logarithms have none.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from time import perf_counter
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
from motorcade.fusion.metrics.poses.pose_error import (
    Delta,
    Drift,
    Relation,
    Statistics,
    absolute_errors,
    constant_rotation,
    drift_by_length,
    log_scales,
    relative_errors,
    tilt_rad,
)
from motorcade.fusion.metrics.smooth_path import NotObservableError
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive

log = logging.getLogger("motorcade.metrics")
T = TypeVar("T")

_ERRORS = (
    "ape_m",
    "rotation_deg",
    "rotation_rest_deg",
    "tilt_deg",
    "rpe_trans_m",
    "rpe_rot_deg",
    "rpe_by_length_trans_m",
    "rpe_by_length_rot_deg",
)
_RELATION_NAMES: Mapping[Relation, tuple[str, str]] = {
    "full": ("full", ""),
    "trans_part": ("trans_part", "_m"),
    "rot_part": ("rot_part", ""),
    "angle_deg": ("angle", "_deg"),
    "angle_rad": ("angle", "_rad"),
    "point_distance": ("point_distance", "_m"),
    "point_distance_error_ratio": ("point_distance_error", "_percent"),
}


@dataclass(frozen=True)
class Evaluation:
    """Figures of one estimate against one reference, after the alignment named in `align`.

    Fields:
        align: "none", "se3", "sim3", "yaw", "scale", "origin" or "scaled_origin".
        pairs: how many poses were compared.
        scale: the factor that the alignment put on the estimate.
        ape_m: distance between positions.
        ape_axes_rmse_m: its root mean squares along x, y and z of the reference's world.
        rotation_deg: angle between orientations.
        rotation_constant_deg: the part of it that one turn of the world, or of what moves, takes
            away, whichever leaves less: an alignment by few positions, or extrinsics, not an error
            of every pose.
        rotation_rest_deg: the angle that is left then.
        tilt_deg: angle between the two directions of up.
        log_scale: logarithm of the ratio of the scales; None where both are rigid.
        rpe_trans_m, rpe_rot_deg: error of the motion over `rpe_delta`; None where no poses are so
            far apart.
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
        rpe_delta: between which poses relative errors are taken.
        relations: errors by evo's pose relations, where they were asked for: name, unit as a suffix
            of keys, and summary, which is None as for `rpe_trans_m`.
        drift: KITTI's, where it was asked for; empty where the path is shorter than all lengths.

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
    ape_axes_rmse_m: tuple[float, float, float]
    rotation_deg: Statistics
    rotation_constant_deg: float
    rotation_rest_deg: Statistics
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
    rpe_delta: Delta
    relations: tuple[tuple[str, str, Statistics | None], ...] = ()
    drift: tuple[Drift, ...] | None = None

    def as_dict(self) -> dict[str, float | int | str | None]:
        """Flat figures ready for JSON: ``ape_rmse_m``, ``rpe_rot_rmse_deg``, ``lag_ms``, …

        Each error gives ``rmse``, ``mean``, ``median``, ``std``, ``min`` and ``max`` as
        ``<error>_<statistic>_<unit>``. Every key is always there, but those of `rpe_delta`,
        `relations` and `drift` only where they were asked for; what could not be told is None.
        """
        flat: dict[str, float | int | str | None] = {
            "align": self.align,
            "pairs": self.pairs,
            "scale": self.scale,
        }
        for name in _ERRORS:
            error, _, unit = name.rpartition("_")
            statistics = getattr(self, name)
            for statistic in Statistics.names():
                flat[f"{error}_{statistic}_{unit}"] = getattr(statistics, statistic, None)
        for axis, rmse_m in zip("xyz", self.ape_axes_rmse_m, strict=True):
            flat[f"ape_{axis}_rmse_m"] = rmse_m
        for statistic in Statistics.names():
            flat[f"log_scale_{statistic}"] = getattr(self.log_scale, statistic, None)
        flat["rotation_constant_deg"] = self.rotation_constant_deg
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
        if self.rpe_delta != Delta():
            flat["rpe_delta"], flat["rpe_delta_unit"] = self.rpe_delta.value, self.rpe_delta.unit
            flat["rpe_pairs"] = "all" if self.rpe_delta.all_pairs else "consecutive"
        for error, unit, statistics in self.relations:
            for statistic in Statistics.names():
                flat[f"{error}_{statistic}{unit}"] = getattr(statistics, statistic, None)
        return flat if self.drift is None else flat | _flat_drift(self.drift)


def evaluate(
    estimate: Trajectory,
    reference: Trajectory,
    align: Align = "none",
    max_difference_s: float = 0.01,
    rpe_length_m: float = 1.0,
    energy_above_hz: float = 5.0,
) -> Evaluation:
    """Compare an estimate with a reference of the same moving frame.

    `match` and `evaluate_matched` do the same, with more to choose.

    Args:
        estimate: the trajectory to judge, at any rate; of similarities the rigid part is judged,
            and the scale apart.
        reference: the ground truth, at any rate; stamps are paired as in `associate`.
        align: "none", "se3" (turn and shift the estimate's world), "sim3" (and scale it), or
            another of `alignment_of`.
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
    matched = match(estimate, reference, align, max_difference_s=max_difference_s)
    return evaluate_matched(matched, rpe_length_m, energy_above_hz)


def evaluate_matched(
    matched: Matched,
    rpe_length_m: float = 1.0,
    energy_above_hz: float = 5.0,
    *,
    delta: Delta | None = None,
    relations: Sequence[Relation] = (),
    drift_lengths_m: Sequence[float] = (),
) -> Evaluation:
    """All figures of what `match` made comparable.

    Args:
        matched: the estimate beside its ground truth.
        rpe_length_m: length of path for the relative error by length, above zero.
        energy_above_hz: cut-off of the spectral energy, as `evaluate` has it.
        delta: between which poses relative errors are taken; one frame unless said otherwise.
        relations: evo's pose relations to report beside, absolute and relative.
        drift_lengths_m: of KITTI's drift, which is not told unless there are some.

    Raises:
        ValueError: a relation, length or cut-off that there is not.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.metrics import Delta, evaluate_matched, match
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> found = evaluate_matched(
        ...     match(noisy, true, "se3", n_to_align=30),
        ...     delta=Delta(10, all_pairs=True),
        ...     relations=["full", "point_distance"],
        ... ).as_dict()
        >>> print(f"{found['ape_full_rmse']:.3f}, {found['rpe_point_distance_rmse_m']:.3f} m")
        0.057, 0.014 m
    """
    ours, true = matched.pairs.estimate, matched.pairs.reference
    aligned, reference = matched.estimate, matched.reference
    delta = Delta() if delta is None else delta
    trans, rot, *others = _relative(ours, true, delta, relations)
    checked_positive(rpe_length_m, "rpe_length_m")
    far_trans, far_rot = _relative(ours, true, Delta(rpe_length_m, "m"))
    above_hz = checked_positive(energy_above_hz, "energy_above_hz")
    if len(aligned) > 1:
        above_hz = min(above_hz, 0.25 / float(np.median(np.diff(aligned.time_s))))
    constant_rad, rest_rad = constant_rotation(ours, true)
    apart_m = ours.translation_m - true.translation_m
    x_m, y_m, z_m = np.sqrt(np.mean(apart_m**2, axis=0)).tolist()
    return Evaluation(
        align=matched.align,
        pairs=len(matched.pairs),
        scale=matched.alignment.scale,
        ape_m=Statistics.of(absolute_errors(ours, true, "trans_part")),
        ape_axes_rmse_m=(x_m, y_m, z_m),
        rotation_deg=Statistics.of(absolute_errors(ours, true, "angle_deg")),
        rotation_constant_deg=degrees(constant_rad),
        rotation_rest_deg=Statistics.of(np.rad2deg(rest_rad)),
        tilt_deg=Statistics.of(np.rad2deg(tilt_rad(ours, true))),
        log_scale=None if matched.log_scale is None else Statistics.of(np.abs(matched.log_scale)),
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
        rpe_delta=delta,
        relations=_by_relation(ours, true, relations, others),
        drift=_drift(ours, true, drift_lengths_m),
    )


def _relative(
    ours: Motor, true: Motor, delta: Delta, relations: Sequence[Relation] = ()
) -> list[Statistics | None]:
    wanted: tuple[Relation, ...] = ("trans_part", "angle_deg", *relations)
    per_relation = _if_observable(lambda: relative_errors(ours, true, delta, wanted))
    if per_relation is None:
        return [None] * len(wanted)
    return [Statistics.of(errors) if errors.size else None for errors in per_relation]


def _by_relation(
    ours: Motor, true: Motor, relations: Sequence[Relation], relative: list[Statistics | None]
) -> tuple[tuple[str, str, Statistics | None], ...]:
    summaries: list[tuple[str, str, Statistics | None]] = []
    for relation in relations:
        if relation != "point_distance_error_ratio":
            name, unit = _RELATION_NAMES[relation]
            errors = absolute_errors(ours, true, relation)
            summaries.append((f"ape_{name}", unit, Statistics.of(errors)))
    for relation, summary in zip(relations, relative, strict=True):
        name, unit = _RELATION_NAMES[relation]
        summaries.append((f"rpe_{name}", unit, summary))
    return tuple(summaries)


def _drift(ours: Motor, true: Motor, lengths_m: Sequence[float]) -> tuple[Drift, ...] | None:
    if not lengths_m:
        return None
    return _if_observable(lambda: drift_by_length(ours, true, lengths_m)) or ()


def _flat_drift(drift: Sequence[Drift]) -> dict[str, float | int | str | None]:
    """KITTI's figures by length, and their mean over all sub-sequences as its table has them."""
    flat: dict[str, float | int | str | None] = {}
    count = sum(one.count for one in drift)
    flat["drift_subsequences"] = count
    for key, factor, field in (
        ("translation_percent", 100.0, "translation"),
        ("rotation_deg_100m", 100.0 * degrees(1.0), "rotation_rad_m"),
    ):
        each = {one.length_m: factor * float(getattr(one, field)) for one in drift}
        whole = sum(one.count * each[one.length_m] for one in drift)
        flat[f"drift_{key}"] = whole / count if count else None
        flat |= {f"drift_{length:g}m_{key}": value for length, value in each.items()}
    return flat


def _if_observable(figure: Callable[[], T]) -> T | None:
    """The figure, or None where the trajectories cannot tell it."""
    try:
        return figure()
    except NotObservableError:
        return None


def seconds_per_pose(
    smoother: Callable[[Trajectory], Trajectory], trajectory: Trajectory, repeats: int = 3
) -> float:
    """Wall time of the fastest of `repeats` runs over the number of poses, in seconds.

    The fastest run is the one that other work disturbed least. A short trajectory also shows what
    a call costs that has nothing to do with its length.

    Raises:
        ValueError: fewer than one run.

    Examples:
        >>> from motorcade.fusion import smooth
        >>> from motorcade.fusion.metrics import seconds_per_pose
        >>> from motorcade.fusion.motions import screw
        >>> path = screw().sampled(30.0, 2.0)
        >>> seconds_per_pose(lambda given: smooth(given, "gaussian"), path) > 0.0
        True
    """
    if repeats < 1:
        raise ValueError(f"repeats: expected 1 or more, got {repeats}")
    fastest_s = float("inf")
    for _ in range(repeats):
        start_s = perf_counter()
        smoother(trajectory)
        fastest_s = min(fastest_s, perf_counter() - start_s)
    return fastest_s / len(trajectory)


# An estimate and its ground truth made comparable, in evo's order: the window on the ground truth,
# pairs by stamps, alignment by the pairs, projection of both.


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
