"""Planar flips over time: the optimum is the optimum, truth is found, the doubt is honest."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import (
    MarkerObservations,
    best_single,
    pose_stream,
    resolve,
)
from motorcade.tracking.markers.disambiguate.resolving import FixedLagResolver, Resolution
from motorcade.tracking.markers.disambiguate.states import (
    chain_probabilities,
    forward_messages,
    most_probable,
)
from tests.bench.tracking.tag_flips import resolve_online


def right_choice(scene, observations: MarkerObservations) -> np.ndarray:
    """The candidate nearest to the true orientation, ``(N,)``."""
    seen = np.isin(_keys(scene.stream), _keys(observations))  # markers nearly edge-on have no pose
    true = scene.camera_T_marker().rotor[seen]
    return np.argmin(
        (true[:, None].inverse() @ observations.camera_T_marker.rotor).angle(), axis=-1
    )


def _keys(detections: CornerStream | MarkerObservations) -> np.ndarray:
    """One number for each detection: its frame and its marker."""
    return detections.frame * 1000 + detections.marker_ids


def wrong(answer: Resolution, scene) -> int:
    return int(np.count_nonzero(answer.choice != right_choice(scene, answer.observations)))


# Chains ------------------------------------------------------------------------------------------


def random_chain(rng, count: int, states: int, batch: tuple[int, ...] = ()):
    first = rng.exponential(1.0, (*batch, states))
    unary = rng.exponential(2.0, (*batch, count, states))
    steps = rng.exponential(2.0, (*batch, count - 1, states, states))
    steps[rng.random(steps.shape) < 0.1] = np.inf
    return first, unary, steps


def total(first, unary, steps, path) -> float:
    cost = first[path[0]] + sum(unary[t, s] for t, s in enumerate(path))
    return cost + sum(steps[t, a, b] for t, (a, b) in enumerate(pairwise(path)))


@pytest.mark.parametrize(("count", "states"), [(1, 2), (2, 3), (6, 2), (5, 4)])
def test_the_most_probable_sequence_is_that_of_all_sequences(count, states, rng) -> None:
    for _ in range(20):
        chain = random_chain(rng, count, states)
        paths = list(product(range(states), repeat=count))
        costs = np.array([total(*chain, path) for path in paths])
        if not np.isfinite(costs).any():
            continue
        assert tuple(most_probable(*chain)) == paths[int(np.argmin(costs))]


@pytest.mark.parametrize(("count", "states"), [(1, 2), (6, 2), (5, 4)])
def test_probabilities_are_sums_over_all_sequences(count, states, rng) -> None:
    chain = random_chain(rng, count, states)
    expected = np.zeros((count, states))
    for path in product(range(states), repeat=count):
        expected[np.arange(count), path] += np.exp(-total(*chain, path))
    expected /= expected.sum(axis=-1, keepdims=True)
    np.testing.assert_allclose(chain_probabilities(*chain), expected, atol=1e-12)
    last = np.exp(-forward_messages(*chain)[-1])
    np.testing.assert_allclose(last / last.sum(), expected[-1], atol=1e-12)


def test_chains_in_a_batch_are_the_single_ones(rng) -> None:
    chain = random_chain(rng, 7, 3, (4, 2))
    for at in np.ndindex(4, 2):
        single = tuple(part[at] for part in chain)
        np.testing.assert_array_equal(most_probable(*chain)[at], most_probable(*single))
        np.testing.assert_allclose(
            chain_probabilities(*chain)[at], chain_probabilities(*single), atol=1e-14
        )


def test_long_chains_neither_over_nor_underflow(rng) -> None:
    first, unary, steps = random_chain(rng, 3000, 2)
    steps = np.where(np.isinf(steps), 3.0, steps)
    found = chain_probabilities(first, 500.0 * unary, 500.0 * steps)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found.sum(axis=-1), 1.0)


def test_chains_whose_shapes_disagree_are_refused(rng) -> None:
    first, unary, steps = random_chain(rng, 4, 2)
    with pytest.raises(ValueError, match="first, steps"):
        most_probable(first, unary, steps[:-1])
    with pytest.raises(ValueError, match="first, steps"):
        chain_probabilities(first[:1], unary, steps)


# Whole recordings --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_time_resolves_what_single_images_cannot(make_scene, seed: int) -> None:
    scene = make_scene(30, 12, seed)
    observations = pose_stream(scene.stream, scene.side_m)
    alone, together = wrong(best_single(observations), scene), wrong(resolve(observations), scene)
    assert alone > 15
    assert together <= 0.1 * alone


@pytest.mark.parametrize("seed", [1, 2])
def test_a_growing_lag_comes_to_agree_with_the_whole_recording(make_scene, seed: int) -> None:
    scene = make_scene(20, 10, seed)
    observations = pose_stream(scene.stream, scene.side_m)
    whole = resolve(observations, 0.3).choice
    apart = [
        np.count_nonzero(resolve_online(observations, lag, 0.3).choice != whole)
        for lag in (0, 4, 20)
    ]
    assert apart[0] >= apart[1] >= apart[2] == 0


def test_the_resolver_answers_each_frame_once_and_in_order(make_scene) -> None:
    scene = make_scene(9, 6, 4)
    observations = pose_stream(scene.stream, scene.side_m)
    resolver = FixedLagResolver(3)
    answers = [resolver.update(observations.of_frames(np.array([row]))) for row in range(9)]
    assert [one is None for one in answers] == [True] * 3 + [False] * 6
    stamps = [one.observations.time_ns[0] for one in [*answers[3:], *resolver.finish()]]
    np.testing.assert_array_equal(stamps, observations.time_ns)
    assert resolver.finish() == ()


def test_what_the_future_holds_does_not_change_an_answer_given(make_scene) -> None:
    scene = make_scene(12, 8, 5)
    observations = pose_stream(scene.stream, scene.side_m)
    early = resolve_online(observations.of_frames(np.arange(8)), 2, 0.3)
    late = resolve_online(observations, 2, 0.3)
    settled = np.count_nonzero(observations.frame < 6)
    np.testing.assert_array_equal(early.choice[:settled], late.choice[:settled])
    np.testing.assert_array_equal(early.probability[:settled], late.probability[:settled])


@pytest.mark.parametrize("seed", [1, 2])
def test_online_what_is_remembered_answers_at_once(make_scene, seed: int) -> None:
    scene = make_scene(40, 10, seed)
    observations = pose_stream(scene.stream, scene.side_m)
    late = observations.frame >= 15
    right = right_choice(scene, observations)
    alone = np.count_nonzero((best_single(observations).choice != right) & late)
    together = np.count_nonzero((resolve_online(observations, 0, 0.3).choice != right) & late)
    assert alone > 50
    assert together <= 0.1 * alone


@pytest.mark.parametrize("seed", [6, 7])
def test_a_marker_that_is_carried_is_resolved_beside_the_others(scenes, seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames, markers = 60, 9
    cameras, still = scenes.path(frames, rng), scenes.wall(markers, rng)
    phase = 2.0 * np.pi * np.linspace(0.0, 1.0, frames)[:, None]
    swing = np.sin(phase * [1.0, 1.5, 0.7]) * [1.0, 0.8, 0.5]
    carried = Rotor.from_rotation_vector(swing) @ still[0].rotor.reshape(1)
    moving = np.tile(still.coefficients, (frames, 1, 1))
    held = Motor.from_rotor_translation(carried, still[0].translation_m + 0.1 * swing)
    moving[:, 0] = held.coefficients
    sides = dict.fromkeys(range(markers), 0.08)
    scene = scenes.seen_by(scenes.camera, cameras, Motor(moving), sides, 0.3, rng)
    observations = pose_stream(scene.stream, sides)
    own = observations.marker_ids == 0
    right = right_choice(scene, observations)
    alone = np.count_nonzero((best_single(observations).choice != right) & own)
    together = np.count_nonzero((resolve(observations).choice != right) & own)
    assert alone > 10
    assert together <= 0.2 * alone


def test_probabilities_come_true_as_often_as_they_say(make_scene) -> None:
    """Few frames and small markers, so that doubt remains; pooled over many scenes."""
    probability, hit = [], []
    for seed in range(60):
        scene = make_scene(1 + seed % 3, 5, 100 + seed, side_m=0.05, noise_px=0.4)
        observations = pose_stream(scene.stream, scene.side_m)
        answer = resolve(observations, 0.4)
        probability.append(answer.probability)
        hit.append(answer.choice == right_choice(scene, observations))
    said, came = np.concatenate(probability), np.concatenate(hit)
    edges = [0.0, 0.7, 0.9, 0.98, 1.01]
    for low, high in pairwise(edges):
        part = (said >= low) & (said < high)
        assert np.count_nonzero(part) > 20
        doubt = np.sqrt(said[part].mean() * (1.0 - said[part].mean()) / np.count_nonzero(part))
        assert abs(came[part].mean() - said[part].mean()) < 3.0 * doubt + 0.05


def test_frames_without_markers_count_as_frames(make_scene) -> None:
    scene = make_scene(8, 6, 9)
    observations = pose_stream(scene.stream, scene.side_m)
    kept = (observations.frame < 3) | (observations.frame > 5)
    thinned = MarkerObservations(
        observations.time_ns,
        observations.frame[kept],
        observations.marker_ids[kept],
        observations.camera_T_marker[kept],
        observations.error_px[kept],
        observations.rotation_covariance[kept],
    )
    for answer in (resolve(thinned), resolve_online(thinned, 0), resolve_online(thinned, 2)):
        assert len(answer.choice) == np.count_nonzero(kept)
    nothing = thinned.of_frames(np.arange(3, 6))
    assert len(resolve(nothing).choice) == len(resolve_online(nothing, 1).choice) == 0


def test_the_covariance_of_a_turn_is_that_of_many_noisy_observations(scenes) -> None:
    """Monte Carlo through IPPE, for a marker so tilted that the second candidate is far."""
    rng = np.random.default_rng(10)
    tilted = Rotor.from_rotation_vector([0.0, 0.8, 0.3])
    marker = Motor.from_rotor_translation(tilted, [0.05, 0.0, 0.0]).reshape(1)
    cameras = scenes.path(1, rng)
    poses = Motor(np.repeat(cameras.coefficients, 400, axis=0))
    scene = scenes.seen_by(scenes.camera, poses, marker, {0: 0.3}, 0.2, rng)
    observations = pose_stream(scene.stream, scene.side_m)
    true = (cameras[0].inverse() @ marker[0]).rotor
    turns = (
        observations.camera_T_marker[:, 0].rotor @ true.inverse().reshape(1)
    ).as_rotation_vector()
    expected = 0.2**2 * observations.rotation_covariance[:, 0].mean(axis=0)
    ratio = np.linalg.eigvals(np.linalg.solve(expected, turns.T @ turns / len(turns)))
    assert np.all((ratio.real > 0.75) & (ratio.real < 1.4))


def test_bad_input_is_refused_by_name(make_scene) -> None:
    scene = make_scene(3, 4, 11)
    observations = pose_stream(scene.stream, scene.side_m)
    with pytest.raises(ValueError, match=r"side_m: expected the size of marker 0"):
        pose_stream(scene.stream, {})
    with pytest.raises(ValueError, match="sigma_px"):
        resolve(observations, 0.0)
    with pytest.raises(ValueError, match="lag_frames"):
        FixedLagResolver(-1)
    with pytest.raises(ValueError, match="one frame"):
        FixedLagResolver(1).update(observations)
    resolver = FixedLagResolver(1)
    resolver.update(observations.of_frames(np.array([1])))
    with pytest.raises(ValueError, match="stamp after"):
        resolver.update(observations.of_frames(np.array([0])))
    with pytest.raises(ValueError, match="each id once"):
        MarkerObservations(
            observations.time_ns[:1],
            np.zeros(2, int),
            np.zeros(2, int),
            Motor.identity((2, 2)),
            np.zeros((2, 2)),
            np.zeros((2, 2, 3, 3)),
        )


# Markers never seen before -----------------------------------------------------------------------


def wrong_at_first_sight(scenes, tilt_deg: float, seed: int) -> tuple[int, int]:
    """Wrong at first sight when eight more markers come into view: each alone, and in company."""
    rng = np.random.default_rng(seed)
    sides = dict.fromkeys(range(16), 0.06)
    place = scenes.wall(16, rng, tilt_deg)
    whole = scenes.seen_by(scenes.camera, scenes.path(11, rng), place, sides, 0.4, rng)
    stream = whole.stream
    kept = (stream.marker_ids < 8) | (stream.frame == 10)
    few = CornerStream(
        stream.camera,
        stream.time_ns,
        stream.frame[kept],
        stream.marker_ids[kept],
        stream.corners_px[kept],
    )
    scene = replace(whole, stream=few)
    observations = pose_stream(few, sides)
    late = observations.marker_ids >= 8
    right = right_choice(scene, observations)
    alone, company = best_single(observations), resolve_online(observations, 0)
    return (
        int(np.count_nonzero((alone.choice != right)[late])),
        int(np.count_nonzero((company.choice != right)[late])),
    )


def test_a_new_marker_on_a_known_wall_is_right_at_first_sight(scenes) -> None:
    found = np.array([wrong_at_first_sight(scenes, 0.0, seed) for seed in range(6)])
    alone, company = found.sum(axis=0)
    assert alone >= 6
    assert company <= 0.35 * alone


def test_where_no_markers_are_parallel_their_company_decides_nothing(scenes) -> None:
    found = np.array([wrong_at_first_sight(scenes, 50.0, seed) for seed in range(6)])
    alone, company = found.sum(axis=0)
    assert company <= alone + 1
