"""Orientation of simulated sensors: the ground truth is known, and VQF runs beside."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuFaults, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import SimulatedImu
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.orientation import (
    OrientationFilter,
    OrientationModel,
    estimate_orientation,
)
from motorcade.ga import Motor, Rotor, Trajectory

FAULTS = ImuFaults(gyro_bias_rad_s=[0.01, -0.02, 0.005], gyro_scale=[1.003, 0.996, 1.001])


def ridden(name: str, rng: np.random.Generator, duration_s: float = 120.0) -> SimulatedImu:
    path = ContinuousPath.along(MOTIONS[name], duration_s)
    return simulate_imu(path, 200.0, ADIS16448, rng, faults=FAULTS)


def resting(turn: Rotor, rng: np.random.Generator, duration_s: float = 10.0) -> SimulatedImu:
    stamps = np.array([0, round(duration_s * 1e9)])
    pose = Motor.from_rotor_translation(turn, np.zeros(3))
    both = Motor(np.tile(pose.coefficients, (2, 1)))
    return simulate_imu(Trajectory(stamps, both), 200.0, ADIS16448, rng, faults=FAULTS)


@pytest.mark.parametrize(
    "name",
    ["gimbal_crossing", "gimbal_hover", "handheld", "walk_and_look", "stop_and_go"],
)
def test_tilt_of_motions_is_no_worse_than_vqfs(name, smooth, rng, vqf_tilt, inclination_rms_deg):
    """Hands and heads, with bias and scale errors, the first 10 s left out."""
    simulated = ridden(name, rng)
    truth = simulated.path.poses.rotor
    found = estimate_orientation(simulated.stream, smooth=smooth).world_R_imu
    settled = slice(2000, None)
    ours = inclination_rms_deg(found, truth, settled)
    assert ours <= inclination_rms_deg(vqf_tilt(simulated.stream, smooth), truth, settled)
    assert ours < (0.35 if smooth else 0.65)


def test_at_rest_it_stands_upright_and_knows_the_bias(rng):
    turn = Rotor.from_rotation_vector([0.7, -0.4, 0.0])
    simulated = resting(turn, rng)
    running = OrientationFilter()
    stream = simulated.stream
    for row in range(len(stream)):
        found = running.update(
            int(stream.time_ns[row]),
            stream.angular_rate_rad_s[row],
            stream.specific_force_m_s2[row],
        )
        assert running.at_rest == (stream.time_ns[row] > 1.6e9) or row < 340
    up = np.array([0.0, 0.0, 1.0])
    angle = np.arccos(found.inverse().apply(up) @ turn.inverse().apply(up))
    # the walk of the accelerometer's bias tilts what it calls up
    assert angle < 3.0 * np.linalg.norm(simulated.accel_bias_m_s2[-1]) / 9.81 + 1e-3
    np.testing.assert_allclose(running.gyro_bias_rad_s, simulated.gyro_bias_rad_s[-1], atol=2e-4)
    assert running.tilt_deviation_rad < 5e-3  # most of it the accelerometer's bias


def test_a_slow_steady_turn_is_no_rest():
    """2°/s about the vertical for 30 s, once the bias is known: it must not become bias."""
    rate = np.deg2rad(2.0)
    stamps = np.arange(40 * 100) * 10_000_000
    turning = stamps >= 10_000_000_000
    rates = np.outer(np.where(turning, rate, 0.0), [0.0, 0.0, 1.0])
    found = estimate_orientation(
        ImuStream(stamps, rates, np.tile([0.0, 0.0, 9.81], (stamps.size, 1))), smooth=False
    )
    assert found.at_rest[900]
    assert not np.any(found.at_rest[1100:])
    angle = found.world_R_imu[-1].as_rotation_vector()
    np.testing.assert_allclose(angle, [0.0, 0.0, 30.0 * rate], atol=0.02)


def test_a_stream_gives_what_the_whole_gives(rng):
    stream = ridden("stop_and_go", rng, 20.0).stream
    running = OrientationFilter()
    rotors, biases, rests = [], [], []
    for stamp, rate, force in zip(
        stream.time_ns, stream.angular_rate_rad_s, stream.specific_force_m_s2, strict=True
    ):
        rotors.append(running.update(int(stamp), rate, force).coefficients)
        biases.append(running.gyro_bias_rad_s)
        rests.append(running.at_rest)
    found = estimate_orientation(stream, smooth=False)
    assert np.array_equal(found.world_R_imu.coefficients, rotors)
    assert np.array_equal(found.gyro_bias_rad_s, biases)
    assert np.array_equal(found.at_rest, rests)


def test_axes_may_be_named_anew(smooth, rng):
    """The x axis to y, y to z, z to x in the sensor: the same orientation, seen from other axes."""
    stream = ridden("handheld", rng, 20.0).stream
    cycled = Rotor.from_matrix([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    other = ImuStream(
        stream.time_ns,
        cycled.apply(stream.angular_rate_rad_s),
        cycled.apply(stream.specific_force_m_s2),
    )
    plain = estimate_orientation(stream, smooth=smooth).world_R_imu
    seen = estimate_orientation(other, smooth=smooth).world_R_imu @ cycled
    difference = (plain.inverse() @ seen).as_rotation_vector()
    # the first turn upright is the shortest, which fixes the heading
    up = plain.apply(difference)
    np.testing.assert_allclose(up[:, :2], 0.0, atol=1e-9)
    np.testing.assert_allclose(up[:, 2], up[0, 2], atol=1e-9)


def test_smoothing_carries_later_knowledge_back():
    """What only later samples tell holds for the first as well.

    A noise-free sensor at rest but for a constant bias: all of the stream, its first sample too,
    must come out level with the bias that only later samples tell.
    """
    bias = np.array([0.004, -0.003, 0.002])
    stamps = np.arange(3000) * 5_000_000
    stream = ImuStream(stamps, np.tile(bias, (3000, 1)), np.tile([0.0, 0.0, 9.81], (3000, 1)))
    found = estimate_orientation(stream)
    online = estimate_orientation(stream, smooth=False)
    np.testing.assert_allclose(found.gyro_bias_rad_s, np.tile(bias, (3000, 1)), atol=2e-5)
    turned = found.world_R_imu.as_rotation_vector()
    assert np.max(np.abs(turned - turned[0])) < 2e-4
    assert np.max(np.abs(online.gyro_bias_rad_s - bias)) > 1e-3


@pytest.mark.parametrize("name", ["handheld", "gimbal_crossing", "stop_and_go"])
def test_the_tilt_is_as_uncertain_as_it_says(name, rng, inclination_rms_deg):
    """The deviation that the filter expects, over its true error: cautious, and not absurdly so."""
    simulated = ridden(name, rng, 60.0)
    stream, truth = simulated.stream, simulated.path.poses.rotor
    running = OrientationFilter()
    rotors, expected = [], []
    for k in range(len(stream)):
        readings = stream.angular_rate_rad_s[k], stream.specific_force_m_s2[k]
        rotors.append(running.update(int(stream.time_ns[k]), *readings).coefficients)
        expected.append(running.tilt_deviation_rad)
    error = inclination_rms_deg(Rotor(np.array(rotors)), truth, slice(2000, None))
    ratio = error / np.degrees(np.sqrt(np.mean(np.square(expected[2000:]))))
    assert 0.1 < ratio < 1.2


def test_after_a_gap_it_knows_less_and_finds_back(rng, smooth, inclination_rms_deg):
    simulated = ridden("handheld", rng, 60.0)
    kept = np.r_[0:4000, 4400:12001]  # two seconds are missing
    stream = simulated.stream
    with_gap = ImuStream(
        stream.time_ns[kept], stream.angular_rate_rad_s[kept], stream.specific_force_m_s2[kept]
    )
    truth = simulated.path.poses.rotor[kept]
    instant = OrientationModel(readings="instant")  # as the simulator's are
    found = estimate_orientation(with_gap, instant, smooth=smooth).world_R_imu
    assert inclination_rms_deg(found, truth, slice(2000, 4000)) < 0.75
    assert inclination_rms_deg(found, truth, slice(9000, None)) < 1.5
    running = OrientationFilter()
    deviations = []
    for k in range(3900, 4100):
        running.update(
            int(with_gap.time_ns[k]),
            with_gap.angular_rate_rad_s[k],
            with_gap.specific_force_m_s2[k],
        )
        deviations.append(running.tilt_deviation_rad)
    assert max(deviations[101:120]) > 3.0 * deviations[99]


def test_it_stays_sound_over_an_hour(rng, inclination_rms_deg):
    path = ContinuousPath.along(MOTIONS["handheld"], 3600.0)
    simulated = simulate_imu(path, 25.0, ADIS16448, rng, faults=FAULTS)
    late = slice(45_000, None)
    # the accelerometer's bias walks to 0.1 m/s² and more in this time: 0.6°
    astray = simulated.accel_bias_m_s2[late] / 9.81
    walked = np.degrees(np.sqrt(np.mean(np.sum(astray**2, axis=1))))
    for smooth in (False, True):
        found = estimate_orientation(simulated.stream, smooth=smooth)
        sizes = np.linalg.norm(found.world_R_imu.coefficients, axis=1)
        np.testing.assert_allclose(sizes, 1.0, atol=1e-12)
        error = inclination_rms_deg(found.world_R_imu, simulated.path.poses.rotor, late)
        assert error < walked + 0.5
        bias = found.gyro_bias_rad_s[late] - simulated.gyro_bias_rad_s[late]
        assert np.max(np.abs(bias)) < 5e-3


def refuse(change: dict[str, object]) -> Callable[[], OrientationModel]:
    return lambda: OrientationModel(**change)  # type: ignore[arg-type]


def test_bad_input_is_refused():
    for change, message in [
        ({"speed_m_s": 0.0}, "speed_m_s: expected a number above 0, got 0.0"),
        ({"interval_s": float("nan")}, "interval_s: expected a number above 0, got nan"),
        ({"readings": "mean"}, "expected one of instant, interval, got 'mean'"),
    ]:
        with pytest.raises(ValueError, match=message):
            refuse(change)()
    running = OrientationFilter()
    up, still = np.array([0.0, 0.0, 9.81]), np.zeros(3)
    running.update(5, still, up)
    with pytest.raises(ValueError, match="time_ns: expected a stamp after 5, got 5"):
        running.update(5, still, up)
    with pytest.raises(ValueError, match="angular_rate_rad_s: expected finite numbers"):
        running.update(6, np.array([0.0, np.nan, 0.0]), up)
    with pytest.raises(ValueError, match="specific_force_m_s2: expected finite numbers"):
        running.update(6, still, np.array([0.0, np.inf, 0.0]))
    with pytest.raises(TypeError):
        running.update(6.0, still, up)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        running.update(6, np.zeros(4), up)
    running.update(6, still, up)
