"""The report's plots: paths smoothed once more, and their errors over time.

A passage through gimbal lock, drawn frame by frame: the true camera and every smoothed one.

The camera is a pyramid seen from a fixed place without perspective; what is drawn are the recorded
poses themselves, none between them. The page's script only shows one frame after another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.fusion.metrics.artifacts import steps_rad
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import plot_series
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.comparison.plan import DegradedMotion, Setting
from motorcade.replays.comparison.report.matrix import LABELS, shown
from motorcade.replays.comparison.report.results import REFERENCE, Results
from motorcade.replays.comparison.tables import PLACE
from motorcade.replays.web.pages import PagePlot


@dataclass(frozen=True, eq=False)
class Replayed:
    """One seed of a motion and a degradation, smoothed by one method in every representation.

    Fields:
        time_s: stamps ``(N,)``.
        true: poses ``(N,)``.
        paths: poses ``(N,)`` by representation; without those that were refused, and without
            `similarity` where poses are rigid and it equals `motor`.
    """

    motion: str
    degradation: str
    method: str
    seed: int
    time_s: FloatArray
    true: Motor
    paths: Mapping[str, Motor]

    def rotation_errors_deg(self) -> dict[str, FloatArray]:
        """Angles ``(N,)`` between smoothed and true orientations."""
        true = self.true.rotor.inverse()
        return {name: np.rad2deg((true @ path.rotor).angle()) for name, path in self.paths.items()}

    def position_errors_mm(self) -> dict[str, FloatArray]:
        """Distances ``(N,)`` between smoothed and true positions."""
        true = self.true.translation_m
        return {
            name: 1e3 * np.linalg.norm(path.translation_m - true, axis=-1)
            for name, path in self.paths.items()
        }

    def turning_deg_s(self) -> dict[str, FloatArray]:
        """Angular rates from stamp to stamp ``(N-1,)``, the ground truth's first."""
        paths = {"truth": self.true, **self.paths}
        return {
            name: np.rad2deg(steps_rad(path.rotor) / np.diff(self.time_s))
            for name, path in paths.items()
        }


def can_be_drawn(results: Results, motion: str) -> bool:
    """Whether the motion is a known formula; recordings are not kept."""
    return motion in MOTIONS and "rate_hz" in results.document["plan"]


def method_to_draw(results: Results) -> str | None:
    """The method with the least residual error and jitter."""
    return next((str(row["method"]) for row in results.ranking() if row["method"] != "raw"), None)


def method_apart(results: Results, motion: str, degradation: str) -> str | None:
    """The method with which some representation turns furthest from ground truth, beside motors."""

    def apart(method: str) -> float:
        at = {
            representation: results.figures.get(
                (motion, degradation, method, representation, "rotation_rmse_deg")
            )
            for representation in results.representations
        }
        base = at.get(REFERENCE)
        known = [one.mean for one in at.values() if one is not None]
        return max(known) / base.mean if base is not None and known else 0.0

    best = max(results.methods, key=apart)
    return best if apart(best) > 0.0 else method_to_draw(results)


def replay(results: Results, motion: str, degradation: str, method: str) -> Replayed:
    """Smooth the first test seed again, with the parameters that were found."""
    plan = results.document["plan"]
    seed = int(plan["test_seeds"][0])
    degraded, evaluator = DegradedMotion(
        motion, degradation, seed, plan["rate_hz"], plan["duration_s"]
    ).drawn()
    failed = {tuple(row[key] for key in PLACE) for row in results.document["failures"]}
    rigid = MOTIONS[motion].versor is Motor and REFERENCE in results.representations
    paths = {}
    for (name, representation), row in results.parameters(motion, degradation).items():
        drawn = representation in results.representations
        if name != method or not drawn or (rigid and representation == "similarity"):
            continue
        if (motion, degradation, method, representation) in failed:
            continue
        setting = Setting(method, representation, tuple(row["parameters"].items()))
        paths[representation] = setting.smooth(degraded).poses.rigid
    return Replayed(motion, degradation, method, seed, evaluator.time_s, evaluator.true, paths)


_LOWEST_DEG = 1e-3


