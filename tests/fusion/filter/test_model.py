"""The symbolic model: its C is current, its derivatives are those of functions on the manifold."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.filter.extended_pose import corrected, extended_pose
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from tests.fusion.filter.by_hand import GRAVITY, Intervals, increments, moved, transitions

pytest.importorskip("casadi")

from motorcade.fusion.filter.model.__main__ import GENERATED, model_files
from motorcade.fusion.filter.model.definitions import MEASUREMENTS, MOTION

Call = Callable[..., list[FloatArray]]


@pytest.fixture(scope="module")
def call(tmp_path_factory: pytest.TempPathFactory) -> Call:
    """Calls a generated C function, compiled apart from the filter, by name."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = tmp_path_factory.mktemp("model") / "model.so"
    sources = [str(GENERATED / "motion.c"), str(GENERATED / "measurements.c")]
    flags = ["-O1", "-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, "-o", str(library), *sources, "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))
    known = {definition.name: definition for definition in (*MOTION, *MEASUREMENTS)}

    def run(name: str, *given: Any) -> list[FloatArray]:
        definition = known["motorcade_" + name]
        arguments: list[Any] = []
        for operand, value in zip(definition.inputs, given, strict=True):
            numbers = np.ascontiguousarray(value, dtype=np.float64).ravel()
            assert numbers.size == operand.width, operand.name
            arguments.append(
                ctypes.c_double(float(numbers[0]))
                if operand.width == 1
                else (ctypes.c_double * operand.width)(*numbers)
            )
        made = [(ctypes.c_double * operand.width)() for operand in definition.outputs]
        getattr(loaded, definition.name)(*arguments, *made)
        return [np.array(values) for values in made]

    return run


def numeric(function: Callable[[FloatArray], FloatArray], size: int, step: float) -> FloatArray:
    """Central differences at zero, of a function that is zero or any value there."""
    columns = [
        (function(step * axis) - function(-step * axis)) / (2.0 * step) for axis in np.eye(size)
    ]
    return np.stack(columns, axis=-1)


def motor_with(rng: np.random.Generator, turn: float = 2.0) -> Motor:
    return Motor.from_twist(rng.normal(0.0, turn, 6))


def test_the_generated_code_is_current() -> None:
    assert {path.name for path in GENERATED.iterdir()} == set(model_files())
    for name, text in model_files().items():
        assert (GENERATED / name).read_text(encoding="utf-8") == text, (
            f"{name} is old: run python -m motorcade.fusion.filter.model"
        )


def stepped(
    call: Call, pose: Motor, bias: FloatArray, rate: FloatArray, force: FloatArray, dt: float
) -> Motor:
    """The extended pose ``(2,)`` after a step."""
    moved, velocity = call(
        "step", pose[0].coefficients, pose[1].translation_m, bias, rate, force, dt, GRAVITY
    )
    made = Motor(moved)
    return extended_pose(made.rotor, made.translation_m, velocity)


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-4, 0.1, 1.0, 2.9])
def test_a_step_is_that_of_the_increments_at_every_turn(rng, call, size):
    """Turns up to the limit of 3 rad; rotations by matrices of sines and cosines there."""
    for _ in range(5):
        axis = rng.standard_normal(3)
        bias, force, dt = 0.1 * rng.standard_normal(6), 8.0 * rng.standard_normal(3), 0.4
        rate = size * axis / np.linalg.norm(axis) / dt + bias[:3]
        pose = extended_pose(Rotor.random(rng), *(3.0 * rng.standard_normal((2, 3))))
        data = Intervals(np.array([dt]), rate[None], force[None])
        theirs = moved(pose, bias, data)
        ours = stepped(call, pose, bias, rate, force, dt)
        np.testing.assert_allclose((theirs.inverse() @ ours).as_twist(), 0.0, atol=2e-12)


def transition_of(
    call: Call, bias: FloatArray, rate: FloatArray, force: FloatArray, dt: float
) -> FloatArray:
    """The matrix (15, 15) that the blocks stand for."""
    parts = [block.reshape(3, 3) for block in call("transition", bias, rate, force, dt)]
    matrix = np.eye(15)
    for k, place in enumerate(((0, 0), (3, 0), (6, 0), (0, 9), (3, 9), (6, 9), (3, 12), (6, 12))):
        matrix[place[0] : place[0] + 3, place[1] : place[1] + 3] = parts[k]
    matrix[3:6, 3:6] = matrix[6:9, 6:9] = parts[0]
    matrix[3:6, 6:9] = dt * parts[0]
    return matrix


@pytest.mark.parametrize("dt", [0.005, 0.01, 0.3])
def test_the_transition_is_the_derivative_of_a_step_wherever_it_starts(rng, call, dt):
    """By differences of errors on the manifold, from a state that the derivation did not use."""
    bias, rate = 0.1 * rng.standard_normal(6), rng.standard_normal(3)
    force = rng.normal([0.0, 0.0, 9.8], 4.0)
    pose = extended_pose(Rotor.random(rng), *(5.0 * rng.standard_normal((2, 3))))
    end = stepped(call, pose, bias, rate, force, dt)

    def after(error: FloatArray) -> FloatArray:
        moved = stepped(call, corrected(pose, error), bias + error[9:], rate, force, dt)
        twists = (end.inverse() @ moved).as_twist()
        return np.concatenate([twists[0], twists[1, 3:], error[9:]])

    matrix = transition_of(call, bias, rate, force, dt)
    np.testing.assert_allclose(matrix, numeric(after, 15, 1e-5), atol=3e-8)


