"""The textured room agrees with geometry worked out ray by ray, and is read like any recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from motorcade.fusion.imu import ADIS16448
from motorcade.ga import Motor
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.tracking import Camera
from tests.textured_room.inertial import IMU_T_CAMERA, simulated_imu
from tests.textured_room.recording import write_recording
from tests.textured_room.renderer import Renderer, Sensor
from tests.textured_room.scenarios import SCENARIOS, scenario
from tests.textured_room.scene import Panel, Room, furnished_room

SMALL = Camera(160, 120, 130.0, 131.0, 79.5, 59.5)
QUIET = Sensor(camera=SMALL, noise=0.0)


@pytest.fixture(scope="module")
def room() -> Room:
    return furnished_room(np.random.default_rng(3))


def nearest_hit_m(room: Room, camera: Camera, pose: Motor, pixel: np.ndarray) -> float:
    """Depth of the first panel on a pixel's ray: one ray, one panel at a time."""
    ray = pose.rotor.apply(camera.unproject(pixel))
    best = np.inf
    for panel in room.panels:
        normal = np.cross(panel.right_m, panel.down_m)
        slant = float(normal @ ray)
        if slant <= 0.0:
            continue
        depth = float(normal @ (panel.corner_m - pose.translation_m)) / slant
        at = pose.translation_m + depth * ray - panel.corner_m
        s = at @ panel.right_m / (panel.right_m @ panel.right_m)
        t = at @ panel.down_m / (panel.down_m @ panel.down_m)
        if depth > 0.0 and 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            best = min(best, depth)
    return best


@pytest.mark.parametrize("name", ["loop", "handheld", "turning"])
def test_depth_is_that_of_the_first_panel_on_the_ray(
    room: Room, rng: np.random.Generator, name: str
) -> None:
    truth = SCENARIOS[name].truth().motors
    renderer = Renderer(room, QUIET)
    for pose in (truth[int(k)] for k in rng.integers(0, len(truth), 4)):
        _, depth = renderer.draw(pose)
        assert np.isfinite(depth).all(), "the room is closed"
        pixels = rng.integers(0, (160, 120), (60, 2))
        wanted = [nearest_hit_m(room, SMALL, pose, pixel) for pixel in pixels]
        np.testing.assert_allclose(depth[pixels[:, 1], pixels[:, 0]], wanted, rtol=2e-5)


def oblique_panel(rng: np.random.Generator) -> Panel:
    texture = rng.integers(0, 256, (60, 80)).astype(np.uint8)
    return Panel(
        np.array([-0.9, -0.6, 1.5]), np.array([1.7, 0.1, 0.4]), np.array([0.1, 1.2, -0.2]), texture
    )


def test_an_image_shows_the_texture_where_projection_puts_it(rng: np.random.Generator) -> None:
    panel = oblique_panel(rng)
    image, depth = Renderer(Room((panel,)), QUIET).draw(Motor.identity())
    rows, columns = np.nonzero(np.isfinite(depth))
    assert len(rows) > 5000
    points = SMALL.unproject(np.column_stack([columns, rows])) * depth[rows, columns, None]
    local = np.linalg.lstsq(
        np.column_stack([panel.right_m, panel.down_m]), (points - panel.corner_m).T, rcond=None
    )[0]
    u, v = local[0] * 80 - 0.5, local[1] * 60 - 0.5
    # Tiles replicate their edges: compare where no tile's edge is between the texels used.
    inner = (np.abs(u - 39.5) > 1.0) & (u > 1) & (u < 78) & (v > 1) & (v < 58)
    wanted = map_coordinates(panel.texture.astype(float), [v[inner], u[inner]], order=1)
    shown = image[rows[inner], columns[inner]]
    # OpenCV interpolates at 32 places between texels.
    assert np.abs(shown - wanted).max() < 12.0
    assert np.abs(shown - wanted).mean() < 2.0


def test_points_of_one_view_are_found_in_another(room: Room, rng: np.random.Generator) -> None:
    truth = SCENARIOS["handheld"].truth().motors
    sensor = Sensor(noise=0.0)
    renderer, camera = Renderer(room, sensor), sensor.camera
    (first, depth), (second, other_depth) = renderer.draw(truth[0]), renderer.draw(truth[25])
    pixels = rng.integers(0, (640, 480), (4000, 2))
    x, y = pixels.T
    world = truth[0].apply(camera.unproject(pixels) * depth[y, x, None])
    local = truth[25].inverse().apply(world)
    seen = camera.project(local)
    inside = np.all((seen > 1) & (seen < (638, 478)), axis=1)
    column, row = np.rint(seen[inside]).astype(int).T
    visible = np.abs(other_depth[row, column] - local[inside, 2]) < 0.02
    assert np.count_nonzero(visible) > 1000
    at = seen[inside][visible]
    shown = map_coordinates(second.astype(float), [at[:, 1], at[:, 0]], order=1)
    before = first[y[inside][visible], x[inside][visible]].astype(float)
    same = np.abs(shown - before)
    shifted = map_coordinates(second.astype(float), [at[:, 1], at[:, 0] + 2.0], order=1)
    assert np.median(same) < 4.0
    assert np.median(np.abs(shifted - before)) > 3.0 * np.median(same)