def small_panels(drawn: Sequence[Replayed]) -> list[PagePlot]:
    """Rotation errors over time, small enough to stand beside others, on one scale."""
    errors = [one.rotation_errors_deg() for one in drawn]
    ends = [end for one in errors for values in one.values() for end in _ends(values)]
    limits = (max(min(ends), _LOWEST_DEG), 1.2 * max(ends)) if ends else None
    panels = []
    for path, values in zip(drawn, errors, strict=True):
        series = {name: (path.time_s, value) for name, value in values.items()}
        svg = plot_series(
            series,
            f"rotation error, {path.motion}",
            "rotation error (°)",
            log_scale=True,
            width_in=3.6,
            height_in=1.9,
            nested=True,
            limits=limits,
        )
        svg = with_own_ids(svg, f"small-{path.motion}")
        panels.append(PagePlot(path.motion, "", svg, tuple(values)))
    return panels


def _ends(values: FloatArray) -> tuple[float, float]:
    """Nearly the least, as logarithms fall without end where errors pass zero; and the largest."""
    return float(np.percentile(values, 2.0)), float(np.max(values))


def large_panels(drawn: Replayed) -> list[PagePlot]:
    """Rotation error, angular rate and position error over time."""
    lines = {
        "rotation error": (drawn.time_s, drawn.rotation_errors_deg(), "degrees"),
        "angular rate": (drawn.time_s[1:], drawn.turning_deg_s(), "degrees/s"),
        "position error": (drawn.time_s, drawn.position_errors_mm(), "mm"),
    }
    panels = []
    for title, (time_s, values, unit) in lines.items():
        ordered = _nested(values)
        series = {name: (time_s, one) for name, one in ordered.items()}
        svg = plot_series(series, title, unit, log_scale=True, nested=True)
        caption = f"`{drawn.method}` with {LABELS[drawn.degradation]}"
        mark = f"{drawn.degradation}-{drawn.method}-{title.split()[0]}"
        panels.append(PagePlot(title, caption, with_own_ids(svg, mark), tuple(ordered)))
    return panels


