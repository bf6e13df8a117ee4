"""How the report calls things: metrics with units, definitions and sources; a line a name."""

from __future__ import annotations

import math
from typing import NamedTuple

from motorcade.ga.versors.euler_angles import SEQUENCES


class Metric(NamedTuple):
    """Heading, shown unit, factor into it, one line of definition, and its source."""

    heading: str
    unit: str
    factor: float
    definition: str
    source: str


METRICS = {
    "score": Metric(
        "residual error and jitter",
        "",
        1.0,
        "mean of four ratios to the raw poses: APE, rotation, linear and angular jitter; geometric "
        "mean over motions and degradations. Parameters are tuned by it",
        "defined here",
    ),
    "ape_rmse_m": Metric(
        "APE",
        "mm",
        1e3,
        "root mean square distance between smoothed and true positions, without alignment",
        "J. Sturm et al., A benchmark for the evaluation of RGB-D SLAM systems, 2012; as evo's",
    ),
    "rotation_rmse_deg": Metric(
        "rotation error",
        "°",
        1.0,
        "root mean square angle between smoothed and true orientations, along the geodesic",
        "D. Q. Huynh, Metrics for 3D rotations, 2009",
    ),
    "linear_jitter_m_s2": Metric(
        "linear jitter",
        "m/s²",
        1.0,
        "root mean square of (acceleration − true acceleration), by second differences at the "
        "same stamps",
        "defined here",
    ),
    "angular_jitter_rad_s2": Metric(
        "angular jitter",
        "rad/s²",
        1.0,
        "the same of angular acceleration in the moving frame",
        "defined here",
    ),
    "lag_ms": Metric(
        "lag",
        "ms",
        1.0,
        "where the cross-correlation of positions with the ground truth peaks, to a fraction of a "
        "sample; "
        "positive is late",
        "C. H. Knapp, G. C. Carter, The generalized correlation method, 1976",
    ),
    "angular_rate_lag_ms": Metric(
        "lag of rotation",
        "ms",
        1.0,
        "the same of angular rates",
        "as above",
    ),
    "overshoot_m": Metric(
        "overshoot",
        "mm",
        1e3,
        "how far positions run on where the ground truth stops or turns back; noise has some too",
        "K. Ogata, Modern control engineering: maximum overshoot",
    ),
    "rotation_overshoot_deg": Metric(
        "rotation overshoot", "°", 1.0, "the same of orientations", "as above"
    ),
    "rotation_path_ratio": Metric(
        "rotation path",
        "× true",
        1.0,
        "length of the path of orientations over the true one's; 1 is right",
        "gimbal index, defined here",
    ),
    "peak_rate_ratio": Metric(
        "peak rate",
        "× true",
        1.0,
        "largest angular rate from stamp to stamp over the largest true one; 1 is right",
        "gimbal index, defined here",
    ),
    "spurious_turns": Metric(
        "spurious turns",
        "",
        1.0,
        "full revolutions that the path makes and the ground truth does not",
        "gimbal index, defined here",
    ),
    "log_scale_rmse": Metric(
        "scale error",
        "%",
        1e2,
        "root mean square of the logarithm of (scale / true scale); similarities only",
        "defined here",
    ),
}
RATIOS = ("score", "ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")
"""Shown as what is left of the raw poses' figure."""
SIZES = ("lag_ms", "angular_rate_lag_ms", "peak_rate_ratio", "spurious_turns")
"""Shown as they are, in their unit."""

