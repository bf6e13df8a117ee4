"""`make bench SUITE=tracking`, flips: how often the wrong one of a marker's planar poses is chosen.

On TagSLAM's recordings, against the reference beside them. A step is a marker seen in two
consecutive frames that have a reference (at most 0.3 s apart); it is a flip if the chosen normal,
turned by the reference's relative rotation, differs from the next chosen one by more than 15°. A
marker that is always wrong never flips, so the share of normals more than 15° from the reference's
stands beside it. A detection without an answer counts as wrong, and its steps as flips.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.replays.io.readers.tagslam.recording import TagSlamReference, read_reference
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import (
    MarkerObservations,
    best_single,
    pose_stream,
    resolve,
)
from motorcade.tracking.markers.disambiguate.resolving import FixedLagResolver, Resolution
from tests.bench.data import data_folder

__all__ = [
    "Flips",
    "bench_flips",
    "count_flips",
    "flips_table",
    "reference_rotors",
    "resolve_online",
    "tagslam_folder",
]

RECORDINGS = ("test_24", "test_23")
LAGS = (0, 1, 2, 5, 10)
_LIMIT_RAD = np.radians(15.0)
_LONGEST_STEP_NS = 300_000_000
_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Flips:
    """What was counted.

    Args:
        steps: markers seen in two consecutive frames with a reference.
        flips: those of them that flip.
        detections: markers seen in a frame with a reference.
        wrong: those of them whose normal is more than 15° from the reference's.
    """

    steps: int
    flips: int
    detections: int
    wrong: int

    @property
    def wrong_percent(self) -> float:
        """Share of detections that are wrong."""
        return 100.0 * self.wrong / max(self.detections, 1)


def reference_rotors(stream: CornerStream, reference: TagSlamReference, camera: str) -> FloatArray:
    """Coefficients ``(N, 4)`` of each detection's camera_R_tag; NaN where there is none."""
    rotors = np.full((len(stream), 4), np.nan)
    for row, stamp in enumerate(reference.time_ns):
        tags = _camera_T_tags(reference.world_T_frame[row], camera)
        for one in np.flatnonzero(stream.time_ns[stream.frame] == stamp):
            if int(stream.marker_ids[one]) in tags:
                rotors[one] = tags[int(stream.marker_ids[one])].rotor.coefficients
    return rotors


def _camera_T_tags(world_T_frame: Mapping[str, Motor], camera: str) -> dict[int, Motor]:
    """Pose of each tag's centred frame in a camera, by id."""
    if camera not in world_T_frame:
        return {}
    camera_T_world = world_T_frame[camera].inverse()
    tags = ((name.removeprefix("tag_"), pose) for name, pose in world_T_frame.items())
    return {int(name): camera_T_world @ pose for name, pose in tags if name.isdigit()}


def count_flips(stream: CornerStream, normals: FloatArray, reference: FloatArray) -> Flips:
    """Count flips and wrong normals as this module defines them.

    Args:
        stream: all N detections.
        normals: ``(N, 3)`` unit, camera frame; NaN for detections that were withheld.
        reference: ``(N, 4)`` from `reference_rotors`.
    """
    known = np.isfinite(reference[:, 0])
    true = Rotor.normalize(np.where(known[:, None], reference, [1.0, 0.0, 0.0, 0.0]))
    before, after = _steps(stream, known)
    expected = _turned(true[after] @ true[before].inverse(), normals[before])
    return Flips(
        steps=len(before),
        flips=int(np.count_nonzero(~_near(expected, normals[after]))),
        detections=int(np.count_nonzero(known)),
        wrong=int(np.count_nonzero(~_near(true.apply(_Z), normals)[known])),
    )


def _steps(stream: CornerStream, known: np.ndarray[Any, Any]) -> tuple[IntArray, IntArray]:
    """Rows of the same marker in consecutive frames that have a reference."""
    with_reference = np.unique(stream.frame[known])
    before, after = [], []
    for a, b in pairwise(with_reference):
        if stream.time_ns[b] - stream.time_ns[a] > _LONGEST_STEP_NS:
            continue
        rows_a, rows_b = (np.flatnonzero((stream.frame == f) & known) for f in (a, b))
        _, in_a, in_b = np.intersect1d(
            stream.marker_ids[rows_a], stream.marker_ids[rows_b], return_indices=True
        )
        before.append(rows_a[in_a])
        after.append(rows_b[in_b])
    none = [np.zeros(0, np.int64)]
    return np.concatenate(before or none), np.concatenate(after or none)


