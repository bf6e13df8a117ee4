"""Kalman filters and the RTS smoother: filterpy on translations, their own statistics on turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter as Witness

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.fusion.smoothing import (
    REPRESENTATIONS,
    ConstantAccelerationFilter,
    ConstantVelocityFilter,
    smooth,
)
from motorcade.fusion.smoothing.causal import KalmanFilter, smoothed_states
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

DENSITY, NOISE_M = 1.7, 0.02


def model(order: int, name: str = "motor", noise_m: FloatArray | float = NOISE_M) -> KalmanFilter:
    """A filter that takes rotations and scales for known: translations stand for themselves."""
    kind = (ConstantVelocityFilter, ConstantAccelerationFilter)[order - 1]
    return kind(DENSITY, 1e-10, noise_m, 1e-10, 1e-10, 1e-10, representation=name)


@dataclass
class Line:
    """A noisy path without turns at uneven stamps, and what filterpy makes of it."""

    trajectory: Trajectory
    noise_m: FloatArray

    @staticmethod
    def random(rng: np.random.Generator) -> Line:
        stamps = np.cumsum(rng.integers(10_000_000, 60_000_000, 120))
        stamps[60:] += 900_000_000
        noise = rng.uniform(0.5, 2.0, 120) * NOISE_M
        seconds = stamps[:, None] * 1e-9
        way = np.sin(seconds * [1.0, 1.7, 0.6]) + noise[:, None] * rng.standard_normal((120, 3))
        poses = Motor.from_rotor_translation(Rotor.identity((120,)), way)
        return Line(Trajectory(stamps, poses), noise)

    def filterpy(self, order: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
        """Filtered states, smoothed states and their variances, log-likelihood: states by axis."""
        size = order + 1
        z, dt = self.trajectory.poses.translation_m, np.diff(self.trajectory.time_ns) * 1e-9
        kf = Witness(dim_x=3 * size, dim_z=3)
        kf.H = np.kron(np.eye(3), np.eye(size)[:1])
        kf.x = np.kron(z[0], np.eye(size)[0])[:, None]
        prior = (1e3 * self.noise_m[1]) ** 2 + 1e2 * np.sum((z[1] - z[0]) ** 2)
        first = [self.noise_m[0] ** 2, *(prior / dt[0] ** (2 * k) for k in range(1, size))]
        kf.P = np.kron(np.eye(3), np.diag(first))
        means, covariances, f, q = [kf.x], [kf.P], [np.eye(3 * size)], [np.zeros((3 * size,) * 2)]
        likelihood = 0.0
        for k, step in enumerate(dt, start=1):
            f.append(np.kron(np.eye(3), transition(size, step)))
            q.append(np.kron(np.eye(3), DENSITY**2 * diffusion(size, step)))
            kf.predict(F=f[-1], Q=q[-1])
            kf.update(z[k], R=self.noise_m[k] ** 2)
            means.append(kf.x)
            covariances.append(kf.P)
            likelihood += kf.log_likelihood if k > order else 0.0
        x, p = np.array(means), np.array(covariances)
        smoothed, variances, _, _ = kf.rts_smoother(x, p, f, q)
        by_axis = (len(z), 3, size)
        return (
            x[..., 0].reshape(by_axis),
            smoothed[..., 0].reshape(by_axis),
            np.diagonal(variances, axis1=1, axis2=2).reshape(by_axis),
            z,
            likelihood,
        )


def transition(size: int, dt: float) -> FloatArray:
    return np.array([[1.0, dt, dt * dt / 2], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])[:size, :size]


def diffusion(size: int, dt: float) -> FloatArray:
    """White noise on the highest derivative, integrated by quadrature that is exact for it."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    total = np.zeros((size, size))
    for node, weight in zip(nodes, weights, strict=True):
        column = transition(size, dt * (1.0 - node) / 2)[:, -1:]
        total += weight * dt / 2 * column @ column.T
    return total


@pytest.mark.parametrize("name", [name for name in REPRESENTATIONS if name != "dual_quaternion"])
@pytest.mark.parametrize("order", [1, 2])
def test_translations_are_filtered_and_smoothed_as_filterpy_does(
    order: int, name: str, rng: np.random.Generator
) -> None:
    line = Line.random(rng)
    filtered, smoothed, variances, _, _ = line.filterpy(order)
    chosen = model(order, name, line.noise_m)
    forward = chosen.smooth(line.trajectory).poses.translation_m
    np.testing.assert_allclose(forward, filtered[..., 0], rtol=0.0, atol=1e-9)
    states = smoothed_states(line.trajectory, chosen)
    both = states.trajectory.poses.translation_m
    np.testing.assert_allclose(both, smoothed[..., 0], rtol=0.0, atol=1e-9)
    rates = states.rates[..., 4:7] if name == "quaternion" else states.rates[..., 3:6]
    np.testing.assert_allclose(
        np.moveaxis(rates, 1, 2), smoothed[..., 1:], rtol=0.0, atol=1e-9 * 10.0 ** (2 * order)
    )
    # filterpy's first variances lose their digits to the wide prior.
    np.testing.assert_allclose(
        states.deviations[order:, 1] ** 2, variances[order:].mean(axis=1), rtol=1e-6, atol=0.0
    )


