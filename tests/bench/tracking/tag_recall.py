"""`python -m tests.bench.tracking.tag_recall`: tags found in drawn scenes that are hard to read.

Tags of 12 to 50 pixels at up to 78 degrees, of many greys, on texture that is brighter or darker
than their paper, under shadows, blurred and noisy; beside the AprilTag library and OpenCV. Many of
them nobody can read: what counts is what the three find.

Part of `make bench SUITE=tracking`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from typing import Any

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage
from tests.bench.tracking.tag_markers import apriltag_detector

__all__ = ["bench_recall", "draw_scene", "measure_recall", "recall_table"]

FAMILY, SCENES = "tag36h11", 40
_COLUMNS, _ROWS, _FINE, _CELL_PX, _FOCAL_PX = 6, 4, 4, 20, 500.0
_SAME_PX = 8.0
Tags = list[tuple[int, FloatArray]]


def draw_scene(
    rng: np.random.Generator, family: str = FAMILY, width: int = 640, height: int = 480
) -> tuple[GrayImage, Tags]:
    """An image, and the id and centre of each tag in it."""
    from motorcade.tracking.markers.families import family_size

    size = (width * _FINE, height * _FINE)
    texture = cv2.GaussianBlur(
        rng.standard_normal((height, width)).astype(np.float32), (0, 0), rng.uniform(1.0, 4.0)
    )
    texture *= rng.uniform(0.0, 25.0) / texture.std()
    fine = cv2.resize(texture, size) + np.float32(rng.uniform(90.0, 230.0))
    tags: Tags = []
    for place in range(_COLUMNS * _ROWS):
        row, column = divmod(place, _COLUMNS)
        centre = (np.array([column, row]) + 0.5) * (width / _COLUMNS, height / _ROWS)
        marker = int(rng.integers(family_size(family)))
        centre += rng.uniform(-8.0, 8.0, 2)
        view = _view(centre - (width / 2, height / 2), rng)
        view = np.array([[1.0, 0.0, width / 2], [0.0, 1.0, height / 2], [0.0, 0.0, 1.0]]) @ view
        _draw_tag(fine, view, family, marker, rng)
        seen = view @ (0.0, 0.0, 1.0)
        tags.append((marker, seen[:2] / seen[2]))
    for _ in range(rng.integers(0, 4)):
        shade = np.zeros(fine.shape, np.uint8)
        corners = rng.uniform(-100.0, (width + 100.0, height + 100.0), (3, 2))
        cv2.fillPoly(shade, [np.int32(corners * _FINE)], 1)
        fine[shade > 0] *= rng.uniform(0.25, 0.7)
    image = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 1.1))
    image += rng.uniform(0.5, 6.0) * rng.standard_normal(image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8), tags


def _view(centre_px: FloatArray, rng: np.random.Generator) -> FloatArray:
    """From a tag's plane, its side 1 and its origin in its middle, to pixels from the centre."""
    distance = _FOCAL_PX / rng.uniform(12.0, 50.0)
    tilt, azimuth = np.radians(rng.uniform(0.0, 78.0)), rng.uniform(0.0, 2.0 * np.pi)
    lean = cv2.Rodrigues(tilt * np.array([np.cos(azimuth), np.sin(azimuth), 0.0]))[0]
    turn = cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)]))[0]
    axes = (lean @ turn)[:, :2]
    middle = distance * np.array([*(centre_px / _FOCAL_PX), 1.0])
    view: FloatArray = np.diag([_FOCAL_PX, _FOCAL_PX, 1.0]) @ np.column_stack([axes, middle])
    return view


