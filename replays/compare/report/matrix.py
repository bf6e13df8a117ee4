"""Tables of methods by representations, tinted: blue where less is left, orange where more is."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from motorcade.replays.compare.report.names import (
    LABELS,
    METRICS,
    RATIOS,
    SIZES,
    shown,
    shown_metric,
)
from motorcade.replays.compare.report.results import REFERENCE, Ratio, Results, tied
from motorcade.replays.pages.parts import PageCell

__all__ = [
    "Matrix",
    "against_motor",
    "best_of_each",
    "matrices",
    "place_rows",
    "rotation_errors",
]

_STEPS_TO_RAW = (0.1, 0.2, 0.35, 0.6, 0.95, 1.05, 1.5, 2.5, 5.0, 10.0)
_STEPS_TO_MOTOR = (0.5, 0.7, 0.85, 0.95, 0.99, 1.01, 1.05, 1.2, 1.5, 3.0)
_STEPS = {
    "lag_ms": (2.0, 10.0, 25.0, 50.0, 100.0),
    "angular_rate_lag_ms": (2.0, 10.0, 25.0, 50.0, 100.0),
    "peak_rate_ratio": (1.05, 1.5, 3.0, 8.0, 20.0),
    "spurious_turns": (0.01, 0.1, 0.5, 1.0, 3.0),
}
_BLUE_TO_ORANGE = ("b5", "b4", "b3", "b2", "b1", "n", "o1", "o2", "o3", "o4", "o5")
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
    made = [
        *(_to_raw(results, scope, metric) for metric in RATIOS),
        *(_to_motor(results, scope, metric) for metric in RATIOS),
        *(_sizes(results, scope, metric) for metric in SIZES),
    ]
    return [one for one in made if any(_known(cell) for _, row in one.rows for cell in row)]


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
        cells = []
        for one in best:
            if one is None or base is None:
                cells.append(PageCell("–", math.nan, "none"))
                continue
            ratio, method = one
            tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_MOTOR, ratio.value / base[0].value)]
            cells.append(PageCell(shown(ratio.value), ratio.value, tint, note=method))
        rows.append((motion, cells))
    caption = (
        "Residual error and jitter, as a share of the raw poses', by the method that serves each "
        "representation best on that motion, over all degradations. Tinted against motors; no tint "
        "is within 1 %."
    )
    return Matrix("best-of-each", "", "", caption, "motion", results.representations, rows)


def rotation_errors(results: Results, motion: str, degradation: str) -> Matrix:
    """Mean rotation error in degrees of a place, tinted by what is left of the raw poses'."""
    place = (motion, degradation)
    raw = results.figures[*place, "raw", "none", "rotation_rmse_deg"].mean

    def cell(method: str, representation: str) -> PageCell:
        figure = results.figures.get((*place, method, representation, "rotation_rmse_deg"))
        if figure is None or not math.isfinite(figure.mean):
            return PageCell("–", math.nan, "none")
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
            return PageCell("–", math.nan, "none")
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
        return PageCell("–", math.nan, "none")
    tint = _BLUE_TO_ORANGE[bisect_left(_STEPS_TO_MOTOR, ratio.value)]
    return PageCell(
        shown(ratio.value), ratio.value, "n" if tied(ratio) else tint, note=_note(ratio)
    )


def _sizes(results: Results, scope: str, metric: str) -> Matrix:
    told = METRICS[metric]
    factor = told.factor

    def cell(method: str, representation: str) -> PageCell:
        value = factor * results.mean_size(scope, (method, representation), metric)
        if not math.isfinite(value):
            return PageCell("–", math.nan, "none")
        return PageCell(shown(value), value, _ORANGE[bisect_left(_STEPS[metric], value)])

    unit = f", {told.unit}" if told.unit else ""
    caption = (
        f"Mean size of {told.heading}{unit}, where it can be told: {told.definition}. Orange is "
        "more; dashes are where fewer than half of the places tell."
    )
    return _matrix(results, metric, "as measured", told.heading, caption, cell)


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
    made = []
    pairs = [("raw", "none")] + [(m, r) for m in results.methods for r in results.representations]
    for pair in pairs:
        figures = [results.figures.get((motion, degradation, *pair, name)) for name in metrics]
        cells = []
        for name, figure in zip(metrics, figures, strict=True):
            if figure is None or not math.isfinite(figure.mean):
                cells.append(PageCell("–", math.nan, "none"))
                continue
            low, high = (shown_metric(name, end) for end in (figure.low, figure.high))
            note = f"{low} to {high}" if math.isfinite(figure.low) else ""
            value = METRICS[name].factor * figure.mean
            cells.append(PageCell(shown_metric(name, figure.mean), value, "none", note=note))
        if any(_known(cell) for cell in cells):
            made.append((*pair, cells))
    return made
