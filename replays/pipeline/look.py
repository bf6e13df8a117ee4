"""The look of a run: all that a page shows of it but the images of its film.

That is plots and states, characters as glTF with the poses of their joints at every frame, and what
hides them. The film hides a figure pixel by pixel; a page gets, for every frame, a smaller image of
the depth of all that may be nearer than the figures, and nothing of what lies behind them.
"""

from __future__ import annotations

import math
import tempfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from motorcade.animation import Character, write_gltf
from motorcade.fusion.metrics.consistency import chi2_bounds
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import off_record, read_bounded
from motorcade.ga.progress import track
from motorcade.ga.stamps import LONGEST_BRIDGE_S
from motorcade.render import Performer
from motorcade.render.composite import is_grey
from motorcade.render.light import Prints
from motorcade.render.plots.style import thinned
from motorcade.render.scene import DepthArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Recording
from motorcade.replays.pipeline.packing import (
    drawn_name,
    drawn_rows,
    packed,
    packed_smooth,
    rows_of,
    scaled_rows,
    shown_paths,
    text,
)
from motorcade.replays.pipeline.report.findings import Findings, map_unit, told_paths
from motorcade.replays.stages.camera.offered import as_found
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.ground import prints_of
from motorcade.replays.web.film import film_rate_hz
from motorcade.tracking import Board, Camera, MarkerMap

FORMAT, VERSION = "motorcade-look", 1


@dataclass(frozen=True)
class LookedAt:
    """What a look is made of: a run's findings, and the map of markers where it has one.

    `headline` says in a line what was measured and made.
    """

    findings: Findings
    marker_map: MarkerMap | None
    headline: str

    @property
    def recording(self) -> Recording:
        """The recording, with the camera as the run found it."""
        poses = self.findings.camera_poses
        return as_found(self.findings.recording, poses.camera, poses.depth_camera)

    @property
    def has_images(self) -> bool:
        """Whether there is footage, and not corners alone."""
        return not isinstance(self.recording.frames, CornerFrames)


def look_of(run: LookedAt, clips: list[dict[str, str]]) -> dict[str, Any]:
    """The document of a run, ready for JSON.

    Args:
        run: what is shown.
        clips: name ("overlay", "footage") and address of each film.

    Raises:
        ValueError: a recording without a camera.
    """
    findings, recording = run.findings, run.recording
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    stamps = recording.frames.time_ns
    start_ns = int(stamps[0])
    performing = performers(findings.placed, 1e-9 * float(np.ptp(stamps)))
    figures = _figures(findings, performing, stamps)
    height_m = max(one["height_m"] for one in figures)
    placed = findings.placed
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": recording.name,
        "headline": run.headline,
        "unit": map_unit(findings),
        "up": placed.placement.up.tolist(),
        "film": {
            "width": recording.camera.width,
            "height": recording.camera.height,
            "rate_hz": film_rate_hz(stamps),
            "time_s": packed((stamps - start_ns) * 1e-9, "f64"),
            "clips": clips,
        },
        "camera": shown_camera(recording.camera),
        "grey": run.has_images and is_grey(recording.frames[0].image()),
        "drawn": drawn_name(findings),
        "paths": shown_paths(findings, stamps),
        "boards": shown_boards(recording, findings.camera_poses),
        "markers": shown_markers(run.marker_map),
        "planes": [shown_plane(placed, height_m)],
        "points_m": shown_points(findings.camera_poses),
        "characters": figures,
        "hiding": shown_hiding(
            recording,
            performing,
            prints_of(recording, findings.camera_poses, run.marker_map),
            drawn_rows(findings, stamps),
        ),
        "plots": shown_plots(findings, start_ns),
        "states": shown_states(findings, start_ns),
    }


def shown_camera(camera: Camera) -> dict[str, Any]:
    """A camera for `camera.js`."""
    names = ("width", "height", "fx", "fy", "cx", "cy", "model")
    about = {name: getattr(camera, name) for name in names}
    return about | {"coefficients": list(camera.distortion)}


def _figures(
    findings: Findings, performing: list[Performer], time_ns: IntArray
) -> list[dict[str, Any]]:
    names = [part.name for part in findings.placed.parts] or ["character"]
    return [
        shown_character(name, performer, time_ns)
        for name, performer in zip(names, performing, strict=True)
    ]


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
    registered, labels = _registered(findings), told_paths(findings)
    plots = [
        _plot("rotation", "Rotation error", "°", rotation, labels, later_s),
        _plot("position", "Position error", "mm", position, labels, later_s),
        _plot("jitter", "Angular acceleration", "rad/s²", jitter, labels, later_s),
        _plot("registration", "Distance from the footage", "px", registered, labels, later_s),
        _squares(findings, start_ns),
    ]
    return [one for one in plots if one["series"]]