def test_the_right_image_is_shifted_by_focal_length_times_baseline_over_depth(
    rng: np.random.Generator,
) -> None:
    texture = rng.integers(0, 256, (300, 400)).astype(np.uint8)
    wall = Panel(np.array([-2.0, -1.5, 1.3]), np.array([4.0, 0, 0]), np.array([0, 3.0, 0]), texture)
    # 130 px * 0.12 m / 1.3 m = 12 px
    view = Renderer(Room((wall,)), QUIET).view(Motor.identity(), rng)
    np.testing.assert_allclose(view.depth_m, 1.3, rtol=1e-6)
    difference = view.gray[:, 12:].astype(int) - view.right[:, :-12]
    assert np.abs(difference).max() <= 1


def test_the_same_seed_draws_the_same_and_another_does_not() -> None:
    first, again, other = (
        next(iter(scenario("blurred", seed=seed, frames=2).views())) for seed in (5, 5, 6)
    )
    for field in ("gray", "depth_m", "right"):
        np.testing.assert_array_equal(getattr(first, field), getattr(again, field))
        assert np.any(getattr(first, field) != getattr(other, field))


def test_noise_has_the_stated_size(room: Room, rng: np.random.Generator) -> None:
    pose = SCENARIOS["handheld"].truth().motors[0]
    noisy = Renderer(room, Sensor(noise=3.0, depth_noise_px=0.2))
    exact, depth = noisy.draw(pose)
    view = noisy.view(pose, rng)
    assert np.std(view.gray.astype(float) - exact) == pytest.approx(3.0, rel=0.05)
    reach = noisy.sensor.camera.fx * noisy.sensor.baseline_m
    assert np.std(reach / view.depth_m - reach / depth) == pytest.approx(0.2, rel=0.02)


def test_blur_softens_and_keeps_the_depth_of_the_middle(room: Room) -> None:
    truth = SCENARIOS["handheld"].path(0.5 + np.linspace(-0.05, 0.05, 9))
    renderer = Renderer(room, QUIET)
    rng = np.random.default_rng(0)
    sharp, blurred = renderer.view(truth[4], rng), renderer.view(truth, rng)
    np.testing.assert_array_equal(sharp.depth_m, blurred.depth_m)
    steps = [np.abs(np.diff(view.gray.astype(float), axis=1)).mean() for view in (sharp, blurred)]
    assert steps[1] < 0.8 * steps[0]


def test_the_loop_loses_its_first_view_and_comes_back_to_it(room: Room) -> None:
    made = SCENARIOS["loop"]
    truth, renderer = made.truth().motors, Renderer(room, QUIET)
    assert len(truth) == 540
    columns, rows = np.meshgrid(np.arange(0, 160, 5), np.arange(0, 120, 5))
    pixels = np.column_stack([columns.ravel(), rows.ravel()])
    _, depth = renderer.draw(truth[0])
    world = truth[0].apply(SMALL.unproject(pixels) * depth[pixels[:, 1], pixels[:, 0], None])

    def share_seen(frame: int) -> float:
        local = truth[frame].inverse().apply(world)
        local = local[local[:, 2] > 0.05]
        _, depth = renderer.draw(truth[frame])
        seen = np.rint(SMALL.project(local)).astype(int)
        inside = np.all((seen >= 0) & (seen < (160, 120)), axis=1)
        column, row = seen[inside].T
        visible = np.abs(depth[row, column] - local[inside, 2]) < 0.05
        return np.count_nonzero(visible) / len(world)

    assert share_seen(3) > 0.7
    assert max(share_seen(frame) for frame in range(90, 270, 15)) == 0.0
    assert share_seen(360) > 0.95
    assert share_seen(len(truth) - 1) == 0.0, "it goes on past its start"


def test_the_light_goes_down_and_comes_back_but_the_noise_stays() -> None:
    made = replace(SCENARIOS["loop"], sensor=Sensor(camera=SMALL, noise=3.0), frames=2)
    light = np.array([made.light(number) for number in range(540)])
    assert np.all(light[:121] == 1.0)
    assert np.all(light[270:] == 1.0)
    assert light.min() == light[195] == pytest.approx(made.least_light)
    assert np.all(np.diff(light[120:196]) <= 0.0)
    dark = list(replace(made, darkened=(0, 2)).views())[1]
    exact, depth = made.renderer().draw(made.truth().motors[1])
    np.testing.assert_array_equal(dark.depth_m, depth)
    left = dark.gray - made.least_light * exact.astype(float)
    assert np.std(left) == pytest.approx(3.0, rel=0.05)


