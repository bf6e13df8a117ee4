"""Photometric refinement: nearer to truth than corners, by derivatives that others confirm."""

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.tracking import Camera, detect_markers
from motorcade.tracking.markers.families import marker_cells, marker_points_m
from motorcade.tracking.markers.photometric import (
    PhotometricUnavailable,
    joined_frames,
    refine_frame,
)
from motorcade.tracking.markers.photometric.prints import (
    blurred,
    grid_extent,
    grid_points,
    prints,
    rectified,
    require,
)
from motorcade.tracking.markers.photometric.refine import refine_photometric
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers

torch = pytest.importorskip("torch", reason="photometric refinement needs torch and kornia")
pytest.importorskip("kornia", reason="photometric refinement needs torch and kornia")

CAMERA = Camera(320, 240, 300.0, 301.0, 159.5, 120.5)
FAMILY, SIDE_M = "tag36h11", 0.08


@pytest.fixture(scope="module")
def seen():
    """One image of four markers: the scene, the pose, the image, its detections."""
    rng = np.random.default_rng(2)
    wall = wall_of_markers(2, 2, 0.15, 25.0, rng)
    scene = TagScene(CAMERA, FAMILY, np.arange(4), SIDE_M, wall, blur_px=0.9)
    pose = handheld_path(9, 0.6)[4]
    image = scene.image(pose, rng)
    return scene, pose, image, detect_markers(image, FAMILY, CAMERA)


def test_refined_corners_are_nearer_to_the_truth_than_detected_ones(seen) -> None:
    scene, pose, image, found = seen
    ids = np.array([one.marker_id for one in found])
    assert len(ids) == 4
    detected = np.stack([one.corners_px for one in found])
    refined = refine_frame(image, CAMERA, FAMILY, ids, detected, np.full(4, SIDE_M))
    true = scene.corners_px(pose)[ids]
    before = np.sqrt(np.mean((detected - true) ** 2))
    after = np.sqrt(np.mean((refined.corners_px - true) ** 2))
    assert after < 0.6 * before
    assert after < 0.02
    assert np.all(refined.error_px[:, 0] == 0.0)
    assert np.all(refined.error_px[:, 1] > 0.1)
    true_pose = pose.inverse().reshape(1) @ scene.world_T_marker[ids]
    apart = refined.camera_T_marker[:, 0].inverse() @ true_pose
    assert np.degrees(apart.rotor.angle()).max() < 0.5


def test_frames_join_to_a_stream_and_observations_that_agree(seen) -> None:
    _, _, image, found = seen
    ids = np.array([one.marker_id for one in found])
    corners = np.stack([one.corners_px for one in found])
    full = refine_frame(image, CAMERA, FAMILY, ids, corners, np.full(4, SIDE_M))
    empty = refine_frame(image, CAMERA, FAMILY, ids[:0], corners[:0], np.zeros(0))
    stream, observations = joined_frames(CAMERA, np.array([10, 20, 30]), [full, empty, full])
    np.testing.assert_array_equal(stream.frame, [0, 0, 0, 0, 2, 2, 2, 2])
    np.testing.assert_array_equal(observations.marker_ids, [*ids, *ids])
    best = observations.camera_T_marker[:, 0]
    points = CAMERA.project(best[:, None].apply(marker_points_m(SIDE_M)))
    np.testing.assert_allclose(stream.corners_px, points, atol=1e-9)


def test_a_covered_marker_is_put_back(seen) -> None:
    """A finger over one corner: the print explains too little, and the corners' poses stay."""
    scene, pose, image, found = seen
    covered = image.copy()
    x, y = np.rint(found[0].corners_px.mean(axis=0)).astype(int)
    covered[y : y + 40, x : x + 40] = 128
    ids = np.array([one.marker_id for one in found])
    true = pose.inverse().reshape(1) @ scene.world_T_marker[ids]
    start = Motor(np.repeat(true.coefficients[:, None], 2, axis=1))
    refined = refine_photometric(covered, CAMERA, FAMILY, ids, np.full(4, SIDE_M), start)
    assert not refined.refined[0].any()
    np.testing.assert_array_equal(refined.camera_T_marker[0].coefficients, start[0].coefficients)
    assert refined.refined[1:].any(axis=-1).all()
    corners = np.stack([one.corners_px for one in found])
    frame = refine_frame(covered, CAMERA, FAMILY, ids, corners, np.full(4, SIDE_M))
    np.testing.assert_array_equal(frame.corners_px[0], corners[0])
    assert np.all(frame.error_px[0] > 0.0)


