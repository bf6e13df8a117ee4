"""What the report says, in figures (`report.json`, whose keys carry units) and in words.

The same recording, knobs and code give the same bytes: what a machine or an hour adds, such as how
long a stage took, stands in the run log instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from motorcade.replays.pipeline.report.film import FilmView
from motorcade.replays.pipeline.report.findings import Findings, map_unit

COLUMNS = {
    "ape_rmse_m": ("APE", "mm", 1e3),
    "rotation_rmse_deg": ("rotation", "deg", 1.0),
    "rotation_constant_deg": ("constant part", "deg", 1.0),
    "rotation_rest_rmse_deg": ("rest", "deg", 1.0),
    "rpe_trans_rmse_m": ("RPE", "mm", 1e3),
    "rpe_rot_rmse_deg": ("RPE rot.", "deg", 1.0),
    "angular_jitter_rad_s2": ("ang. jitter", "rad/s²", 1.0),
    "linear_jitter_m_s2": ("lin. jitter", "m/s²", 1.0),
    "lag_ms": ("lag", "ms", 1.0),
    "registration_rmse_px": ("registration", "px", 1.0),
}
"""Figures shown side by side: key, heading, shown unit, factor into it."""


LEFT_AS_IT_WAS = (
    "The fused path was left as it is: any more smoothing would take away motion, not noise, so "
    "the representations do not differ here (smoothed.method or smoothed.parameters ask for it)."
)


def summarise(findings: Findings, film: FilmView | None) -> dict[str, Any]:
    """The report's figures as a JSON-ready tree."""
    start, drawn = findings.convergence, findings.overlay
    tree = {
        "recording": findings.recording.name,
        "camera_poses": _camera_poses(findings),
        "imu": {
            "origin": findings.imu.origin,
            "samples": _samples(findings),
            "clock_offset_s": findings.imu.clock_offset_s,
            "clock_offset_sigma_s": findings.imu.clock_offset_sigma_s,
        },
        "fused": _fused(findings),
        "smoothed": {"method": findings.smoothed.method, **findings.smoothed.parameters},
        "integrity": findings.integrity.as_dict(),
        "align": findings.errors.align,
        "unaligned": findings.errors.unaligned or None,
        "errors": findings.errors.figures,
        "stage_comparison": findings.errors.stages.as_dict(),
        "convergence": {
            "initial_tilt_deg": start.initial_tilt_deg,
            "settled_s": start.settled_s,
            "judged_by": start.judged_by,
        },
        "unmeasured_spans": [
            {"start_s": span[0], "end_s": span[1], "fused_worst_m": findings.worst_m("fused", span)}
            for span in findings.unmeasured_spans_s()
        ],
        "overlay": (drawn and film)
        and {
            "frames": film.frames,
            "frames_with_character": drawn.frames_with_character,
            "frames_in_view": film.in_view,
            "figure_height_px": film.height_px,
            "figure_height_share": film.height_share,
            "stands_on": film.stands_on,
            "in_words": film.sentence,
            "figures": [figure.as_dict() for figure in drawn.checks],
        },
        "people": findings.recording.people,
        "doubts": list(findings.doubts),
        "choices": [place.name for place in findings.placed.choices],
        "cast": _cast(findings),
    }
    cleaned: dict[str, Any] = without_nan(tree)
    return cleaned


def _cast(findings: Findings) -> dict[str, Any] | None:
    """Who does what and when, how far feet slide and bodies are apart; None without a cast."""
    placed = findings.placed
    if not placed.parts:
        return None
    return {
        "least_distance_m": placed.apart_m,
        "characters": [
            {
                "name": part.name,
                "note": part.note,
                "worst_foot_slide_m": part.worst_slide_m,
                "states": [
                    {
                        "state": state.state,
                        "clip": state.clip,
                        "start_s": state.start_s,
                        "end_s": state.end_s,
                    }
                    for state in part.states
                ],
            }
            for part in placed.parts
        ],
    }