def _draw_tag(
    fine: Any, view: FloatArray, family: str, marker: int, rng: np.random.Generator
) -> None:
    from motorcade.tracking.markers.families import layout, marker_cells

    cells = np.pad(marker_cells(family, marker), 1, constant_values=True)
    black, white = rng.uniform(10.0, 110.0), rng.uniform(120.0, 250.0)
    print_ = np.kron(np.where(cells, white, black), np.ones((_CELL_PX, _CELL_PX)))
    step = 1.0 / (layout(family).side_cells * _CELL_PX)
    first = -0.5 * (len(print_) - 1) * step
    to_plane = np.array([[step, 0.0, first], [0.0, step, first], [0.0, 0.0, 1.0]])
    middle = 0.5 * (_FINE - 1)
    finer = np.array([[_FINE, 0.0, middle], [0.0, _FINE, middle], [0.0, 0.0, 1.0]])
    place, size = finer @ view @ to_plane, fine.shape[::-1]
    drawn = cv2.warpPerspective(print_.astype(np.float32), place, size)
    whole = np.ones(print_.shape, np.uint8)
    inside = cv2.warpPerspective(whole, place, size, flags=cv2.INTER_NEAREST) > 0
    fine[inside] = drawn[inside]


def measure_recall(scenes: int, first_seed: int = 0) -> dict[str, Any]:
    """Right and false ones of each way, and how many the libraries find together."""
    ways = _ways()
    right, false = dict.fromkeys(ways, 0), dict.fromkeys(ways, 0)
    seconds, together = dict.fromkeys(ways, 0.0), 0
    for seed in range(first_seed, first_seed + scenes):
        image, tags = draw_scene(np.random.default_rng(seed))
        hits: dict[str, set[int]] = {}
        for name, way in ways.items():
            start = time.thread_time()
            found = way(image)
            seconds[name] += time.thread_time() - start
            which = [_which(one, tags) for one in found]
            hits[name] = {one for one in which if one is not None}
            right[name] += len(hits[name])
            false[name] += which.count(None)
        together += len(hits["apriltag"] | hits["opencv"])
    return {
        "scenes": scenes,
        "right": right,
        "false": false,
        "libraries_together": together,
        "ms_an_image": {name: 1e3 * one / scenes for name, one in seconds.items()},
    }


def _ways() -> dict[str, Callable[[GrayImage], Tags]]:
    from motorcade.tracking.markers import detect_markers
    from motorcade.tracking.markers.families import dictionary

    library = apriltag_detector(FAMILY)
    aruco = cv2.aruco.ArucoDetector(dictionary(FAMILY))

    def opencv(image: GrayImage) -> Tags:
        quads, ids, _ = aruco.detectMarkers(image)
        if ids is None:
            return []
        return [
            (int(one), quad[0].mean(axis=0)) for one, quad in zip(ids.ravel(), quads, strict=True)
        ]

    return {
        "motorcade": lambda image: [
            (one.marker_id, one.corners_px.mean(axis=0)) for one in detect_markers(image, FAMILY)
        ],
        "apriltag": lambda image: [(one.tag_id, one.center - 0.5) for one in library.detect(image)],
        "opencv": opencv,
    }


def _which(one: tuple[int, FloatArray], tags: Tags) -> int | None:
    near = [
        row
        for row, (marker, centre) in enumerate(tags)
        if marker == one[0] and np.linalg.norm(centre - one[1]) < _SAME_PX
    ]
    return near[0] if near else None


def bench_recall() -> dict[str, Any]:
    """The scenes of the page."""
    return measure_recall(SCENES)


def recall_table(found: Mapping[str, Any]) -> str:
    """A row a way: right ones, false ones, milliseconds."""
    lines = [f"{found['scenes']} drawn scenes, {FAMILY:<18}{'right':>10}{'false':>10}{'ms':>10}"]
    for name, ms in found["ms_an_image"].items():
        lines.append(f"{name:<36}{found['right'][name]:>10}{found['false'][name]:>10}{ms:>10.1f}")
    lines.append(f"{'apriltag and opencv together':<36}{found['libraries_together']:>10}")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--first-seed", type=int, default=0)
    given = parser.parse_args()
    print(recall_table(measure_recall(given.scenes, given.first_seed)))