def test_pixels_move_with_twists_as_the_camera_says(seen) -> None:
    """The hand-written derivative against differences of `Camera.project`."""
    from motorcade.tracking.markers.photometric.refine import _Batch

    scene, pose, image, _ = seen
    start = pose.inverse().reshape(1) @ scene.world_T_marker[:1]
    both = Motor.stack([start, start]).coefficients.swapaxes(0, 1)
    batch = _Batch.of(image, CAMERA, FAMILY, np.array([0]), np.array([SIDE_M]), Motor(both), "cpu")
    ours = batch._pixel_by_twist(batch.start)[0].numpy()
    places = np.pad(batch.points[0].numpy().astype(np.float64), ((0, 0), (0, 1)))
    for axis in range(6):
        delta = 1e-5 * np.eye(6)[axis]
        ahead, behind = (
            CAMERA.project((batch.start[0] @ Motor.from_twist(sign * delta)).apply(places))
            for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(ours[..., axis], (ahead - behind) / 2e-5, rtol=2e-3, atol=0.05)


def twist_motion(delta):
    """Matrices ``(b, 4, 4)`` of small twists ``(b, 6)``, to first order."""
    turn, shift = delta[:, :3], delta[:, 3:]
    motion = torch.eye(4, device=delta.device).repeat(len(delta), 1, 1)
    cross = torch.zeros(len(delta), 3, 3, device=delta.device)
    for row, column, axis in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
        cross[:, row, column] = turn[:, axis]
        cross[:, column, row] = -turn[:, axis]
    motion[:, :3, :3] = motion[:, :3, :3] + cross
    motion[:, :3, 3] = shift
    return motion


def test_the_rectified_image_is_differentiable_by_the_twist() -> None:
    """Torch's own derivative through the warp against a difference quotient."""
    down, across = torch.meshgrid(
        torch.linspace(0, 3, 80), torch.linspace(0, 4, 100), indexing="ij"
    )
    image = (100.0 * torch.sin(across) * torch.cos(down))[None, None]
    matrix = torch.tensor([[[90.0, 0.0, 49.5], [0.0, 90.0, 39.5], [0.0, 0.0, 1.0]]])
    pose = Motor.from_twist([0.3, -0.4, 0.2, 0.0, 0.0, 0.0]).as_matrix().astype(np.float32)
    pose[:3, 3] = (-0.03, 0.05, 0.2)
    side = torch.tensor([0.08])

    def total(delta):
        poses = torch.as_tensor(pose)[None] @ twist_motion(delta)
        view = rectified(image, matrix, poses, side, side, 16)
        return (view * torch.linspace(0.0, 1.0, 16)).sum() / 256.0

    at = torch.zeros(1, 6, requires_grad=True)
    (slope,) = torch.autograd.grad(total(at), at)
    for axis in range(6):
        step = 2e-3 * torch.eye(6)[axis][None]
        difference = (total(step) - total(-step)) / 4e-3
        assert float(slope[0, axis]) == pytest.approx(float(difference), rel=0.05, abs=0.5)


def test_the_grid_is_the_print_with_half_a_cell_of_white() -> None:
    samples = 90  # ten a cell of the nine: eight and two halves
    drawn = prints(FAMILY, np.array([17]), samples)[0]
    assert grid_extent(FAMILY) == 9.0 / 8.0
    cells = marker_cells(FAMILY, 17)
    count = cells.shape[0]
    step = samples / (count + 1)
    middles = np.rint((np.arange(count) + 1.0) * step - 0.5).astype(int)
    np.testing.assert_allclose(drawn[np.ix_(middles, middles)], cells, atol=1e-6)
    assert drawn[0].min() > 0.99
    side = torch.tensor([1.0])
    places = grid_points(samples, torch.tensor([grid_extent(FAMILY)]), side)[0].numpy()
    np.testing.assert_allclose(places.mean(axis=0), [0.5, -0.5], atol=1e-5)
    assert places[0, 0] < 0.0 < places[0, 1]  # the first sample is beyond the top-left corner


def test_blur_is_opencv_s_blur() -> None:
    drawn = prints(FAMILY, np.array([5]), 64).astype(np.float32)
    ours = blurred(torch.as_tensor(drawn), 4.0 * torch.eye(2)[None])[0].numpy()
    theirs = cv2.GaussianBlur(np.pad(drawn[0], 32, mode="wrap"), (0, 0), 2.0)[32:-32, 32:-32]
    np.testing.assert_allclose(ours, theirs, atol=0.01)


def test_what_cannot_be_is_refused(seen, monkeypatch: pytest.MonkeyPatch) -> None:
    _, _, image, _ = seen
    one = Motor.identity((1, 2))
    with pytest.raises(ValueError, match=r"camera_T_marker, side_m: expected \(2, 2\) poses"):
        refine_photometric(image, CAMERA, FAMILY, np.arange(2), np.ones(2), one)
    with pytest.raises(ValueError, match="expected 320 x 240 pixels, got 320 x 9"):
        refine_photometric(image[:9], CAMERA, FAMILY, np.arange(1), np.ones(1), one)

    monkeypatch.setitem(__import__("sys").modules, "kornia.geometry.transform", None)
    with pytest.raises(PhotometricUnavailable, match=r'pip install "motorcade\[photometric\]"'):
        require()
