"""What is set into footage, against the same room rendered with the character standing in it.

The room is lit by a sun of some width and light from all sides, and rendered once with the
character and once without; shadows fall by shadow maps, from many points of the sun. The character
is then set into the empty room's image as into any footage: along the true path in the true
light, and along the tracked path in the light that the images told. The room's own surfaces are
chalk, since footage does not tell what would gleam. The frames on one sheet:

    python -m tests.bench.view.ground_truth SHEET.jpg
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.metrics import structural_similarity

from motorcade.animation import Character, Placement, mannequin, place_on_plane, skin
from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Sun, Surface, render_overlay
from motorcade.render.backends.renderer import Renderer
from motorcade.render.light.estimate import (
    LightEstimate,
    ShadedPoints,
    estimate_light,
    shaded_points,
)
from motorcade.render.light.lamps import estimated_lighting
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.render.shadow import ShadowLook
from motorcade.render.video import contact_sheet
from motorcade.replays.demo.furniture import BOARD, Occluders, boxes, irradiance, world_T_board
from motorcade.replays.demo.recording import CAMERA, HandheldPath
from motorcade.replays.demo.scene import room
from motorcade.tracking import track_board

__all__ = [
    "Alike",
    "Shots",
    "alike",
    "drawn_silhouettes",
    "found_light",
    "found_lighting",
    "overlap",
    "room_light",
    "set_into",
    "sheet",
    "take_shots",
    "tracked_path",
    "true_light",
]

HEIGHT_M = 0.23
TO_SUN = np.array([-0.45, 0.68, 0.80]) / np.linalg.norm([-0.45, 0.68, 0.80])
SUN_RADIUS_RAD = 0.05
SUN_POINTS = 9
TIME_NS = np.array([300_000_000, 2_000_000_000, 4_400_000_000])
# What differs by more bytes than this from the empty room belongs to figure or shadow.
TOUCHED = 3


@dataclass(frozen=True, eq=False)
class Shots:
    """Images of every stamp: with the character, without, where the character is seen, and the
    room as its own lamps light it, with its depth.
    """

    direct: tuple[ImageArray, ...]
    empty: tuple[ImageArray, ...]
    silhouette: tuple[NDArray[np.bool_], ...]
    painted: tuple[tuple[ImageArray, NDArray[np.float32]], ...]
    poses: Trajectory
    placement: Placement


@dataclass(frozen=True)
class Alike:
    """How far an image is from another where figure or shadow are: mean difference of 255, mean
    structural similarity, and how many pixels that is.
    """

    mean_of_255: float
    similarity: float
    pixels: int


def true_light() -> Lighting:
    """The light that the room was rendered in."""
    return _lit_from(TO_SUN)


def take_shots() -> Shots:
    """Render the room with the character and without.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    poses = HandheldPath.of(np.random.default_rng(0)).trajectory(TIME_NS)
    placement = place_on_plane(_figure(), (0.0, 0.0), 2.6, height_m=HEIGHT_M)
    chalk = [replace(surface, roughness=1.0) for surface in room()]
    direct, silhouette, painted = [], [], []
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        empty = _mean_light(renderer, chalk, poses.motors)
        for k, pose in enumerate(poses.motors):
            figure = _standing(placement, k)
            renderer.show([figure, *chalk], true_light())
            depth_m = renderer.render(CAMERA, pose).depth_m
            direct.append(_mean_light(renderer, [figure, *chalk], Motor.stack([pose]))[0])
            renderer.show(room(), None)
            plain = renderer.render(CAMERA, pose)
            silhouette.append(depth_m < plain.depth_m - 1e-4)
            painted.append((plain.rgba[..., :3].copy(), plain.depth_m))
    return Shots(tuple(direct), tuple(empty), tuple(silhouette), tuple(painted), poses, placement)


def set_into(shots: Shots, poses: Trajectory, lighting: Lighting) -> list[ImageArray]:
    """The character in the empty room's images, as in any footage."""
    frames = list(zip(TIME_NS.tolist(), shots.empty, strict=True))
    look = ShadowLook(lamp_radius_rad=SUN_RADIUS_RAD, contact=0.0)
    figure = _figure()
    return list(
        render_overlay(
            frames,
            CAMERA,
            poses,
            figure,
            figure.clip("walk"),
            shots.placement,
            lighting=lighting,
            look=look,
        )
    )


def drawn_silhouettes(shots: Shots, poses: Trajectory) -> list[NDArray[np.bool_]]:
    """Where the character is drawn along a path."""
    seen = []
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        for k, pose in enumerate(poses.motors):
            renderer.show([_standing(shots.placement, k)], true_light())
            seen.append(renderer.render(CAMERA, pose).depth_m > 0.0)
    return seen


def overlap(one: NDArray[np.bool_], two: NDArray[np.bool_]) -> float:
    """Pixels of both over pixels of either."""
    return float(np.count_nonzero(one & two) / np.count_nonzero(one | two))


def alike(direct: ImageArray, made: ImageArray, empty: ImageArray) -> Alike:
    """Compare where either image differs from the empty room."""
    region = np.any(np.abs(direct.astype(int) - empty) > TOUCHED, axis=2)
    region |= np.any(np.abs(made.astype(int) - empty) > TOUCHED, axis=2)
    _, local = structural_similarity(direct, made, channel_axis=2, full=True)
    apart = np.abs(direct.astype(int) - made)[region]
    return Alike(float(apart.mean()), float(local[region].mean()), int(np.count_nonzero(region)))


