"""`make bench SUITE=tracking`, photometric: what refinement on the whole print is worth.

Markers are drawn with exact truth at three distances, so that jitter and flips can be told: corners
alone against corners refined on the print, pose by pose and with candidates chosen over time. On
photographs (`tags/rotations`: one marker turned to nominal yaws, 15 images) the spread about the
nominal angles is compared; those were set by hand, to a degree or two.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera, detect_markers
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import (
    MarkerObservations,
    best_single,
    pose_stream,
    resolve,
)
from motorcade.tracking.markers.disambiguate.resolving import Resolution
from motorcade.tracking.markers.photometric import (
    PhotometricUnavailable,
    joined_frames,
    refine_frame,
)
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers

__all__ = ["bench_photometric", "photometric_table"]

FAMILY, SIDE_M, FRAMES = "tag36h11", 0.08, 20
DISTANCES_M = (0.5, 1.2, 2.4)
_CAMERA = Camera(640, 480, 600.0, 600.0, 319.5, 239.5)
_WRONG_RAD = np.radians(15.0)


@dataclass(frozen=True, eq=False)
class _Way:
    """What one way made of a sequence: corners, both poses of each, seconds."""

    stream: CornerStream
    observations: MarkerObservations
    seconds: float


def bench_photometric() -> dict[str, Any]:
    """Measure with and without refinement, at every distance; nothing without torch and kornia."""
    rows: list[dict[str, Any]] = []
    try:
        for distance_m in DISTANCES_M:
            scene, path, ways = _sequence(distance_m)
            rows += [_row(scene, path, distance_m, name, way) for name, way in ways.items()]
    except PhotometricUnavailable as missing:
        return {"rows": [], "left_out": str(missing)}
    return {"rows": rows, "left_out": None}


def _sequence(distance_m: float) -> tuple[TagScene, Motor, dict[str, _Way]]:
    rng = np.random.default_rng(0)
    wall = wall_of_markers(3, 2, 1.75 * SIDE_M, 30.0, rng)
    scene = TagScene(_CAMERA, FAMILY, np.arange(6), SIDE_M, wall)
    path = handheld_path(FRAMES, distance_m)
    stamps = np.arange(FRAMES, dtype=np.int64) * 33_333_333
    frames, ids, corners, refined = [], [], [], []
    seconds = 0.0
    for row in range(FRAMES):
        image = scene.image(path[row], rng)
        found = detect_markers(image, FAMILY, _CAMERA)
        own = np.array([one.marker_id for one in found], np.int64)
        places = np.array([one.corners_px for one in found]).reshape(-1, 4, 2)
        start = time.perf_counter()
        sides = np.full(len(own), SIDE_M)
        refined.append(refine_frame(image, _CAMERA, FAMILY, own, places, sides))
        seconds += time.perf_counter() - start
        frames.append(np.full(len(own), row))
        ids.append(own)
        corners.append(places)
    stream = CornerStream(
        _CAMERA, stamps, np.concatenate(frames), np.concatenate(ids), np.concatenate(corners)
    )
    plain = pose_stream(stream, dict.fromkeys(range(6), SIDE_M))
    return (
        scene,
        path,
        {
            "corners": _Way(stream, plain, 0.0),
            "photometric": _Way(*joined_frames(_CAMERA, stamps, refined), seconds),
        },
    )


def _row(scene: TagScene, path: Motor, distance_m: float, name: str, way: _Way) -> dict[str, Any]:
    seen = way.observations
    true = path[seen.frame].inverse() @ scene.world_T_marker[seen.marker_ids]
    corners = np.stack([scene.corners_px(path[row]) for row in range(FRAMES)])
    off = way.stream.corners_px - corners[way.stream.frame, way.stream.marker_ids]
    over_time = resolve(seen)
    jitter_m, jitter_rad = _jitter(over_time, true)
    return {
        "distance_m": distance_m,
        "way": name,
        "side_px": SIDE_M * _CAMERA.fx / distance_m,
        "markers": len(seen),
        "corner_rms_px": float(np.sqrt(np.mean(off**2))),
        "wrong_single": _wrong(best_single(seen), true),
        "wrong_over_time": _wrong(over_time, true),
        "jitter_mm": 1e3 * jitter_m,
        "jitter_deg": float(np.degrees(jitter_rad)),
        "ms_a_marker": 1e3 * way.seconds / max(len(seen), 1),
    }


def _wrong(answer: Resolution, true: Motor) -> int:
    """Normals more than 15 degrees off."""
    z = np.array([0.0, 0.0, 1.0])
    agree = np.sum(answer.camera_T_marker.rotor.apply(z) * true.rotor.apply(z), axis=-1)
    return int(np.count_nonzero(agree < np.cos(_WRONG_RAD)))


def _jitter(answer: Resolution, true: Motor) -> tuple[float, float]:
    """RMS over axes of the errors' second differences: metres, radians."""
    errors = (true.inverse() @ answer.camera_T_marker).as_twist()
    seen = answer.observations
    parts: list[FloatArray] = []
    for marker in np.unique(seen.marker_ids):
        rows = np.flatnonzero(seen.marker_ids == marker)
        whole = np.diff(seen.frame[rows], 2) == 0
        whole &= np.diff(seen.frame[rows])[:-1] == 1
        parts.append(np.diff(errors[rows], 2, axis=0)[whole])
    jumps = np.concatenate(parts)
    turn, shift = np.sqrt(np.mean(jumps[:, :3] ** 2)), np.sqrt(np.mean(jumps[:, 3:] ** 2))
    return float(shift), float(turn)


def photometric_table(found: Mapping[str, Any]) -> str:
    """A row a distance and way."""
    if found["left_out"]:
        return f"photometric: {found['left_out']}"
    heads = ("markers", "corner px", "wrong alone", "over time", "jitter mm", "jitter °", "ms each")
    lines = [f"{'drawn markers, refined on their print':<42}" + "".join(f"{h:>12}" for h in heads)]
    for row in found["rows"]:
        label = f"{row['distance_m']} m ({row['side_px']:.0f} px), {row['way']}"
        lines.append(
            f"{label:<42}{row['markers']:>12}{row['corner_rms_px']:>12.3f}{row['wrong_single']:>12}"
            f"{row['wrong_over_time']:>12}{row['jitter_mm']:>12.2f}{row['jitter_deg']:>12.2f}"
            f"{row['ms_a_marker']:>12.1f}"
        )
    return "\n".join(lines)