def _camera_poses(findings: Findings) -> dict[str, Any]:
    poses = findings.camera_poses
    return {
        "origin": poses.origin,
        "summary": poses.summary,
        "skipped": list(poses.skipped),
        "scale": "metric" if poses.metric else "free",
        "metres_a_unit": poses.metres_a_unit,
        "scale_sigma": poses.scale_sigma,
        "frames": len(poses.frame_times_ns),
        "measured": len(poses.measurements.trajectory),
        "reprojection_median_px": float(np.median(poses.reprojection_px)),
        "damaged_images": list(findings.recording.damaged),
        "slam": None if poses.slam_history is None else poses.slam_history.as_dict(),
        "inertial": None if poses.inertial is None else poses.inertial.as_dict(),
    }


def _fused(findings: Findings) -> dict[str, Any]:
    fused = findings.fused
    return {
        "by": fused.by,
        "summary": fused.summary,
        "nis_per_dimension": findings.nis_per_dimension,
        "left_out": int(np.count_nonzero(~fused.accepted)),
        "noise": None if fused.noise is None else fused.noise.as_dict(),
        "latency": _latency(findings),
    }


def _latency(findings: Findings) -> list[dict[str, float]] | None:
    """By lag, how far the path is from that by all of the recording; None where not asked for."""
    curve = findings.fused.latency
    if curve is None:
        return None
    rows = zip(
        curve.lag_s.tolist(), curve.position_m.tolist(), curve.rotation_deg.tolist(), strict=True
    )
    return [
        {"lag_s": lag_s, "position_rmse_m": metres, "rotation_rmse_deg": degrees}
        for lag_s, metres, degrees in rows
        if np.isfinite(lag_s)
    ]


def _samples(findings: Findings) -> int:
    imu = findings.imu
    return 0 if imu.origin == "none" else len(imu.stream(findings.recording))


