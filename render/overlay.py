"""Draws animated characters: into footage, or on an empty stage; by a renderer of a name."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip, Placement, place_on_plane
from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats, checked_positive
from motorcade.ga.lookahead import ahead
from motorcade.ga.names import nearest_name
from motorcade.render.backends.fast import FastRenderer
from motorcade.render.backends.pyrender_backend import OffscreenRenderer
from motorcade.render.backends.renderer import Renderer
from motorcade.render.composite import Matching
from motorcade.render.figures import FigureSeen, Performer
from motorcade.render.light import ExposureMeter, Prints, character_lighting, sunlight_direction
from motorcade.render.light.lamps import above_ground
from motorcade.render.scene import ImageArray, Lighting
from motorcade.render.shadow import ShadowLook
from motorcade.render.shots import AnyFrame, FilmStage
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.sweep import SceneViews

RendererName = Literal["fast", "pyrender"]
RENDERERS: tuple[RendererName, ...] = get_args(RendererName)


def new_renderer(name: str, width: int, height: int) -> Renderer:
    """The renderer of a name.

    Args:
        name: one of `RENDERERS`; docs/rendering.md says when to take which.
        width: of the images, pixels.
        height: of the images, pixels.

    Raises:
        ValueError: another name, or a size that is not positive.
        RenderUnavailable: this machine has no OpenGL.

    >>> from motorcade.render import new_renderer
    >>> new_renderer("paper", 640, 480)
    Traceback (most recent call last):
    ValueError: renderer: expected one of fast, pyrender, got 'paper'
    """
    if name == "fast":
        return FastRenderer(width, height)
    if name == "pyrender":
        return OffscreenRenderer(width, height)
    known = ", ".join(RENDERERS)
    near = nearest_name(name, RENDERERS)
    raise ValueError(f"renderer: expected one of {known}, got {name!r}{near}")


log = logging.getLogger("motorcade.overlay")


def render_overlay(
    frames: Iterable[AnyFrame],
    camera: Camera,
    world_T_camera: Trajectory,
    character: Character,
    clip: Clip,
    placement: Placement,
    **options: Any,
) -> Iterator[ImageArray]:
    """Draw one placed character, whose clip starts at the first frame, as `render_performers` does.

    Its clip is one of its own, or another for the same skeleton; options are those named there.
    """
    performers = [Performer(character, clip, placement)]
    return render_performers(frames, camera, world_T_camera, performers, **options)


def render_performers(
    frames: Iterable[AnyFrame],
    camera: Camera,
    world_T_camera: Trajectory,
    performers: Sequence[Performer],
    *,
    light_direction: ArrayLike | None = None,
    lighting: Lighting | None = None,
    look: ShadowLook | None = None,
    matching: Matching | None = None,
    prints: Prints | None = None,
    meter: ExposureMeter | None = None,
    views: SceneViews | None = None,
    renderer: RendererName = "fast",
    visibility: list[tuple[FigureSeen, ...] | None] | None = None,
) -> Iterator[ImageArray]:
    """Draw characters and props with their shadows into every frame that has a pose.

    Each throws its shadow on the ground of its own placement, wherever that moves; what lies
    beneath the ground of the first one whose ground does not move is hidden. Poses between stamps
    are interpolated; a frame outside the span of the trajectory comes back as it is. The same input
    gives the same bytes on the same OpenGL driver.

    Args:
        frames: (stamp in ns, uint8 image (h, w) or (h, w, 3) RGB) and, where it is known, the
            depth (h, w) in metres of what the camera saw: it hides figures where it is nearer;
            the mask (h, w) of what moves: it hides figures unless that is seen to stand behind them
            (`tracking.masks.standing_depth`); and the focal length over the camera's, where
            the lens zooms.
        camera: of the frames' size. The frames of a camera with distortion stay as they are: what
            is drawn is distorted as by its lens (see `LensWarp`).
        world_T_camera: the camera's path, in the world of the placements.
        performers: who and what is drawn, one or more.
        light_direction: (3,) the way the light travels in the world; by default from high over
            the viewer's left shoulder.
        lighting: all the light, made for the first, in place of one that is made for the viewer;
            its lamps and shadows are spread over all.
        look: of the shadows.
        matching: how what is drawn is fitted to the footage; its noise is the same in every run.
        prints: boards and markers whose place is known: where a frame has no depth, they and the
            ground hide what is behind them.
        meter: of the footage's exposure, which what is drawn then follows.
        views: of the still scene by `LensWarp(camera).pinhole`: where a frame has no depth, what
            they show before figures hides these.
        renderer: that draws; see `new_renderer`.
        visibility: takes up, frame by frame, what each performer shows; None without a pose.

    Yields:
        uint8 (h, w, 3) RGB, one a frame.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a frame of another size, light from below ground, a direction and a lighting
            both, or an unknown renderer.
    """
    if light_direction is not None and lighting is not None:
        raise ValueError("render_overlay: expected light_direction or lighting, got both")
    first = performers[0]
    light = lighting or _usual_light(first, world_T_camera, light_direction)
    stage = FilmStage(camera, performers, light, look, prints, matching, views)
    pinhole, rng = stage.lens.pinhole, np.random.default_rng(0)
    if stage.lens.drawable < 1.0:
        log.warning(
            "overlay: the lens as described has no use for %.1f %% of the image (its terms fold "
            "back there, or it sees too far aside): nothing is drawn there, the footage stays",
            100.0 * (1.0 - stage.lens.drawable),
        )
    posed, seen = 0, False
    with new_renderer(renderer, pinhole.width, pinhole.height) as drawing:
        drawing.show([figure.surface for figure in stage.figures], stage.lighting)
        shots = stage.shots(drawing, frames, world_T_camera, meter)
        for image, shows in ahead(partial(stage.composed, rng), shots):
            posed += shows is not None
            seen |= any(figure.drawn_px > 0.0 for figure in shows or ())
            if visibility is not None:
                visibility.append(shows)
            yield image
    if posed and not seen:
        log.warning(
            "overlay: no figure shows a pixel in %d frames with poses; the first stands at %s m, "
            "%.3g m tall: out of the images, behind the camera, or too small",
            posed,
            np.round(first.world_T_character(stage.start_ns or 0).translation_m, 3).tolist(),
            stage.figures[0].height_m,
        )


def _usual_light(
    first: Performer, world_T_camera: Trajectory, light_direction: ArrayLike | None
) -> Lighting:
    """Sun, fill and rim as they flatter the first figure."""
    cameras, placement = world_T_camera.motors, first.placement
    if light_direction is None:
        direction = sunlight_direction(placement, cameras)
    else:
        vector = checked_floats(light_direction, "light_direction", (3,))
        length = np.linalg.norm(vector)
        if length == 0.0:
            raise ValueError("light_direction: expected a vector with a length, got zeros")
        direction = vector / length
    height_m = placement.scale * first.character.height_m
    light = character_lighting(placement, cameras, height_m, direction)
    return above_ground(light, placement.world_T_character.translation_m, placement.up)


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
