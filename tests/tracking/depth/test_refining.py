"""Surfaces laid on each other: drift is taken out, and what registers depth is found."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from motorcade.ga import Motor, Trajectory
from motorcade.tracking import Camera, MapSnapshot
from motorcade.tracking.depth import DepthCamera, focal_factor
from motorcade.tracking.depth.refine import (
    CamerasPrior,
    _Problem,
    adjust_rgbd,
    plane_distance_m,
    refine_by_depth,
)
from motorcade.tracking.depth.residuals import GLOBALS, DepthSurfaces, Matches, RgbdState
from motorcade.tracking.slam.geometry import parallax_rad
from tests.textured_room.scenarios import scenario
from tests.tracking.depth.test_registration import COLOUR, COLOUR_T_DEPTH, TAKEN_BY, seen

FRAMES = (0, 40, 80, 120)
PAIRS = [(a, b) for a in range(4) for b in range(a + 1, 4)]


def truth() -> Motor:
    return scenario("handheld").truth().motors[list(FRAMES)]


def surfaces() -> DepthSurfaces:
    return DepthSurfaces.of([seen(number)[1].depth_m for number in FRAMES])


def matches(rng: np.random.Generator) -> Matches:
    """Points of the colour images, where all frames see them, with tracking's noise."""
    poses, depth_m = truth(), seen(FRAMES[0])[0].depth_m
    px = rng.uniform((30.0, 30.0), (290.0, 210.0), (400, 2)).round()
    points = COLOUR.unproject(px) * depth_m[px[:, 1].astype(int), px[:, 0].astype(int), None]
    points = poses[0].apply(points)
    rows = []
    for b in range(1, 4):
        there = COLOUR.project(poses[b].inverse().apply(points))
        ahead = poses[b].inverse().apply(points)[:, 2]
        cell = np.rint(np.nan_to_num(there, nan=-1.0)).astype(int)
        inside = np.all((cell >= 0) & (cell < (320, 240)), axis=-1)
        cell[~inside] = 0
        inside &= np.abs(seen(FRAMES[b])[0].depth_m[cell[:, 1], cell[:, 0]] - ahead) < 0.02
        inside &= parallax_rad(poses[0], poses[b], points) > 0.0
        rows.append((b, px[inside], there[inside] + 0.2 * rng.standard_normal((inside.sum(), 2))))
    return Matches(
        np.concatenate([np.zeros(len(one), dtype=np.int64) for _, one, _ in rows]),
        np.concatenate([np.full(len(one), b) for b, one, _ in rows]),
        np.concatenate([one for _, one, _ in rows]),
        np.concatenate([two for _, _, two in rows]),
    )


def test_drift_of_keyframes_is_taken_out() -> None:
    rng = np.random.default_rng(3)
    found, exact = surfaces(), truth()
    drift = np.concatenate([np.zeros((1, 6)), rng.normal(0.0, [0.004] * 3 + [0.01] * 3, (3, 6))])
    start = RgbdState(exact.retract(drift), COLOUR, TAKEN_BY)
    prior = CamerasPrior(COLOUR, TAKEN_BY, np.zeros(GLOBALS))
    fit = adjust_rgbd(start, found, matches(rng), PAIRS, [0], prior)
    before, after = (
        np.abs(exact.local(one.world_T_colour)).max(axis=0) for one in (start, fit.state)
    )
    assert np.all(after[:3] < 0.001)
    assert np.all(after[3:] < 0.002)
    assert np.all(10.0 * after < 10.0 * before)
    assert plane_distance_m(fit.state, found, PAIRS) < 0.5 * plane_distance_m(start, found, PAIRS)


def test_a_wrong_registration_is_found() -> None:
    """Depth turned by 1.5 degrees and 20 mm off: the adjustment finds where the sensor sits."""
    rng = np.random.default_rng(4)
    off = COLOUR_T_DEPTH @ Motor.from_twist([0.01, 0.02, -0.01, 0.02, -0.01, 0.01])
    wrong = DepthCamera(TAKEN_BY.camera, off)
    sigma = np.array([0.0, 0.0, *[0.05] * 3, *[0.05] * 3])
    start = RgbdState(truth(), COLOUR, wrong)
    fit = adjust_rgbd(
        start, surfaces(), matches(rng), PAIRS, [0], CamerasPrior(COLOUR, wrong, sigma)
    )
    apart = COLOUR_T_DEPTH.local(fit.state.depth.colour_T_depth)
    assert np.all(np.abs(apart[:3]) < 0.003), apart
    assert np.all(np.abs(apart[3:]) < 0.006), apart


def test_what_is_counted_twice_is_not_known_better() -> None:
    """The pixels of an image share its errors: only other frames add to what is known."""
    given, one = surfaces(), matches(np.random.default_rng(5))
    there = one.first, one.second, one.px, one.second_px
    back = one.second, one.first, one.second_px, one.px
    shared = Matches(*map(np.concatenate, zip(there, back, strict=True)))
    twice = Matches(*map(np.concatenate, zip(there, back, there, back, strict=True)))
    state = RgbdState(truth(), COLOUR, TAKEN_BY)
    prior = CamerasPrior(COLOUR, TAKEN_BY, np.array([0.1, 0.1, *[0.0] * 6]))
    free = np.array([True, True, *[False] * 12, *[True] * 18])
    once, again = (
        _Problem(state, given, of, pairs, prior, free).fit(state).covariance[:2, :2]
        for of, pairs in ((shared, PAIRS), (twice, [*PAIRS, *PAIRS]))
    )
    assert np.all(np.diag(once) > 0.0)
    np.testing.assert_allclose(again, once, rtol=0.05)