def _plot(
    name: str,
    title: str,
    unit: str,
    lines: Mapping[str, tuple[FloatArray, FloatArray]],
    fields: Mapping[str, str],
    later_s: float,
) -> dict[str, Any]:
    series = [
        _line(key, fields[key], time_s + later_s, values)
        for key, (time_s, values) in lines.items()
        if len(time_s) and key in fields
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
    plot = _plot("squares", "Innovations squared (NIS)", "", lines, {"fused": "Fused"}, 0.0)
    return plot | {"band": list(map(float, chi2_bounds(FREEDOM, 1))), "dots": True}


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
        {
            "from_s": stamp,
            "to_s": stamp,
            "state": "left out",
            "why": "the filter left this pose out",
        }
        for stamp in stamps.tolist()
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


FINEST = 2e-4
"""Of joints, in the character's metres: half of it shows nowhere that a character is seen whole."""
GLTF_LIMIT = 256 * 2**20
"""Bytes of a character as it is written here."""


def shown_character(name: str, figure: Performer, time_ns: IntArray) -> dict[str, Any]:
    """A character as the film draws it at the stamps ``(F,)``, its clip begun at the first.

    Joints are told in the character's space, so that no number is large wherever it stands.
    """
    since_s = 1e-9 * (time_ns - time_ns[0])
    world = figure.character.skeleton.world(figure.clip.at(since_s))
    weights = figure.clip.morph_weights(since_s)
    stands = figure.world_T_character(time_ns)
    seen = figure.visible_s
    return {
        "name": name,
        "gltf": text(gltf_bytes(figure.character)),
        "joints": packed_smooth(scaled_rows(world), FINEST),
        "morphs": None if weights is None else packed(weights),
        "world_T_character": packed(scaled_rows(stands), "f64"),
        "visible_s": None if seen is None else [float(one) for one in seen],
        "height_m": float(stands.as_motor_scale()[1][0]) * figure.character.height_m,
    }


def gltf_bytes(character: Character) -> bytes:
    """The character's mesh, skeleton and materials as `.glb`, without clips."""
    with tempfile.TemporaryDirectory() as folder, off_record():  # a file of our own
        path = Path(folder, "character.glb")
        write_gltf(path, character, [])
        return read_bounded(path, GLTF_LIMIT)


MOST_POINTS = 60_000
LONGEST_PX = 512
_SHEET = 0.6
"""Half the side of the sheet under a character, in its heights."""


def shown_boards(recording: Recording, camera_poses: CameraPoses) -> list[dict[str, Any]]:
    """The board where the poses come from it: its corners in the world, and its print as PNG."""
    board = recording.board
    if board is None or camera_poses.origin not in ("board", "simulated"):
        return []
    image, corners_m = _printed(board)
    written, data = cv2.imencode(".png", image)
    if not written:
        raise OSError(f"{recording.name}: the board cannot be written as PNG")
    return [
        {
            "name": board.name,
            "corners_m": packed(recording.world_T_board.apply(corners_m), "f64"),
            "image": f"data:image/png;base64,{text(data.tobytes())}",
        }
    ]


def _printed(board: Board) -> tuple[np.ndarray, FloatArray]:
    """The board's image, and the corners ``(4, 3)`` of that sheet from its top left on."""
    scale = LONGEST_PX / max(board.size_m)
    image, (column, row) = board.draw(scale)
    high, wide = image.shape
    # A pixel's centre is at its number; rows run down, y of the board's frame up.
    x = (np.array([-0.5, wide - 0.5]) - column) / scale
    y = (row - np.array([-0.5, high - 0.5])) / scale
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    return image, np.array([(*one, 0.0) for one in corners])


def shown_markers(marker_map: MarkerMap | None) -> list[dict[str, Any]]:
    """Markers of a map, with their corners ``(4, 3)`` in the world."""
    if marker_map is None:
        return []
    corners = marker_map.points_m.reshape(-1, 4, 3)
    return [
        {"id": int(number), "corners_m": packed(four, "f64")}
        for number, four in zip(marker_map.marker_ids, corners, strict=True)
    ]


def shown_plane(placed: PlacedCharacter, height_m: float) -> dict[str, Any]:
    """A square sheet of what the first character stands on, by its corners in the world."""
    half = _SHEET * height_m
    square = half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=np.float64)
    stand: Motor = placed.placement.world_T_character
    return {"name": placed.stands_on, "corners_m": packed(stand.apply(square), "f64")}


