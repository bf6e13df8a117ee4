"""Classical poses with the versors' verbs: which laws hold, which do not, what is refused."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pytransform3d import transformations
from scipy.spatial.transform import Rotation

from motorcade.ga import DualQuaternion, EulerPose, Motor, QuaternionPose, Rotor
from motorcade.ga.classical import Pose
from motorcade.ga.versors.euler_angles import SEQUENCES, euler_from_matrix, matrix_from_euler

AnyPose = QuaternionPose | DualQuaternion | EulerPose
ROUNDING = 2e-14
CLASSICAL: dict[str, Callable[[Motor], AnyPose]] = {
    "quaternion": lambda m: QuaternionPose.from_quaternion_translation(
        *m.as_quaternion_translation()
    ),
    "dual quaternion": lambda m: DualQuaternion.from_quaternion_translation(
        *m.as_quaternion_translation()
    ),
    "euler xyz": lambda m: EulerPose.from_quaternion_translation(*m.as_quaternion_translation()),
    "euler zxz extrinsic": lambda m: EulerPose.from_quaternion_translation(
        *m.as_quaternion_translation(), "zxz", True
    ),
}
ANGLES_OFF = 1e-12  # Euler angles lose digits towards gimbal lock


def off(a: Any, b: Any) -> float:
    """Largest difference of matrix entries, relative to translations beyond 1 m."""
    one, two = a.as_matrix(), b.as_matrix()
    return float(np.max(np.abs(one - two), initial=0.0) / np.max(np.abs(one), initial=1.0))


@pytest.fixture(params=CLASSICAL)
def classical(request: pytest.FixtureRequest) -> Callable[[Motor], AnyPose]:
    return CLASSICAL[request.param]


@pytest.fixture
def poses(classical: Callable[[Motor], AnyPose], motors: Motor) -> AnyPose:
    return classical(motors)


@pytest.fixture
def kind(classical: Callable[[Motor], AnyPose]) -> AnyPose:
    """Any one pose, for verbs that need no particular one."""
    return classical(Motor.from_euler_translation([0.3, -0.4, 1.1], [1.0, 2.0, 3.0]))


def test_conversions_agree_with_the_motor(poses: AnyPose, motors: Motor) -> None:
    assert off(poses, motors) < ROUNDING
    again = Motor.from_quaternion_translation(*poses.as_quaternion_translation())
    assert off(again, motors) < ROUNDING
    fields = {k: v for k, v in vars(poses).items() if k != "coefficients"}
    assert off(type(poses).from_matrix(poses.as_matrix(), **fields), motors) < ROUNDING


def test_composition_inverse_and_action_agree_with_the_motor(
    classical: Callable[[Motor], AnyPose], motors: Motor, rng: np.random.Generator
) -> None:
    other = Motor.random(rng, motors.shape)
    assert off(classical(motors) @ classical(other), motors @ other) < ROUNDING
    assert off(classical(motors).inverse(), motors.inverse()) < ROUNDING
    points = rng.standard_normal((*motors.shape, 3))
    moved = motors.apply(points)
    size = max(1.0, float(np.max(np.abs(moved))))
    assert np.max(np.abs(classical(motors).apply(points) - moved)) < ROUNDING * size


def test_exp_undoes_log(poses: AnyPose) -> None:
    fields = {k: v for k, v in vars(poses).items() if k != "coefficients"}
    assert off(type(poses).exp(poses.log(), **fields), poses) < ROUNDING


def test_products_are_associative_and_inverses_cancel(
    classical: Callable[[Motor], AnyPose], motors: Motor, rng: np.random.Generator
) -> None:
    a, b = classical(motors), classical(Motor.random(rng, motors.shape))
    assert off((a @ b) @ a, a @ (b @ a)) < ANGLES_OFF
    size = float(np.max(np.abs(a.as_matrix()), initial=1.0))
    for product in (a @ a.inverse(), a.inverse() @ a):
        assert np.max(np.abs(product.as_matrix() - np.eye(4))) < ROUNDING * size


def test_interpolation_meets_its_ends(
    classical: Callable[[Motor], AnyPose], motors: Motor, rng: np.random.Generator
) -> None:
    a, b = classical(Motor.random(rng, motors.shape)), classical(motors)
    assert off(a.interpolate(b, 0.0), a) < ROUNDING
    assert off(a.interpolate(b, 1.0), b) < ROUNDING
    for method in {QuaternionPose: ["nlerp"], DualQuaternion: ["linear"]}.get(type(a), []):
        assert isinstance(a, QuaternionPose | DualQuaternion)
        assert off(a.interpolate(b, 0.0, method=method), a) < ROUNDING
        assert off(a.interpolate(b, 1.0, method=method), b) < ROUNDING


def test_local_undoes_retract_up_to_half_a_turn(poses: AnyPose, rng: np.random.Generator) -> None:
    size = max(1.0, float(np.max(np.abs(poses.coefficients))))
    for angle in (1e-12, 1e-6, 0.1, 1.0, 3.1):
        step = rng.uniform(-1.0, 1.0, (*poses.shape, 6))
        step[..., :3] *= angle / np.linalg.norm(step[..., :3], axis=-1, keepdims=True)
        assert np.max(np.abs(poses.local(poses.retract(step)) - step)) < 4e-14 * size


def test_retract_undoes_local_and_a_part_of_it_interpolates(
    classical: Callable[[Motor], AnyPose], motors: Motor, rng: np.random.Generator
) -> None:
    a, b = classical(Motor.random(rng, motors.shape)), classical(motors)
    assert off(a.retract(a.local(b)), b) < ROUNDING
    assert off(a.retract(0.3 * a.local(b)), a.interpolate(b, 0.3)) < 1e-13


def test_steps_are_the_motors_where_the_kinds_agree(rng: np.random.Generator) -> None:
    a, b, one, two = pair("dual quaternion", rng)
    np.testing.assert_allclose(one.local(two), a.local(b), rtol=0, atol=1e-13)
    a, b, one, two = pair("quaternion", rng)
    apart = np.hstack([a.local(b)[:, :3], b.translation_m - a.translation_m])
    np.testing.assert_allclose(one.local(two), apart, rtol=0, atol=1e-13)


def pair(classical: str, rng: np.random.Generator) -> tuple[Motor, Motor, AnyPose, AnyPose]:
    a, b = Motor.random(rng, (30,)), Motor.random(rng, (30,))
    return a, b, CLASSICAL[classical](a), CLASSICAL[classical](b)


@pytest.mark.parametrize(
    ("name", "holds"), [("quaternion", True), ("dual quaternion", True), ("euler xyz", False)]
)
def test_left_invariance(name: str, holds: bool, rng: np.random.Generator) -> None:
    a, b, one, two = pair(name, rng)
    moved = Motor.random(rng)
    path = CLASSICAL[name](moved) @ one.interpolate(two, 0.3)
    again = CLASSICAL[name](moved @ a).interpolate(CLASSICAL[name](moved @ b), 0.3)
    assert off(path, again) < ANGLES_OFF if holds else off(path, again) > 0.1


@pytest.mark.parametrize(
    ("name", "holds"), [("quaternion", False), ("dual quaternion", True), ("euler xyz", False)]
)
def test_right_invariance(name: str, holds: bool, rng: np.random.Generator) -> None:
    a, b, one, two = pair(name, rng)
    mount = Motor.random(rng)
    path = one.interpolate(two, 0.3) @ CLASSICAL[name](mount)
    again = CLASSICAL[name](a @ mount).interpolate(CLASSICAL[name](b @ mount), 0.3)
    assert off(path, again) < ANGLES_OFF if holds else off(path, again) > 0.1


def test_the_screw_is_the_motors_and_pytransform3ds(rng: np.random.Generator) -> None:
    a, b, one, two = pair("dual quaternion", rng)
    path = one.interpolate(two, np.linspace(0, 1, 5)[:, None])
    assert off(path, a.interpolate(b, np.linspace(0, 1, 5)[:, None])) < 1e-13
    start, end = one[0].coefficients, two[0].coefficients
    end = -end if start[:4] @ end[:4] < 0 else end
    witness = transformations.dual_quaternion_sclerp(start, end, 0.25)
    np.testing.assert_allclose(path[1, 0].coefficients, witness, rtol=0, atol=1e-13)


def test_the_screw_has_even_speed_and_the_linear_blend_almost(rng: np.random.Generator) -> None:
    _, _, one, two = pair("dual quaternion", rng)
    fractions = np.linspace(0, 1, 9)[:, None]

    def speeds(method: str) -> np.ndarray:
        assert isinstance(one, DualQuaternion)
        assert isinstance(two, DualQuaternion)
        path = one.interpolate(two, fractions, method=method)
        steps = (path[:-1].inverse() @ path[1:]).log()
        size: np.ndarray = np.linalg.norm(steps[..., :3], axis=-1)
        return size / size.mean(axis=0) - 1.0

    assert np.max(np.abs(speeds("screw"))) < 1e-12
    assert 1e-3 < np.max(np.abs(speeds("linear"))) < 0.4


def test_quaternion_poses_go_straight(rng: np.random.Generator) -> None:
    a, b, one, two = pair("quaternion", rng)
    middle = one.interpolate(two, 0.3)
    straight = 0.7 * a.translation_m + 0.3 * b.translation_m
    np.testing.assert_allclose(middle.as_matrix()[:, :3, 3], straight, rtol=0, atol=1e-14)
    rotor = a.rotor.interpolate(b.rotor, 0.3)
    np.testing.assert_allclose(middle.as_matrix()[:, :3, :3], rotor.as_matrix(), rtol=0, atol=1e-13)


@pytest.mark.parametrize("extrinsic", [False, True])
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_scipy_reads_the_same_angles(
    sequence: str, extrinsic: bool, rng: np.random.Generator
) -> None:
    angles = rng.uniform(-3, 3, (50, 3))
    # scipy writes intrinsic sequences with capitals.
    letters = sequence if extrinsic else sequence.upper()
    witness = Rotation.from_euler(letters, angles)
    ours = matrix_from_euler(angles, sequence, extrinsic)
    np.testing.assert_allclose(ours, witness.as_matrix(), rtol=0, atol=1e-14)
    back = euler_from_matrix(ours, sequence, extrinsic)
    np.testing.assert_allclose(back, witness.as_euler(letters), rtol=0, atol=1e-12)
    pose = EulerPose.from_matrix(Motor.identity((50,)).as_matrix(), sequence, extrinsic)
    turned = EulerPose(np.concatenate([angles, np.ones((50, 3))], -1), sequence, extrinsic)
    assert off(pose @ turned, turned) < ROUNDING
    assert off(EulerPose.normalize(turned.coefficients, sequence, extrinsic), turned) < ROUNDING


@pytest.mark.parametrize("extrinsic", [False, True])
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angles_at_gimbal_lock_still_give_the_rotation(
    sequence: str, extrinsic: bool, rng: np.random.Generator
) -> None:
    angles = rng.uniform(-3, 3, (20, 3))
    angles[:, 1] = 0.0 if sequence[0] == sequence[2] else np.pi / 2
    matrix = matrix_from_euler(angles, sequence, extrinsic)
    back = matrix_from_euler(euler_from_matrix(matrix, sequence, extrinsic), sequence, extrinsic)
    np.testing.assert_allclose(back, matrix, rtol=0, atol=1e-14)


def test_euler_angles_wrap_only_when_asked() -> None:
    almost = EulerPose(np.deg2rad([179.0, 0, 0, 0, 0, 0]))
    beyond = EulerPose(np.deg2rad([-179.0, 0, 0, 0, 0, 0]))
    assert almost.interpolate(beyond, 0.5).angles_rad[0] == pytest.approx(0.0, abs=1e-15)
    short = almost.interpolate(beyond, 0.5, short_way=True).angles_rad[0]
    assert short == pytest.approx(np.pi)


def test_blending_two_is_interpolating(rng: np.random.Generator) -> None:
    cases = (("quaternion", "nlerp"), ("dual quaternion", "linear"), ("euler xyz", None))
    for name, method in cases:
        _, _, one, two = pair(name, rng)
        both = type(one)(np.stack([one.coefficients, two.coefficients], axis=1))
        extra = {} if method is None else {"method": method}
        witness = one.interpolate(two, 0.3, **extra)
        assert off(both.blend([1.4, 0.6]), witness) < 1e-12


# Refusals --------------------------------------------------------------------------------------


def test_wrong_dimensions_nan_and_zero_are_refused(kind: AnyPose) -> None:
    make, size = type(kind), kind.coefficients.size
    with pytest.raises(ValueError, match=rf"{make.__name__}.coefficients: expected shape"):
        make(np.zeros(size + 1))
    for bad in (np.nan, np.inf):
        broken = kind.coefficients.copy()
        broken[0] = bad
        with pytest.raises(ValueError, match="expected finite numbers"):
            make(broken)
        with pytest.raises(ValueError, match="expected finite numbers"):
            make.exp(np.full(6, bad))
        with pytest.raises(ValueError, match="expected finite numbers"):
            kind.interpolate(kind, bad)
        with pytest.raises(ValueError, match="expected finite numbers"):
            kind.apply([0.0, bad, 0.0])
        with pytest.raises(ValueError, match="expected finite numbers"):
            kind.retract(np.full(6, bad))
    with pytest.raises(ValueError, match=r"retract\(step\): expected shape \(\*, 6\)"):
        kind.retract(np.zeros(7))
    with pytest.raises(ValueError, match=r"apply\(points\): expected shape \(\*, 3\)"):
        kind.apply([1.0, 2.0])
    if not isinstance(kind, EulerPose):
        with pytest.raises(ValueError, match="expected unit"):
            make(np.zeros(size))
        with pytest.raises(ValueError, match="non-zero"):
            make.normalize(np.zeros(size))
        made = make.normalize(3.0 * kind.coefficients)
        assert off(made.inverse() @ made, make.identity()) < ROUNDING


def test_dual_parts_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="expected unit dual quaternions"):
        DualQuaternion([1, 0, 0, 0, 0.1, 0, 0, 0])


def test_types_and_sequences_do_not_mix(rng: np.random.Generator) -> None:
    one, two = QuaternionPose.random(rng), DualQuaternion.random(rng)
    for a, b in ((one, two), (two, Motor.random(rng)), (one, np.eye(4)), (np.eye(4), one)):
        with pytest.raises(TypeError):
            a @ b
    with pytest.raises(TypeError, match="expected two poses of type QuaternionPose"):
        one.interpolate(two, 0.5)
    with pytest.raises(TypeError, match="expected two poses of type QuaternionPose"):
        one.local(two)
    angles = EulerPose.random(rng)
    for other in (EulerPose.random(rng, sequence="zyx"), EulerPose.random(rng, extrinsic=True)):
        with pytest.raises(ValueError, match="expected two poses of one sequence"):
            angles @ other
        with pytest.raises(ValueError, match="expected two poses of one sequence"):
            angles.interpolate(other, 0.5)
        with pytest.raises(ValueError, match="expected two poses of one sequence"):
            angles.local(other)
        with pytest.raises(ValueError, match="expected two poses of one sequence"):
            EulerPose.stack([angles, other])


@pytest.mark.parametrize("sequence", ["", "xy", "xxy", "XYZ", "abc"])
def test_unknown_sequences_are_refused(sequence: str) -> None:
    with pytest.raises(ValueError, match="sequence: expected one of xyz"):
        EulerPose(np.zeros(6), sequence)
    with pytest.raises(ValueError, match="sequence: expected one of xyz"):
        euler_from_matrix(np.eye(3), sequence, extrinsic=True)


def test_unknown_methods_are_refused(rng: np.random.Generator) -> None:
    for one in (QuaternionPose.random(rng), DualQuaternion.random(rng)):
        with pytest.raises(ValueError, match=r"interpolate\(method\): expected one of"):
            one.interpolate(one, 0.5, method="cubic")


def test_batches_broadcast_or_are_refused(
    classical: Callable[[Motor], AnyPose], rng: np.random.Generator
) -> None:
    three, four = classical(Motor.random(rng, (3,))), classical(Motor.random(rng, (4,)))
    for act in (
        lambda: three @ four,
        lambda: three.interpolate(four, 0.5),
        lambda: three.apply(np.zeros((4, 3))),
        lambda: three.interpolate(three, [0, 1]),
        lambda: three.local(four),
        lambda: three.retract(np.zeros((4, 6))),
        lambda: three.blend(np.ones(5)),
    ):
        with pytest.raises(ValueError, match="expected"):
            act()
    assert (three.reshape(3, 1) @ four).shape == (3, 4)
    assert three.reshape(3, 1).interpolate(four, np.ones((2, 1, 1))).shape == (2, 3, 4)
    assert three.reshape(3, 1).local(four).shape == (3, 4, 6)
    assert three.reshape(3, 1).retract(np.ones((2, 1, 4, 6))).shape == (2, 3, 4)
    with pytest.raises(ValueError, match="sums other than 0"):
        three.blend([1.0, -1.0, 0.0])


def test_empty_batches_pass_through_every_verb(classical: Callable[[Motor], AnyPose]) -> None:
    none = classical(Motor.identity((0, 4)))
    assert none.log().shape == (0, 4, 6)
    assert (none @ none.inverse()).interpolate(none, 0.5).shape == (0, 4)
    assert none.apply(np.zeros((0, 4, 3))).shape == (0, 4, 3)
    assert none.as_matrix().shape == (0, 4, 4, 4)
    assert none.blend(np.ones(4)).shape == (0,)
    assert none.retract(none.local(none)).shape == (0, 4)


def test_values_are_frozen_and_batches_behave_as_arrays(
    classical: Callable[[Motor], AnyPose], rng: np.random.Generator
) -> None:
    batch = classical(Motor.random(rng, (4, 3)))
    rows = list(batch)
    assert len(batch) == len(rows) == 4
    make: type[Pose] = type(batch)
    np.testing.assert_array_equal(make.stack(rows).coefficients, batch.coefficients)
    joined = make.concatenate(rows)
    np.testing.assert_array_equal(joined.coefficients, batch.reshape(12).coefficients)
    for one in (
        batch,
        batch @ batch,
        batch[1],
        joined,
        batch.inverse(),
        copy.deepcopy(batch),
        pickle.loads(pickle.dumps(batch)),
        batch.interpolate(batch, 0.5),
    ):
        assert vars(one).keys() == vars(batch).keys()
        with pytest.raises(ValueError, match="read-only"):
            one.coefficients[..., 0] = 2.0
    with pytest.raises(AttributeError):
        batch.coefficients = batch.coefficients
    strided = np.repeat(batch.coefficients, 2, axis=-1)[::-1, :, ::2]
    strided.setflags(write=False)
    fields = {k: v for k, v in vars(batch).items() if k != "coefficients"}
    np.testing.assert_array_equal(
        type(batch)(strided, **fields).coefficients, batch.coefficients[::-1]
    )
    with pytest.raises(TypeError, match="has no length"):
        len(batch[0, 0])
    with pytest.raises(IndexError, match="has no batch"):
        batch[0, 0][0]
    with pytest.raises(ValueError, match="expected one or more, got none"):
        make.stack([])
    with pytest.raises(ValueError, match="stack joins single ones"):
        make.concatenate([batch[0, 0]])


def test_euler_poses_are_intrinsic_xyz_unless_said(rng: np.random.Generator) -> None:
    wxyz, t = Rotor.random(rng, (3,)).as_quaternion(), rng.standard_normal((3, 3))
    given = EulerPose.from_quaternion_translation(wxyz, t)
    made = [
        given,
        EulerPose.identity((3,)),
        EulerPose.random(rng, (3,)),
        EulerPose.normalize(given.coefficients),
        EulerPose.exp(given.log()),
        EulerPose.from_matrix(given.as_matrix()),
        EulerPose(given.coefficients),
    ]
    assert {(pose.sequence, pose.extrinsic) for pose in made} == {("xyz", False)}
    witness = Rotation.from_euler("XYZ", given.angles_rad).as_matrix()
    np.testing.assert_allclose(given.as_matrix()[:, :3, :3], witness, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(EulerPose.identity((2,)).coefficients, np.zeros((2, 6)))