REPRESENTATIONS = {
    "motor": "one screw motion from pose to pose, rotation and translation together",
    "similarity": "the same with the scale in it",
    "rotor": "rotation by logarithms, translation separately in the world",
    "dual_quaternion": "eight numbers averaged and projected back",
    "quaternion": "four numbers averaged and renormalised, translation separately",
    "euler_best": "three angles in the order of axes that stays farthest from gimbal lock, each "
    "triple the nearest to the one before; translation separately",
    "euler_unwrapped": "angles x-y′-z″, each made continuous for itself, translation separately",
    "euler": "angles x-y′-z″ as they come, wrapped at ±180°, translation separately",
} | {
    f"euler_{order}": f"three angles in the order {order}, each triple the nearest to the one "
    "before; translation separately"
    for order in SEQUENCES
}
METHODS = {
    "auto": "estimates the noise and picks method and parameters",
    "exponential": "low-pass of first order; causal",
    "double_exponential": "low-pass with a trend; causal",
    "one_euro": "low-pass whose cut-off rises with speed; causal",
    "constant_velocity": "Kalman filter; causal",
    "constant_acceleration": "Kalman filter; causal",
    "rts_constant_velocity": "Kalman filter and backward pass; sees the future",
    "rts_constant_acceleration": "Kalman filter and backward pass; sees the future",
    "gaussian": "moving Gaussian window; sees the future",
    "savitzky_golay": "moving polynomial, even weights; sees the future",
    "local_polynomial": "moving polynomial, tricube weights; sees the future",
    "spline": "cumulative B-spline fit; sees the future",
    "robust_map": "all poses at once, outliers weighed down; sees the future",
}
LABELS = {
    "gaussian": "plain noise",
    "gaussian_strong": "strong noise",
    "outliers": "outliers",
    "outliers_and_flips": "outliers and flips",
    "quantised": "quantisation",
    "stamp_jitter": "stamp jitter",
    "dropped_frames": "dropped frames",
    "latency": "latency",
    "recorded": "its own noise",
}
"""Degradations in sentences."""
CAUSAL = (
    "exponential",
    "double_exponential",
    "one_euro",
    "constant_velocity",
    "constant_acceleration",
)
"""Methods that need no pose that is still to come."""
MOTIONS = {
    "gimbal_crossing_slow": "swings through gimbal lock and back at 0.5 rad/s, missing it by 1°",
    "gimbal_crossing": "swings through gimbal lock and back at 2 rad/s, missing it by 1°",
    "gimbal_crossing_fast": "swings through gimbal lock and back at 4 rad/s, missing it by 1°",
    "gimbal_hover": "looks about within 5° of gimbal lock",
    "tumble": "a free symmetric top",
    "screw": "turns and rises at a constant rate",
    "distant_circle": "swings about an axis 10 m away: small turns, large shifts",
    "handheld": "a camera in the hand, random in a band",
    "walk_and_look": "walks, bobs, and looks left, right and down",
    "stop_and_go": "goes from place to place and stands still at each",
    "fast_spin": "spins at 20 rad/s about a tilted axis",
    "antipodal_crossing": "turns by 270° and back, through half a turn each time",
    "zoom": "grows and shrinks while turning and wandering: a similarity",
}
DEGRADATIONS = {
    "gaussian": "noise of 5 mm and 0.5°",
    "gaussian_strong": "noise of 20 mm and 2°",
    "outliers": "noise, and 5 % heavy-tailed outliers",
    "outliers_and_flips": "noise, outliers, and 2 % planar-pose flips in runs",
    "quantised": "rounded to 10 mm and 1°",
    "stamp_jitter": "noise, and stamps off by 5 ms",
    "dropped_frames": "noise, and 20 % of frames lost in runs",
    "latency": "noise, and poses 50 ± 10 ms late",
    "recorded": "as recorded",
}


def shown(value: float | None, digits: int = 3) -> str:
    """A number with that many significant digits, at most four decimals, or a dash."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if abs(value) < 5e-5:
        return f"{value:.0e}".replace("e-0", "e-")
    after = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{min(after, 4)}f}"
    return text if abs(value) < 10_000 else f"{float(f'{value:.{digits}g}'):,.0f}"


def shown_metric(metric: str, value: float) -> str:
    """A metric's value in its shown unit, without naming it."""
    return shown(value * METRICS[metric].factor)


def listed(names: list[str]) -> str:
    """``a, b and c``."""
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]
