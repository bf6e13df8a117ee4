"""Plots and states for a page: errors, jitter, the filter's squares, and what tracking lost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from motorcade.fusion.metrics.consistency import chi2_bounds
from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import LONGEST_BRIDGE_S
from motorcade.render.plots.style import thinned
from motorcade.replays.report.findings import Findings, told_paths
from motorcade.replays.studio.look.packing import packed

SPANS = 1500
"""Of a line; of each, the least and the largest value are told."""
FREEDOM = 6
_STATES = {
    "initialising": "finding its bearings",
    "weak": "tracked by few corners",
    "lost": "lost",
    "relocalised": "found again",
}


def shown_plots(findings: Findings, start_ns: int) -> list[dict[str, Any]]:
    """Lines over seconds from the first frame; those that the run has no figures for are absent."""
    measured_ns = int(findings.camera_poses.measurements.trajectory.time_ns[0])
    later_s = (measured_ns - start_ns) * 1e-9
    errors = findings.errors
    against = errors.against_truth
    rotation = {name: (one.time_s, one.rotation_deg) for name, one in against.items()}
    position = {name: (one.time_s, 1e3 * one.position_m) for name, one in against.items()}
    jitter = {name: (one.time_s, one.angular_rad_s2) for name, one in errors.acceleration.items()}
    registered, told = _registered(findings), told_paths(findings)
    made = [
        _plot("rotation", "Rotation error", "°", rotation, told, later_s),
        _plot("position", "Position error", "mm", position, told, later_s),
        _plot("jitter", "Angular acceleration", "rad/s²", jitter, told, later_s),
        _plot("registration", "Distance from the footage", "px", registered, told, later_s),
        _squares(findings, start_ns),
    ]
    return [one for one in made if one["series"]]


def _plot(
    name: str,
    title: str,
    unit: str,
    lines: Mapping[str, tuple[FloatArray, FloatArray]],
    told: Mapping[str, str],
    later_s: float,
) -> dict[str, Any]:
    series = [
        _line(key, told[key], time_s + later_s, values)
        for key, (time_s, values) in lines.items()
        if len(time_s) and key in told
    ]
    return {"name": name, "title": title, "unit": unit, "log": True, "series": series}


def _line(name: str, label: str, time_s: FloatArray, values: FloatArray) -> dict[str, Any]:
    time_s, values = thinned(time_s, values, SPANS)
    return {"name": name, "label": label, "time_s": packed(time_s), "values": packed(values)}


def _registered(findings: Findings) -> dict[str, tuple[FloatArray, FloatArray]]:
    """How far what is drawn along each path lies from the footage, a measured frame each."""
    stamps = findings.camera_poses.measurements.trajectory.time_ns
    time_s = (stamps - stamps[0]) * 1e-9
    return {
        name: (time_s, values)
        for name, values in findings.integrity.registration_px.items()
        if values.shape == time_s.shape
    }


def _squares(findings: Findings, start_ns: int) -> dict[str, Any]:
    """The filter's innovations squared, and the band that holds 95 % where it is right."""
    fused = findings.fused
    known = np.isfinite(fused.nis) & (fused.nis > 0.0)
    time_s = 1e-9 * (fused.trajectory.time_ns[known] - start_ns).astype(np.float64)
    lines = {"fused": (time_s, fused.nis[known])} if np.any(known) else {}
    made = _plot("squares", "Innovations squared (NIS)", "", lines, {"fused": "Fused"}, 0.0)
    return made | {"band": list(map(float, chi2_bounds(FREEDOM, 1))), "dots": True}


def shown_states(findings: Findings, start_ns: int) -> list[dict[str, Any]]:
    """Spans in which tracking was not as it should be, and what it was, in order of time."""
    poses = findings.camera_poses
    measured_ns = int(poses.measurements.trajectory.time_ns[0])
    later_s = (measured_ns - start_ns) * 1e-9
    spans = [
        {"from_s": a + later_s, "to_s": b + later_s, "state": "lost", "why": "no pose measured"}
        for a, b in findings.unmeasured_spans_s()
    ]
    history = poses.slam_history
    if history is not None:
        spans = [*_slam_spans(history.time_ns, history.states, start_ns)]
    out = np.flatnonzero(~findings.fused.accepted)
    stamps = (findings.fused.trajectory.time_ns[out] - start_ns) * 1e-9
    spans += [
        {"from_s": one, "to_s": one, "state": "left out", "why": "the filter left this pose out"}
        for one in stamps.tolist()
    ]
    return sorted(spans, key=lambda span: span["from_s"])


def _slam_spans(time_ns: Any, states: tuple[str, ...], start_ns: int) -> list[dict[str, Any]]:
    """Runs of frames whose state is worth a word."""
    seconds = (time_ns - start_ns) * 1e-9
    ends = np.append(seconds[1:], seconds[-1])
    spans: list[dict[str, Any]] = []
    for state, begun, ended in zip(states, seconds.tolist(), ends.tolist(), strict=True):
        if state not in _STATES or ended - begun > LONGEST_BRIDGE_S:
            continue
        last = spans[-1] if spans else None
        if last is not None and last["state"] == state and last["to_s"] == begun:
            last["to_s"] = ended
        else:
            spans.append({"from_s": begun, "to_s": ended, "state": state, "why": _STATES[state]})
    return spans
