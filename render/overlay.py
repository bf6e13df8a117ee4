"""Sets animated characters into footage: the image that shows what the poses are worth."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip, Placement
from motorcade.ga import Trajectory
from motorcade.ga.arrays import checked_floats
from motorcade.ga.lookahead import ahead
from motorcade.render.backends.choice import RendererName, new_renderer
from motorcade.render.composite import Matching
from motorcade.render.figures import Performer
from motorcade.render.light import (
    ExposureMeter,
    Prints,
    above_ground,
    character_lighting,
    sunlight_direction,
)
from motorcade.render.scene import ImageArray, Lighting
from motorcade.render.shadow import ShadowLook
from motorcade.render.shots import AnyFrame, FilmStage
from motorcade.render.visibility import FigureSeen
from motorcade.tracking.cameras.camera import Camera

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
    stage = FilmStage(camera, performers, light, look, prints, matching)
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
