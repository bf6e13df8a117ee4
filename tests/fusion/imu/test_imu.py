"""Inertial data: what a sensor reads follows from closed forms; noise has its stated densities."""

from __future__ import annotations

import pickle
from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream, simulate_imu
from motorcade.ga import Motor, Rotor, Trajectory

KALIBR = """\
#Accelerometers
accelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)
accelerometer_random_walk:   4.33e-04   #Bias random walk
#Gyroscopes
gyroscope_noise_density:     1.87e-04
gyroscope_random_walk:       2e-5
rostopic:                    /imu0
update_rate:                 200.0
"""


def still(pose: Motor, duration_s: float = 2.0) -> Trajectory:
    stamps = np.arange(int(duration_s * 20) + 1) * 50_000_000
    coefficients = np.tile(pose.coefficients, (stamps.size, 1))
    return Trajectory(stamps, Motor(coefficients), child="imu")


def test_at_rest_the_accelerometer_reads_plus_g_upward(rng):
    level = simulate_imu(still(Motor.identity()), 100.0, None, rng).stream
    np.testing.assert_allclose(
        level.specific_force_m_s2, [[0.0, 0.0, 9.81]] * len(level), atol=1e-9
    )
    np.testing.assert_allclose(level.angular_rate_rad_s, 0.0, atol=1e-9)
    # Rolled by 90° about x: the sensor's y axis now points up.
    on_its_side = Rotor.from_rotation_vector([np.pi / 2, 0.0, 0.0])
    rolled = still(Motor.from_rotor_translation(on_its_side, np.ones(3)))
    stream = simulate_imu(rolled, 100.0, None, rng, gravity_m_s2=9.7).stream
    np.testing.assert_allclose(
        stream.specific_force_m_s2, [[0.0, 9.7, 0.0]] * len(stream), atol=1e-9
    )


def test_on_a_turntable_it_feels_rate_and_centripetal_force(rng):
    """Radius 0.5 m, 2 rad/s about the vertical, x outwards: force (-ω² r, 0, g)."""
    stamps = np.arange(401) * 10_000_000
    turn = Rotor.from_rotation_vector(np.outer(2.0 * stamps * 1e-9, [0.0, 0.0, 1.0]))
    arm = turn.apply(np.array([0.5, 0.0, 0.0]))
    path = Trajectory(stamps, Motor.from_rotor_translation(turn, arm), child="imu")
    stream = simulate_imu(path, 200.0, None, rng).stream
    inner = slice(60, -60)
    np.testing.assert_allclose(stream.angular_rate_rad_s[inner] - [0.0, 0.0, 2.0], 0.0, atol=1e-6)
    np.testing.assert_allclose(
        stream.specific_force_m_s2[inner] - [-2.0, 0.0, 9.81], 0.0, atol=1e-5
    )


def test_a_moving_sensor_reads_the_closed_form(handheld, rng):
    simulated = simulate_imu(handheld.trajectory(200.0, 6.0, "imu"), 200.0, None, rng)
    stamps = simulated.stream.time_ns
    up = np.array([0.0, 0.0, 9.81])
    force = handheld.poses(stamps).rotor.inverse().apply(handheld.accelerations(stamps) + up)
    inner = slice(100, -100)
    difference = simulated.stream.specific_force_m_s2 - force
    assert np.max(np.abs(difference[inner])) < 1e-3
    velocity = simulated.velocity_m_s - handheld.velocities(stamps)
    assert np.max(np.abs(velocity[inner])) < 1e-5


def test_simulated_readings_integrate_back_to_the_path(handheld, rng):
    """By scipy: q' = q ω / 2, v' = R f + g, p' = v; the readings alone give the path."""
    simulated = simulate_imu(handheld.trajectory(100.0, 4.0, "imu"), 200.0, None, rng)
    stream, path = simulated.stream, simulated.path
    seconds = (stream.time_ns - stream.time_ns[0]) * 1e-9
    readings = CubicSpline(
        seconds, np.hstack([stream.angular_rate_rad_s, stream.specific_force_m_s2])
    )

    def slope(t, state):
        rate, force = np.split(readings(t), 2)
        turn = Rotation.from_quat(state[:4])
        q_rate = 0.5 * np.append(state[3] * rate + np.cross(state[:3], rate), -state[:3] @ rate)
        return np.concatenate([q_rate, turn.apply(force) - [0.0, 0.0, 9.81], state[4:7]])

    start = np.concatenate(
        [
            Rotation.from_matrix(path.poses[0].rotor.as_matrix()).as_quat(),
            simulated.velocity_m_s[0],
            path.poses[0].translation_m,
        ]
    )
    end = solve_ivp(slope, (0.0, seconds[-1]), start, rtol=1e-9, atol=1e-11).y[:, -1]
    np.testing.assert_allclose(end[7:], path.poses[-1].translation_m, atol=1e-5)
    np.testing.assert_allclose(end[4:7], simulated.velocity_m_s[-1], atol=1e-5)
    turned = Rotation.from_quat(end[:4]).as_matrix()
    np.testing.assert_allclose(turned, path.poses[-1].rotor.as_matrix(), atol=1e-6)