@pytest.mark.parametrize("order", [1, 2])
def test_the_likelihood_is_filterpys(order: int, rng: np.random.Generator) -> None:
    line = Line.random(rng)
    expected = line.filterpy(order)[-1]
    # Rotations without error add the same density whatever the translations do.
    still = Trajectory(line.trajectory.time_ns, Motor.identity((len(line.trajectory),)))
    chosen = model(order, "rotor", line.noise_m)
    shares = [model(order, "rotor", line.noise_m).log_likelihood(line.trajectory) for _ in range(2)]
    assert shares[0] == shares[1]
    other = Line.random(rng)
    other = Line(Trajectory(line.trajectory.time_ns, other.trajectory.poses), line.noise_m)
    found = chosen.log_likelihood(line.trajectory) - chosen.log_likelihood(other.trajectory)
    assert found == pytest.approx(expected - other.filterpy(order)[-1], rel=1e-9)
    assert chosen.log_likelihood(still) > chosen.log_likelihood(line.trajectory)
    assert smoothed_states(line.trajectory, chosen).log_likelihood == shares[0]


# Turns -----------------------------------------------------------------------------------------


def simulated(
    order: int, versor: type[Motor] | type[Similarity], rng: np.random.Generator, turn_rad_s: float
) -> tuple[Trajectory, Trajectory, FloatArray]:
    """Truth from the model itself at 30 Hz, in fine steps; its measurements; its rates."""
    size, fine, dt = 7 if versor is Similarity else 6, 8, 1.0 / 30.0
    count = 400 if order == 1 else 200  # rates wander ever farther
    densities = np.array([1.5, 1.5, 1.5, 0.8, 0.8, 0.8, 0.3])[:size]
    rates = np.zeros((order, size))
    rates[0, :6] = [0.3 * turn_rad_s, 0.2 * turn_rad_s, turn_rad_s, 0.5, -0.3, 0.2]
    poses, kept, pose = [], [], versor.identity()
    for _ in range(count):
        poses.append(pose)
        kept.append(rates.copy())
        for _ in range(fine):
            way = rates[0] * dt / fine + (rates[1] * (dt / fine) ** 2 / 2 if order == 2 else 0.0)
            pose = pose @ versor.from_twist(way)
            if order == 2:
                rates[0] += rates[1] * dt / fine
            rates[-1] += densities * np.sqrt(dt / fine) * rng.standard_normal(size)
    noise = np.array([0.01] * 3 + [0.005] * 3 + [0.004])[:size] * rng.standard_normal((count, size))
    truth = Trajectory(np.round(np.arange(count) * dt * 1e9).astype(np.int64), versor.stack(poses))
    measured = Trajectory(truth.time_ns, truth.poses @ versor.from_twist(noise))
    return truth, measured, np.array(kept)


@pytest.mark.parametrize("versor", [Motor, Similarity])
@pytest.mark.parametrize("turn_rad_s", [0.5, 5.0, 15.0])
@pytest.mark.parametrize("order", [1, 2])
def test_errors_are_as_large_as_the_smoother_says(
    order: int,
    turn_rad_s: float,
    versor: type[Motor] | type[Similarity],
    rng: np.random.Generator,
) -> None:
    """Normalised errors of poses and rates have mean square 1, at half a radian a step too."""
    kind = (ConstantVelocityFilter, ConstantAccelerationFilter)[order - 1]
    name = "similarity" if versor is Similarity else "motor"
    chosen, inner, squares = kind(0.8, 1.5, 0.005, 0.01, 0.3, 0.004, name), slice(20, -20), []
    for _ in range(4):
        truth, measured, rates = simulated(order, versor, rng, turn_rad_s)
        states = smoothed_states(measured, chosen)
        error = (truth.poses.inverse() @ states.trajectory.poses).as_twist()[:, None]
        errors = np.concatenate([error, states.rates - rates], axis=1)[inner]
        blocks = range(states.deviations.shape[1])
        squares.append(
            [
                np.mean(
                    (errors[..., 3 * b : 3 * b + 3] / states.deviations[inner, b, :, None]) ** 2,
                    axis=(0, 2),
                )
                for b in blocks
            ]
        )
    found = np.mean(squares, axis=0)
    assert np.all((found > 0.7) & (found < 1.3)), found