def _nested(values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The ground truth on top, then what is drawn widest at the bottom first."""
    return dict(sorted(values.items(), key=lambda item: item[0] == "truth"))


_SHOWN = ("euler", "euler_unwrapped", "quaternion", "motor")
_SIZE = 100.0
# Corners of the image clockwise from the top left, the mark above it, and where it looks.
_CAMERA = np.array(
    [
        [-0.52, -0.38, 0.88],
        [0.52, -0.38, 0.88],
        [0.52, 0.38, 0.88],
        [-0.52, 0.38, 0.88],
        [0.0, -0.66, 0.88],
        [0.0, 0.0, 1.15],
    ]
)
_EYE = np.array([1.25, -1.6, 0.8])
_UP = np.array([0.0, 0.0, 1.0])
_LOCK = np.array([1.15, 0.0, 0.0])
_MOMENTS = 7
_APART_S = 0.1
_WIDTH, _HEIGHT = 900.0, 120.0
_LOW_DEG, _HIGH_DEG = 0.01, 180.0


@dataclass(frozen=True, eq=False)
class Crossing:
    """What the page draws.

    Fields:
        motion, degradation, method, seed: of what is drawn.
        names: "truth" and the representations.
        data: for the script: stamps in ms, points and errors by name, the worst frame.
        lock: where the line of sight is locked, on the drawing.
        strip: rows of the film strip: a name, and for each moment its points as SVG text, the
            truth's, and the error in degrees.
        moments_s: times of the strip's columns.
        curves: polylines of the error over time as SVG text, by name.
        ticks: (degrees as text, height) of the curves' axis.
        worst_deg: largest error of each representation.
    """

    motion: str
    degradation: str
    method: str
    seed: int
    names: list[str]
    data: dict[str, Any]
    lock: tuple[float, float]
    strip: list[tuple[str, list[dict[str, str]]]]
    moments_s: list[str]
    curves: dict[str, str]
    ticks: list[tuple[str, float]]
    worst_deg: dict[str, float]


def crossing(replayed: Replayed) -> Crossing:
    """Draw a motion; representations that were refused are left out."""
    paths = {"truth": replayed.true}
    paths |= {name: replayed.paths[name] for name in _SHOWN if name in replayed.paths}
    points = {name: _drawn(path) for name, path in paths.items()}
    errors = {"truth": np.zeros(len(replayed.time_s))} | replayed.rotation_errors_deg()
    errors = {name: errors[name] for name in paths}
    worst = _passage(replayed, errors)
    columns = _columns(replayed.time_s, worst)
    return Crossing(
        motion=replayed.motion,
        degradation=replayed.degradation,
        method=replayed.method,
        seed=replayed.seed,
        names=list(paths),
        data={
            "ms": np.round(1e3 * replayed.time_s).astype(int).tolist(),
            "points": {name: one.reshape(len(one), -1).tolist() for name, one in points.items()},
            "errors": {name: np.round(one, 2).tolist() for name, one in errors.items()},
            "start": int(columns[0]),
        },
        lock=tuple(_projected(_LOCK).round(1).tolist()),
        strip=[(name, [_moment(points, errors, name, i) for i in columns]) for name in paths],
        moments_s=[f"{replayed.time_s[i]:.2f} s" for i in columns],
        curves={
            name: _curve(replayed.time_s, error)
            for name, error in errors.items()
            if name != "truth"
        },
        ticks=[(f"{deg:g}°", _height(np.array(deg)).item()) for deg in (0.1, 1.0, 10.0, 100.0)],
        worst_deg={name: float(np.max(one)) for name, one in errors.items() if name != "truth"},
    )


def _drawn(path: Motor) -> FloatArray:
    """Whole pixels ``(N, 6, 2)`` of the camera's points."""
    world = path.rotor[..., None].apply(_CAMERA)
    return np.round(_projected(world)).astype(int)


def _projected(points: FloatArray) -> FloatArray:
    ahead = _EYE / np.linalg.norm(_EYE)
    right = np.cross(_UP, ahead)
    right /= np.linalg.norm(right)
    down = -np.cross(ahead, right)
    return _SIZE * np.stack([points @ right, points @ down], axis=-1)


def _passage(replayed: Replayed, errors: dict[str, FloatArray]) -> int:
    """Where the Euler angles go wrong most; where they were not run, where sight is most locked."""
    worst = errors.get("euler", errors.get("euler_unwrapped"))
    if worst is None:
        sight = replayed.true.rotor.apply(np.array([0.0, 0.0, 1.0]))
        return int(np.argmax(np.abs(sight[:, 0])))
    return int(np.argmax(worst))


def _columns(time_s: FloatArray, worst: int) -> list[int]:
    wanted = time_s[worst] + _APART_S * (np.arange(_MOMENTS) - _MOMENTS // 2)
    return [int(np.argmin(np.abs(time_s - one))) for one in wanted]


def _moment(
    points: dict[str, FloatArray], errors: dict[str, FloatArray], name: str, i: int
) -> dict[str, str]:
    return {
        "camera": _text(points[name][i]),
        "truth": _text(points["truth"][i]),
        "error": shown(errors[name][i], 2) + "°" if name != "truth" else "",
        "wrong": "wrong" if errors[name][i] > 5.0 else "",
    }


def _text(points: FloatArray) -> str:
    """Points as the script writes them: a path of sides, image and mark."""
    p = [f"{x:g} {y:g}" for x, y in points]
    sides = "".join(f"M0 0L{corner}" for corner in p[:4])
    return f"{sides}M{p[0]}L{p[1]}L{p[2]}L{p[3]}ZM{p[0]}L{p[4]}L{p[1]}"


def _curve(time_s: FloatArray, errors_deg: FloatArray) -> str:
    x = _WIDTH * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    y = _height(errors_deg)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _height(degrees: FloatArray) -> FloatArray:
    """Logarithmic, within the image."""
    logs = np.log(np.clip(degrees, _LOW_DEG, _HIGH_DEG) / _LOW_DEG)
    return np.asarray(_HEIGHT * (1.0 - logs / np.log(_HIGH_DEG / _LOW_DEG)))