def shown_columns(figures: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Keys of `COLUMNS` that at least one path has a figure for."""
    return [key for key in COLUMNS if any(row.get(key) is not None for row in figures.values())]


def heading(key: str, figures: Mapping[str, Mapping[str, Any]], *, metric: bool) -> str:
    """Name and unit of a column; lengths have one where the path or a ground truth does."""
    name, unit, _ = COLUMNS[key]
    if not metric and all(row.get("ape_rmse_m") is None for row in figures.values()):
        unit = unit.replace("m/s²", "units/s²")
    return f"{name} ({unit})"


def shown_value(key: str, value: float | None) -> str:
    """A figure in its shown unit with three significant digits, or a dash."""
    if value is None or not math.isfinite(value):
        return "–"
    scaled = value * COLUMNS[key][2]
    digits = 2 if scaled == 0 else max(0, 2 - math.floor(math.log10(abs(scaled))))
    return f"{scaled:.{min(digits, 4)}f}"


def as_table(summary: Mapping[str, Any]) -> str:
    """The errors of a report as aligned text; below, what was not smoothed or aligned."""
    figures = summary["errors"]
    keys = shown_columns(figures)
    metric = summary.get("camera_poses", {}).get("scale") != "free"
    head = ["", *(heading(key, figures, metric=metric) for key in keys)]
    rows = [
        [name, *(shown_value(key, row.get(key)) for key in keys)] for name, row in figures.items()
    ]
    widths = [max(len(line[i]) for line in [head, *rows]) for i in range(len(head))]
    lines = []
    for line in [head, *rows]:
        cells = [line[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(line[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells))
    if summary.get("smoothed") == {"method": None}:
        lines.append(LEFT_AS_IT_WAS)
    if summary.get("unaligned"):
        lines.append(f"No error can be told: {summary['unaligned']}.")
    return "\n".join(lines)


def without_nan(value: Any) -> Any:
    """The same tree with None for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


MOST_NAMED = 3
LONG_GAP_S = 0.5
IMU_ORIGINS = {
    "recorded": "recorded",
    "reference": "simulated along the ground truth, as for an experiment",
}
FOUND_BY = {
    "board": "measured by the board in view",
    "markers": "measured by the markers in view",
    "slam": "found from the images alone",
    "simulated": "simulated from the ground truth",
    "turning": "found from the images alone, of a camera that stays at its place",
}
FUSED_WITH = {"imu": " and made one path with the IMU", "odometry": " and the odometry"}
VERDICTS = {
    "consistent": "Looks right",
    "unknown": "Cannot be told",
    "doubtful": "Doubtful",
    "contradicted": "Contradicted",
}
IN_ORDER = {
    "coverage": "enough images have a camera pose",
    "registration": "what is drawn stays where it stands in the footage",
    "innovations": "camera and IMU agree",
    "inertial": "the IMU shows no fault",
    "agreement": "the smoothed path keeps to the measured poses",
}
"""Checks that passed, as clauses; others are told by their names."""
MATTERS = {"inertial": "faults of the IMU", "innovations": "whether camera and IMU agree"}
"""What checks are of that could not tell."""


@dataclass(frozen=True)
class Tile:
    """A figure that stands large, and what it is; `wrong` where it speaks against the result."""

    value: str
    label: str
    wrong: bool = False


@dataclass(frozen=True)
class NextStep:
    """Something that the reader may do, and the command that does it, if one does."""

    text: str
    command: str = ""


def plainly(value: float, floor: float) -> str:
    """Two significant digits, all those before the point, and nothing finer than `floor`."""
    size = abs(value)
    if size < floor:
        return f"under {floor:g}"
    return f"{value:,.{max(0, 1 - math.floor(math.log10(size)))}f}"


def length_words(value: float, unit: str) -> str:
    """A length in millimetres, or metres above one; in units of the map where it has no metre."""
    if unit != "m":
        return f"{plainly(value, 1e-4)} units"
    return f"{plainly(value, 1e-2)} m" if value >= 1.0 else f"{plainly(1e3 * value, 0.01)} mm"


def lead(findings: Findings) -> str:
    """What was found, in a sentence or two."""
    poses = findings.camera_poses
    times_ns = poses.frame_times_ns
    measured, frames = len(poses.measurements.trajectory), len(times_ns)
    share = f"in all {frames} images" if measured == frames else f"in {measured} of {frames}"
    lasting = 1e-9 * float(times_ns[-1] - times_ns[0])
    fused = FUSED_WITH.get(findings.fused.by, "")
    return f"The camera's path over {lasting:.1f} s, {FOUND_BY[poses.origin]} {share}{fused}."


def headline(findings: Findings) -> str:
    """What was measured, and what was made of it, in a few sentences."""
    poses, fused = findings.camera_poses, findings.fused
    imu = f"; IMU {_imu(findings)}" if fused.by == "imu" else ""
    text = f"Camera poses {poses.summary}{imu}. The path was {fused.summary}."
    if fused.noise is not None:
        summary = fused.noise.summary
        text += f" {capital(summary)}."
    if poses.skipped:
        text += f" Skipped: {'; '.join(poses.skipped)}."
    damaged = findings.recording.damaged
    if damaged:
        # A video says how many in a line of its own.
        several = findings.recording.layout != "video"
        text += f" {len(damaged)} damaged images were left" if several else " Left"
        text += f" out: {'; '.join(damaged[:MOST_NAMED])}"
        text += " and others." if len(damaged) > MOST_NAMED else "."
    return text


def _imu(findings: Findings) -> str:
    imu = findings.imu
    text = IMU_ORIGINS[imu.origin]
    if imu.clock_offset_sigma_s is not None:
        text += (
            f", its clock {1e3 * imu.clock_offset_s:+.2f} ± "
            f"{1e3 * imu.clock_offset_sigma_s:.2f} ms from the camera's, taken off"
        )
    return text


def verdict(findings: Findings, film: FilmView | None) -> Tile:
    """The first tile: what the film shows, whether it can be relied on, what speaks against it."""
    tile = _verdict(findings)
    shown = f"{capital(film.sentence)}. " if film else ""
    shown += f"{capital(findings.recording.people)}. " * (" " in findings.recording.people)
    unsure = f" Not sure: {'; '.join(findings.doubts)}." * bool(findings.doubts)
    return replace(tile, label=f"{shown}{tile.label}{unsure}".strip())


def _verdict(findings: Findings) -> Tile:
    integrity = findings.integrity
    if integrity.doubts:
        reasons = "; ".join(check.summary for check in integrity.checks if not check.passed)
        drawn = f"The character stands along the {integrity.drawn_is} path."
        return Tile(VERDICTS[integrity.verdict], f"{capital(reasons)}. {drawn}", wrong=True)
    passed = [check.name for check in integrity.checks if check.verdict == "consistent"]
    agreed = [IN_ORDER[name] for name in passed if name in IN_ORDER]
    others = ", ".join(_words(name) for name in passed if name not in IN_ORDER)
    agreed += [f"in order too: {others}"] if others else []
    unknown = [
        MATTERS.get(check.name, _words(check.name))
        for check in integrity.checks
        if check.verdict == "unknown"
    ]
    text = f"Nothing that was checked speaks against it: {'; '.join(agreed)}." if agreed else ""
    if unknown:
        text += f" This recording cannot tell: {', '.join(unknown)}."
    return Tile(VERDICTS[integrity.verdict], text.strip())


def _words(name: str) -> str:
    return name.replace("_", " ")


def capital(text: str) -> str:
    """The text with a capital first letter."""
    return text[:1].upper() + text[1:]


def tiles(findings: Findings, film: FilmView | None) -> list[Tile]:
    """What stands large at the top: the film and its verdict, what got worse, how good it is."""
    worse = [Tile("Worse", f"{capital(one)}.", wrong=True) for one in findings.errors.stages.worse]
    return [verdict(findings, film), *worse, *_how_good(findings)]


def _how_good(findings: Findings) -> list[Tile]:
    poses, first = findings.camera_poses, next(iter(findings.smoothed.trajectories))
    figures = findings.errors.figures.get(first, {})
    measured = len(poses.measurements.trajectory)
    how_good = [Tile(f"{measured} of {len(poses.frame_times_ns)}", "images with a camera pose")]
    off_px = figures.get("registration_rmse_px")
    if off_px is not None:
        how_good.append(Tile(f"{plainly(off_px, 0.01)} px", "what is drawn is off the footage"))
    elif np.any(np.isfinite(poses.reprojection_px)):
        median = float(np.nanmedian(poses.reprojection_px))
        how_good.append(
            Tile(f"{plainly(median, 0.01)} px", "measured points are off in the median")
        )
    off_m, off_deg = figures.get("ape_rmse_m"), figures.get("rotation_rmse_deg")
    if off_m is not None and off_deg is not None:
        off = f"{length_words(off_m, 'm')}, {plainly(off_deg, 1e-3)}°"
        how_good.append(Tile(off, "the camera is off the ground truth"))
    how_good += _shake(findings)
    if not poses.metric:
        how_good.append(Tile("no metre", "lengths are in units of the map, of unknown length"))
    return how_good


def _shake(findings: Findings) -> list[Tile]:
    """How much far things would shake in the image, frame by frame: before and after smoothing.

    It is the camera's turning alone that moves them. What stands near moves with the camera's
    place as well, which the plot of the character's spot shows (`film.steadiness`).
    """
    figures, times_ns = findings.errors.figures, findings.camera_poses.frame_times_ns
    first = next(iter(findings.smoothed.trajectories))
    ends = [figures.get(name, {}).get("angular_jitter_rad_s2") for name in ("measured", first)]
    camera = findings.camera_poses.camera or findings.recording.camera
    known = [one for one in ends if one is not None]
    if len(known) < 2 or len(times_ns) < 2:
        return []
    if camera is None:
        before, after = (plainly(float(np.rad2deg(one)), 0.01) for one in known)
        return [
            Tile(f"{before} → {after} °/s²", "the camera's turning shakes, measured → smoothed")
        ]
    # What a jitter of the angular acceleration moves far things by, over a frame's time.
    step_s = 1e-9 * float(np.median(np.diff(times_ns)))
    before, after = (plainly(one * step_s**2 * camera.fx, 0.01) for one in known)
    if before == after:
        return [Tile(f"{before} px", "far things shake from image to image")]
    label = "far things shake from image to image, measured → smoothed"
    return [Tile(f"{before} → {after} px", label)]


def to_mend(findings: Findings, without_film: str) -> list[str]:
    """What would make the result better, a sentence each; none where nothing needs mending.

    `without_film` says why there is no film, where there is none.
    """
    integrity = findings.integrity
    advice = [
        capital(check.advice) for check in integrity.checks if not check.passed and check.advice
    ]
    gaps = [one for one in findings.unmeasured_spans_s() if one[1] - one[0] > LONG_GAP_S]
    if gaps:
        start_s, end_s = max(gaps, key=lambda gap: gap[1] - gap[0])
        others = f", and {len(gaps) - 1} more such gaps" if len(gaps) > 1 else ""
        advice.append(
            f"From {start_s:.1f} to {end_s:.1f} s no pose was measured{others}: film so that what "
            "poses come from stays in view, sharp and well lit"
        )
    if not findings.camera_poses.metric:
        advice.append(
            "Lengths have no metre, which one camera alone cannot tell: put a marker or board of "
            "known size into view, or record an IMU"
        )
    if without_film:
        advice.append(f"There is no film: {without_film}")
    return [f"{one.rstrip('.')}." for one in advice]


def next_steps(findings: Findings) -> list[NextStep]:
    """What can be done with the result; "RUN" is the folder that the report was left in."""
    steps = [
        NextStep("Set characters in by hand, on a screen or a phone:", "motorcade author RUN"),
        NextStep(
            "Put one of your own in its place:",
            "motorcade run … --set placed.character=FILE.glb",
        ),
        NextStep("Take all of it into other programs:", "motorcade export RUN --gltf s.glb"),
    ]
    return steps if findings.overlay is not None else steps[2:]


def errors_caption(findings: Findings) -> str:
    """What the table of errors was judged by, and what smoothed the paths."""
    errors = findings.errors
    if errors.unaligned:
        return f"No error can be told, only jitter: {errors.unaligned}."
    if findings.recording.truth is None:
        return "This recording has no ground truth: only jitter can be measured."
    how = {
        "none": "without alignment",
        "se3": "after rigid alignment (SE3)",
        "sim3": "after alignment with scale (Sim3)",
    }[errors.align]
    tint = "" if findings.smoothed.method is None else "The best of a column is tinted. "
    return f"Against the recording's ground truth, {how}; root mean squares. {tint}"


def stages_caption(findings: Findings) -> str:
    """How far each stage's path is from what judges it, at the same stamps."""
    stages = findings.errors.stages
    if stages.judged_by == "nothing":
        return ""
    unit = "m" if stages.judged_by == "ground truth" else map_unit(findings)
    turned = {name: plainly(one, 1e-3) for name, one in stages.rotation_rmse_deg.items()}
    each = ", ".join(
        f"{_words(name)} {length_words(off, unit)} and {turned[name]}°"
        for name, off in stages.position_rmse_m.items()
    )
    how = {
        "ground truth": f"At the {stages.poses} stamps that all paths and the ground truth have",
        "held-out poses": f"Judged by {stages.poses} measured poses that they were made without",
    }[stages.judged_by]
    return f"{how}, the stages' paths are off by: {each}."


def parameters(values: dict[str, Any]) -> str:
    """The numbers of a smoother."""
    numbers = (
        f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in values.items()
    )
    return ", ".join(numbers) or "at its defaults"
