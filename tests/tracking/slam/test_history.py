"""What became of every frame is told, and can be read back."""

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.slam import SlamResult, VisualSlam
from motorcade.tracking.slam.features import SlamImage
from motorcade.tracking.slam.tracker import TrackedPoints, Tracker

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]
Poses = Callable[..., list[Motor]]

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)  # as the room is rendered
STEP_NS = 33_333_333
BLACK = range(8, 11)


@pytest.fixture(scope="module")
def interrupted(view: View, swaying: Poses) -> SlamResult:
    """Tracked, covered, and found again."""
    slam = VisualSlam(CAMERA)
    for index, pose in enumerate(swaying(14)):
        gray, depth_m = view(pose)
        if index in BLACK:
            gray, depth_m = np.zeros_like(gray), np.full_like(depth_m, np.nan)
        slam.track(index * STEP_NS, gray, depth_m)
    return slam.finish()


def test_events_stand_where_they_happened(interrupted: SlamResult) -> None:
    history = interrupted.history
    told = [(one.kind, one.time_ns // STEP_NS, one.map_number) for one in history.events]
    assert told == [("map begun", 0, 0), ("lost", 8, None), ("relocalised", 11, 0)]
    assert history.frames_in_state["lost"] == len(BLACK)
    assert history.map_number.tolist() == [0] * 8 + [-1] * 3 + [0] * 3
    assert np.all((history.inliers > 25) == (history.map_number == 0))
    assert np.all(np.diff(history.keyframes) >= 0)
    assert history.keyframes[-1] == len(interrupted.map.time_ns)
    assert history.as_dict()["events"][2] == {
        "time_ns": 11 * STEP_NS,
        "kind": "relocalised",
        "map_number": 0,
    }


def test_the_table_holds_every_frame(interrupted: SlamResult, tmp_path: Path) -> None:
    interrupted.history.save(tmp_path / "history.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "history.csv").read_text())))
    assert [int(row["time_ns"]) for row in rows] == interrupted.time_ns.tolist()
    assert [row["state"] for row in rows] == list(interrupted.states)
    assert [int(row["inliers"]) for row in rows] == interrupted.history.inliers.tolist()


@pytest.mark.parametrize(
    ("count", "width_px", "weak"), [(40, 400, True), (200, 400, False), (200, 45, True)]
)
def test_few_corners_or_all_in_one_place_are_weak(
    rng: np.random.Generator, count: int, width_px: int, weak: bool
) -> None:
    image = SlamImage(0, np.zeros((300, 400), dtype=np.uint8))
    px = rng.uniform((0.0, 0.0), (width_px, 300.0), (count, 2))
    points = np.column_stack([CAMERA.unproject(px)[:, :2], np.ones(count)])
    tracker = Tracker(CAMERA)
    tracker.restart(TrackedPoints(image, Motor.identity(), np.arange(count), px, points))
    assert tracker.is_weak == weak