def test_the_imu_moves_as_the_camera_does() -> None:
    made = replace(SCENARIOS["long"], frames=240)
    imu = simulated_imu(made)
    seconds = imu.time_ns * 1e-9
    assert np.diff(imu.time_ns) == pytest.approx(5e6, abs=1)
    step = 1e-3
    poses = [made.path(seconds + k * step) @ IMU_T_CAMERA.inverse() for k in (-1, 0, 1)]
    before, here, after = (one.translation_m for one in poses)
    force = poses[1].rotor.inverse().apply((after - 2 * here + before) / step**2 + (0, 0, 9.81))
    turned = poses[0].rotor.inverse() @ poses[2].rotor
    rate = turned.as_rotation_vector() / (2 * step)
    # White noise of EuRoC's sensor at 200 Hz, and biases that walk.
    assert np.std(imu.specific_force_m_s2 - force) == pytest.approx(2e-3 * 200**0.5, rel=0.2)
    assert np.std(imu.angular_rate_rad_s - rate) == pytest.approx(1.7e-4 * 200**0.5, rel=0.2)
    assert np.ptp(force, axis=0).min() > 0.3, "there is something to feel"


def test_a_recording_with_an_imu_is_read_back(tmp_path: Path) -> None:
    made = replace(scenario("gap", frames=4), covered=(2, 3))
    write_recording(tmp_path / "room", made, name="carried", imu=True)
    recording = open_recording(tmp_path / "room")
    recording.check()
    assert recording.imu is not None
    assert recording.imu_T_camera is not None
    assert recording.imu_noise == ADIS16448
    np.testing.assert_allclose(recording.imu_T_camera.as_matrix(), IMU_T_CAMERA.as_matrix())
    assert recording.imu.time_ns[0] == 0
    assert recording.imu.time_ns[-1] > recording.frames.time_ns[-1]
    brightest = [int(frame.gray().max()) for frame in recording.frames]
    assert brightest[2] < 10
    assert min(brightest[:2]) > 100


def test_scenarios_do_what_they_are_called() -> None:
    covered = SCENARIOS["covered"]
    assert covered.covered[1] - covered.covered[0] == 30
    views = list(scenario("covered", frames=3).views())
    assert all(np.isfinite(view.depth_m).all() for view in views)
    hidden = list(
        type(covered)(covered.path, 3, covered=(1, 2), sensor=Sensor(camera=SMALL)).views()
    )[1]
    assert np.isnan(hidden.depth_m).all()
    assert hidden.gray.max() < 10
    blank = next(iter(scenario("blank", frames=2).views()))
    assert np.std(blank.gray.astype(float)) == pytest.approx(1.0, rel=0.1)
    assert np.isfinite(blank.depth_m).all()
    centres = SCENARIOS["turning"].truth().motors.translation_m
    np.testing.assert_allclose(centres - centres[0], 0.0, atol=1e-12)


def test_a_written_recording_is_read_back(tmp_path: Path) -> None:
    made = scenario("handheld", frames=4)
    write_recording(tmp_path / "room", made, name="the room")
    recording = open_recording(tmp_path / "room")
    recording.check()
    assert recording.layout == "tum_rgbd"
    assert recording.name == "the room"
    assert recording.camera == made.sensor.camera
    truth = made.truth()
    assert recording.truth is not None
    np.testing.assert_array_equal(recording.truth.time_ns, truth.time_ns)
    np.testing.assert_array_equal(recording.frames.time_ns, truth.time_ns)
    np.testing.assert_allclose(
        recording.truth.motors.as_matrix(), truth.motors.as_matrix(), atol=1e-14
    )
    for frame, view in zip(recording.frames, made.views(), strict=True):
        np.testing.assert_array_equal(frame.image(), view.gray)
        depth = frame.depth_m()
        assert depth is not None
        np.testing.assert_allclose(depth, view.depth_m, atol=1.01e-4)
        np.testing.assert_array_equal(frame.right(), view.right)
    assert recording.baseline_m == made.sensor.baseline_m
    with pytest.raises(FileExistsError, match="expected an empty folder"):
        write_recording(tmp_path / "room", made, name="again")


@pytest.mark.slow
def test_the_pipeline_runs_on_it(tmp_path: Path) -> None:
    write_recording(tmp_path / "room", scenario("handheld", frames=45), name="room")
    run_job(Job(recording=tmp_path / "room", out=tmp_path / "out", until="smoothed"))
    assert (tmp_path / "out" / "trajectories" / "smoothed_motor.tum").is_file()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"baseline_m": 0.0}, "Sensor.baseline_m: expected metres above 0"),
        ({"noise": -1.0}, "Sensor.noise: expected a number from 0 on"),
        ({"depth_noise_px": float("nan")}, "Sensor.depth_noise_px"),
        ({"exposures": 0}, "Sensor.exposures"),
        (
            {"camera": Camera(8, 8, 9.0, 9.0, 4.0, 4.0, "radtan", (0.1, 0.0))},
            "Sensor.camera: expected a pinhole",
        ),
    ],
)
def test_sensors_that_cannot_be_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Sensor(**change)  # type: ignore[arg-type]


def test_scenarios_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="expected one of handheld"):
        scenario("party")
    with pytest.raises(ValueError, match="expected 2 or more, got 1"):
        scenario("loop", frames=1)
