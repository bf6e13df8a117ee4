"""The report's plots: paths smoothed once more, and their errors over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import plot_series
from motorcade.render.plots.style import with_own_ids
from motorcade.replays.compare.cells import Setting, inputs_of
from motorcade.replays.compare.report.names import CAUSAL, LABELS
from motorcade.replays.compare.report.results import REFERENCE, Results
from motorcade.replays.pages.parts import PagePlot


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
            name: np.rad2deg(
                (path[:-1].rotor.inverse() @ path[1:].rotor).angle() / np.diff(self.time_s)
            )
            for name, path in paths.items()
        }


def can_be_drawn(results: Results, motion: str) -> bool:
    """Whether the motion is a known formula; recordings are not kept."""
    return motion in MOTIONS and "rate_hz" in results.told["plan"]


def method_to_draw(results: Results, causal: bool = False) -> str | None:
    """The method with the least residual error and jitter, of all or of those that are causal."""
    for row in results.ranking():
        if row["method"] != "raw" and (row["method"] in CAUSAL or not causal):
            return str(row["method"])
    return None


def method_apart(results: Results, motion: str, degradation: str) -> str | None:
    """The method with which some representation turns furthest from ground truth, beside motors."""

    def apart(method: str) -> float:
        at = {
            one: results.figures.get((motion, degradation, method, one, "rotation_rmse_deg"))
            for one in results.representations
        }
        base = at.get(REFERENCE)
        known = [one.mean for one in at.values() if one is not None]
        return max(known) / base.mean if base is not None and known else 0.0

    best = max(results.methods, key=apart)
    return best if apart(best) > 0.0 else method_to_draw(results)


def replay(results: Results, motion: str, degradation: str, method: str) -> Replayed:
    """Smooth the first test seed again, with the parameters that were found."""
    plan = results.told["plan"]
    seed = int(plan["test_seeds"][0])
    degraded, evaluator = inputs_of(motion, degradation, seed, plan["rate_hz"], plan["duration_s"])
    rigid = MOTIONS[motion].versor is Motor and REFERENCE in results.representations
    paths = {}
    for (name, representation), row in results.parameters(motion, degradation).items():
        drawn = representation in results.representations
        if name != method or not drawn or (rigid and representation == "similarity"):
            continue
        if any(_at(one) == (motion, degradation, *_pair(row)) for one in results.told["failures"]):
            continue
        setting = Setting(method, representation, tuple(row["parameters"].items()))
        paths[representation] = setting.smooth(degraded).poses.rigid
    return Replayed(motion, degradation, method, seed, evaluator.time_s, evaluator.true, paths)


def _pair(row: Mapping[str, str]) -> tuple[str, str]:
    return row["method"], row["representation"]


def _at(row: Mapping[str, str]) -> tuple[str, str, str, str]:
    return row["motion"], row["degradation"], *_pair(row)


_LOWEST_DEG = 1e-3


def small_panels(drawn: Sequence[Replayed]) -> list[PagePlot]:
    """Rotation errors over time, small enough to stand beside others, on one scale."""
    errors = [one.rotation_errors_deg() for one in drawn]
    ends = [end for one in errors for values in one.values() for end in _ends(values)]
    limits = (max(min(ends), _LOWEST_DEG), 1.2 * max(ends)) if ends else None
    panels = []
    for one, values in zip(drawn, errors, strict=True):
        series = {name: (one.time_s, value) for name, value in values.items()}
        svg = plot_series(
            series,
            f"rotation error, {one.motion}",
            "rotation error (°)",
            log_scale=True,
            width_in=3.6,
            height_in=1.9,
            nested=True,
            limits=limits,
        )
        svg = with_own_ids(svg, f"small-{one.motion}")
        panels.append(PagePlot(one.motion, "", svg, tuple(values)))
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
    return {n: v for n, v in values.items() if n != "truth"} | {
        n: v for n, v in values.items() if n == "truth"
    }
