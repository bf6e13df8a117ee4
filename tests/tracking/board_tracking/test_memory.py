"""Memory grows by what is observed, not by images: long recordings fit."""

import gc
import tracemalloc
from collections.abc import Iterator

import numpy as np
import pytest

from motorcade.replays.io.recording import Frame, LooseMarkers, Recording
from motorcade.replays.stages.camera.marker_poses import markers_found
from motorcade.tracking import BoardTracker, Camera, SingleMarker
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
IMAGE_BYTES = 320 * 240
EARLY, LATE = 10, 40


@pytest.fixture(scope="module")
def images() -> list[np.ndarray]:
    rng = np.random.default_rng(1)
    scene = TagScene(CAMERA, "tag36h11", np.arange(4), 0.1, wall_of_markers(2, 2, 0.2, 20.0, rng))
    path = handheld_path(8, 0.7)
    return [scene.image(path[index], rng) for index in range(8)]


class Sequence:
    """Frames that are made anew each time, and what memory is in use at some of them."""

    def __init__(self, images: list[np.ndarray]) -> None:
        self.images, self.used = images, dict[int, int]()
        self.time_ns = np.arange(LATE + 1, dtype=np.int64) * 33_333_333

    def __len__(self) -> int:
        return len(self.time_ns)

    def __iter__(self) -> Iterator[Frame]:
        for index, time_ns in enumerate(self.time_ns):
            if index in (EARLY, LATE):
                gc.collect()
                self.used[index] = tracemalloc.get_traced_memory()[0]
            yield Frame(int(time_ns), str(index), self.images[index % 8].copy)

    @property
    def bytes_a_frame(self) -> float:
        return (self.used[LATE] - self.used[EARLY]) / (LATE - EARLY)


@pytest.fixture
def traced() -> Iterator[None]:
    tracemalloc.start()
    yield
    tracemalloc.stop()


@pytest.mark.slow
def test_tracking_a_board_keeps_no_images(images: list[np.ndarray], traced: None) -> None:
    frames = Sequence(images)
    tracker = BoardTracker(CAMERA, SingleMarker("tag36h11", 0, 0.1))
    kept = [tracker.update(frame.gray(), frame.time_ns) for frame in frames]
    assert sum(one is not None for one in kept) > LATE // 2
    assert 0 < frames.bytes_a_frame < 0.1 * IMAGE_BYTES


@pytest.mark.slow
def test_finding_loose_markers_keeps_no_images(
    images: list[np.ndarray], traced: None, tmp_path
) -> None:
    frames = Sequence(images)
    recording = Recording("made", tmp_path, "images", frames, CAMERA)  # type: ignore[arg-type]
    stream, *_ = markers_found(recording, LooseMarkers("tag36h11", 0.1))
    assert len(stream) > 2 * LATE
    assert 0 < frames.bytes_a_frame < 0.05 * IMAGE_BYTES