def test_the_transition_agrees_with_the_formulas_by_hand(rng, call):
    """Those leave out how a bias of the gyroscope turns the force at higher orders."""
    for dt in (1e-3, 0.005):
        bias, rate, force = np.zeros(6), rng.standard_normal(3), rng.normal(0.0, 6.0, 3)
        data = Intervals(np.array([dt]), rate[None], force[None])
        by_hand = transitions(increments(data, bias[:3], bias[3:]))[0]
        np.testing.assert_allclose(
            transition_of(call, bias, rate, force, dt), by_hand, atol=20.0 * dt**3
        )
        exact = np.ones((15, 15), dtype=np.bool_)
        exact[3:9, 9:12] = False
        apart = transition_of(call, bias, rate, force, dt) - by_hand
        assert np.max(np.abs(apart[exact])) < 1e-14


def test_tilting_gravity_moves_velocity_and_position(rng, call):
    pose, plumb = motor_with(rng), Rotor.random(rng)
    (down,) = call("gravity", plumb.coefficients, 9.81)
    np.testing.assert_allclose(down, plumb.apply(GRAVITY), atol=1e-12)
    (effect,) = call("gravity_effect", pose.coefficients, plumb.coefficients, 9.81, 0.02)

    def fallen(tilt: FloatArray) -> FloatArray:
        tilted = plumb @ Rotor.from_rotation_vector([*tilt, 0.0])
        fall: FloatArray = pose.rotor.inverse().apply(tilted.apply(0.02 * GRAVITY))
        return fall

    np.testing.assert_allclose(effect.reshape(3, 2), numeric(fallen, 2, 1e-5), atol=1e-9)


def test_a_pose_is_moved_as_motors_are(rng, call):
    for size in (1e-8, 1e-3, 1.0, 2.5):
        twist = size * rng.standard_normal(9)
        state = extended_pose(Rotor.random(rng), *(4.0 * rng.standard_normal((2, 3))))
        pose, velocity = call("corrected", state[0].coefficients, state[1].translation_m, twist)
        ours = extended_pose(Motor(pose).rotor, Motor(pose).translation_m, velocity)
        theirs = corrected(state, np.concatenate([twist, np.zeros(6)]))
        np.testing.assert_allclose((theirs.inverse() @ ours).as_twist(), 0.0, atol=1e-13)


def test_a_measured_pose(rng, call):
    pose, extrinsics, measured = motor_with(rng), motor_with(rng), motor_with(rng)
    rows = pose.coefficients, extrinsics.coefficients
    (residual,) = call("pose_residual", *rows, measured.coefficients)
    expected = ((pose @ extrinsics).inverse() @ measured).as_twist()
    np.testing.assert_allclose(residual, expected, atol=1e-12)
    (effect,) = call("pose_effect", extrinsics.coefficients)
    np.testing.assert_allclose(effect.reshape(6, 6), extrinsics.inverse().adjoint(), atol=1e-12)

    def seen(error: FloatArray) -> FloatArray:
        moved = pose @ Motor.from_twist(error) @ extrinsics
        twist: FloatArray = ((pose @ extrinsics).inverse() @ moved).as_twist()
        return twist

    np.testing.assert_allclose(effect.reshape(6, 6), numeric(seen, 6, 1e-5), atol=1e-8)
    start, spread = call("start", measured.coefficients, extrinsics.coefficients)
    apart = (Motor(start).inverse() @ measured @ extrinsics.inverse()).as_twist()
    np.testing.assert_allclose(apart, 0.0, atol=1e-12)
    np.testing.assert_allclose(spread.reshape(6, 6), extrinsics.adjoint(), atol=1e-12)


def test_a_measured_point_and_velocity(rng, call):
    pose, arm = motor_with(rng), rng.standard_normal(3)
    at, effect = call("point", pose.coefficients, arm)
    np.testing.assert_allclose(at, pose.apply(arm), atol=1e-12)
    by_hand = numeric(lambda e: (pose @ Motor.from_twist(e)).apply(arm), 6, 1e-5)
    np.testing.assert_allclose(effect.reshape(3, 6), by_hand, atol=1e-8)
    (effect,) = call("velocity_effect", pose.coefficients)
    np.testing.assert_allclose(effect.reshape(3, 3), pose.rotor.as_matrix(), atol=1e-12)


def test_a_corner_through_a_camera(rng, call):
    pose, extrinsics = motor_with(rng, 0.5), motor_with(rng, 0.5)
    point = (pose @ extrinsics).apply(np.array([0.4, -0.3, 2.5]))
    seen, depth, by_pose, by_extrinsics = call(
        "corner", pose.coefficients, extrinsics.coefficients, point
    )
    np.testing.assert_allclose([*seen, *depth], [0.16, -0.12, 2.5], atol=1e-12)

    def through(camera: Motor) -> FloatArray:
        x, y, z = camera.inverse().apply(point)
        return np.array([x / z, y / z])

    moved = numeric(lambda e: through(pose @ Motor.from_twist(e) @ extrinsics), 6, 1e-5)
    shifted = numeric(lambda e: through(pose @ extrinsics @ Motor.from_twist(e)), 6, 1e-5)
    np.testing.assert_allclose(by_pose.reshape(2, 6), moved, atol=1e-8)
    np.testing.assert_allclose(by_extrinsics.reshape(2, 6), shifted, atol=1e-8)
