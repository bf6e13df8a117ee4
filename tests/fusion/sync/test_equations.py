"""Under the estimate: derivatives against differences, the solver against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.sync.alignment import interval_residuals, pose_residuals
from motorcade.fusion.sync.normal_equations import Bordered, ChainFactor
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

GRAVITY = np.array([0.3, -0.2, -9.8])


def moved(motor: FloatArray, twist: FloatArray) -> FloatArray:
    return (Motor(motor) @ Motor.from_twist(twist)).coefficients


def test_the_generated_code_is_current():
    pytest.importorskip("casadi")
    from motorcade.fusion.sync.model import GENERATED, residuals_source

    assert GENERATED.read_text(encoding="utf-8") == residuals_source()


def test_an_interval_between_states_that_fit_leaves_nothing(rng):
    """Ends carried by hand from starts and increments, in plain vectors."""
    start = Motor.random(rng, (5,))
    velocity, dt = rng.standard_normal((5, 3)), rng.uniform(0.05, 0.3, 5)
    turn = Rotor.from_rotation_vector(0.3 * rng.standard_normal((5, 3)))
    shift, gain = rng.standard_normal((2, 5, 3))
    seconds = dt[:, None]
    place = start.translation_m + velocity * seconds + 0.5 * GRAVITY * seconds**2
    end = Motor.from_rotor_translation(start.rotor @ turn, place + start.rotor.apply(shift))
    later = velocity + GRAVITY * seconds + start.rotor.apply(gain)
    pair = np.stack(
        [Motor.from_rotor_translation(turn, one).coefficients for one in (shift, gain)], axis=1
    )
    residual, _ = interval_residuals(
        (start.coefficients, end.coefficients),
        (velocity, later),
        np.zeros((5, 6)),
        GRAVITY,
        pair.reshape(5, 16),
        np.zeros((5, 9, 6)),
        dt,
    )
    np.testing.assert_allclose(residual, 0.0, atol=1e-12)


def test_derivatives_of_an_interval_are_differences(rng):
    near = 0.01 * rng.standard_normal((4, 12))
    start, end = Motor.random(rng).coefficients[None], Motor.random(rng).coefficients[None]
    v0, v1, biases = rng.standard_normal((1, 3)), rng.standard_normal((1, 3)), np.zeros((1, 6))
    jacobian, dt = rng.standard_normal((1, 9, 6)), np.array([0.2])
    # Increments near what the states imply, so that residuals are small.
    relative = (Motor(start).inverse() @ Motor(end)).rotor
    back = Motor(start).rotor.inverse()
    place = back.apply(
        Motor(end).translation_m - Motor(start).translation_m - v0 * 0.2 - 0.02 * GRAVITY
    )
    gain = back.apply(v1 - v0 - 0.2 * GRAVITY)
    pair = [
        moved(Motor.from_rotor_translation(relative, one).coefficients, near[:1, part])
        for one, part in ((place, slice(6)), (gain, slice(6, 12)))
    ]
    motion = np.concatenate(pair, axis=-1)

    def residual(step: FloatArray) -> FloatArray:
        # What the start's biases change in the preintegrated motion, done to it.
        by_bias = jacobian[0] @ step[9:15]
        twists = by_bias[:6], np.concatenate([by_bias[:3], by_bias[6:]])
        own = [moved(one, twist) for one, twist in zip(pair, twists, strict=True)]
        return interval_residuals(
            (moved(start, step[:6]), moved(end, step[15:21])),
            (v0 + step[6:9], v1 + step[21:24]),
            biases + step[24:30] - step[9:15],
            GRAVITY + step[30:],
            np.concatenate(own, axis=-1),
            jacobian,
            dt,
        )[0][0]

    _, slope = interval_residuals((start, end), (v0, v1), biases, GRAVITY, motion, jacobian, dt)
    numeric = np.stack(
        [(residual(one) - residual(-one)) / 2e-6 for one in 1e-6 * np.eye(33)], axis=-1
    )
    # By the biases derivatives are taken where residuals are zero: off by the residuals' size.
    np.testing.assert_allclose(slope[0], numeric, atol=0.1)
    others = np.r_[:9, 15:33]
    np.testing.assert_allclose(slope[0][:, others], numeric[:, others], atol=1e-7)


def test_derivatives_of_a_pose_are_differences(rng):
    pose, extrinsics = Motor.random(rng, (1,)), Motor.random(rng)
    twist = rng.standard_normal((1, 6))
    off = Motor.from_twist(0.01 * rng.standard_normal((1, 6)))
    measured = pose @ extrinsics @ off

    def residual(step: FloatArray) -> FloatArray:
        there = moved(pose.coefficients, step[:6] + step[6] * twist)
        # A larger scale of the measurements, seen in their own units, is a smaller place.
        seen = (
            Motor(there) @ Motor(moved(extrinsics.coefficients, step[7:13]))
        ).coefficients.copy()
        seen[:, 4:] *= np.exp(-step[13])
        none = Motor.identity().coefficients
        return pose_residuals(seen, twist, none, measured.coefficients)[0][0]

    slope = pose_residuals(
        pose.coefficients, twist, extrinsics.coefficients, measured.coefficients
    )[1]
    numeric = np.stack(
        [(residual(one) - residual(-one)) / 2e-6 for one in 1e-6 * np.eye(14)], axis=-1
    )
    np.testing.assert_allclose(slope[0], numeric, atol=1e-7)
    found = residual(np.zeros(14))
    np.testing.assert_allclose(found, -off.as_twist()[0], atol=2e-6)


def test_states_that_nothing_determines_are_refused(rng):
    """The second of three unknowns of each state stands in no residual."""
    equations = Bordered(4, 3, 1)
    own = rng.standard_normal((4, 5, 3)) * [1.0, 0.0, 1.0]
    equations.add_states(rng.standard_normal((4, 5)), own, rng.standard_normal((4, 5, 1)))
    with pytest.raises(ValueError, match="expected motion that determines the states, got too"):
        equations.solve(np.array([True]))


@pytest.mark.parametrize("count", range(1, 8))
def test_a_chain_is_solved_and_inverted_as_its_dense_matrix(rng, count):
    root = np.tril(np.triu(rng.standard_normal((3 * count, 3 * count)), -5))
    for k in range(count):  # states touch their neighbours only
        root[3 * k : 3 * k + 3, : 3 * max(k - 1, 0)] = 0.0
    matrix = root @ root.T + np.eye(3 * count)
    blocks = matrix.reshape(count, 3, count, 3).swapaxes(1, 2)
    dense = np.linalg.inv(matrix).reshape(count, 3, count, 3).swapaxes(1, 2)
    rows = np.arange(count)
    factor = ChainFactor(blocks[rows, rows], blocks[rows[1:], rows[:-1]])
    right = rng.standard_normal((count, 3, 2))
    solved = np.linalg.solve(matrix, right.reshape(-1, 2)).reshape(right.shape)
    np.testing.assert_allclose(factor.solve(right), solved, atol=1e-12)
    own, cross = factor.inverse_blocks()
    np.testing.assert_allclose(own, dense[rows, rows], atol=1e-12)
    np.testing.assert_allclose(cross, dense[rows[1:], rows[:-1]], atol=1e-12)


@pytest.mark.parametrize("free", [[True, True], [True, False]])
def test_the_chain_is_solved_as_the_dense_system(rng, free):
    count, size, shared = 5, 3, 2
    own, by_shared = rng.standard_normal((count, 4, size)), rng.standard_normal((count, 4, shared))
    start, end = rng.standard_normal((2, count - 1, 3, size))
    between = rng.standard_normal((count - 1, 3, shared))
    first, second = rng.standard_normal((count, 4)), rng.standard_normal((count - 1, 3))
    equations = Bordered(count, size, shared)
    equations.add_states(first, own, by_shared)
    equations.add_intervals(0, second[:2], start[:2], end[:2], between[:2])
    equations.add_intervals(2, second[2:], start[2:], end[2:], between[2:])
    solved = equations.solve(np.array(free))

    rows = []
    for k in range(count):
        block = np.zeros((4, count * size + shared))
        block[:, k * size : (k + 1) * size], block[:, -shared:] = own[k], by_shared[k]
        rows.append(block)
    for k in range(count - 1):
        block = np.zeros((3, count * size + shared))
        block[:, k * size : (k + 1) * size] = start[k]
        block[:, (k + 1) * size : (k + 2) * size], block[:, -shared:] = end[k], between[k]
        rows.append(block)
    matrix = np.concatenate(rows)
    kept = np.append(np.ones(count * size, dtype=bool), free)
    residual = np.concatenate([first.ravel(), second.ravel()])
    expected = np.linalg.lstsq(matrix[:, kept], -residual, rcond=None)[0]
    np.testing.assert_allclose(solved.states.ravel(), expected[: count * size])
    np.testing.assert_allclose(solved.shared[free], expected[count * size :])
    covariance = np.linalg.inv(matrix[:, kept].T @ matrix[:, kept])
    np.testing.assert_allclose(
        solved.covariance[np.ix_(free, free)], covariance[count * size :, count * size :]
    )
    intervals = np.concatenate(rows[count:])[:, kept]
    spread = (intervals @ covariance @ intervals.T).reshape(count - 1, 3, count - 1, 3)
    found = solved.interval_covariance(start, end, between)
    for k in range(count - 1):
        np.testing.assert_allclose(found[k], spread[k, :, k])
