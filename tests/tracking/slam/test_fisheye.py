"""A fisheye that sees beyond 90 degrees: its images are tracked as they are."""

import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.tracking import Camera
from motorcade.tracking.slam import SlamResult, VisualSlam
from motorcade.tracking.slam.geometry import flattened, triangulate
from tests.tracking.slam.conftest import rendered

# As wide as a T265: the corners of its images stand 115 degrees off the axis.
FISHEYE = Camera(
    424, 400, 143.4, 143.4, 211.5, 199.5, "equidistant", (-0.007, 0.01, -0.003, 0.0002)
)
STEP_NS = 33_000_000


@pytest.fixture(scope="module")
def tracked() -> tuple[SlamResult, Trajectory]:
    """Monocular, 40 frames of a hand that sways."""
    t = np.arange(40) / 20.0
    turn = np.stack([0.2 * np.sin(t), 0.3 * np.sin(0.9 * t), 0.1 * np.sin(1.3 * t)], axis=1)
    place = np.stack([0.4 * np.sin(1.1 * t), 0.3 * np.sin(1.7 * t), 0.3 * np.sin(0.8 * t)], axis=1)
    poses = Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)
    slam = VisualSlam(FISHEYE)
    for step, pose in enumerate(poses):
        slam.track(step * STEP_NS, rendered(pose, FISHEYE)[0])
    return slam.finish(), Trajectory(STEP_NS * np.arange(len(t)), poses)


def test_the_path_is_found_in_the_images_of_the_lens_itself(tracked):
    result, truth = tracked
    assert len(result.trajectory) >= 36
    judged = evaluate(result.trajectory, truth, align="sim3")
    assert judged.ape_m.rmse < 0.005
    assert judged.rotation_deg.rmse < 0.3


def test_corners_beyond_ninety_degrees_are_mapped_as_well_as_others(tracked):
    result, _ = tracked
    seen = result.map
    bearings = FISHEYE.bearings(seen.px)
    angle = np.degrees(np.arccos(bearings[:, 2]))
    assert np.isfinite(angle).all()
    for low, high, fewest in ((0.0, 60.0, 300), (60.0, 90.0, 300), (90.0, 115.0, 30)):
        band = (angle >= low) & (angle < high)
        assert np.count_nonzero(band) >= fewest
        poses = seen.world_T_camera[seen.keyframe_of[band]]
        own = poses.inverse().apply(seen.points[seen.point_of[band]])
        off_px = np.linalg.norm(FISHEYE.project(own) - seen.px[band], axis=-1)
        assert np.median(off_px) < 0.5


def test_rays_of_any_angle_meet_in_their_point():
    rng = np.random.default_rng(0)
    first, second = Motor.identity(), Motor.from_twist([0.1, -0.2, 0.1, 0.3, 0.1, -0.2])
    points = rng.standard_normal((200, 3))
    points *= (2.0 + rng.random((200, 1))) / np.linalg.norm(points, axis=-1, keepdims=True)
    angle = np.degrees(np.arccos(points[:, 2] / np.linalg.norm(points, axis=-1)))
    points = points[angle < 110.0]
    px = [FISHEYE.project(pose.inverse().apply(points)) for pose in (first, second)]
    found = triangulate(first, second, *px, FISHEYE)
    known = np.isfinite(found[:, 0])
    assert np.count_nonzero(~known) <= 0.1 * len(points)  # turned out of the lens's reach
    np.testing.assert_allclose(found[known], points[known], atol=1e-6)


def test_only_corners_near_the_axis_are_flattened():
    angle = np.deg2rad([0.0, 30.0, 60.0, 70.0, 100.0])
    rays = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=-1)
    flat = flattened(FISHEYE, FISHEYE.project(rays))
    np.testing.assert_array_equal(np.isfinite(flat[:, 0]), [True, True, True, False, False])
    expected = FISHEYE.undistorted().project(rays[:3])
    np.testing.assert_allclose(flat[:3], expected, atol=1e-6)


def test_images_of_another_size_and_pairs_are_refused():
    slam = VisualSlam(FISHEYE)
    gray = np.zeros((FISHEYE.height, FISHEYE.width), np.uint8)
    with pytest.raises(ValueError, match=r"gray: expected shape \(400, 424\)"):
        slam.track(0, gray[:-1])
    with pytest.raises(ValueError, match=r"depth_m: expected shape \(400, 424\)"):
        slam.track(0, gray, gray[:-1].astype(np.float32))