def test_noise_has_the_densities_it_was_given(rng):
    """White noise σ/√Δt a sample; bias steps σ_b √Δt (Kalibr's model)."""
    noise = ImuNoise(2e-3, 5e-4, 3e-2, 7e-3)
    found = simulate_imu(still(Motor.identity(), 100.0), 200.0, noise, rng)
    white_gyro = found.stream.angular_rate_rad_s - found.gyro_bias_rad_s
    white_accel = found.stream.specific_force_m_s2 - found.accel_bias_m_s2 - [0.0, 0.0, 9.81]
    for values, expected in [
        (white_gyro, 2e-3 * np.sqrt(200)),
        (white_accel, 3e-2 * np.sqrt(200)),
        (np.diff(found.gyro_bias_rad_s, axis=0), 5e-4 / np.sqrt(200)),
        (np.diff(found.accel_bias_m_s2, axis=0), 7e-3 / np.sqrt(200)),
    ]:
        np.testing.assert_allclose(np.std(values, axis=0), expected, rtol=0.03)
        assert abs(np.corrcoef(values[:-1, 0], values[1:, 0])[0, 1]) < 0.03


def test_the_same_seed_gives_the_same_bytes(handheld):
    runs = [
        simulate_imu(handheld.trajectory(50.0, 2.0), 200.0, ADIS16448, np.random.default_rng(seed))
        for seed in (1, 1, 2)
    ]
    forces = [run.stream.specific_force_m_s2.tobytes() for run in runs]
    assert forces[0] == forces[1] != forces[2]


def test_simulation_refuses_what_it_cannot_do(handheld, rng):
    path = handheld.trajectory(50.0, 2.0)
    with pytest.raises(ValueError, match="rate_hz: expected a number above 0, got -1"):
        simulate_imu(path, -1.0, None, rng)
    with pytest.raises(ValueError, match="rate_hz: expected two samples or more"):
        simulate_imu(path, 0.1, None, rng)
    with pytest.raises(ValueError, match="gravity_m_s2: expected a number above 0, got nan"):
        simulate_imu(path, 100.0, None, rng, gravity_m_s2=float("nan"))


def test_noise_is_read_from_kalibrs_and_eurocs_files(tmp_path):
    file = tmp_path / "imu.yaml"
    expected = (1.87e-4, 2e-5, 1.86e-3, 4.33e-4)
    file.write_text(KALIBR)
    assert astuple(ImuNoise.load(file)) == expected
    indented = "".join(f"  {line}\n" for line in KALIBR.splitlines())
    file.write_text("imu0:\n" + indented)
    assert astuple(ImuNoise.load(file)) == expected
    file.write_text("%YAML:1.0\n" + KALIBR)
    assert astuple(ImuNoise.load(file)) == expected