@pytest.mark.parametrize("pairs", [[(0, 1), (0, 2), (0, 3)], [(0, 1)]])
def test_too_few_frames_do_not_make_the_cameras_certain(pairs: list[tuple[int, int]]) -> None:
    given = matches(np.random.default_rng(5))
    kept = given.second <= pairs[-1][1]
    shared = Matches(given.first[kept], given.second[kept], given.px[kept], given.second_px[kept])
    prior = CamerasPrior(COLOUR, TAKEN_BY, np.array([0.1, 0.1, *[0.0] * 6]))
    free = np.array([True, True, *[False] * 12, *[True] * 18])
    at = RgbdState(truth(), COLOUR, TAKEN_BY)
    covariance = _Problem(at, surfaces(), shared, pairs, prior, free).fit(at).covariance
    assert np.all(np.isinf(np.diag(covariance)[:2]))
    assert not covariance[2:, 2:].any()


def mapped(poses: Motor, colour: Camera) -> tuple[MapSnapshot, Trajectory]:
    """A map of points that keyframes at the frames' true poses saw, and the path, as given."""
    at = np.random.default_rng(5).integers((30, 30), (290, 210), (60, 2))
    ahead = seen(FRAMES[0])[0].depth_m[at[:, 1], at[:, 0], None]
    points = truth()[0].apply(COLOUR.unproject(at) * ahead)
    keyframe_of, point_of = np.divmod(np.arange(4 * 60), 60)
    px = colour.project(truth()[keyframe_of].inverse().apply(points[point_of]), allow_nan=True)
    seen_by = np.flatnonzero(np.isfinite(px[:, 0]))
    stamps = 1_000_000 * np.array(FRAMES, np.int64)
    snapshot = MapSnapshot(
        time_ns=stamps,
        world_T_camera=poses,
        points=points,
        descriptors=np.zeros((60, 32), np.uint8),
        keyframe_of=keyframe_of[seen_by],
        point_of=point_of[seen_by],
        px=px[seen_by],
        depth=np.full(len(seen_by), np.nan),
        metric=True,
    )
    return snapshot, Trajectory(stamps, poses)


def measured(time_ns: int) -> np.ndarray:
    return seen(time_ns // 1_000_000)[1].depth_m


FISHEYE = Camera(320, 240, 262.0, 262.0, 159.5, 119.5, "equidistant", (0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("colour", [COLOUR, FISHEYE])
def test_a_path_and_its_map_are_refined(colour: Camera) -> None:
    rng = np.random.default_rng(3)
    drift = np.concatenate([np.zeros((1, 6)), rng.normal(0.0, [0.004] * 3 + [0.01] * 3, (3, 6))])
    found = refine_by_depth(*mapped(truth().retract(drift), colour), colour, TAKEN_BY, measured)
    assert found is not None
    assert found.after_m < 0.5 * found.before_m
    left = np.abs(truth().local(found.trajectory.motors)).max(axis=0)
    assert np.all(left < 0.5 * np.abs(drift).max(axis=0)), left


@pytest.mark.parametrize("times", [0.95, 1.05])
def test_focal_lengths_that_are_wrong_alike_are_found(times: float) -> None:
    """Edges that fit tell their ratio alone."""
    longer, lens = (
        replace(one, fx=times * one.fx, fy=times * one.fy) for one in (COLOUR, TAKEN_BY.camera)
    )
    known, path = mapped(truth(), COLOUR)
    sensor = DepthCamera(lens, TAKEN_BY.colour_T_depth)
    found = focal_factor(known, path, longer, sensor, measured)
    assert found is not None
    assert 0.0 < found.sigma < 0.02
    assert found.factor * times == pytest.approx(1.0, abs=min(4.0 * found.sigma, 0.01))
    assert focal_factor(known, path, longer, sensor, lambda _: None) is None


def test_a_path_that_surfaces_do_not_mend_is_left_as_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Here the adjustment ends at poses a centimetre worse than those it began with."""

    def spoilt(start: RgbdState, *_: object) -> SimpleNamespace:
        off = np.random.default_rng(6).normal(0.0, 0.01, (4, 6))
        return SimpleNamespace(
            state=replace(start, world_T_colour=start.world_T_colour.retract(off))
        )

    monkeypatch.setattr("motorcade.tracking.depth.refine.adjust_rgbd", spoilt)
    assert refine_by_depth(*mapped(truth(), COLOUR), COLOUR, TAKEN_BY, measured) is None


def test_frames_that_see_nothing_of_the_same_are_left_but_faults_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    apart = Motor.from_translation([[100.0 * k, 0.0, 0.0] for k in range(4)])
    given = mapped(apart @ truth(), COLOUR)
    bare = replace(
        given[0],
        keyframe_of=np.zeros(0, int),
        point_of=np.zeros(0, int),
        px=np.zeros((0, 2)),
        depth=np.zeros(0),
    )
    assert refine_by_depth(bare, given[1], COLOUR, TAKEN_BY, measured) is None

    def faulty(*_: object) -> None:
        raise ValueError("another fault")

    monkeypatch.setattr("motorcade.tracking.depth.refine.adjust_rgbd", faulty)
    with pytest.raises(ValueError, match="another fault"):
        refine_by_depth(*given, COLOUR, TAKEN_BY, measured)
