"""The runtime does in single precision what clips, blending and palettes do one by one."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation import Clip, Skeleton
from motorcade.animation.blend import blend_poses
from motorcade.animation.runtime import PoseRuntime
from motorcade.animation.skin import palette
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


def test_refusals(skeleton, clips):
    runtime = PoseRuntime(skeleton, clips)
    for layers in ([], [(3, 0.0, 1.0)], [(0, np.nan, 1.0)], [(0, 0.0, -1.0)], [(0, 0.0, 0.0)]):
        with pytest.raises(ValueError, match="layers: expected"):
            runtime.palette(layers)
    with pytest.raises(ValueError, match="expected 'matrix' or 'motor'"):
        runtime.palette([(0, 0.0, 1.0)], "euler")
    with pytest.raises(ValueError, match="out: expected a row a joint"):
        runtime.palette([(0, 0.0, 1.0)], out=np.empty((3, 12), np.float32))
    with pytest.raises(ValueError, match="expected 'motor' or 'motor_linear'"):
        PoseRuntime(skeleton, clips, "euler")
    grown = Clip("g", np.zeros(1), Similarity.from_motor_scale(skeleton.rest, 1.1).reshape(1, -1))
    with pytest.raises(ValueError, match="expected rigid poses of 19 joints, got Similarity"):
        PoseRuntime(skeleton, [grown])
