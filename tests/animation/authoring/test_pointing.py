"""Pointing: what was grabbed stays under the finger; what no finger can mean is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorcade.animation import mannequin
from motorcade.animation.authoring.pointing import (
    DragPlane,
    JointDrag,
    OutOfReach,
    Ray,
    moved,
    pinched,
    slid,
    turned,
    unwound,
)
from motorcade.animation.skeleton import turned_joint
from motorcade.ga import Motor, Rotor, Similarity
from tests.ga.cases import over

UP = np.array([0.0, 0.0, 1.0])
FIGURE = mannequin()


def eye_and_points(rng: Any, count: int) -> tuple[np.ndarray, DragPlane, np.ndarray]:
    """A camera, a plane through a grabbed point, and points of the plane that it sees."""
    size = 10.0 ** rng.uniform(-3, 4)
    turn = Motor.random(rng, (), 10.0 * size)
    normal = turn.rotor.apply(UP)
    heading = turn.rotor.apply([1.0, 0.0, 0.0]), turn.rotor.apply([0.0, 1.0, 0.0])
    grabbed = turn.translation_m
    lift = size * 10.0 ** rng.uniform(-1.5, 0) * rng.choice([-1.0, 1.0])
    eye = grabbed - size * heading[0] + lift * normal
    at = rng.normal(0, 0.3 * size, (count, 2))
    points = grabbed + at[:, :1] * heading[0] + at[:, 1:] * heading[1]
    return eye, DragPlane(grabbed, normal), points


def off_ray(ray: Ray, point: np.ndarray) -> float:
    """By what share of its distance a point lies off a ray."""
    away = point - ray.origin_m
    return float(np.linalg.norm(np.cross(away, ray.direction)) / np.linalg.norm(away))


@over(seed=range(200))
def test_what_was_grabbed_stays_under_one_and_two_fingers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    eye, plane, (a0, b0, a1, b1) = eye_and_points(rng, 4)
    rays = [Ray(eye, point - eye) for point in (a0, b0, a1, b1)]
    for start, now, grabbed in ((rays[0], rays[2], a0), (rays[1], rays[3], b0)):
        made = moved(plane, start, now).apply(grabbed)
        assert off_ray(now, made) < 1e-9
    both = pinched(plane, (rays[0], rays[1]), (rays[2], rays[3]))
    for now, grabbed in ((rays[2], a0), (rays[3], b0)):
        made = both.apply(grabbed)
        assert off_ray(now, made) < 1e-9
        # In the plane, it is the ray's own point that it meets.
        away = np.linalg.norm(eye - plane.point_m)
        assert np.linalg.norm(plane.met_by(now) - made) < 1e-9 * away
    normal = both.rotor.apply(plane.normal)
    np.testing.assert_allclose(normal, plane.normal, atol=1e-12)
    assert float(both.scale) == pytest.approx(
        np.linalg.norm(b1 - a1) / np.linalg.norm(b0 - a0), rel=1e-9
    )


@over(seed=range(50))
def test_in_a_parents_frame_a_drag_is_the_same_drag(seed: int) -> None:
    rng = np.random.default_rng(seed)
    eye, plane, points = eye_and_points(rng, 4)
    world_T_parent = Similarity.random(rng, (), 2.0, 1.0)
    there = world_T_parent.inverse()
    rays = [Ray(eye, point - eye) for point in points]
    seen = [ray.seen_from(there) for ray in rays]
    own = DragPlane(there.apply(plane.point_m), there.rotor.apply(plane.normal))
    in_world = pinched(plane, (rays[0], rays[1]), (rays[2], rays[3]))
    in_parent = pinched(own, (seen[0], seen[1]), (seen[2], seen[3]))
    expected = there @ in_world @ world_T_parent
    size = np.abs(expected.as_matrix()).max()
    np.testing.assert_allclose(in_parent.as_matrix(), expected.as_matrix(), atol=1e-8 * size)


@over(seed=range(100))
def test_axes_and_rings_give_back_the_slide_and_the_turn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    point, axis = rng.normal(size=3), rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    eye = point + 3.0 * rng.normal(size=3)
    start, way = rng.normal(0, 0.5, 2)
    rays = [Ray(eye, point + at * axis - eye) for at in (start, start + way)]
    across = min(np.linalg.norm(np.cross(axis, ray.direction)) for ray in rays)
    if across > 0.05:
        assert slid(point, axis, rays[0], rays[1]) == pytest.approx(way, abs=1e-9 / across**2)
    angle = rng.uniform(-3.1, 3.1)
    arm = np.cross(axis, rng.normal(size=3))
    after = Motor.from_matrix(np.eye(4)).rotor.from_rotation_vector(angle * axis).apply(arm)
    rays = [Ray(eye, point + one - eye) for one in (arm, after)]
    if abs(axis @ (eye - point)) > 0.3:
        assert turned(point, axis, rays[0], rays[1]) == pytest.approx(angle, abs=1e-9)


def test_more_than_half_a_turn_goes_on() -> None:
    amount = 0.0
    for angle in np.linspace(0.0, 20.0, 60):
        wrapped = float((angle + np.pi) % (2 * np.pi) - np.pi)
        amount = unwound(wrapped, amount)
    assert amount == pytest.approx(20.0)


@pytest.mark.parametrize("direction", [
    [1.0, 0.0, 0.0],  # along the plane
    [1.0, 0.0, 1e-300],
    [1.0, 0.0, 0.3],  # above the horizon
    [0.0, 0.0, 1.0],
    [1.0, 0.0, -1e-4],  # below it, but a kilometre away
    [1.0, 0.0, -1e-320],
])  # fmt: skip
def test_what_points_at_no_place_of_the_plane_is_refused(direction: list[float]) -> None:
    ground, start = DragPlane([0.0, 0.0, 0.0], UP), Ray([0.0, 0.0, 1.0], [0.0, 0.1, -1.0])
    above = Ray([0.0, 0.0, 1.0], direction)
    with pytest.raises(OutOfReach):
        moved(ground, start, above)
    with pytest.raises(OutOfReach):
        pinched(ground, (start, start), (start, above))
    with pytest.raises(OutOfReach):
        turned([0.0, 0.0, 0.0], UP, start, above)


def test_what_is_no_place_is_refused() -> None:
    ground = DragPlane([0.0, 0.0, 0.0], UP)
    one, other = (Ray([0.0, 0.0, 1.0], [x, 0.0, -1.0]) for x in (0.0, 0.5))
    with pytest.raises(OutOfReach, match="the fingers are at one place"):
        pinched(ground, (one, one), (one, other))
    with pytest.raises(OutOfReach, match="along the axis"):
        slid([0.0, 0.0, 0.0], UP, other, one)
    with pytest.raises(OutOfReach, match="beyond the axis"):
        slid([1.0, 0.0, 1.0], UP, other, Ray([0.0, 0.0, 1.0], [-1.0, 0.1, 0.0]))
    with pytest.raises(OutOfReach, match="at the centre"):
        turned([0.0, 0.0, 0.0], UP, other, one)
    with pytest.raises(OutOfReach):  # the camera is in the plane
        ground.met_by(Ray([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]))
    with pytest.raises(OutOfReach):  # or where it was grabbed
        ground.met_by(Ray([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    for make in (
        lambda: Ray([0, 0], [0, 0, 1]),
        lambda: Ray([0, 0, np.nan], [0, 0, 1]),
        lambda: Ray([0, 0, 0], [0, 0, 0]),
        lambda: DragPlane([0, 0, 0], [0, 0, np.inf]),
        lambda: slid([0, 0, 0], [0, 0, 0], one, other),
    ):
        with pytest.raises(ValueError, match="expected"):
            make()


@pytest.mark.parametrize("joint", [
    "left_hand", "right_hand", "left_foot", "right_foot", "left_forearm", "right_calf", "head",
])  # fmt: skip
@pytest.mark.parametrize("clip", ["idle", "walk", "wave"])
def test_a_dragged_joint_stays_under_the_finger_and_its_bones_keep_their_length(
    joint: str, clip: str, rng: Any
) -> None:
    skeleton, held = FIGURE.skeleton, 0
    number = skeleton.index(joint)
    local = FIGURE.clip(clip).at(0.4).rigid if hasattr(
        FIGURE.clip(clip).at(0.4), "rigid") else FIGURE.clip(clip).at(0.4)  # fmt: skip
    eye = np.array([3.0, 0.5, 1.5])
    before = skeleton.world(local)
    grabbed = before[number].apply([0.02, 0.01, 0.03])
    drag = JointDrag(skeleton, local, joint, DragPlane(grabbed, [-1.0, -0.1, 0.0]))
    still = drag.to(Ray(eye, grabbed - eye))
    for name, rotor in still.rotors.items():  # nothing jumps when it is touched
        was = local[skeleton.index(name)].rotor
        assert float((was.inverse() @ rotor).angle()) < 1e-6
    for _ in range(20):
        # Under the finger there is a place to which the topmost joint alone could swing it.
        top = skeleton.index(list(still.rotors)[-1])
        swing = Rotor.from_rotation_vector(rng.normal(0, 0.3, 3))
        swung = turned_joint(local, top, local[top].rotor @ swing)
        ray = Ray(eye, skeleton.world(swung)[number].apply([0.02, 0.01, 0.03]) - eye)
        made = drag.to(ray)
        world = skeleton.world(made.local_pose)
        point = world[number].apply([0.02, 0.01, 0.03])
        if made.error_m < 1e-9:
            held += 1
            assert off_ray(ray, point) < 1e-9
        away = np.linalg.norm(point - eye)
        assert off_ray(ray, point) * away == pytest.approx(made.error_m, abs=1e-9)
        turning = {skeleton.index(name) for name in made.rotors}
        for k in set(range(len(skeleton))) - turning:
            np.testing.assert_array_equal(made.local_pose[k].coefficients, local[k].coefficients)
        np.testing.assert_allclose(made.local_pose.translation_m, local.translation_m, atol=1e-12)
    assert held >= 16


def test_a_knee_does_not_bend_forwards() -> None:
    skeleton = FIGURE.skeleton
    foot = skeleton.index("left_foot")
    at = skeleton.rest_world.translation_m[foot]
    drag = JointDrag(skeleton, skeleton.rest, "left_foot", DragPlane(at, [0.0, 1.0, 0.0]))
    eye = np.array([0.0, 4.0, 0.8])
    for shift in ([0.0, 0.0, 0.3], [0.3, 0.0, 0.3], [-0.3, 0.0, 0.2]):
        made = drag.to(Ray(eye, at + shift - eye))
        # A leg that is all but stretched, by a part in a million, may end up straight.
        assert made.error_m < 1e-6
        hip, knee, ankle = (
            skeleton.world(made.local_pose).translation_m[skeleton.index(name)]
            for name in ("left_thigh", "left_calf", "left_foot")
        )
        ahead = np.cross([0.0, 1.0, 0.0], ankle - hip)
        assert (knee - hip) @ -ahead > 0.0


def test_joints_that_cannot_be_dragged_are_refused() -> None:
    skeleton = FIGURE.skeleton
    plane = DragPlane([0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="joints above 'hips' that may turn"):
        JointDrag(skeleton, skeleton.rest, skeleton.names[skeleton.root], plane)
    with pytest.raises(ValueError, match="expected one of its joints, got 'tail'"):
        JointDrag(skeleton, skeleton.rest, "tail", plane)
    with pytest.raises(ValueError, match=r"expected shape \(46,\)"):
        JointDrag(skeleton, skeleton.rest[:3], "left_hand", plane)