@pytest.mark.parametrize("motion", ["tumble", "fast_spin", "zoom"])
@pytest.mark.parametrize("method", ["rts_constant_velocity", "rts_constant_acceleration"])
def test_another_world_changes_nothing_of_the_smoother(
    method: str, motion: str, rng: np.random.Generator
) -> None:
    trajectory = Gaussian(0.005, 0.01).apply(MOTIONS[motion].sampled(30.0, 10.0), rng)
    if isinstance(trajectory.poses, Similarity):
        name, left = "similarity", Similarity.random(rng)
    else:
        name, left = "motor", Motor.random(rng, extent_m=3.0)
    moved = smooth(Trajectory(trajectory.time_ns, left @ trajectory.poses), method, name).poses
    expected = left @ smooth(trajectory, method, name).poses
    assert np.abs(moved.as_matrix() - expected.as_matrix()).max() < 1e-10


@pytest.mark.parametrize("name", REPRESENTATIONS)
@pytest.mark.parametrize("order", [1, 2])
def test_the_poses_alone_are_those_of_the_states(
    order: int, name: str, rng: np.random.Generator
) -> None:
    """Over more poses than one segment, so that the second pass over the filter counts too."""
    trajectory = Gaussian(0.005, 0.01).apply(MOTIONS["handheld"].sampled(30.0, 30.0), rng)
    kind = (ConstantVelocityFilter, ConstantAccelerationFilter)[order - 1]
    method = ("rts_constant_velocity", "rts_constant_acceleration")[order - 1]
    states = smoothed_states(trajectory, kind(representation=name))
    alone = smooth(trajectory, method, name).poses.coefficients
    np.testing.assert_allclose(states.trajectory.poses.coefficients, alone, rtol=0.0, atol=1e-12)
    last = kind(representation=name).smooth(trajectory).poses[-1]
    np.testing.assert_array_equal(alone[-1], last.coefficients)
    assert states.rates.shape[:2] == (len(trajectory), order)
    assert not states.rates.flags.writeable