def test_eurocs_own_file_is_that_of_the_adis16448(data_dir):
    file = data_dir / "replays" / "euroc_V1_01" / "mav0" / "imu0" / "sensor.yaml"
    assert ImuNoise.load(file) == ADIS16448


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("gyroscope_random_walk", "gyro_walk"), "expected the field gyroscope_random_walk, got"),
        (("2e-5", "0"), "gyroscope_random_walk: expected a number above 0, got 0"),
        (("2e-5", "-1.0"), "gyroscope_random_walk: expected a number above 0, got -1.0"),
        (("2e-5", ".nan"), "gyroscope_random_walk: expected a number above 0, got nan"),
        (("2e-5", "small"), "gyroscope_random_walk: expected a number above 0, got 'small'"),
        (("2e-5", "[1, 2]"), r"gyroscope_random_walk: expected a number above 0, got \[1, 2\]"),
        (("rostopic:", "a: b:"), "expected YAML: "),
        ((KALIBR, "- 1\n- 2\n"), "expected a YAML mapping, got list"),
        ((KALIBR, " "), "expected a YAML mapping, got NoneType"),
        ((KALIBR, ""), "the file is empty"),
        ((KALIBR, "a: &a {b: 1}\nc:\n  <<: *a"), "expected plain values, got a YAML alias"),
    ],
)
def test_noise_files_are_refused_by_file_and_field(tmp_path, change, message):
    file = tmp_path / "imu.yaml"
    file.write_text(KALIBR.replace(*change))
    with pytest.raises(ValueError, match=f"^{file}: .*{message}"):
        ImuNoise.load(file)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe\x00gyro", "expected YAML in UTF-8, got other bytes"),
        (bytes(range(128)), "expected YAML: "),
        (b"gyroscope_noise_density: 1\x00", "expected YAML: "),
        (b"stamp: 2024-99-99", "expected YAML: month"),
        (b"[" * 5000, "expected at most 32 levels"),
        (KALIBR.replace("2e-5", "1" + 400 * "0").encode(), "gyroscope_random_walk: expected"),
    ],
)
def test_files_that_hold_no_noise_are_refused_in_one_line(tmp_path, content, message):
    file = tmp_path / "imu.yaml"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=f"^{file}: {message}.*$") as refusal:
        ImuNoise.load(file)
    assert "\n" not in str(refusal.value)


def test_noise_files_that_cannot_be_read_are_refused(tmp_path):
    with pytest.raises(ValueError, match=f"^{tmp_path}: expected a file, got a folder"):
        ImuNoise.load(tmp_path)
    path = tmp_path / "none.yaml"
    with pytest.raises(ValueError, match=f"^{path}: the file is missing"):
        ImuNoise.load(path)


def test_noise_must_be_positive_and_scales_as_one():
    with pytest.raises(ValueError, match=r"accel_walk_m_s3_rthz: expected a number above 0"):
        ImuNoise(1e-4, 1e-5, 1e-3, 0.0)
    assert astuple(ADIS16448.scaled(3.0)) == tuple(3.0 * x for x in astuple(ADIS16448))


def test_streams_refuse_bad_data_and_stay_frozen():
    stamps, zeros = np.arange(4) * 5_000_000, np.zeros((4, 3))
    good = ImuStream(stamps, zeros, zeros)
    for arguments, message in [
        (
            (stamps * 1.0, zeros, zeros),
            "expected integer nanoseconds, got dtype float64",
        ),
        ((stamps[:1], zeros[:1], zeros[:1]), "with N >= 2"),
        ((stamps[::-1], zeros, zeros), "strictly increasing stamps, got 10000000 at index 1"),
        ((stamps, zeros[:3], zeros), r"angular_rate_rad_s: expected shape \(4, 3\), got \(3, 3\)"),
        ((stamps, zeros, zeros[None]), r"specific_force_m_s2: expected shape \(4, 3\), got \(1,"),
        ((stamps, zeros, zeros + np.nan), "specific_force_m_s2: expected finite numbers"),
        ((stamps, zeros - 1e160, zeros), r"angular_rate_rad_s: expected readings within 1e\+09"),
    ]:
        with pytest.raises(ValueError, match=message):
            ImuStream(*arguments)
    with pytest.raises(ValueError, match="read-only"):
        good.angular_rate_rad_s[0] = 1.0
    with pytest.raises(ValueError, match="expected stamps in"):
        good.at(stamps + 1)
    copy = pickle.loads(pickle.dumps(good))
    assert not copy.time_ns.flags.writeable
    assert good.rate_hz == 200.0
    assert repr(good) == "ImuStream(4 samples, 200.0 Hz, 0.015 s)"


def test_samples_between_stamps_lie_on_the_line():
    stamps = np.array([0, 10_000_000, 30_000_000])
    values = np.array([[0.0, 1.0, 2.0], [1.0, 1.0, 0.0], [3.0, 1.0, -4.0]])
    found = ImuStream(stamps, values, -values).at(np.array([5_000_000, 20_000_000]))
    np.testing.assert_allclose(found.angular_rate_rad_s, [[0.5, 1.0, 1.0], [2.0, 1.0, -2.0]])
    np.testing.assert_allclose(found.specific_force_m_s2, -found.angular_rate_rad_s)
