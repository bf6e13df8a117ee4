"""Tables of methods by representations, tinted, and what the report calls things.

Blue is where less is left, orange where more is.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from motorcade.ga.versors.euler_angles import SEQUENCES
from motorcade.replays.comparison.report.results import REFERENCE, Ratio, Results, tied
from motorcade.replays.web.pages import PageCell


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


_STEPS_TO_RAW = (0.1, 0.2, 0.35, 0.6, 0.95, 1.05, 1.5, 2.5, 5.0, 10.0)
_STEPS_TO_MOTOR = (0.5, 0.7, 0.85, 0.95, 0.99, 1.01, 1.05, 1.2, 1.5, 3.0)
_STEPS = {
    "lag_ms": (2.0, 10.0, 25.0, 50.0, 100.0),
    "angular_rate_lag_ms": (2.0, 10.0, 25.0, 50.0, 100.0),
    "peak_rate_ratio": (1.05, 1.5, 3.0, 8.0, 20.0),
    "spurious_turns": (0.01, 0.1, 0.5, 1.0, 3.0),
}
_BLUE_TO_ORANGE = ("b5", "b4", "b3", "b2", "b1", "n", "o1", "o2", "o3", "o4", "o5")
_DASH = PageCell("–", math.nan, "none")
_ORANGE = ("n", "o1", "o2", "o3", "o4", "o5")


@dataclass(frozen=True)
class Matrix:
    """A table: what it shows, its columns, and rows of a name and cells."""

    key: str
    group: str
    title: str
    caption: str
    corner: str
    columns: Sequence[str]
    rows: Sequence[tuple[str, Sequence[PageCell]]]


def matrices(results: Results, scope: str) -> list[Matrix]:
    """Every table of a scope that has something to show."""
    every = [
        *(_to_raw(results, scope, metric) for metric in RATIOS),
        *(_to_motor(results, scope, metric) for metric in RATIOS),
        *(_sizes(results, scope, metric) for metric in SIZES),
    ]
    return [one for one in every if any(_known(cell) for _, row in one.rows for cell in row)]


def against_motor(results: Results, kind: str, names: Iterable[str], caption: str) -> Matrix:
    """Rows are motions or degradations: times what motors leave, over all methods."""
    rows = []
    for name in names:
        ratios = results.ratio_to_motor(f"{kind}:{name}", "score")
        cells = [_motor_cell(ratios.get(("all", one))) for one in results.representations]
        rows.append((name, cells))
    return Matrix(f"by-{kind}", "", f"By {kind}", caption, kind, results.representations, rows)


def best_of_each(results: Results) -> Matrix:
    """Rows are motions: what each representation leaves with the method that serves it best."""
    rows = []
    for motion in results.motions:
        best = [results.best_ratio(f"motion:{motion}", one) for one in results.representations]
        base = results.best_ratio(f"motion:{motion}", REFERENCE)
        rows.append((motion, [_best_cell(one, base) for one in best]))
    caption = (
        "Residual error and jitter, as a share of the raw poses', by the method that serves each "
        "representation best on that motion, over all degradations. Tinted against motors; no tint "
        "is within 1 %."
    )
    return Matrix("best-of-each", "", "", caption, "motion", results.representations, rows)


def _best_cell(best: tuple[Ratio, str] | None, base: tuple[Ratio, str] | None) -> PageCell:
    if best is None or base is None:
        return _DASH
    value, method = best[0].value, best[1]
    tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_MOTOR, value / base[0].value)]
    return PageCell(shown(value), value, tint, note=method)


def rotation_errors(results: Results, motion: str, degradation: str) -> Matrix:
    """Mean rotation error in degrees of a place, tinted by what is left of the raw poses'."""
    place = (motion, degradation)
    raw = results.figures[*place, "raw", "none", "rotation_rmse_deg"].mean

    def cell(method: str, representation: str) -> PageCell:
        figure = results.figures.get((*place, method, representation, "rotation_rmse_deg"))
        if figure is None or not math.isfinite(figure.mean):
            return _DASH
        tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_RAW, figure.mean / raw)]
        note = _note(Ratio(figure.mean, figure.low, figure.high))
        return PageCell(shown(figure.mean), figure.mean, tint, note=note)

    caption = (
        f"Rotation error in degrees on {motion} with {LABELS[degradation]}, root mean square, mean "
        f"over seeds. The raw poses have {shown(raw)}°; orange is more than that."
    )
    return _matrix(results, "crossing-errors", "", "rotation error", caption, cell)