def found_light(shots: Shots) -> LightEstimate:
    """The light of the room's own lamps, as images and depth tell it."""
    seen = [
        shaded_points(image, depth_m, CAMERA, pose)
        for (image, depth_m), pose in zip(shots.painted, shots.poses.motors, strict=True)
    ]
    return estimate_light(ShadedPoints.joined(seen), [0.0, 0.0, 0.5 * HEIGHT_M], 2.0 * HEIGHT_M)


def found_lighting(shots: Shots, light: LightEstimate) -> Lighting:
    """The light that the character is drawn in by what was found."""
    return estimated_lighting(shots.placement, HEIGHT_M, light)


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


def tracked_path(shots: Shots) -> Trajectory:
    """The camera's path by the board in the painted room."""
    frames = [
        (int(stamp), image[..., 1].copy())
        for stamp, (image, _) in zip(TIME_NS, shots.painted, strict=True)
    ]
    track = track_board(frames, CAMERA, BOARD)
    return track.measurements.trajectory.transformed_by(left=world_T_board())


def sheet(shots: Shots, true: list[ImageArray], tracked: list[ImageArray]) -> ImageArray:
    """A row a stamp: rendered with the character, set in by ground truth, and by what was found."""
    rows = zip(shots.direct, true, tracked, strict=True)
    frames = [_about(shots.silhouette[k], frame) for k, row in enumerate(rows) for frame in row]
    labels = ["rendered as a whole", "set in, true pose and light", "set in, tracked and estimated"]
    return contact_sheet(frames, 3, 420, labels * len(true))


def _about(silhouette: NDArray[np.bool_], frame: ImageArray) -> ImageArray:
    """The part of a frame, half as wide and high, about the character and its shadow."""
    rows, columns = np.nonzero(silhouette)
    high, wide = frame.shape[0] // 2, frame.shape[1] // 2
    top = int(np.clip(rows.mean() - 0.45 * high, 0, frame.shape[0] - high))
    left = int(np.clip(columns.mean() - 0.5 * wide, 0, frame.shape[1] - wide))
    return frame[top : top + high, left : left + wide]


@cache
def _figure() -> Character:
    """The mannequin by colours of its vertices, which the room's renderer draws too."""
    return replace(mannequin(), appearance=None)


def _lit_from(towards: FloatArray) -> Lighting:
    sun = Sun((-towards[0], -towards[1], -towards[2]), 2.2, (1.0, 0.97, 0.92))
    middle, reach_m = (0.0, 0.0, 0.5 * HEIGHT_M), 0.75 * HEIGHT_M
    # From all sides alike, and mirrored too: band 0 of what is all around.
    r, g, b = (np.sqrt(4.0 * np.pi) * value for value in (0.35, 0.35, 0.37))
    around = ((r, g, b), *[(0.0, 0.0, 0.0)] * 8)
    return Lighting((0.0, 0.0, 0.0), sun, (), middle, reach_m, around)


def _suns() -> list[FloatArray]:
    """Directions spread evenly over the sun's disc."""
    side = np.cross(TO_SUN, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    k = np.arange(SUN_POINTS) + 0.5
    radius, turn = SUN_RADIUS_RAD * np.sqrt(k / SUN_POINTS), k * np.pi * (3.0 - np.sqrt(5.0))
    given = TO_SUN + (radius * np.cos(turn))[:, None] * side
    given += (radius * np.sin(turn))[:, None] * np.cross(side, TO_SUN)
    return list(given / np.linalg.norm(given, axis=1, keepdims=True))


def _mean_light(renderer: Renderer, surfaces: list[Surface], poses: Motor) -> list[ImageArray]:
    """Images of all poses, their light averaged over the points of the sun."""
    light = np.zeros((len(poses), CAMERA.height, CAMERA.width, 3))
    for towards in _suns():
        renderer.show(surfaces, _lit_from(towards))
        for total, pose in zip(light, poses, strict=True):
            total += to_linear(renderer.render(CAMERA, pose).rgba[..., :3] / 255.0) / SUN_POINTS
    return [np.rint(255.0 * to_srgb(one)).astype(np.uint8) for one in light]


def _standing(placement: Placement, k: int) -> Surface:
    """The character in the room, as it stands at stamp number k."""
    figure = _figure()
    vertices, normals = skin(figure, figure.clip("walk").at(1e-9 * (TIME_NS[k] - TIME_NS[0])))
    turn = placement.world_T_character.rotor
    return Surface(
        placement.apply(vertices),
        turn.apply(normals),
        figure.triangles,
        figure.colors,
        roughness=0.42,
    )


def main(path: str) -> None:
    """Write the sheet of all frames, as PNG or JPEG by its ending."""
    shots = take_shots()
    true = set_into(shots, shots.poses, true_light())
    made = set_into(shots, tracked_path(shots), found_lighting(shots, found_light(shots)))
    image = sheet(shots, true, made)[..., ::-1]
    if not cv2.imwrite(path, image, [cv2.IMWRITE_JPEG_QUALITY, 85]):
        raise OSError(f"{path}: the sheet cannot be written there")


if __name__ == "__main__":
    main(sys.argv[1])
