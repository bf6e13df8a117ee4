"""A virtual checkerboard drawn onto a real one lies where the real one is."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.readers.opening import open_recording
from motorcade.tracking import track_board
from motorcade.tracking.boards import Checkerboard
from motorcade.tracking.cameras.camera import Camera
from tests.bench.view.printed import printed_surface
from tests.bench.view.registration import (
    drawn_corner_distances_px,
    jitter_px,
    straightened,
)

MANIFEST = Path(__file__).parents[2] / "docs" / "manifests" / "vamr_board.toml"
CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)


@pytest.mark.usefixtures("opengl")
def test_drawn_corners_lie_on_the_real_ones_within_half_a_pixel(data_dir: Path) -> None:
    recording = open_recording(data_dir / "replays" / "vamr_board", MANIFEST)
    board, camera = recording.board, recording.camera
    assert isinstance(board, Checkerboard)
    assert camera is not None
    chosen = [frame for k, frame in enumerate(recording.frames) if k % 40 == 0]
    track = track_board(((frame.time_ns, frame.gray()) for frame in chosen), camera, board)
    path = track.measurements.trajectory
    taken = [(frame.time_ns, frame.image()) for frame in chosen]
    straight = [(stamp, camera.undistort_image(one)) for stamp, one in taken]
    for frames, lens, seen in (
        (taken, camera, track),
        (straight, camera.undistorted(), straightened(track, camera)),
    ):
        found = drawn_corner_distances_px(frames, lens, path, seen, board, Motor.identity())
        assert found.found >= 5
        assert found.rms_px <= 0.5
    aside = path.transformed_by(left=Motor.from_twist([0.0, 0.0, 0.0, 0.005, 0.0, 0.0]))
    off = drawn_corner_distances_px(taken, camera, aside, track, board, Motor.identity())
    assert off.rms_px > 1.0


def test_a_print_lies_where_its_pixels_are_said_to_lie() -> None:
    pose = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.1, 0.2, 0.3]), [1.0, 2, 3])
    surface = printed_surface(np.zeros((40, 60), dtype=np.uint8), 100.0, (9.5, 4.5), pose)
    u, v = surface.texture_coordinates.T
    local = pose.inverse().apply(surface.vertices)
    np.testing.assert_allclose(local[:, 0], (60 * u - 0.5 - 9.5) / 100.0, atol=1e-12)
    np.testing.assert_allclose(local[:, 1], -(40 * (1 - v) - 0.5 - 4.5) / 100.0, atol=1e-12)
    for bad in (np.zeros((0, 4), dtype=np.uint8), np.zeros(4, dtype=np.uint8)):
        with pytest.raises(ValueError, match="pixels"):
            printed_surface(bad, 100.0, (0.0, 0.0), pose)
    with pytest.raises(ValueError, match="above 0"):
        printed_surface(np.zeros((4, 4), dtype=np.uint8), 0.0, (0.0, 0.0), pose)


def test_jitter_is_the_deviation_of_white_noise(rng: np.random.Generator) -> None:
    places = np.zeros((4000, 3))
    places[:, :2] = 0.002 * rng.standard_normal((4000, 2)) + np.linspace(0, 0.1, 4000)[:, None]
    stamps = np.arange(4000) * 33_333_333
    path = Trajectory(stamps, Motor.from_translation(places))
    expected = 300.0 / 2.0 * 0.002 * np.sqrt(2.0)
    assert jitter_px(path, CAMERA, np.array([0.0, 0.0, 2.0])) == pytest.approx(expected, rel=0.05)
