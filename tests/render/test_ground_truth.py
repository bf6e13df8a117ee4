"""What is set into footage, against the same room rendered with the character standing in it.

The room is lit by a sun of some width and light from all sides, and rendered once with the
character and once without; shadows fall by shadow maps, from many points of the sun. The character
is then set into the empty room's picture as into any footage. The room's own surfaces are chalk,
since footage does not tell what would gleam.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.metrics import structural_similarity

from motorcade.animation import Placement, mannequin, place_on_plane, skin
from motorcade.ga import FloatArray, Motor, Trajectory
from motorcade.render import Lighting, Sun, Surface, render_overlay
from motorcade.render.backends.renderer import Renderer, new_renderer
from motorcade.render.light import (
    LightEstimate,
    ShadedPoints,
    estimate_light,
    estimated_lighting,
    shaded_points,
)
from motorcade.render.scene import ImageArray
from motorcade.render.shadow import ShadowLook
from motorcade.replays.synthetic_room.furniture import BOARD, boxes, world_T_board
from motorcade.replays.synthetic_room.lighting import Occluders, irradiance
from motorcade.replays.synthetic_room.path import HandheldPath
from motorcade.replays.synthetic_room.recording import CAMERA
from motorcade.replays.synthetic_room.scene import room
from motorcade.tracking import track_board

pytestmark = [pytest.mark.usefixtures("opengl"), pytest.mark.slow]

HEIGHT_M = 0.23
TO_SUN = np.array([-0.45, 0.68, 0.80]) / np.linalg.norm([-0.45, 0.68, 0.80])
SUN_RADIUS_RAD = 0.05
SUN_POINTS = 9
TIME_NS = np.array([300_000_000, 2_000_000_000, 4_400_000_000])
FIGURE = mannequin()
CLIP = FIGURE.clip("walk")


@dataclass
class Shots:
    """Pictures of every stamp: with the character, without, and where the character is seen."""

    direct: list[ImageArray]
    empty: list[ImageArray]
    silhouette: list[NDArray[np.bool_]]
    painted: list[tuple[ImageArray, NDArray[np.float32]]]
    poses: Trajectory
    placement: Placement


def lit_from(towards: FloatArray) -> Lighting:
    sun = Sun((-towards[0], -towards[1], -towards[2]), 2.2, (1.0, 0.97, 0.92))
    return Lighting((0.35, 0.35, 0.37), sun, (), (0.0, 0.0, 0.5 * HEIGHT_M), 0.75 * HEIGHT_M)


def suns() -> list[FloatArray]:
    """Directions spread evenly over the sun's disc."""
    side = np.cross(TO_SUN, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    k = np.arange(SUN_POINTS) + 0.5
    radius, turn = SUN_RADIUS_RAD * np.sqrt(k / SUN_POINTS), k * np.pi * (3.0 - np.sqrt(5.0))
    given = TO_SUN + (radius * np.cos(turn))[:, None] * side
    given += (radius * np.sin(turn))[:, None] * np.cross(side, TO_SUN)
    return list(given / np.linalg.norm(given, axis=1, keepdims=True))


def mean_light(renderer: Renderer, surfaces: list[Surface], poses: Motor) -> list[ImageArray]:
    """Pictures of all poses, their light averaged over the points of the sun."""
    light = np.zeros((len(poses), CAMERA.height, CAMERA.width, 3))
    for towards in suns():
        renderer.show(surfaces, lit_from(towards))
        for total, pose in zip(light, poses, strict=True):
            total += (renderer.render(CAMERA, pose).rgba[..., :3] / 255.0) ** 2.2 / SUN_POINTS
    return [np.rint(255.0 * one ** (1.0 / 2.2)).astype(np.uint8) for one in light]


@pytest.fixture(scope="module")
def shots() -> Shots:
    path = HandheldPath.of(np.random.default_rng(0))
    poses = path.trajectory(TIME_NS)
    placement = place_on_plane(FIGURE, (0.0, 0.0), 2.6, height_m=HEIGHT_M)
    chalk = [replace(surface, roughness=1.0) for surface in room()]
    taken = Shots([], [], [], [], poses, placement)
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        taken.empty = mean_light(renderer, chalk, poses.motors)
        for k, pose in enumerate(poses.motors):
            figure = standing(placement, k)
            renderer.show([figure, *chalk], lit_from(TO_SUN))
            depth_m = renderer.render(CAMERA, pose).depth_m
            taken.direct.append(mean_light(renderer, [figure, *chalk], Motor.stack([pose]))[0])
            renderer.show(room(), None)
            plain = renderer.render(CAMERA, pose)
            taken.silhouette.append(depth_m < plain.depth_m - 1e-4)
            taken.painted.append((plain.rgba[..., :3].copy(), plain.depth_m))
    return taken


def standing(placement: Placement, k: int) -> Surface:
    """The character in the room, as it stands at stamp number k."""
    vertices, normals = skin(FIGURE, CLIP.at(1e-9 * (TIME_NS[k] - TIME_NS[0])))
    turn = placement.world_T_character.rotor
    return Surface(
        placement.apply(vertices), turn.apply(normals), FIGURE.triangles, FIGURE.colors,
        roughness=0.42,
    )  # fmt: skip


def set_into(shots: Shots, poses: Trajectory, lighting: Lighting) -> list[ImageArray]:
    frames = list(zip(TIME_NS.tolist(), shots.empty, strict=True))
    look = ShadowLook(lamp_radius_rad=SUN_RADIUS_RAD, contact=0.0)
    return list(
        render_overlay(
            frames, CAMERA, poses, FIGURE, CLIP, shots.placement, lighting=lighting, look=look
        )
    )


def drawn_silhouettes(shots: Shots, poses: Trajectory) -> list[NDArray[np.bool_]]:
    seen = []
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        for k, pose in enumerate(poses.motors):
            renderer.show([standing(shots.placement, k)], lit_from(TO_SUN))
            seen.append(renderer.render(CAMERA, pose).depth_m > 0.0)
    return seen


def overlap(one: NDArray[np.bool_], two: NDArray[np.bool_]) -> float:
    return float(np.count_nonzero(one & two) / np.count_nonzero(one | two))


def test_true_pose_and_light_give_the_directly_rendered_picture(shots: Shots) -> None:
    for direct, empty, made in zip(
        shots.direct, shots.empty, set_into(shots, shots.poses, lit_from(TO_SUN)), strict=True
    ):
        region = np.any(np.abs(direct.astype(int) - empty) > 3, axis=2)
        region |= np.any(np.abs(made.astype(int) - empty) > 3, axis=2)
        assert np.count_nonzero(region) > 4000
        assert np.abs(direct.astype(int) - made)[region].mean() <= 4.0
        _, local = structural_similarity(direct, made, channel_axis=2, full=True)
        assert local[region].mean() >= 0.97


def test_true_poses_give_the_true_silhouette(shots: Shots) -> None:
    for true, drawn in zip(shots.silhouette, drawn_silhouettes(shots, shots.poses), strict=True):
        assert overlap(true, drawn) >= 0.995


@pytest.fixture(scope="module")
def estimate(shots: Shots) -> LightEstimate:
    seen = [
        shaded_points(picture, depth_m, CAMERA, pose)
        for (picture, depth_m), pose in zip(shots.painted, shots.poses.motors, strict=True)
    ]
    return estimate_light(ShadedPoints.joined(seen), [0.0, 0.0, 0.5 * HEIGHT_M], 2.0 * HEIGHT_M)


def room_light() -> FloatArray:
    """Where most of the room's light comes from: its flux at the place, from its own lamps."""
    k = np.arange(300) + 0.5
    z, turn = 1.0 - k / 150.0, k * np.pi * (3.0 - np.sqrt(5.0))
    level = np.sqrt(1.0 - z * z)
    facing = np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)
    place = np.tile([0.0, 0.0, 0.5 * HEIGHT_M], (300, 1))
    falling = irradiance(place, facing, Occluders.of(boxes())).mean(axis=1)
    flux = falling @ facing
    return np.asarray(flux / np.linalg.norm(flux))


def test_the_rooms_own_light_is_found_within_20_degrees(estimate: LightEstimate) -> None:
    apart_deg = np.rad2deg(np.arccos(estimate.towards_light @ room_light()))
    assert apart_deg <= 20.0
    assert estimate.contrast > 0.3


def test_tracked_poses_and_found_light_keep_the_silhouette_and_most_of_the_picture(
    shots: Shots, estimate: LightEstimate
) -> None:
    frames = [
        (int(stamp), one[..., 1].copy())
        for stamp, (one, _) in zip(TIME_NS, shots.painted, strict=True)
    ]
    track = track_board(frames, CAMERA, BOARD)
    poses = track.measurements.trajectory.transformed_by(left=world_T_board())
    assert len(poses) == 3
    for true, drawn in zip(shots.silhouette, drawn_silhouettes(shots, poses), strict=True):
        assert overlap(true, drawn) >= 0.97
    made = set_into(shots, poses, estimated_lighting(shots.placement, HEIGHT_M, estimate))
    for direct, one, there in zip(shots.direct, made, shots.silhouette, strict=True):
        assert np.abs(direct.astype(int) - one)[there].mean() < 40.0
