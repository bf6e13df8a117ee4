"""The synthetic room: its path, its images against its ground truth, and the files it leaves."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.render import RenderUnavailable
from motorcade.render.backends import platform
from motorcade.replays import demo as synthetic_room
from motorcade.replays.demo import write_recording
from motorcade.replays.demo.furniture import BOARD, world_T_board
from motorcade.replays.demo.recording import (
    BETWEEN_POLES_S,
    CAMERA,
    FIRST_POLE_S,
    FRAMES,
    IMU_T_CAMERA,
    HandheldPath,
    exposed,
)
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording

RENDERED = 24


@pytest.fixture(scope="module")
def path() -> HandheldPath:
    return HandheldPath.of(np.random.default_rng(3))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A short recording of the room, rendered once for this file."""
    try:
        platform.choose_platform()
    except RenderUnavailable as missing:
        pytest.skip(str(missing))
    folder = tmp_path_factory.mktemp("room") / "recording"
    write_recording(folder, frames=RENDERED, seed=3)
    return open_recording(folder, None)


def test_the_path_passes_exactly_through_the_pole(path: HandheldPath) -> None:
    times = FIRST_POLE_S + BETWEEN_POLES_S * np.arange(6)
    assert times[-1] < FRAMES / 30.0
    along_x = path.at(times).rotor.as_matrix()[:, 0, 2]
    np.testing.assert_allclose(along_x, 1.0, atol=1e-15)
    pitch_deg = np.degrees(path.at(times).rotor.as_euler("xyz")[:, 1])
    assert pitch_deg.min() > 89.99


def test_the_camera_leaves_the_pole_in_between(path: HandheldPath) -> None:
    times = FIRST_POLE_S + BETWEEN_POLES_S * (np.arange(5) + 0.3)
    pitch = np.arcsin(path.at(times).rotor.as_matrix()[:, 0, 2])
    assert np.degrees(pitch).max() < 86.0


def test_the_path_is_band_limited(path: HandheldPath) -> None:
    rate = 100.0
    position = path.at(np.arange(0.0, 60.0, 1.0 / rate)).translation_m
    window = np.hanning(len(position))[:, None]
    power = np.abs(np.fft.rfft((position - position.mean(axis=0)) * window, axis=0)) ** 2
    hertz = np.fft.rfftfreq(len(position), 1.0 / rate)
    assert power[hertz > 2.5].sum() < 1e-6 * power.sum()


def test_the_whole_board_stays_in_the_image_and_faces_the_camera(path: HandheldPath) -> None:
    times = np.arange(FRAMES) / 30.0
    camera_T_board = path.at(times).inverse() @ world_T_board()
    pixels = CAMERA.project(camera_T_board[:, None].apply(BOARD.points_m))
    assert pixels.min() > 10.0
    assert pixels[..., 0].max() < CAMERA.width - 10.0
    assert pixels[..., 1].max() < CAMERA.height - 10.0
    face = camera_T_board.rotor.apply([0.0, 0.0, 1.0])
    assert face[:, 2].max() < -0.8


def test_the_board_stands_upright_and_faces_away_from_x() -> None:
    axes = world_T_board().rotor.as_matrix()
    np.testing.assert_allclose(axes, [[0, 0, -1], [-1, 0, 0], [0, 1, 0]], atol=1e-12)


def test_detected_corners_lie_on_the_true_ones(recording: Recording) -> None:
    assert recording.truth is not None
    errors = []
    for frame in recording.frames:
        corners = BOARD.detect(frame.gray())
        assert corners is not None
        assert len(corners.ids) == len(BOARD.points_m)
        camera_T_world = recording.truth.at(np.int64(frame.time_ns)).inverse()
        true_px = CAMERA.project(camera_T_world.apply(world_T_board().apply(corners.points_m)))
        errors.append(corners.corners_px - true_px)
    distance = np.linalg.norm(np.concatenate(errors), axis=1)
    assert distance.max() < 0.3
    assert np.sqrt(np.mean(distance**2)) < 0.1
    assert np.abs(np.mean(np.concatenate(errors), axis=0)).max() < 0.02