def shown_points(camera_poses: CameraPoses) -> dict[str, Any]:
    """Points ``(P, 3)`` of the map, thinned evenly."""
    points = np.asarray(camera_poses.points, dtype=np.float64).reshape(-1, 3)
    return packed(points[:: -(-len(points) // MOST_POINTS) or 1])


LONGEST_DEPTH_PX, MOST_BYTES = 320, 24 * 2**20
"""Of an image of depth, and of all of them before they are compressed."""
FEWEST_PX = 32
"""Images so small would hide by blocks: the page then does without."""
LEVELS = 254
"""Steps of depth between the nearest and the farthest, evenly in its logarithm; 0 hides nothing."""


def shown_hiding(
    recording: Recording, figures: list[Performer], prints: Prints | None, drawn: FloatArray
) -> dict[str, Any]:
    """What hides figures, as in the film: the depth of each frame, or else prints and the ground.

    Args:
        recording: with the camera as the run found it.
        figures: who is drawn.
        prints: boards and markers; where figures ride on what moves, a map may not hold, and they
            hide nothing.
        drawn: ``(F, 7)`` poses of the drawn path at the frames' stamps, as `rows_at` gives them.

    Returns:
        `depth` (None without), `prints` by their corners, and the `ground` by its pose, None where
        all grounds move.
    """
    still = [one for one in figures if one.ground_motion is None]
    ground = None
    if still:
        ground = packed(rows_of(still[0].placement.world_T_character), "f64")
    return {
        "depth": None
        if isinstance(recording.frames, CornerFrames)
        else _depth(recording, figures, drawn),
        "prints": _corners(prints if len(still) == len(figures) else None),
        "ground": ground,
    }


def _corners(prints: Prints | None) -> dict[str, Any]:
    """Corners ``(P, 4, 3)`` of boards and markers."""
    if prints is None:
        return packed(np.zeros((0, 4, 3)))
    low, high = prints.low_m, prints.high_m
    around = [(low, low), (high, low), (high, high), (low, high)]
    flat = [np.stack([x[:, 0], y[:, 1], np.zeros(len(low))], axis=-1) for x, y in around]
    return packed(np.stack([prints.world_T_print.apply(one) for one in flat], axis=1))


def _depth(
    recording: Recording, figures: list[Performer], drawn: FloatArray
) -> dict[str, Any] | None:
    """Depth of all that is nearer than a figure's far side, an image a frame; None without.

    `deflated` holds ``shape`` ``(F, h, w)`` bytes: 0 for nothing, then `near_m` to `far_m`.
    """
    camera = recording.camera
    assert camera is not None  # `look_of` refuses that before
    time_ns = recording.frames.time_ns
    if recording.frames[0].depth_m() is None:
        return None
    longest = max(camera.width, camera.height)
    fits = math.sqrt(MOST_BYTES / (len(time_ns) * camera.width * camera.height))
    share = min(LONGEST_DEPTH_PX / longest, fits, 1.0)
    if share * longest < FEWEST_PX:
        return None
    size = (max(1, int(share * camera.height)), max(1, int(share * camera.width)))
    behind_m = _farthest_m(figures, drawn, time_ns)
    small = np.zeros((len(time_ns), *size), dtype=np.float16)
    for k, frame in enumerate(track(recording.frames, "images of depth", len(time_ns))):
        depth_m = frame.depth_m()
        if depth_m is not None and behind_m[k] > 0.0:
            small[k] = _nearer(depth_m, size, behind_m[k])
    return _levelled(small)


def _farthest_m(
    figures: list[Performer], world_T_camera: FloatArray, time_ns: IntArray
) -> FloatArray:
    """Depth ``(F,)`` that no part of a figure is beyond, 0 where there is no pose."""
    x, y, z, w = (world_T_camera[:, k] for k in (4, 5, 6, 3))
    ahead = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    farthest = np.zeros(len(time_ns))
    for figure in figures:
        rigid, scale = figure.world_T_character(time_ns).as_motor_scale()
        tall_m = scale * figure.character.height_m
        away_m = np.sum(ahead * (rigid.translation_m - world_T_camera[:, :3]), axis=-1)
        # A figure walks off its footing by no more than its clip takes it.
        farthest = np.fmax(farthest, away_m + scale * _reach_m(figure) + tall_m)
    return farthest


def _reach_m(figure: Performer) -> float:
    """How far its clip takes the root from where it stands, in the character's space."""
    moments = np.linspace(figure.clip.time_s[0], figure.clip.time_s[-1], 64)
    root = figure.clip.at(moments).translation_m[..., 0, :]
    return float(np.max(np.linalg.norm(root, axis=-1)))


def _nearer(depth_m: DepthArray, size: tuple[int, int], behind_m: float) -> FloatArray:
    """A smaller image ``size``, of single pixels, 0 where unknown or behind."""
    rows, columns = (
        ((np.arange(few) + 0.5) * many / few).astype(np.intp)
        for few, many in zip(size, depth_m.shape, strict=True)
    )
    some = depth_m[rows[:, None], columns]
    with np.errstate(invalid="ignore"):
        return np.where((some > 0.0) & (some < behind_m), some, 0.0)


def _levelled(depths_m: np.ndarray) -> dict[str, Any]:
    """Depths ``(F, h, w)`` by levels of their logarithm, compressed."""
    known = depths_m > 0.0
    near, far = (1.0, 2.0)
    if known.any():
        near, far = float(depths_m[known].min()), float(depths_m[known].max()) * 1.0001
    step = math.log(far / near) / LEVELS
    levels = np.zeros(depths_m.shape, dtype=np.uint8)
    for level, depth, seen in zip(levels, depths_m, known, strict=True):
        logs = np.log(depth[seen].astype(np.float64) / near)
        level[seen] = 1 + np.clip(np.rint(logs / step), 0, LEVELS)
    data = text(zlib.compress(levels.tobytes(), 6))
    return {"deflated": data, "shape": list(levels.shape), "near_m": near, "far_m": far}