def _to_raw(results: Results, scope: str, metric: str) -> Matrix:
    ratios = results.ratio_to_raw(scope, metric)
    ratios.pop(("raw", "none"), None)
    least = min((ratio.value for ratio in ratios.values()), default=math.nan)

    def cell(method: str, representation: str) -> PageCell:
        ratio = ratios.get((method, representation))
        if ratio is None:
            return _DASH
        tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_RAW, ratio.value)]
        return PageCell(shown(ratio.value), ratio.value, tint, ratio.value == least, _note(ratio))

    heading = METRICS[metric].heading
    caption = (
        f"{heading[0].upper()}{heading[1:]} left, as a share of the raw poses'. Blue is less than "
        "raw, orange more than raw; the best is outlined; a dash was not run in every place."
    )
    return _matrix(results, f"raw-{metric}", "left of the raw poses'", heading, caption, cell)


def _to_motor(results: Results, scope: str, metric: str) -> Matrix:
    ratios = results.ratio_to_motor(scope, metric)
    heading = METRICS[metric].heading
    caption = (
        f"{heading[0].upper()}{heading[1:]}, times what the same method leaves on motors. Blue is "
        "less than motors, orange more; no tint is a tie: an interval around 1, or within 1 %."
    )
    return _matrix(
        results,
        f"motor-{metric}",
        "times what motors leave",
        heading,
        caption,
        lambda method, representation: _motor_cell(ratios.get((method, representation))),
    )


def _motor_cell(ratio: Ratio | None) -> PageCell:
    if ratio is None or not math.isfinite(ratio.value):
        return _DASH
    tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_MOTOR, ratio.value)]
    return PageCell(
        shown(ratio.value), ratio.value, "n" if tied(ratio) else tint, note=_note(ratio)
    )


def _sizes(results: Results, scope: str, metric: str) -> Matrix:
    metric_text = METRICS[metric]
    factor = metric_text.factor

    def cell(method: str, representation: str) -> PageCell:
        value = factor * results.mean_size(scope, (method, representation), metric)
        if not math.isfinite(value):
            return _DASH
        return PageCell(shown(value), value, _ORANGE[bisect_left(_STEPS[metric], value)])

    unit = f", {metric_text.unit}" if metric_text.unit else ""
    caption = (
        f"Mean size of {metric_text.heading}{unit}, where it can be told: "
        f"{metric_text.definition}. Orange is "
        "more; dashes are where fewer than half of the places tell."
    )
    return _matrix(results, metric, "as measured", metric_text.heading, caption, cell)


def _matrix(
    results: Results,
    key: str,
    group: str,
    title: str,
    caption: str,
    cell: Callable[[str, str], PageCell],
) -> Matrix:
    rows = [
        (method, [cell(method, name) for name in results.representations])
        for method in results.methods
    ]
    return Matrix(key, group, title, caption, "method", results.representations, rows)


def _known(cell: PageCell) -> bool:
    return cell.value is not None and math.isfinite(cell.value)


def _note(ratio: Ratio) -> str:
    if not math.isfinite(ratio.low):
        return ""
    return f"95 %: {shown(ratio.low)} to {shown(ratio.high)}"


def place_rows(
    results: Results, motion: str, degradation: str, metrics: Sequence[str]
) -> list[tuple[str, str, list[PageCell]]]:
    """Method, representation and figures with intervals of one place; raw poses first."""
    places = []
    pairs = [("raw", "none")] + [(m, r) for m in results.methods for r in results.representations]
    for pair in pairs:
        figures = [results.figures.get((motion, degradation, *pair, name)) for name in metrics]
        cells = []
        for name, figure in zip(metrics, figures, strict=True):
            if figure is None or not math.isfinite(figure.mean):
                cells.append(_DASH)
                continue
            low, high = (shown_metric(name, end) for end in (figure.low, figure.high))
            note = f"{low} to {high}" if math.isfinite(figure.low) else ""
            value = METRICS[name].factor * figure.mean
            cells.append(PageCell(shown_metric(name, figure.mean), value, "none", note=note))
        if any(_known(cell) for cell in cells):
            places.append((*pair, cells))
    return places


