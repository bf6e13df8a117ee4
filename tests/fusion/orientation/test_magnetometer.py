"""Heading by a magnetometer: found, kept while disturbed, found again; simulated sensors."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuFaults, ImuStream, simulate_imu
from motorcade.fusion.imu.stream import STANDARD_GRAVITY_M_S2
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.orientation import (
    Orientation,
    OrientationFilter,
    OrientationModel,
    estimate_orientation,
)
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

RATE_HZ = 200.0
FIELD_UT = np.array([0.0, 17.0, -42.0])  # central Europe: north and down
FAULTS = ImuFaults(gyro_bias_rad_s=[0.002, -0.003, 0.004])
MODEL = OrientationModel(readings="instant")


class Ride:
    """A motion of 100 s, with the field that a magnetometer reads along it."""

    def __init__(self, rng: np.random.Generator, name: str = "walk_and_look") -> None:
        path = ContinuousPath.along(MOTIONS[name], 100.0)
        simulated = simulate_imu(path, RATE_HZ, ADIS16448, rng, faults=FAULTS)
        self.imu: ImuStream = simulated.stream
        self.truth: Rotor = simulated.path.poses.rotor
        self.time_s: FloatArray = 1e-9 * (self.imu.time_ns - self.imu.time_ns[0])
        self.white: FloatArray = rng.normal(0.0, 0.5, (len(self.imu), 3))

    def field(self, world_ut: FloatArray = FIELD_UT, late: int = 0) -> FloatArray:
        """Readings of a field in the axes of the world, some samples late."""
        read = self.truth.inverse().apply(np.broadcast_to(world_ut, (len(self.imu), 3)))
        return np.concatenate([np.repeat(read[:1], late, 0), read[: len(read) - late]]) + self.white

    def estimate(self, field: FloatArray, smooth: bool) -> Orientation:
        return estimate_orientation(self.imu, MODEL, magnetic_field=field, smooth=smooth)

    def heading_error_deg(self, found: Orientation) -> FloatArray:
        error = (found.world_R_imu @ self.truth.inverse()).as_quaternion()
        angle = 2.0 * np.arctan2(error[:, 3], error[:, 0])
        return np.degrees((angle + np.pi) % (2.0 * np.pi) - np.pi)


@pytest.fixture
def ride(rng: np.random.Generator) -> Ride:
    return Ride(rng)


def test_north_is_found_and_kept(ride, smooth):
    found = ride.estimate(ride.field(), smooth)
    error = ride.heading_error_deg(found)
    if smooth:
        assert np.max(np.abs(error)) < 1.5
    assert np.sqrt(np.mean(error[1000:] ** 2)) < 1.0
    expected = np.degrees(found.heading_deviation_rad)
    assert np.sqrt(np.mean((error / expected) ** 2)) < 1.5
    bias = found.gyro_bias_rad_s[-1] - FAULTS.gyro_bias_rad_s
    assert np.max(np.abs(bias)) < 2e-3


def test_a_late_magnetometer_is_found_out(rng, smooth):
    ride = Ride(rng, "antipodal_crossing")
    found = ride.estimate(ride.field(late=4), smooth)  # 20 ms
    assert found.magnetometer_lag_s == pytest.approx(0.02, abs=0.006)
    assert np.sqrt(np.mean(ride.heading_error_deg(found)[1000:] ** 2)) < 1.5
    assert abs(ride.estimate(ride.field(), smooth).magnetometer_lag_s) < 0.003


def test_a_magnet_at_the_sensor_is_bridged(ride, smooth):
    field = ride.field()
    attached = (ride.time_s > 40.0) & (ride.time_s < 70.0)
    field[attached] += [15.0, -20.0, 10.0]
    found = ride.estimate(field, smooth)
    assert np.max(np.abs(ride.heading_error_deg(found)[1000:])) < 4.0
    assert np.degrees(np.median(found.field_deviation_rad[attached])) > 30.0
    assert np.degrees(np.median(found.field_deviation_rad[~attached])) < 5.0
    if not smooth:
        halfway = np.searchsorted(ride.time_s, [39.0, 69.0])
        before, within = found.heading_deviation_rad[halfway]
        assert within > before


def test_a_start_in_a_disturbed_place_is_recovered_from(ride, smooth):
    """The field of the first 15 s is turned by 60° and stronger."""
    begun = ride.time_s < 15.0
    turned = Rotor.from_rotation_vector([0.0, 0.0, np.deg2rad(60.0)]).apply(1.4 * FIELD_UT)
    field = ride.field(np.where(begun[:, None], turned, FIELD_UT))
    error = np.abs(ride.heading_error_deg(ride.estimate(field, smooth)))
    if smooth:
        assert np.max(error) < 5.0
    else:
        assert np.min(error[:2000]) > 45.0
        assert np.max(error[ride.time_s > 75.0]) < 8.0


def test_the_unit_of_the_field_does_not_matter(ride, smooth):
    in_ut, in_gauss = (ride.estimate(scale * ride.field(), smooth) for scale in (1.0, 0.01))
    np.testing.assert_allclose(
        in_ut.world_R_imu.coefficients, in_gauss.world_R_imu.coefficients, atol=1e-9
    )


def test_a_stream_gives_what_the_whole_gives(ride):
    """Also where the magnetometer is slower than the IMU, and silent for a while."""
    field = ride.field()
    field[np.arange(len(field)) % 5 > 0] = np.nan
    field[2000:3000] = np.nan
    found = ride.estimate(field, smooth=False)
    live = OrientationFilter(MODEL)
    rotors, deviations = [], []
    for k in range(4000):
        reading = None if np.isnan(field[k, 0]) else field[k]
        rates, forces = ride.imu.angular_rate_rad_s[k], ride.imu.specific_force_m_s2[k]
        rotors.append(live.update(int(ride.imu.time_ns[k]), rates, forces, reading).coefficients)
        deviations.append([live.heading_deviation_rad, live.field_deviation_rad])
    assert np.array_equal(found.world_R_imu.coefficients[:4000], rotors)
    both = np.stack([found.heading_deviation_rad, found.field_deviation_rad], axis=1)
    assert np.array_equal(both[:4000], deviations)


def test_a_magnetometer_may_come_later(ride, smooth):
    field = ride.field()
    field[:3000] = np.nan
    error = np.abs(ride.heading_error_deg(ride.estimate(field, smooth)))
    assert np.max(error[3020:]) < 5.0
    if smooth:
        assert np.max(error) < 5.0


def test_bad_fields_are_refused(ride):
    for field, message in [
        (np.zeros((3, 3)), r"magnetic_field: expected shape \(20001, 3\), got \(3, 3\)"),
        (np.full((20001, 3), np.nan), "expected a reading, got rows of NaN alone"),
        (np.full((20001, 3), np.inf), "expected readings within 1e"),
    ]:
        with pytest.raises(ValueError, match=message):
            ride.estimate(field, smooth=False)
    live = OrientationFilter()
    with pytest.raises(ValueError, match="magnetic_field: expected finite numbers"):
        live.update(0, np.zeros(3), np.array([0.0, 0.0, 9.81]), np.array([0.0, np.nan, 0.0]))


def test_a_field_of_zero_says_nothing(ride, smooth):
    found = ride.estimate(np.zeros((len(ride.imu), 3)), smooth)
    plain = estimate_orientation(ride.imu, MODEL, smooth=smooth)
    np.testing.assert_allclose(
        found.world_R_imu.coefficients, plain.world_R_imu.coefficients, atol=1e-12
    )


def test_short_stays_claim_no_more_of_north_than_they_tell(rng):
    """A still sensor for 6 s beside a disturbance as the model has it: 3° that last for 3 s."""
    time_s = 0.01 * np.arange(600)
    still = ImuStream(
        np.round(1e9 * time_s).astype(np.int64),
        1e-3 * rng.normal(size=(600, 3)),
        [0.0, 0.0, STANDARD_GRAVITY_M_S2] + 0.01 * rng.normal(size=(600, 3)),
    )
    kept = np.exp(-0.01 / MODEL.field_disturbance_time_s)
    off, squares = MODEL.field_disturbance_rad * rng.normal(size=400), []
    angles = np.empty((600, 400))
    for angle in angles:
        angle[:] = off
        new = MODEL.field_disturbance_rad * np.sqrt(1.0 - kept**2) * rng.normal(size=400)
        off = kept * off + new
    for angle in angles.T:
        field = FIELD_UT[1] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
        found = estimate_orientation(
            still, MODEL, magnetic_field=np.column_stack([field, np.full(600, FIELD_UT[2])])
        )
        heading = found.world_R_imu[300].as_rotation_vector()[2]
        squares.append((heading / found.heading_deviation_rad[300]) ** 2)
    assert np.mean(squares) < 1.0
