"""Going on in a saved map, and what is held in memory meanwhile."""

import gc
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FunctionType, ModuleType

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera
from motorcade.tracking.slam import MapSnapshot, VisualSlam
from motorcade.tracking.slam.mapping import mapper

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]
Poses = Callable[..., list[Motor]]

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)  # as the room is rendered
STEP_NS = 33_333_333
MAPPED, AGAIN = 30, range(25, 75, 2)


@pytest.fixture(scope="module")
def stored(view: View, swaying: Poses, tmp_path_factory: pytest.TempPathFactory) -> MapSnapshot:
    """A map of the start of a path, saved and read back."""
    slam = VisualSlam(CAMERA)
    for index, pose in enumerate(swaying(MAPPED)):
        slam.track(index * STEP_NS, *view(pose))
    path: Path = tmp_path_factory.mktemp("map") / "room.npz"
    slam.finish().map.save(path)
    return MapSnapshot.load(path)


def resumed(view: View, swaying: Poses, stored: MapSnapshot, extend: bool) -> VisualSlam:
    slam = VisualSlam(CAMERA, known=stored, extend=extend)
    poses = swaying(AGAIN.stop)
    states = []
    for index in AGAIN:
        gray, depth_m = view(poses[index])
        frame = slam.track(index * STEP_NS, gray, depth_m if extend else None)
        states.append(frame.state)
        assert frame.world_T_camera is not None
        # The world is that of the saved map: the first camera of the first run.
        apart = (poses[0].inverse() @ poses[index]).inverse() @ frame.world_T_camera
        assert np.linalg.norm(apart.translation_m) < 0.02
        assert np.degrees(apart.rotor.angle()) < 0.6
    assert states == ["relocalised"] + ["tracking"] * (len(AGAIN) - 1)
    return slam


def test_the_camera_is_found_and_tracked_in_a_saved_map_that_stays_as_it_is(
    view: View, swaying: Poses, stored: MapSnapshot
) -> None:
    result = resumed(view, swaying, stored, extend=False).finish()
    assert result.metric
    assert result.trajectory is not None
    assert len(result.trajectory) == len(AGAIN)
    for name in ("time_ns", "points", "descriptors", "keyframe_of", "point_of", "px", "depth"):
        np.testing.assert_array_equal(getattr(result.map, name), getattr(stored, name))
    ours, theirs = (one.world_T_camera.as_matrix() for one in (result.map, stored))
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_a_saved_map_grows_where_asked(view: View, swaying: Poses, stored: MapSnapshot) -> None:
    result = resumed(view, swaying, stored, extend=True).finish()
    assert len(result.map.time_ns) > len(stored.time_ns)
    assert len(result.map.points) > len(stored.points)
    # What was seen again is not mapped anew.
    known = {row.tobytes() for row in stored.descriptors}
    newest = result.map.keyframe_of >= len(stored.time_ns)
    seen = result.map.descriptors[np.unique(result.map.point_of[newest])]
    assert sum(row.tobytes() in known for row in seen) > 50


def test_a_strange_room_is_not_taken_for_the_saved_one(
    view: View, stored: MapSnapshot, rng: np.random.Generator
) -> None:
    slam = VisualSlam(CAMERA, known=stored)
    for index in range(3):
        strange = rng.integers(0, 256, (CAMERA.height // 4, CAMERA.width // 4)).astype(np.uint8)
        frame = slam.track(index, np.kron(strange, np.ones((4, 4), dtype=np.uint8)))
        assert frame.state == "lost"
        assert frame.world_T_camera is None
    assert slam.finish().trajectory is None


def test_a_known_map_that_shows_nothing_is_refused(stored: MapSnapshot) -> None:
    nothing = replace(
        stored,
        keyframe_of=stored.keyframe_of[:0],
        point_of=stored.point_of[:0],
        px=stored.px[:0],
        depth=stored.depth[:0],
    )
    grey = np.full((CAMERA.height, CAMERA.width), 128, dtype=np.uint8)
    unmapped = VisualSlam(CAMERA)
    unmapped.track(0, grey)
    for known in (nothing, unmapped.finish().map):
        with pytest.raises(ValueError, match="known: expected a map whose keyframes see points"):
            VisualSlam(CAMERA, known=known)


def held_bytes(thing: object) -> int:
    """Bytes of everything reachable from here; arrays by the memory they own."""
    seen, waiting, total = set(), [thing], 0
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, (type, ModuleType, FunctionType)):
            continue
        seen.add(id(one))
        total += sys.getsizeof(one)
        waiting += gc.get_referents(one)
    return total


def test_memory_grows_with_keyframes_and_hardly_with_frames(view: View, swaying: Poses) -> None:
    slam, pose = VisualSlam(CAMERA), swaying(1)[0]
    gray, depth_m = view(pose)
    held = []
    for index in range(90):
        frame = slam.track(index * STEP_NS, gray, depth_m)
        assert frame.keyframe == (index == 0), "standing still shows nothing new"
        if index in (59, 89):
            held.append(held_bytes(slam))
    assert held[0] > gray.nbytes
    assert (held[1] - held[0]) / 30 < 1500, "a frame leaves its pose and state, nothing more"
    result = slam.finish()
    assert len(result.map.time_ns) == 1
    assert len(result.states) == 90


def test_old_keyframes_keep_no_image(
    view: View, swaying: Poses, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mapper, "_IMAGES_KEPT", 3)
    slam = VisualSlam(CAMERA)
    for index, pose in enumerate(swaying(AGAIN.stop)[:: AGAIN.step]):
        slam.track(index * STEP_NS, *view(pose))
    kept = [one.gray is not None for one in slam._map.keyframes]
    assert len(kept) > 5
    assert sum(kept) == 3
    assert all(kept[-3:])