_DEFECTS = (1e-10, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
_DEFECT_TINTS = ("b3", "n", "o1", "o2", "o3", "o4", "o5")
_TIMES_US = (1.0, 3.0, 10.0, 100.0, 1000.0)
_TIME_TINTS = ("b3", "b1", "n", "o1", "o2", "o3")
_RATIO_METRICS = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")


def trait_matrices(results: Results) -> list[Matrix]:
    """Defects on the world's and the sensor's side, and the time a pose."""
    rows = {
        (row["method"], row["representation"]): row
        for row in results.document["traits"]
        if not row["failure"]
    }
    if not rows:
        return []
    poses = next(iter(rows.values()))["poses"]
    tables = (
        (
            "left",
            "world's frame",
            "Largest difference between smoothing and then changing the world's frame, and the "
            "other way round. Blue is none but rounding (at most 1e-10).",
        ),
        ("right", "sensor's frame", "The same for the frame of the sensor: another mount."),
        ("time", "time a pose", f"Microseconds a pose over {poses} poses, called from Python."),
    )

    def matrix(key: str, title: str, caption: str) -> Matrix:
        def cell(method: str, representation: str) -> PageCell:
            return _trait_cell(rows.get((method, representation)), key)

        return _matrix(results, f"trait-{key}", "", title, caption, cell)

    return [matrix(*table) for table in tables]


def _trait_cell(row: Mapping[str, Any] | None, key: str) -> PageCell:
    if row is None:
        return _DASH
    if key == "time":
        value = row["time_us_per_pose"]
        return PageCell(shown(value), value, _TIME_TINTS[bisect_left(_TIMES_US, value)])
    metres, radians = row[f"{key}_defect_m"], row[f"{key}_defect_rad"]
    value = max(metres, radians)
    tint = _DEFECT_TINTS[bisect_left(_DEFECTS, value)]
    text = f"{value:.0e}" if value <= _DEFECTS[0] else f"{shown(value, 2)}"
    unit = "m" if value == metres else "rad"
    note = f"{metres:.1e} m, {radians:.1e} rad"
    return PageCell(f"{text} {unit}", value, tint, note=note)


def exact_ties(results: Results) -> list[dict[str, Any]]:
    """A row a tie that theory predicts, over the methods it was tried on."""
    ties = results.document["exact_ties"]
    rows = []
    for theory in dict.fromkeys(one["theory"] for one in ties):
        of = [one for one in ties if one["theory"] == theory]
        largest = {
            unit: max(row[f"largest_difference_{unit}"] or 0.0 for row in of)
            for unit in ("m", "rad")
        }
        rows.append(
            {
                "theory": theory,
                "reason": of[0]["reason"],
                "methods": [one["method"] for one in of],
                "fails": [one["method"] for one in of if not one["holds"]],
                "holds": all(one["holds"] for one in of),
                "m": largest["m"],
                "rad": largest["rad"],
                "shown": " and ".join(
                    f"{value:.0e} {unit}" for unit, value in largest.items() if value > 0.0
                ),
            }
        )
    return rows


def verdict_counts(results: Results) -> list[dict[str, Any]]:
    """Place by place, method by method: how often each representation beats or ties with motors.

    Over APE, rotation error and both jitters.
    """
    counted = []
    for name in results.representations:
        rows = [
            row
            for row in results.document["verdicts"]
            if row["representation"] == name and row["metric"] in _RATIO_METRICS
        ]
        if name == REFERENCE or not rows:
            continue
        counts = {key: sum(row[key] for row in rows) for key in ("better", "tie", "equal", "worse")}
        total = sum(counts.values())
        shares = {key: 100.0 * count / total for key, count in counts.items()}
        counted.append({"name": name, "total": total, "counts": counts, "shares": shares})
    return counted