def _turned(rotor: Rotor, normals: FloatArray) -> FloatArray:
    answered = np.isfinite(normals)
    return np.where(answered, rotor.apply(np.where(answered, normals, 0.0)), np.nan)


def _near(a: FloatArray, b: FloatArray) -> np.ndarray[Any, Any]:
    """Whether unit vectors are within 15°; not where one is missing."""
    near: np.ndarray[Any, Any] = np.sum(a * b, axis=-1) >= np.cos(_LIMIT_RAD)
    return near


def _normals(stream: CornerStream, answer: Resolution) -> FloatArray:
    """Chosen normals ``(N, 3)`` of all detections; NaN for those that are not in the answer."""
    normals = np.full((len(stream), 3), np.nan)
    seen = answer.observations
    place = {
        key: row
        for row, key in enumerate(
            zip(stream.frame.tolist(), stream.marker_ids.tolist(), strict=True)
        )
    }
    rows = [place[key] for key in zip(seen.frame.tolist(), seen.marker_ids.tolist(), strict=True)]
    normals[rows] = answer.camera_T_marker.rotor.apply(_Z)
    return normals


def resolve_online(
    observations: MarkerObservations, lag_frames: int, sigma_px: float | None = None
) -> Resolution:
    """A recording resolved as `FixedLagResolver` would have done while it was taken.

    Raises:
        ValueError: a lag below 0, or a noise that is not above zero.
    """
    resolver = FixedLagResolver(lag_frames, sigma_px)
    frames = range(len(observations.time_ns))
    answers = [resolver.update(observations.of_frames(np.array([row]))) for row in frames]
    done = [answer for answer in answers if answer is not None] + list(resolver.finish())
    return Resolution(
        observations,
        np.concatenate([answer.choice for answer in done]) if done else np.zeros(0, np.int64),
        np.concatenate([answer.probability for answer in done]) if done else np.zeros(0),
    )


def _methods() -> Iterator[tuple[str, Callable[[MarkerObservations], Resolution]]]:
    yield "best reprojection", best_single
    for lag in LAGS:
        yield f"online, {lag} frames late", partial(resolve_online, lag_frames=lag)
    yield "whole recording", resolve


def bench_flips(folder: Path | None = None) -> list[dict[str, Any]]:
    """Count flips of every method on every recording that is there.

    Args:
        folder: where TagSLAM's recordings lie; None looks in `MOTORCADE_DATA`, or else in
            `../shared/data`.
    """
    rows = []
    root = folder or tagslam_folder()
    for name in RECORDINGS:
        if not tagslam.recognise(root / name):
            continue
        recording = tagslam.read_corners(root / name)
        stream = recording.streams["cam0"]
        true = reference_rotors(stream, read_reference(root / name), "cam0")
        observations = pose_stream(stream, recording.side_m)
        for method, answer in _methods():
            start = time.perf_counter()
            found = answer(observations)
            seconds = time.perf_counter() - start
            counted = count_flips(stream, _normals(stream, found), true)
            rows.append(
                {"recording": name, "method": method, **asdict(counted)}
                | {"wrong_percent": counted.wrong_percent}
                | {"milliseconds_a_frame": 1e3 * seconds / len(stream.time_ns)}
            )
    return rows


def tagslam_folder() -> Path:
    """Where TagSLAM's recordings lie, if they do."""
    return data_folder() / "tags" / "tagslam"


def flips_table(rows: list[Mapping[str, Any]]) -> str:
    """A row a recording and method."""
    if not rows:
        return "flips: none of TagSLAM's recordings is here; set MOTORCADE_DATA to their folder"
    lines = [f"{'chosen planar poses':<34}{'flips':>12}{'wrong normals':>22}{'ms a frame':>12}"]
    for row in rows:
        name = f"{row['recording']}, {row['method']}"
        flips = f"{row['flips']} of {row['steps']}"
        wrong = f"{row['wrong']} of {row['detections']}, {row['wrong_percent']:.2f} %"
        lines.append(f"{name:<34}{flips:>12}{wrong:>22}{row['milliseconds_a_frame']:>12.2f}")
    return "\n".join(lines)
