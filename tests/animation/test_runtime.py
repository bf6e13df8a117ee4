"""The runtime does in single precision what clips, blending and palettes do one by one."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.animation.blend import blend_poses
from motorcade.animation.skin import PoseRuntime, palette
from motorcade.ga import Motor, Similarity

JOINTS = 19


@pytest.fixture
def skeleton(rng) -> Skeleton:
    parents = np.array([-1, *(int(rng.integers(0, k)) for k in range(1, JOINTS))])
    return Skeleton(tuple(f"j{k}" for k in range(JOINTS)), parents, Motor.random(rng, (JOINTS,)))


@pytest.fixture
def clips(skeleton, rng) -> list[Clip]:
    made = []
    for name, count, looped in (("a", 7, True), ("b", 4, False), ("still", 1, False)):
        twists = 0.4 * rng.standard_normal((count, JOINTS, 6))
        if looped:
            twists[-1] = twists[0]
        time_s = np.sort(rng.uniform(0.0, 2.0, count))
        made.append(Clip(name, time_s, skeleton.rest @ Motor.from_twist(twists), looped))
    return made


def _expected(skeleton, clips, layers, method) -> Motor:
    poses = np.stack([clips[k].at(time_s).coefficients for k, time_s, _ in layers])
    return blend_poses(Motor(poses), [weight for *_, weight in layers], method)


@pytest.mark.parametrize("method", ["motor", "motor_linear"])
@pytest.mark.parametrize("time_s", [-3.0, 0.0, 0.71, 1.9, 50.0])
def test_palettes_are_those_of_the_plain_way(skeleton, clips, method, time_s):
    runtime = PoseRuntime(skeleton, clips, method)
    for layers in (
        [(0, time_s, 2.0)],
        [(0, time_s, 0.3), (1, 0.6 * time_s, 0.9)],
        [(2, time_s, 1.0), (0, time_s, 0.0)],
    ):
        local = _expected(skeleton, clips, layers, method)
        for kind, written in (("matrix", "linear"), ("motor", "motor")):
            expected = palette(skeleton, local, written)[0]
            found = runtime.palette(layers, kind)
            np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())
        back = runtime.local(layers).astype(np.float64)
        assert np.abs((back.inverse() @ local).as_twist()).max() < 1e-5


def test_many_layers_blend_linearly_alone(skeleton, clips):
    layers = [(0, 0.4, 0.2), (1, 0.5, 0.5), (2, 0.0, 0.9)]
    found = PoseRuntime(skeleton, clips).local(layers).astype(np.float64)
    expected = _expected(skeleton, clips, layers, "motor_linear")
    assert np.abs((found.inverse() @ expected).as_twist()).max() < 1e-5
    with pytest.raises(ValueError, match="two at most"):
        PoseRuntime(skeleton, clips, "motor").local(layers)


@pytest.mark.parametrize("time_s", [-1e17, -1e-20, 1e17, 1e300])
def test_a_loop_goes_on_at_any_time(skeleton, clips, time_s):
    """The remainder of a division stays within the loop where a product of cycles does not."""
    found = PoseRuntime(skeleton, clips).local([(0, time_s, 1.0)])
    expected = _expected(skeleton, clips, [(0, time_s, 1.0)], "motor")
    assert np.abs((found.astype(np.float64).inverse() @ expected).as_twist()).max() < 1e-5


@pytest.mark.parametrize("size", [1e-30, 1.0, 1e30])
def test_only_ratios_of_weights_count(skeleton, clips, size):
    layers = [(0, 0.4, 0.2), (1, 0.5, 0.5), (2, 0.0, 0.9)]
    runtime = PoseRuntime(skeleton, clips)
    sized = [(clip, time_s, size * weight) for clip, time_s, weight in layers]
    np.testing.assert_allclose(runtime.palette(sized), runtime.palette(layers), atol=1e-4)


def test_layers_without_weight_lend_no_signs(rng):
    """Two poses that are opposite as seen from a third one cancel, unless that one is left out."""
    still = Skeleton(("a",), np.array([-1]), Motor.identity((1,)))
    turns = Motor.from_twist([[[0, 0, t, 0, 0, 0.0]] for t in (0.0, np.pi, -np.pi)])
    clips = [Clip(str(k), np.zeros(1), turns[k : k + 1]) for k in range(3)]
    made = PoseRuntime(still, clips).palette([(0, 0.0, 0.0), (1, 0.0, 1.0), (2, 0.0, 1.0)])
    np.testing.assert_allclose(made[0, :3], [-1.0, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        ([], "one or more.*got 0"),
        ([(3, 0.0, 1.0)], "number of a clip to be from 0 to 2, got 3"),
        ([(0, 0.0, 1.0), (-1, 0.0, 1.0)], "of layer 1 the number of a clip .* got -1"),
        ([(-(10**30), 0.0, 1.0)], "number of a clip to be from 0 to 2"),
        ([(1.0, 0.0, 1.0)], "an integer as the number of a clip, got 1.0"),
        ([(True, 0.0, 1.0)], "an integer as the number of a clip, got True"),
        ([(np.True_, 0.0, 1.0)], "an integer as the number of a clip, got np.True_"),
        ([("a", 0.0, 1.0)], "an integer as the number of a clip, got 'a'"),
        ([(0, np.nan, 1.0)], "time_s to be finite, got nan"),
        ([(0, 0.0, -1.0)], "weight to be 0 or more and finite in float32, got -1"),
        ([(0, 0.0, 1e39)], "weight to be 0 or more and finite in float32, got inf"),
        ([(0, 0.0, 0.0)], "weights with a finite sum above 0, got 0"),
        ([(0, 0.0)], "for each layer, got"),
        (None, "for each layer, got None"),
    ],
)
def test_layers_that_are_none_are_refused(skeleton, clips, layers, message):
    runtime = PoseRuntime(skeleton, clips)
    for asked in (runtime.palette, runtime.local, lambda given: runtime.repeat(given, 1)):
        with pytest.raises(ValueError, match=f"layers: expected.*{message}"):
            asked(layers)


@pytest.mark.parametrize("number", [np.int64(1), np.uint8(1)])
def test_numbers_of_arrays_are_numbers_of_clips(skeleton, clips, number):
    runtime = PoseRuntime(skeleton, clips)
    np.testing.assert_array_equal(
        runtime.palette([(number, 0.0, 1.0)]), runtime.palette([(1, 0.0, 1.0)])
    )


@pytest.mark.parametrize(
    "out",
    [
        np.empty((3, 12), np.float32),
        np.empty((JOINTS, 12)),
        np.empty((12, JOINTS), np.float32).T,
        np.broadcast_to(np.float32(0.0), (JOINTS, 12)),
    ],
)
def test_a_result_is_never_written_into_a_copy(skeleton, clips, out):
    runtime = PoseRuntime(skeleton, clips)
    with pytest.raises(ValueError, match=r"out: expected a row a joint.*float32 and C order"):
        runtime.palette([(0, 0.0, 1.0)], out=out)
    with pytest.raises(ValueError, match="expected 'matrix' or 'motor', got 'local'"):
        runtime.palette([(0, 0.0, 1.0)], "local", np.empty((JOINTS, 8), np.float32))


def test_a_measurement_poses_as_often_as_asked(skeleton, clips):
    runtime = PoseRuntime(skeleton, clips)
    for kind in ("matrix", "motor"):
        assert runtime.repeat([(0, 0.0, 1.0)], 3, kind) > 0.0
    with pytest.raises(ValueError, match="expected 1 or more, got 0"):
        runtime.repeat([(0, 0.0, 1.0)], 0)
    with pytest.raises(ValueError, match="expected 'matrix' or 'motor', got 'euler'"):
        runtime.repeat([(0, 0.0, 1.0)], 1, "euler")


def test_refusals_of_runtimes(skeleton, clips):
    with pytest.raises(ValueError, match="expected 'motor' or 'motor_linear'"):
        PoseRuntime(skeleton, clips, "euler")
    grown = Clip("g", np.zeros(1), Similarity.from_motor_scale(skeleton.rest, 1.1).reshape(1, -1))
    with pytest.raises(ValueError, match="expected rigid poses of 19 joints, got Similarity"):
        PoseRuntime(skeleton, [grown])
