"""Interpolation of versors is the screw between them, whatever the frame and the sign."""

from collections.abc import Callable

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Versor

Distance = Callable[[Versor, Versor], float]
ROUNDING = 5e-14


def test_endpoints_are_met(versors: Versor, others: Versor, distance: Distance) -> None:
    assert distance(others.interpolate(versors, 0.0), others) < ROUNDING
    assert distance(others.interpolate(versors, 1.0), versors) < ROUNDING


def test_a_versor_and_itself_have_nothing_between(versors: Versor, distance: Distance) -> None:
    assert distance(versors.interpolate(versors, 0.3), versors) < ROUNDING


def test_speed_along_the_screw_is_constant(versors: Versor) -> None:
    start = type(versors).identity(versors.shape)
    fractions = np.linspace(0, 1, 11).reshape(11, *(1 for _ in versors.shape))
    path = start.interpolate(versors, fractions)
    steps = (path[:-1].inverse() @ path[1:]).log()
    scale = max(1.0, float(np.max(np.abs(steps))))
    np.testing.assert_allclose(
        steps, np.broadcast_to(steps[:1], steps.shape), rtol=0, atol=ROUNDING * scale
    )


def test_the_path_is_a_tenth_of_the_logarithm_at_a_tenth(versors: Versor) -> None:
    part = type(versors).identity(versors.shape).interpolate(versors, 0.1)
    scale = max(1.0, float(np.max(np.abs(versors.log()))))
    np.testing.assert_allclose(part.log(), 0.1 * versors.log(), rtol=0, atol=ROUNDING * scale)


def test_moving_the_world_moves_the_path(
    kind: type[Versor], rng: np.random.Generator, distance: Distance
) -> None:
    a, b, moved = (kind.random(rng, (30,)) for _ in range(3))
    fraction = rng.uniform(-0.5, 1.5, 30)
    path = a.interpolate(b, fraction)
    assert distance((moved @ a).interpolate(moved @ b, fraction), moved @ path) < ROUNDING


def test_moving_the_body_frame_moves_the_path(
    kind: type[Versor], rng: np.random.Generator, distance: Distance
) -> None:
    a, b, mount = (kind.random(rng, (30,)) for _ in range(3))
    fraction = rng.uniform(-0.5, 1.5, 30)
    path = a.interpolate(b, fraction)
    assert distance((a @ mount).interpolate(b @ mount, fraction), path @ mount) < ROUNDING


def test_the_path_moves_with_both_frames_on_hard_samples(
    versors: Versor, others: Versor, distance: Distance, rng: np.random.Generator
) -> None:
    left, right = (type(versors).random(rng) for _ in range(2))
    path = left @ others.interpolate(versors, 0.3) @ right
    again = (left @ others @ right).interpolate(left @ versors @ right, 0.3)
    assert distance(again, path) < 10 * ROUNDING


def test_near_neighbours_keep_their_distance_from_each_other(
    versors: Versor, distance: Distance
) -> None:
    # From a versor to itself moved by next to nothing, seen from either side.
    size = versors.log().shape[-1]
    for step in (1e-12, 1e-9, 1e-5):
        nudge = type(versors).exp(np.full(size, step))
        path = versors.interpolate(versors @ nudge, 0.25)
        assert distance(path, versors @ type(versors).exp(np.full(size, 0.25 * step))) < ROUNDING


def test_back_and_forth_are_one_path(
    kind: type[Versor], rng: np.random.Generator, distance: Distance
) -> None:
    a, b = kind.random(rng, (30,)), kind.random(rng, (30,))
    assert distance(b.interpolate(a, 0.7), a.interpolate(b, 0.3)) < ROUNDING


def test_the_short_way_is_taken_whatever_the_signs(
    kind: type[Versor], rng: np.random.Generator, distance: Distance
) -> None:
    a, b = kind.random(rng, (50,)), kind.random(rng, (50,))
    opposite = kind(-b.coefficients)
    assert distance(a.interpolate(opposite, 0.4), a.interpolate(b, 0.4)) < ROUNDING
    step = (a.inverse() @ a.interpolate(b, 1e-3)).log()
    assert np.all(2 * np.linalg.norm(step[:, :3], axis=1) <= 1e-3 * np.pi + 1e-12)


def test_the_long_way_turns_by_the_rest_of_the_circle() -> None:
    start, end = Rotor.identity(), Rotor.from_rotation_vector([0.0, 0.0, 1.0])
    opposite = Rotor(-end.coefficients)
    halfway = start.interpolate(opposite, 0.5, short_way=False)
    expected = Rotor.from_rotation_vector([0.0, 0.0, (1.0 - 2 * np.pi) / 2])
    np.testing.assert_allclose(halfway.as_matrix(), expected.as_matrix(), rtol=0, atol=1e-15)
    near = start.interpolate(end, 0.5, short_way=False)
    np.testing.assert_allclose(near.as_rotation_vector(), [0, 0, 0.5], rtol=0, atol=1e-15)


def test_antipodal_pairs_do_not_move(versors: Versor, distance: Distance) -> None:
    opposite = type(versors)(-versors.coefficients)
    assert distance(versors.interpolate(opposite, 0.5), versors) < ROUNDING


def test_the_long_way_between_opposite_signs_is_refused(versors: Versor) -> None:
    opposite = type(versors)(-versors.coefficients)
    with pytest.raises(ValueError, match="expected a defined axis"):
        versors.interpolate(opposite, 0.5, short_way=False)


def test_half_a_turn_is_followed_one_way_or_the_other() -> None:
    end = Rotor.from_quaternion([0.0, 1.0, 0.0, 0.0])
    halfway = Rotor.identity().interpolate(end, 0.5)
    np.testing.assert_allclose(np.abs(halfway.as_rotation_vector()), [np.pi / 2, 0, 0], atol=1e-15)


def test_fractions_broadcast_against_both_ends(rng: np.random.Generator) -> None:
    a, b = Motor.random(rng, (5, 1)), Motor.random(rng)
    path = a.interpolate(b, np.linspace(0, 1, 7))
    assert path.shape == (5, 7)
    np.testing.assert_allclose(
        path[2, 3].coefficients, a[2, 0].interpolate(b, 0.5).coefficients, rtol=0, atol=1e-15
    )


def test_motors_follow_the_straight_line_where_nothing_turns(rng: np.random.Generator) -> None:
    start, end = rng.standard_normal((2, 20, 3))
    still = Rotor.identity((20,))
    path = Motor.from_rotor_translation(still, start).interpolate(
        Motor.from_rotor_translation(still, end), 0.25
    )
    np.testing.assert_allclose(path.translation_m, 0.75 * start + 0.25 * end, rtol=0, atol=1e-15)


def test_geodesics_are_never_longer_than_the_angle_between(rng: np.random.Generator) -> None:
    a, b = Rotor.random(rng, (200,)), Rotor.random(rng, (200,))
    path = a.interpolate(b, np.linspace(0, 1, 101)[:, None])
    travelled = (path[:-1].inverse() @ path[1:]).angle().sum(axis=0)
    np.testing.assert_allclose(travelled, (a.inverse() @ b).angle(), rtol=0, atol=1e-12)
