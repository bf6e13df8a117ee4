"""Visual SLAM in a rendered room with ground truth, and what it says when it cannot know."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.tracking import Camera
from motorcade.tracking.slam import (
    MapSnapshot,
    SlamFrame,
    SlamResult,
    SlamSettings,
    VisualSlam,
)

View = Callable[[Motor], tuple[np.ndarray, np.ndarray]]
Poses = Callable[..., list[Motor]]

CAMERA = Camera(400, 300, 320.0, 320.0, 199.5, 149.5)  # as the room is rendered
STEP_NS = 33_333_333
COUNT, BLACK = 45, range(20, 30)
Ran = tuple[SlamResult, list[SlamFrame]]


def ran(view: View, poses: list[Motor], depth: bool, black: range = range(0)) -> Ran:
    slam, frames = VisualSlam(CAMERA), []
    for index, pose in enumerate(poses):
        gray, depth_m = view(pose)
        if index in black:
            gray, depth_m = np.zeros_like(gray), np.full_like(depth_m, np.nan)
        frames.append(slam.track(index * STEP_NS, gray, depth_m if depth else None))
    return slam.finish(), frames


@pytest.fixture(scope="module")
def with_depth(view: View, swaying: Poses) -> Ran:
    return ran(view, swaying(COUNT), depth=True)


def umeyama_rmse(ours: np.ndarray, truth: np.ndarray, scaled: bool) -> float:
    """Error after the best rigid or similarity alignment, by the closed form."""
    a, b = ours - ours.mean(axis=0), truth - truth.mean(axis=0)
    u, d, vt = np.linalg.svd(b.T @ a)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = np.trace(np.diag(d) @ sign) / np.sum(a**2) if scaled else 1.0
    return float(np.sqrt(np.mean(np.sum((b - scale * a @ (u @ sign @ vt).T) ** 2, axis=1))))


def truth_of(trajectory: Trajectory | None, poses: list[Motor]) -> tuple[np.ndarray, np.ndarray]:
    assert trajectory is not None
    places = Motor.stack(poses).translation_m
    return trajectory.motors.translation_m, places[trajectory.time_ns // STEP_NS]


def test_frames_between_keyframes_are_measured_again_by_what_these_made_certain(
    view: View, swaying: Poses
) -> None:
    """With one camera new points are seen from one side first; poses given at the time drift."""
    poses = swaying(COUNT)
    result, frames = ran(view, poses, depth=False)
    assert result.trajectory is not None
    assert result.online is not None
    keyframes = {one.time_ns for one in frames if one.keyframe}
    between = [one for one in result.online.time_ns.tolist() if one not in keyframes]
    assert len(between) > 10
    errors = []
    for path in (result.online, result.trajectory):
        some = path[np.isin(path.time_ns, between)]
        errors.append(umeyama_rmse(*truth_of(some, poses), scaled=True))
    at_the_time, in_the_end = errors
    assert in_the_end < 0.7 * at_the_time


def test_a_room_with_depth_is_tracked_in_metres_at_every_frame(
    with_depth: Ran, swaying: Poses
) -> None:
    result, frames = with_depth
    poses = swaying(COUNT)
    assert [frame.state for frame in frames] == ["tracking"] * COUNT
    assert result.metric
    ours, truth = truth_of(result.trajectory, poses)
    assert len(ours) == COUNT
    assert umeyama_rmse(ours, truth, scaled=False) < 0.003
    assert result.trajectory is not None
    # The world is the first camera: without any alignment the poses agree too.
    expected = poses[0].inverse() @ Motor.stack(poses)
    apart = expected.inverse() @ result.trajectory.motors
    assert np.linalg.norm(apart.translation_m, axis=1).max() < 0.015
    assert np.degrees(apart.rotor.angle()).max() < 0.5


def test_covariances_are_those_of_poses_and_small(with_depth: Ran) -> None:
    result, _ = with_depth
    assert result.covariance.shape == (COUNT, 6, 6)
    assert np.linalg.eigvalsh(result.covariance).min() > 0.0
    assert np.sqrt(result.covariance[1:, range(3, 6), range(3, 6)]).max() < 0.02


def test_one_camera_finds_the_same_path_up_to_scale(view: View, swaying: Poses) -> None:
    result, frames = ran(view, swaying(COUNT), depth=False)
    assert not result.metric
    assert Counter(frame.state for frame in frames)["tracking"] > COUNT // 2
    ours, truth = truth_of(result.trajectory, swaying(COUNT))
    assert len(ours) == COUNT  # frames before the start are given a pose afterwards
    assert umeyama_rmse(ours, truth, scaled=True) < 0.005


def test_the_same_images_give_the_same_bytes(view: View, swaying: Poses, with_depth: Ran) -> None:
    again, _ = ran(view, swaying(COUNT), depth=True)
    first = with_depth[0]
    assert first.trajectory is not None
    assert again.trajectory is not None
    assert (
        first.trajectory.motors.coefficients.tobytes()
        == again.trajectory.motors.coefficients.tobytes()
    )
    assert first.map.points.tobytes() == again.map.points.tobytes()


def test_black_frames_are_lost_and_the_camera_is_found_again(view: View, swaying: Poses) -> None:
    poses = swaying(COUNT)
    result, frames = ran(view, poses, depth=True, black=BLACK)
    assert all(frames[index].state == "lost" for index in BLACK)
    assert all(frames[index].world_T_camera is None for index in BLACK)
    after = [frame.state for frame in frames[BLACK.stop :]]
    assert "relocalised" in after[:10]
    assert after[-1] == "tracking"
    ours, truth = truth_of(result.trajectory, poses)
    assert umeyama_rmse(ours, truth, scaled=False) < 0.005


def test_a_camera_that_only_turns_has_no_map(view: View, turning: Poses) -> None:
    result, frames = ran(view, turning(25, 0.4), depth=False)
    assert {frame.state for frame in frames} == {"initialising"}
    assert result.trajectory is None


def test_a_room_without_texture_has_no_pose(rng: np.random.Generator) -> None:
    slam = VisualSlam(CAMERA)
    for index in range(5):
        noise = rng.normal(128.0, 0.4, (CAMERA.height, CAMERA.width))
        gray = np.rint(noise).astype(np.uint8)
        depth = np.full(gray.shape, 2.0, dtype=np.float32)
        frame = slam.track(index, gray, depth)
        assert frame.state == "initialising"
        assert frame.world_T_camera is None
    assert slam.finish().trajectory is None


def test_another_scene_cut_in_is_not_believed(
    view: View, swaying: Poses, rng: np.random.Generator
) -> None:
    slam = VisualSlam(CAMERA)
    for index, pose in enumerate(swaying(8)):
        assert slam.track(index * STEP_NS, *view(pose)).state == "tracking"
    stranger = rng.integers(0, 256, (CAMERA.height // 4, CAMERA.width // 4)).astype(np.uint8)
    cut = slam.track(9 * STEP_NS, np.kron(stranger, np.ones((4, 4), dtype=np.uint8)))
    assert cut.state == "lost"


def test_a_map_survives_saving(with_depth: Ran, tmp_path: Path) -> None:
    stored = with_depth[0].map
    stored.save(tmp_path / "map.npz")
    again = MapSnapshot.load(tmp_path / "map.npz")
    for name in ("time_ns", "points", "descriptors", "keyframe_of", "point_of", "px"):
        assert np.array_equal(getattr(stored, name), getattr(again, name)), name
    assert np.array_equal(stored.world_T_camera.coefficients, again.world_T_camera.coefficients)
    stored.save(tmp_path / "twice.npz")
    assert (tmp_path / "map.npz").read_bytes() == (tmp_path / "twice.npz").read_bytes()
    (tmp_path / "torn.npz").write_bytes((tmp_path / "map.npz").read_bytes()[:500])
    with pytest.raises(ValueError, match="not a saved map"):
        MapSnapshot.load(tmp_path / "torn.npz")


def test_points_of_the_map_lie_on_the_walls(
    with_depth: Ran, swaying: Poses, half_m: np.ndarray
) -> None:
    points = swaying(1)[0].apply(with_depth[0].map.points)
    assert len(points) > 300
    from_wall = np.abs(np.max(np.abs(points) / half_m, axis=1) - 1.0)
    assert np.median(from_wall) < 0.005
    assert np.quantile(from_wall, 0.95) < 0.03


GRAY = np.zeros((CAMERA.height, CAMERA.width), dtype=np.uint8)


@pytest.mark.parametrize(
    ("feed", "message"),
    [
        (lambda slam: slam.track(1, GRAY[:-1]), r"image: expected 400 x 300"),
        (lambda slam: slam.track(1, GRAY, np.ones((3, 3), dtype=np.float32)), "depth_m: expected"),
        (lambda slam: slam.track(0, GRAY), "time_ns: expected more than 0"),
        (lambda slam: slam.track(1.5, GRAY), "time_ns: expected whole"),
        (lambda slam: slam.track(1, GRAY.astype(float)), "image: expected a grey uint8"),
        (lambda slam: slam.track(1, GRAY, None, GRAY), "right: expected SlamSettings\\.baseline_m"),
    ],
)
def test_bad_frames_are_refused(feed: Callable[[VisualSlam], object], message: str) -> None:
    slam = VisualSlam(CAMERA)
    slam.track(0, GRAY)
    with pytest.raises(ValueError, match=message):
        feed(slam)


def test_bad_settings_are_refused() -> None:
    with pytest.raises(ValueError, match=r"SlamSettings\.features"):
        SlamSettings(features=3)
    with pytest.raises(ValueError, match=r"SlamSettings\.baseline_m"):
        SlamSettings(baseline_m=-1.0)
    with pytest.raises(ValueError, match="expected at least one frame"):
        VisualSlam(Camera(64, 48, 50.0, 50.0, 32.0, 24.0)).finish()
