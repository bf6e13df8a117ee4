"""`make bench SUITE=tracking`, markers: how many are found, and how long it takes.

On the images of tags in the recordings' folder, beside pupil-apriltags alone (`quad_decimate=1`)
and OpenCV's detector alone, each on one thread. The three take turns on each image, and each
time is the median of the thread's own seconds, so that other load on the machine hardly counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from tests.bench.data import data_folder

__all__ = ["apriltag_detector", "bench_markers", "markers_table", "measure_images"]

FAMILY = "tag36h11"
ROUNDS = 15
_FOLDERS = ("rotations", "multi", "photos")


def bench_markers() -> dict[str, Any]:
    """Markers found and milliseconds for each folder of images, each way."""
    folder = data_folder() / "tags"
    rows = []
    for name in _FOLDERS:
        files = sorted(
            path for path in (folder / name).glob("*") if path.suffix in (".png", ".jpg")
        )
        if files:
            rows.append({"images": name, **measure_images(files, ROUNDS)})
    return {"family": FAMILY, "rows": rows}


def measure_images(files: list[Path], rounds: int) -> dict[str, Any]:
    """Markers found in image files, milliseconds an image, and times relative to AprilTag.

    Raises:
        RecordingError: an image that cannot be read.
    """
    from motorcade.replays.io.readers.frames.images import read_gray

    found: dict[str, int] = {}
    spent_ms: dict[str, float] = {}
    with _one_opencv_thread():
        for path in files:
            image = read_gray(path, None, None)
            for name, (count, seconds) in _take_turns(_ways(image), rounds).items():
                found[name] = found.get(name, 0) + count
                spent_ms[name] = spent_ms.get(name, 0.0) + 1e3 * seconds
    return {
        "count": len(files),
        "found": found,
        "ms_an_image": {name: ms / len(files) for name, ms in spent_ms.items()},
        "times_apriltag": {name: ms / spent_ms["apriltag"] for name, ms in spent_ms.items()},
    }


def _ways(image: Any) -> dict[str, Callable[[], int]]:
    import cv2

    from motorcade.tracking.markers import detect_markers
    from motorcade.tracking.markers.families import dictionary

    peer = apriltag_detector(FAMILY)
    aruco = cv2.aruco.ArucoDetector(dictionary(FAMILY))
    return {
        "motorcade": lambda: len(detect_markers(image, FAMILY)),
        "apriltag": lambda: len(peer.detect(image)),
        "opencv": lambda: len(aruco.detectMarkers(image)[0]),
    }


def apriltag_detector(family: str) -> Any:
    """The AprilTag library's own detector at full resolution, on one thread."""
    from pupil_apriltags import Detector

    detector = Detector(families=family, nthreads=1, quad_decimate=1.0)
    # Its destructor frees the family before the detector that still writes into it, which corrupts
    # memory; not knowing the family, it leaves those few kilobytes alone.
    detector.tag_families.clear()
    return detector


def _take_turns(ways: Mapping[str, Callable[[], int]], rounds: int) -> dict[str, tuple[int, float]]:
    """What each way returns, and the median seconds of it, all of them once a round."""
    counts = {name: way() for name, way in ways.items()}
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            start = time.thread_time()
            way()
            seconds[name].append(time.thread_time() - start)
    return {name: (counts[name], median(seconds[name])) for name in ways}


@contextmanager
def _one_opencv_thread() -> Iterator[None]:
    import cv2

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def markers_table(found: Mapping[str, Any]) -> str:
    """A row a folder and way: markers found, milliseconds, times AprilTag's."""
    if not found["rows"]:
        return "markers: no images of tags here; set MOTORCADE_DATA to the recordings' folder"
    lines = [f"{found['family'] + ', one thread':<38}{'found':>10}{'ms':>10}{'x apriltag':>12}"]
    for row in found["rows"]:
        for name, ms in row["ms_an_image"].items():
            label = f"{row['images']} ({row['count']}), {name}"
            count, times = row["found"][name], row["times_apriltag"][name]
            lines.append(f"{label:<38}{count:>10}{ms:>10.1f}{times:>12.2f}")
    return "\n".join(lines)
