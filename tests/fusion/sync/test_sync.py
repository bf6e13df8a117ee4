"""Offset and extrinsics found from data, how sure they are, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream, simulate_imu
from motorcade.fusion.imu.simulate import simulate_camera_poses
from motorcade.fusion.motions.standard import MOTIONS
from motorcade.fusion.sync import Synchronised, synchronise
from motorcade.fusion.sync.synchronise import covered, match_rates, plausible
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.cli import main
from motorcade.replays.io.imu import read_imu, write_imu
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from tests.bench.fusion.recorded import DEGRADED, flight, measured

IMU_T_CAMERA = Motor.from_euler_translation(
    np.array([1.2, -0.4, 0.3]), np.array([0.05, -0.1, 0.07])
)
SIGMA_M, SIGMA_RAD = 0.01, np.deg2rad(0.5)


def later(path: Trajectory, seconds: float) -> Trajectory:
    return Trajectory(path.time_ns + round(seconds * 1e9), path.poses)


def recorded(
    rng: np.random.Generator, name: str = "handheld", offset_s: float = 0.02,
    duration_s: float = 16.0, noise: ImuNoise = ADIS16448, camera_hz: float = 20.0,
) -> tuple[Trajectory, ImuStream]:  # fmt: skip
    """Camera poses on their own clock, in a world that leans, and the stream of the IMU."""
    path = MOTIONS[name].sampled(100.0, duration_s, start_ns=10**18, child="imu")
    simulated = simulate_imu(path, 100.0, noise, rng)
    leaning = Motor.from_euler_translation(np.array([0.2, 0.1, 0.7]), np.array([1.0, 2.0, 3.0]))
    camera = simulated.path.transformed_by(left=leaning, right=IMU_T_CAMERA)
    measured = simulate_camera_poses(camera, camera_hz, SIGMA_M, SIGMA_RAD, rng)
    biases = np.array([0.02, -0.01, 0.03]), np.array([0.1, -0.2, 0.05])
    stream = simulated.stream
    imu = ImuStream(
        stream.time_ns,
        stream.angular_rate_rad_s + biases[0],
        stream.specific_force_m_s2 + biases[1],
    )
    return later(measured.trajectory, -offset_s), imu


def errors_in_deviations(found: Synchronised, offset_s: float) -> FloatArray:
    """Errors of offset and extrinsics ``(7,)``, white if the stated covariance is right."""
    apart = (found.imu_T_camera.inverse() @ IMU_T_CAMERA).as_twist()
    error = np.append(offset_s - found.offset_s, apart)
    return np.linalg.solve(np.linalg.cholesky(found.covariance[:7, :7]), error)


@pytest.mark.parametrize("name", ["handheld", "gimbal_crossing"])
@pytest.mark.parametrize("offset_s", [-0.35, 0.005, 0.05])
def test_offset_and_mount_are_found_within_their_stated_uncertainty(rng, name, offset_s):
    camera, imu = recorded(rng, name, offset_s)
    found = synchronise(camera, imu, ADIS16448, search_s=0.5)
    assert found.offset_s == pytest.approx(offset_s, abs=3.0 * found.offset_sigma_s)
    apart = (IMU_T_CAMERA.inverse() @ found.imu_T_camera).as_twist()
    assert np.all(np.abs(apart[:3]) < 3.0 * found.rotation_sigma_rad)
    lever = found.imu_T_camera.translation_m - IMU_T_CAMERA.translation_m
    assert np.all(np.abs(lever) < 3.0 * found.lever_arm_sigma_m)
    assert found.offset_sigma_s < 2e-3
    assert np.max(found.rotation_sigma_rad) < np.deg2rad(0.4)
    assert np.max(found.lever_arm_sigma_m) < 0.02
    assert found.camera_sigma_m == pytest.approx(SIGMA_M, rel=0.15)
    assert found.camera_sigma_rad == pytest.approx(SIGMA_RAD, rel=0.15)
    np.testing.assert_allclose(found.gyro_bias_rad_s.mean(axis=0), [0.02, -0.01, 0.03], atol=3e-3)
    np.testing.assert_array_equal(
        found.on_imu_clock(camera).time_ns, camera.time_ns + round(found.offset_s * 1e9)
    )


@pytest.mark.slow
def test_over_many_runs_errors_are_as_large_as_stated():
    squares = [
        np.sum(
            errors_in_deviations(
                synchronise(*recorded(np.random.default_rng(seed)), ADIS16448, search_s=0.2), 0.02
            )
            ** 2
        )
        for seed in range(16)
    ]
    low, high = chi2.ppf([0.001, 0.999], 7 * len(squares))
    assert low < np.sum(squares) < high


def test_wrong_poses_hardly_matter(rng):
    camera, imu = recorded(rng)
    twists = np.where(np.arange(len(camera))[:, None] % 25 == 12, [0.6, 0, 0, 0, 0.8, 0], 0.0)
    degraded = camera.transformed_by(right=Motor.from_twist(twists))
    found = synchronise(degraded, imu, ADIS16448, search_s=0.2)
    assert np.max(np.abs(errors_in_deviations(found, 0.02))) < 4.0


def test_of_a_fast_camera_fifty_poses_a_second_are_taken(rng):
    camera, imu = recorded(rng, camera_hz=100.0, duration_s=8.0)
    found = synchronise(camera, imu, ADIS16448, search_s=0.2)
    assert np.min(np.diff(found.time_ns)) >= 15_000_000
    assert np.max(np.abs(errors_in_deviations(found, 0.02))) < 4.0


def test_a_worse_sensor_than_stated_is_noticed(rng):
    """Eight times the densities; how much of it walks is hard to tell within seconds."""
    camera, imu = recorded(rng, noise=ADIS16448.scaled(8.0))
    found = synchronise(camera, imu, ADIS16448, search_s=0.2)
    worse = ADIS16448.scaled(8.0)
    noise = found.imu_noise
    assert noise.gyro_density_rad_s_rthz == pytest.approx(worse.gyro_density_rad_s_rthz, rel=0.5)
    assert 3.0 < noise.accel_density_m_s2_rthz / ADIS16448.accel_density_m_s2_rthz < 16.0
    assert np.max(np.abs(errors_in_deviations(found, 0.02))) < 4.0


def test_about_one_axis_the_lever_arm_along_it_stays_open(rng):
    """Turning about the vertical alone tells nothing of how high the camera sits."""
    time_s = np.arange(1601) * 0.01
    vectors = np.stack([0 * time_s, 0 * time_s, np.sin(1.7 * time_s)], axis=-1)
    poses = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(vectors), 0.4 * np.sin(time_s[:, None] * [1.1, 0.7, 0.9])
    )
    path = Trajectory(np.round(time_s * 1e9).astype(np.int64), poses, "world", "imu")
    imu = simulate_imu(path, 100.0, ADIS16448, rng).stream
    camera = simulate_camera_poses(
        path.transformed_by(right=IMU_T_CAMERA), 20.0, SIGMA_M, SIGMA_RAD, rng
    ).trajectory
    found = synchronise(camera, imu, ADIS16448, search_s=0.2)
    sigma = found.lever_arm_sigma_m
    assert sigma[2] > 0.5
    assert np.max(sigma[:2]) < 0.05
    assert found.offset_s == pytest.approx(0.0, abs=3.0 * found.offset_sigma_s)


def test_rates_alone_give_a_start(rng):
    """Offset to less than a sample, rotation by Wahba as scipy finds it from the same rates."""
    camera, imu = recorded(rng, offset_s=1.2345, duration_s=20.0)
    match = match_rates(camera, imu, 2.0)
    assert match.offset_s == pytest.approx(1.2345, abs=5e-3)
    assert (match.imu_R_camera.inverse() @ IMU_T_CAMERA.rotor).angle() < np.deg2rad(1.5)
    # The same problem for scipy, from rates over the same spans without any noise.
    vectors = rng.standard_normal((30, 3))
    turned = IMU_T_CAMERA.rotor.apply(vectors) + 0.01 * rng.standard_normal((30, 3))
    from motorcade.fusion.sync.synchronise import _wahba

    own = _wahba(vectors, turned)
    centred = turned - turned.mean(axis=0), vectors - vectors.mean(axis=0)
    np.testing.assert_allclose(
        own.as_matrix(), Rotation.align_vectors(*centred)[0].as_matrix(), atol=1e-9
    )


def test_streams_that_do_not_belong_together_are_refused(rng):
    camera, imu = recorded(rng)
    with pytest.raises(ValueError, match="expected streams that overlap"):
        synchronise(later(camera, 100.0), imu, ADIS16448)
    other = MOTIONS["walk_and_look"].sampled(20.0, 16.0, start_ns=10**18)
    with pytest.raises(ValueError, match="too little rotation, or not one motion"):
        synchronise(other, imu, ADIS16448, search_s=0.2)
    still = Trajectory(camera.time_ns, Motor.identity((len(camera),)))
    jittered = simulate_camera_poses(still, 20.0, SIGMA_M, SIGMA_RAD, rng).trajectory
    rest = ImuStream(
        imu.time_ns,
        1e-3 * rng.standard_normal((len(imu), 3)),
        np.array([0.0, 0.0, 9.81]) + 0.02 * rng.standard_normal((len(imu), 3)),
    )
    with pytest.raises(ValueError, match=r"turns by 0\.00\d rad/s RMS.*too little rotation"):
        synchronise(jittered, rest, ADIS16448)
    with pytest.raises(ValueError, match="search_s"):
        synchronise(camera, imu, ADIS16448, search_s=0.0)
    falling = ImuStream(imu.time_ns, imu.angular_rate_rad_s, 0.0 * imu.specific_force_m_s2)
    with pytest.raises(ValueError, match="imu: expected specific forces, got zeros"):
        synchronise(camera, falling, ADIS16448)


def test_the_command_writes_what_it_finds(rng, tmp_path, capsys):
    camera, imu = recorded(rng, duration_s=12.0)
    write_trajectory(camera, tmp_path / "camera.tum")
    write_imu(imu, tmp_path / "imu.csv")
    result = tmp_path / "sync.json"
    arguments = [str(tmp_path / "camera.tum"), str(tmp_path / "imu.csv"), "--search-s", "0.2"]
    assert main(["sync", *arguments, "--json", str(result)]) == 0
    found = json.loads(result.read_text())
    assert found["offset_ms"] == pytest.approx(20.0, abs=3.0 * found["offset_sigma_ms"])
    assert "offset_sigma_ms" in capsys.readouterr().out
    write_trajectory(later(camera, 50.0), tmp_path / "camera.tum")
    assert main(["sync", *arguments]) == 1
    assert "overlap" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("offset_ms", [5, 20, 50])
def test_on_a_real_flight_an_injected_offset_is_found_to_a_millisecond(data_dir: Path, offset_ms):
    imu = read_imu(data_dir / "imu" / "V102_imu.txt")
    truth = read_trajectory(data_dir / "imu" / "V1_02_medium.csv")
    camera = simulate_camera_poses(
        truth.transformed_by(right=IMU_T_CAMERA),
        20.0,
        SIGMA_M,
        SIGMA_RAD,
        np.random.default_rng(offset_ms),
    ).trajectory
    found = synchronise(later(camera, -1e-3 * offset_ms), imu, ADIS16448)
    assert found.offset_s == pytest.approx(1e-3 * offset_ms, abs=3.0 * found.offset_sigma_s)
    assert found.offset_sigma_s < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "delay_s"), enumerate([0.005, 0.02, 0.05, 0.005, 0.02]))
def test_outliers_and_blackouts_leave_offset_and_mount_within_what_is_said(
    data_dir: Path, seed: int, delay_s: float
):
    """V1_02, whose accelerometer pulls the extrinsics from where its gyroscope has it.

    The gyroscope is turned by up to 0.1° from the recorded ground truth's axes, and so is an
    estimate.
    """
    one = flight("V1_02", data_dir)
    assert one is not None
    found = synchronise(measured(one, seed, delay_s, DEGRADED).trajectory, one.imu, ADIS16448)
    assert found.offset_s == pytest.approx(-delay_s, abs=3.0 * found.offset_sigma_s)
    turned = found.imu_T_camera.rotor.as_rotation_vector()
    assert np.all(np.abs(turned) < 3.0 * found.rotation_sigma_rad + np.deg2rad(0.1))


def test_gross_errors_are_found_by_their_neighbours(rng):
    camera, imu = recorded(rng, offset_s=0.0)
    wrong = np.arange(len(camera)) % 20 == 10
    wrong[100:102] = True  # two that follow each other
    twists = np.zeros((len(camera), 6))
    twists[wrong, 0], twists[np.arange(len(camera)) % 40 == 10, 4] = 0.3, 0.6
    degraded = camera.transformed_by(right=Motor.from_twist(twists))
    used, _ = covered(degraded, imu, 0.0, 0.0)
    kept = plausible(used, imu, match_rates(degraded, imu, 0.2))
    known = wrong[np.isin(degraded.time_ns, used.time_ns)]
    assert not np.any(kept & known)
    assert np.mean(kept[~known]) > 0.98
    assert np.all(plausible(camera[:1], imu, match_rates(camera, imu, 0.2)))


def test_rates_state_how_sure_their_offset_is():
    """Squares of errors in stated deviations, over seeds, by the χ² of their number."""
    squares = []
    for seed in range(8):
        camera, imu = recorded(np.random.default_rng(seed), offset_s=0.02)
        match = match_rates(camera, imu, 0.1)
        squares.append(((match.offset_s - 0.02) / match.offset_sigma_s) ** 2)
    low, high = chi2.ppf([1e-4, 0.9999], len(squares))
    assert low < np.sum(squares) < high


@pytest.mark.parametrize(
    ("rate", "force", "mend"),
    [
        (float(np.rad2deg(1.0)), 1.0, "reads degrees a second"),
        (1.0, 1 / 9.80665, "the accelerometer reads g"),
        (-1.0, 1.0, "the gyroscope's axes are left-handed"),
        (1.0, -1.0, "the accelerometer's sign is wrong"),
    ],
)
def test_faults_that_no_offset_mends_are_refused_by_name(rng, rate, force, mend):
    camera, imu = recorded(rng)
    rates, forces = rate * imu.angular_rate_rad_s, force * imu.specific_force_m_s2
    with pytest.raises(ValueError, match=mend):
        synchronise(camera, ImuStream(imu.time_ns, rates, forces), ADIS16448, search_s=0.2)


def test_stamps_in_another_unit_are_refused_by_name(rng):
    camera, imu = recorded(rng)
    early = Trajectory(camera.time_ns // 1000, camera.poses)
    with pytest.raises(ValueError, match="the poses' stamps are in µs"):
        synchronise(early, imu, ADIS16448)