def test_the_recording_reads_like_any_other(recording: Recording) -> None:
    recording.check()
    assert len(recording.frames) == RENDERED
    assert recording.camera == CAMERA
    assert recording.board == BOARD
    assert recording.imu_T_camera is not None
    for given, made in (
        (recording.world_T_board, world_T_board()),
        (recording.imu_T_camera, IMU_T_CAMERA),
    ):
        assert np.abs((given.inverse() @ made).as_twist()).max() < 1e-12
    image = recording.frames[0].image()
    assert image.shape == (480, 640, 3)
    assert 60.0 < image.mean() < 200.0


def test_truth_is_the_path_at_the_stamps_of_the_frames(recording: Recording) -> None:
    assert recording.truth is not None
    stamps = recording.frames.time_ns
    assert np.all(np.isin(stamps, recording.truth.time_ns))
    hand = np.random.default_rng(np.random.SeedSequence(3).spawn(1)[0])
    expected = HandheldPath.of(hand).at(stamps * 1e-9)
    gap = (recording.truth.at(stamps).inverse() @ expected).as_twist()
    assert np.abs(gap).max() < 1e-12


def test_the_imu_feels_the_path(recording: Recording) -> None:
    """Rates and forces against central differences of the exact path."""
    assert recording.imu is not None
    hand = np.random.default_rng(np.random.SeedSequence(3).spawn(1)[0])
    path = HandheldPath.of(hand)
    time_s = recording.imu.time_ns[20:-20] * 1e-9
    step = 1e-3
    before, here, after = (path.at(time_s + k * step) @ IMU_T_CAMERA.inverse() for k in (-1, 0, 1))
    rate = (before.inverse() @ after).rotor.as_rotation_vector() / (2.0 * step)
    second = before.translation_m - 2.0 * here.translation_m + after.translation_m
    force = here.rotor.inverse().apply(second / step**2 + [0.0, 0.0, 9.81])
    rate_error = recording.imu.angular_rate_rad_s[20:-20] - rate
    force_error = recording.imu.specific_force_m_s2[20:-20] - force
    # white noise of the simulated sensor at 200 Hz: 0.0024 rad/s and 0.028 m/s^2
    assert np.sqrt(np.mean(rate_error**2)) < 0.006
    assert np.sqrt(np.mean(force_error**2)) < 0.06


@pytest.mark.slow
def test_the_same_seed_writes_the_same_bytes(recording: Recording, tmp_path: Path) -> None:
    write_recording(tmp_path / "again", frames=RENDERED, seed=3)
    for file in sorted(recording.root.rglob("*.*")):
        again = tmp_path / "again" / file.relative_to(recording.root)
        assert file.read_bytes() == again.read_bytes(), file.name


def test_the_sensor_darkens_corners_and_adds_noise(rng: np.random.Generator) -> None:
    flat = np.full((480, 640, 3), 150, dtype=np.uint8)
    seen = exposed(flat, rng).astype(float)
    middle, corner = seen[220:260, 300:340], seen[:40, :40]
    assert middle.mean() == pytest.approx(150.0, abs=1.0)
    assert corner.mean() < 0.9 * middle.mean()
    assert 1.0 < middle.std() < 4.0


def test_without_opengl_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(name: str, width: int, height: int) -> None:
        raise RenderUnavailable("no OpenGL")

    monkeypatch.setattr(synthetic_room.recording, "new_renderer", none)
    with pytest.raises(RenderUnavailable):
        write_recording(tmp_path / "room")
    assert not (tmp_path / "room").exists()


def test_a_folder_in_use_and_too_few_frames_are_refused(recording: Recording) -> None:
    with pytest.raises(OSError, match="empty folder"):
        write_recording(recording.root, frames=2)
    with pytest.raises(ValueError, match="2 or more"):
        write_recording(recording.root, frames=1)


def test_progress_sees_every_frame(recording: Recording, tmp_path: Path) -> None:
    seen: list[int] = []

    def progress(numbers: Iterable[int], what: str, total: int) -> Iterator[int]:
        assert (what, total) == ("rendering the room", 2)
        for number in numbers:
            seen.append(number)
            yield number

    write_recording(tmp_path / "room", frames=2, progress=progress)
    assert seen == [0, 1]


def test_two_seeds_shake_differently_and_sweep_alike() -> None:
    times = np.arange(0.0, 6.0, 0.1)
    one, two = (HandheldPath.of(np.random.default_rng(seed)).at(times) for seed in (1, 2))
    gap = np.abs((one.inverse() @ two).as_twist()).max()
    assert 1e-4 < gap < 0.05
    assert isinstance(one, Motor)
