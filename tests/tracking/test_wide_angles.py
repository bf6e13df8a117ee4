"""Markers at the rim of a fisheye's image: none is left out for its angle."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.replays.io.readers.tagslam import recording as tagslam
from motorcade.tracking import Camera
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.planar import planar_poses
from motorcade.tracking.pose import TrackingError, planar_candidates, refine
from tests.bench.data import data_folder

FISHEYE = Camera(
    848, 800, 286.8, 286.8, 423.5, 399.5, "equidistant", (-0.007, 0.01, -0.003, 0.0002)
)


@pytest.mark.parametrize("degrees", [0.0, 70.0, 79.0, 88.0, 95.0, 105.0])
@pytest.mark.parametrize("around", [0.3, 2.0, -2.5])
def test_a_marker_has_its_pose_at_every_angle(degrees: float, around: float):
    points = marker_points_m(np.array([0.2]))[0]
    aim = Rotor.from_rotation_vector([0.0, 0.0, around]) @ Rotor.from_rotation_vector(
        [0.0, np.deg2rad(degrees), 0.0]
    )
    faced = Rotor.from_rotation_vector([np.pi - 0.5, 0.3, 0.2])
    camera_T_marker = Motor.from_rotor_translation(aim, np.zeros(3)) @ Motor.from_rotor_translation(
        faced, [0.0, 0.0, 1.0]
    )
    px = FISHEYE.project(camera_T_marker.apply(points))
    corners = BoardCorners(np.arange(4), px, points)
    found = planar_candidates(corners, FISHEYE)
    assert found.error_px[0] < 0.1
    exact = refine(corners, FISHEYE, found.world_T_camera[0])
    off = exact.world_T_camera.local(camera_T_marker.inverse())
    assert np.abs(off).max() < 1e-5


def test_bearings_are_the_rays_of_project(rng):
    rays = rng.standard_normal((500, 3))
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays = rays[rays[:, 2] > np.cos(np.deg2rad(115.0))]
    np.testing.assert_allclose(FISHEYE.bearings(FISHEYE.project(rays)), rays, atol=1e-9)
    ahead = rays[rays[:, 2] > 0.3]
    for model, lens in (("pinhole", ()), ("radtan", (-0.1, 0.01, 0.001, 0.001))):
        camera = Camera(848, 800, 286.8, 286.8, 423.5, 399.5, model, lens)
        near = ahead[ahead[:, 2] > 0.8]
        np.testing.assert_allclose(camera.bearings(camera.project(near)), near, atol=1e-9)


def test_a_lens_that_folds_back_has_no_rays_beyond():
    """A T265's polynomial, fitted to 80 degrees or so, turns back at 97."""
    lens = (-0.0067, 0.0393, -0.0356, 0.0055)
    camera = Camera(848, 800, 286.7, 286.7, 423.5, 399.5, "equidistant", lens)
    px = 423.5 + 286.7 * np.linspace(0.0, 2.0, 200)
    angle = np.arccos(camera.bearings(np.stack([px, np.full(200, 399.5)], axis=-1))[:, 2])
    known = np.isfinite(angle)
    assert np.all(np.diff(known.astype(int)) <= 0)
    assert np.all(np.diff(angle[known]) > 0.0)
    assert np.deg2rad(90.0) < angle[known][-1] < np.deg2rad(100.0)


def test_corners_all_around_are_refused():
    points = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    px = FISHEYE.project(points + np.array([0.0, 0.0, 0.01]))
    with pytest.raises(TrackingError, match="within one view"):
        planar_candidates(BoardCorners(np.arange(4), px, points), FISHEYE)


@pytest.mark.slow
def test_no_corner_of_a_recording_with_two_fisheyes_is_left_out():
    folder = data_folder() / "tags/tagslam/test_21"
    if not folder.is_dir():
        pytest.skip(f"no {folder}; set MOTORCADE_DATA")
    recording = tagslam.read_corners(folder)
    for name in ("cam0", "cam1"):
        stream = recording.streams[name]
        assert np.isfinite(stream.camera.bearings(stream.corners_px)).all()
        sides = np.array([recording.side_m[int(one)] for one in stream.marker_ids])
        rows, _, errors = planar_poses(stream.camera, stream.corners_px, sides)
        assert len(rows) == len(stream.marker_ids)
        assert np.isfinite(errors).all()