@pytest.mark.parametrize("name", ["motor", "rotor", "quaternion"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("memory", ["short", "long", "long, and still at first"])
def test_long_paths_are_smoothed_in_parts_as_if_in_one(
    memory: str, order: int, name: str, rng: np.random.Generator
) -> None:
    """In parts side by side where a filter forgets in time, and not where it remembers for long."""
    count = 6000
    stamps = np.cumsum(rng.integers(4_000_000, 60_000_000, count))
    stamps[count // 3 :] += 3_000_000_000
    drawn = MOTIONS["tumble"].sampled(rate_hz=50.0, duration_s=20.0)
    poses = drawn.motors_at(drawn.time_ns[0] + stamps % 19_000_000_000)
    if "still" in memory:
        poses = Motor(np.where(np.arange(count)[:, None] < 2000, poses[0].coefficients, poses))
    else:
        poses = poses @ Motor.from_twist(0.01 * rng.standard_normal((count, 6)))
    kind = (ConstantVelocityFilter, ConstantAccelerationFilter)[order - 1]
    method = ("rts_constant_velocity", "rts_constant_acceleration")[order - 1]
    noise = {"noise_m": rng.uniform(0.002, 0.05, count), "noise_rad": 0.01}
    if "long" in memory:
        noise = {"noise_m": 1e4, "noise_rad": 0.01}
    trajectory = Trajectory(stamps, poses)
    states = smoothed_states(trajectory, kind(representation=name, **noise))
    alone = smooth(trajectory, method, name, **noise).poses.coefficients
    np.testing.assert_allclose(states.trajectory.poses.coefficients, alone, rtol=0.0, atol=1e-12)


def test_noise_of_single_poses_counts_in_streams(rng: np.random.Generator) -> None:
    trajectory = MOTIONS["handheld"].sampled(30.0, 3.0)
    noise = rng.uniform(0.001, 0.1, len(trajectory))
    noise[0] = 0.005
    batch = smooth(trajectory, "constant_velocity", noise_m=noise)
    chosen = ConstantVelocityFilter()
    for k, pose in enumerate(trajectory.poses):
        made = chosen.update(pose, int(trajectory.time_ns[k]), noise_m=float(noise[k]))
        np.testing.assert_array_equal(made.coefficients, batch.poses.coefficients[k])
    with pytest.raises(ValueError, match="noise: expected one deviation for a stream"):
        ConstantVelocityFilter(noise_m=noise).update(trajectory.poses[0], 0)


@pytest.mark.parametrize("method", ["rts_constant_velocity", "rts_constant_acceleration"])
def test_one_pose_and_two_are_smoothed(method: str, rng: np.random.Generator) -> None:
    for count in (1, 2):
        trajectory = Trajectory(np.arange(count) * 10, Motor.random(rng, (count,)))
        made = smooth(trajectory, method).poses
        assert np.abs((trajectory.poses.inverse() @ made).as_twist()).max() < 1e-3


def test_the_likelihood_tells_the_noise_and_the_motion(rng: np.random.Generator) -> None:
    _, measured, _ = simulated(1, Motor, rng, 2.0)
    found = {
        (density, noise): ConstantVelocityFilter(density, 1.5, noise, 0.01).log_likelihood(measured)
        for density in (0.2, 0.8, 3.2)
        for noise in (0.0025, 0.005, 0.01)
    }
    assert max(found, key=lambda pair: found[pair]) == (0.8, 0.005)


@pytest.mark.parametrize("method", ["rts_constant_velocity", "rts_constant_acceleration"])
def test_quaternions_are_filtered_as_four_numbers_and_projected_once(
    method: str, rng: np.random.Generator
) -> None:
    """Projected at every step they would no longer fit their rates, and run away."""
    truth = MOTIONS["handheld"].sampled(30.0, 6.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, rng)
    densities = (1.0, 3.0) if "velocity" in method else (5.0, 20.0)
    names = (
        ("acceleration_m_s2", "angular_acceleration_rad_s2")
        if "velocity" in method
        else ("jerk_m_s3", "angular_jerk_rad_s3")
    )
    given = dict(zip(names, densities, strict=True))
    smoothed = smooth(noisy, method, "quaternion", noise_m=0.005, noise_rad=0.01, **given)
    # Half a radian a component: the components as positions, three and one at a time.
    wxyz = REPRESENTATIONS["quaternion"].coordinates(noisy.poses)[:, :4]
    halved = dict(zip(names, (0.5 * densities[1], 1.0), strict=True))
    columns = []
    for part in (wxyz[:, :3], np.pad(wxyz[:, 3:], ((0, 0), (0, 2)))):
        still = Motor.from_translation(part)
        path = smooth(Trajectory(noisy.time_ns, still), method, "motor", noise_m=0.005, **halved)
        columns.append(path.poses.translation_m)
    expected = np.concatenate([columns[0], columns[1][:, :1]], axis=1)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    found = REPRESENTATIONS["quaternion"].coordinates(smoothed.poses)[:, :4]
    found *= np.sign(np.sum(found[:1] * expected[:1]))
    np.testing.assert_allclose(found, expected, atol=2e-6)


@pytest.mark.parametrize("representation", ["motor", "rotor", "similarity"])
@pytest.mark.parametrize("gap_s", [1.0, 3.0, 30.0])
def test_long_gaps_do_not_make_the_smoother_run_away(
    representation: str, gap_s: float, rng: np.random.Generator
) -> None:
    """Keyframes as of monocular odometry: an acceleration carried over a gap says little."""
    time_s = np.cumsum(np.concatenate([[0.0], rng.uniform(0.06, 0.3, 39)]))
    time_s[20:] += gap_s
    turn = np.stack([np.sin(0.9 * time_s), 0.6 * np.sin(1.3 * time_s), np.cos(0.7 * time_s)], -1)
    twists = np.concatenate([0.5 * turn, 0.3 * turn[:, ::-1]], axis=-1)
    noise = 0.002 * rng.standard_normal((40, 6))
    poses = Motor.from_twist(twists) @ Motor.from_twist(noise)
    path = Trajectory(np.round(1e9 * time_s).astype(np.int64), poses)
    found = smooth(
        path,
        "rts_constant_acceleration",
        representation,
        jerk_m_s3=3.0,
        angular_jerk_rad_s3=3.0,
        noise_m=0.002,
        noise_rad=0.002,
    )
    apart = (path.poses.inverse() @ found.poses).as_twist()
    assert np.abs(apart).max() < 0.02


@pytest.mark.parametrize("motion", ["handheld", "zoom"])
@pytest.mark.parametrize("name", ["quaternion", "dual_quaternion"])
def test_components_do_as_well_as_motors_on_calm_motion(
    name: str, motion: str, rng: np.random.Generator
) -> None:
    truth = MOTIONS[motion].sampled(30.0, 6.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, rng)
    off = {}
    for representation in (name, "motor"):
        path = smooth(noisy, "rts_constant_acceleration", representation)
        turns = truth.poses.rotor.inverse() @ path.poses.rotor
        off[representation] = float(np.sqrt(np.mean(turns.as_rotation_vector() ** 2)))
    assert off[name] < 1.1 * off["motor"]
