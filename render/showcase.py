"""A character on an empty stage: images of poses and clips, seen from beside its front."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorcade.animation import Character, Clip, place_on_plane
from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.render.overlay import render_overlay
from motorcade.render.scene import ImageArray
from motorcade.tracking.cameras.camera import Camera

# The stage in heights of the character: where the camera stands, and what it looks at.
DISTANCE, EYE, AIM = 2.3, 0.75, 0.48
FLOOR, WALL, LINE = (205, 206, 208), (238, 239, 241), (186, 188, 191)
TILE, TILES = 0.5, 12


def show_clip(
    character: Character,
    clip: Clip,
    size: tuple[int, int] = (640, 640),
    rate_hz: float = 30.0,
    duration_s: float | None = None,
    azimuth_rad: float = 0.6,
) -> Iterator[ImageArray]:
    """Frames of a clip played on the spot.

    Args:
        character: who is drawn, at its own height.
        clip: what it does; one that travels walks out of the image.
        size: width and height of the frames, pixels.
        rate_hz: frames a second.
        duration_s: how long; by default once through the clip, and one frame of a single pose.
        azimuth_rad: from where it is seen: 0 from its front, towards its left.

    Yields:
        uint8 (h, w, 3) RGB.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a size or rate that is not positive.
    """
    checked_positive(rate_hz, "show_clip(rate_hz)")
    seconds = clip.duration_s if duration_s is None else duration_s
    count = max(1, round(seconds * rate_hz))
    stamps = np.round(np.arange(count) * 1e9 / rate_hz).astype(np.int64)
    focal = 1.35 * min(size)
    camera = Camera(*size, focal, focal, 0.5 * size[0] - 0.5, 0.5 * size[1] - 0.5)
    pose = _standing(character.height_m, azimuth_rad)
    ends = np.array([0, max(int(stamps[-1]), 1)], dtype=np.int64)
    path = Trajectory(ends, Motor.stack([pose, pose]), "world", "camera")
    stage = _stage(camera, pose, character.height_m)
    placement = place_on_plane(character, height_m=character.height_m)
    frames = ((int(stamp), stage) for stamp in stamps)
    yield from render_overlay(frames, camera, path, character, clip, placement)


def _standing(height_m: float, azimuth_rad: float) -> Motor:
    """`world_T_camera` beside the character's front, looking at its middle."""
    around = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad)])
    eye = height_m * np.append(DISTANCE * around, EYE)
    ahead = np.array([0.0, 0.0, AIM * height_m]) - eye
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    return Motor.from_rotor_translation(axes_along(right, np.cross(ahead, right)), eye)


def _stage(camera: Camera, world_T_camera: Motor, height_m: float) -> ImageArray:
    """A floor with tiles before a plain wall."""
    import cv2

    pixels = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
    rays = world_T_camera.rotor.apply(camera.unproject(pixels.reshape(-1, 2).astype(np.float64)))
    down = rays[:, 2].reshape(camera.height, camera.width) < 0.0
    image = np.where(down[..., None], FLOOR, WALL).astype(np.uint8)
    reach = TILE * TILES * height_m
    for k in range(-TILES, TILES + 1):
        at = k * TILE * height_m
        for ends in ([[at, -reach, 0.0], [at, reach, 0.0]], [[-reach, at, 0.0], [reach, at, 0.0]]):
            line = _seen(camera, world_T_camera, np.array(ends))
            if line is not None:
                cv2.polylines(image, [line], False, LINE, 1, cv2.LINE_AA, shift=4)
    return image


def _seen(camera: Camera, world_T_camera: Motor, ends_m: FloatArray) -> FloatArray | None:
    """A straight line of the world in pixels times 16, cut off behind the camera."""
    start, end = world_T_camera.inverse().apply(ends_m)
    near = 0.1
    if max(start[2], end[2]) <= near:
        return None
    for a, b in ((start, end), (end, start)):
        if a[2] < near:
            a += (b - a) * (near - a[2]) / (b[2] - a[2])
    pixels = camera.project(np.stack([start, end]))
    return np.round(16.0 * np.clip(pixels, -4e3, 4e3)).astype(np.int32)
