"""Sets animated characters into footage: the picture that shows what the poses are worth."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip, Placement
from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.render.backends.choice import RendererName, new_renderer
from motorcade.render.backends.renderer import Renderer
from motorcade.render.composite import (
    Matching,
    as_rgb,
    blended,
    darken,
    exposed,
    frame_noise,
    greyed,
    is_grey,
    noisy,
    over,
)
from motorcade.render.figures import DrawnFigure, Performer, lit_together
from motorcade.render.lens import LensWarp
from motorcade.render.light import (
    ExposureMeter,
    Prints,
    above_ground,
    character_lighting,
    sunlight_direction,
)
from motorcade.render.occluders import known_depth, raised, share_on_ground
from motorcade.render.scene import DepthArray, ImageArray, Layer, Lighting
from motorcade.render.shadow import (
    ShadowLook,
    ground_depth,
    ground_shade,
    shade_in_picture,
)
from motorcade.tracking.cameras.camera import Camera

# In heights of the character: what is farther than this from the ground, above or below, takes no
# shadow; what is lower than this is the ground, as a sensor has it, and hides no foot.
LOW, SOLE = 0.1, 0.05

log = logging.getLogger("motorcade.overlay")

StampedFrame = tuple[int, ImageArray] | tuple[int, ImageArray, DepthArray | None]


def render_overlay(
    frames: Iterable[StampedFrame],
    camera: Camera,
    world_T_camera: Trajectory,
    character: Character,
    clip: Clip,
    placement: Placement,
    *,
    light_direction: ArrayLike | None = None,
    lighting: Lighting | None = None,
    look: ShadowLook | None = None,
    matching: Matching | None = None,
    prints: Prints | None = None,
    meter: ExposureMeter | None = None,
    renderer: RendererName = "fast",
) -> Iterator[ImageArray]:
    """Draw a placed character with its shadow into every frame that has a pose.

    Poses between stamps are interpolated. A frame outside the span of the trajectory comes back
    as it is. The clip starts at the first frame. The same input gives the same bytes on the same
    OpenGL driver.

    Args:
        frames: (stamp in ns, uint8 picture (h, w) or (h, w, 3) RGB) and, where it is known, the
            depth (h, w) in metres of what the camera saw: it hides the character where it is
            nearer.
        camera: of the frames' size. The frames of a camera with distortion stay as they are: what
            is drawn is distorted as by its lens (see `LensWarp`).
        world_T_camera: the camera's path, in the world of the placement.
        character: who is drawn.
        clip: what it does; one of its clips, or another for the same skeleton.
        placement: where it stands and how large it is.
        light_direction: (3,) the way the light travels in the world; by default from high over
            the viewer's left shoulder.
        lighting: all the light, in place of one that is made for the viewer.
        look: of the shadow.
        matching: how what is drawn is fitted to the footage; its noise is the same in every run.
        prints: boards and markers whose place is known: where a frame has no depth, they and the
            ground hide what is behind them.
        meter: of the footage's exposure, which what is drawn then follows.
        renderer: that draws; see `new_renderer`.

    Yields:
        uint8 (h, w, 3) RGB, one a frame.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a frame of another size, light from below ground, a direction and a lighting
            both, a lens too wide to draw for, or an unknown renderer.
    """
    yield from render_performers(
        frames,
        camera,
        world_T_camera,
        [Performer(character, clip, placement)],
        light_direction=light_direction,
        lighting=lighting,
        look=look,
        matching=matching,
        prints=prints,
        meter=meter,
        renderer=renderer,
    )


def render_performers(
    frames: Iterable[StampedFrame],
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
) -> Iterator[ImageArray]:
    """Draw characters and props with their shadows into every frame that has a pose.

    See `render_overlay` for what is not told here. Each throws its shadow on the ground of its own
    placement, wherever that moves. What lies beneath the ground of the first one whose ground does
    not move is hidden.

    Args:
        frames: as for one alone.
        camera: of the frames' size.
        world_T_camera: the camera's path.
        performers: who and what is drawn, one or more.
        light_direction: (3,) the way the light travels in the world.
        lighting: all the light, made for the first; its lamps and shadows are spread over all.
        look: of the shadows.
        matching: how what is drawn is fitted to the footage.
        prints: as for one alone.
        meter: of the footage's exposure.
        renderer: that draws.

    Yields:
        uint8 (h, w, 3) RGB, one a frame.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: as `render_overlay`.
    """
    if light_direction is not None and lighting is not None:
        raise ValueError("render_overlay: expected light_direction or lighting, got both")
    first = performers[0]
    light = lighting or _usual_light(first, world_T_camera, light_direction)
    stage = _Stage(camera, performers, light, look or ShadowLook(), prints)
    matched = matching or Matching()
    rng = np.random.default_rng(0)
    span_ns = int(world_T_camera.time_ns[0]), int(world_T_camera.time_ns[-1])
    start_ns: int | None = None
    posed, seen = 0, False
    pinhole = stage.lens.pinhole
    with new_renderer(renderer, pinhole.width, pinhole.height) as drawing:
        drawing.show([figure.surface for figure in stage.figures], stage.lighting)
        for time_ns, picture, *rest in frames:
            start_ns = time_ns if start_ns is None else start_ns
            frame = as_rgb(picture)
            if frame.shape[:2] != (camera.height, camera.width):
                raise ValueError(
                    f"frames: expected {camera.width} x {camera.height} pixels, got "
                    f"{frame.shape[1]} x {frame.shape[0]} at {time_ns} ns"
                )
            if not span_ns[0] <= time_ns <= span_ns[1]:
                yield frame
                continue
            depth_m = rest[0] if rest else None
            drawn = [
                stage.draw(
                    drawing,
                    world_T_camera.motors_at(moment),
                    1e-9 * (moment - start_ns),
                    int(moment),
                    measured=depth_m is not None,
                )
                for moment in np.clip(matched.moments_ns(time_ns), *span_ns)
            ]
            gain = 1.0
            if meter is not None:
                gain = meter.gain(frame, camera, world_T_camera.motors_at(time_ns))
            posed += 1
            seen |= any(one.layer.rgba.any() for one in drawn)
            yield stage.laid_over(frame, drawn, depth_m, matched, gain, rng)
    if posed and not seen:
        log.warning(
            "overlay: no figure shows a pixel in %d frames with poses; the first stands at %s m, "
            "%.3g m tall: out of the pictures, behind the camera, or too small",
            posed,
            np.round(first.world_T_character(start_ns or 0).translation_m, 3).tolist(),
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
        given = checked_floats(light_direction, "light_direction", (3,))
        length = np.linalg.norm(given)
        if length == 0.0:
            raise ValueError("light_direction: expected a vector with a length, got zeros")
        direction = given / length
    height_m = placement.scale * first.character.height_m
    light = character_lighting(placement, cameras, height_m, direction)
    return above_ground(light, placement.world_T_character.translation_m, placement.up)


@dataclass(frozen=True, eq=False)
class _Drawn:
    """One moment in the footage's pixels: layer, shade, where depth was measured the depth
    of the ground and the camera's height above it, and where not the depth of what is known to hide
    the figure.
    """

    layer: Layer
    shade: FloatArray | None
    ground_m: DepthArray | None
    known_m: DepthArray | None
    eye_m: float = 0.0


class _Stage:
    """What stays the same over all frames: surfaces, light, and the ground with its shadows."""

    def __init__(
        self,
        camera: Camera,
        figures: Sequence[Performer],
        lighting: Lighting,
        look: ShadowLook,
        prints: Prints | None,
    ) -> None:
        self.lens = LensWarp(camera)
        self.figures = [DrawnFigure(figure) for figure in figures]
        self.look, self.prints, self.lighting = look, prints, lit_together(lighting, self.figures)
        self.height_m = max(figure.height_m for figure in self.figures)
        still = [figure for figure in self.figures if figure.performer.ground_motion is None]
        self.ground = (still or self.figures)[0].performer

    def draw(
        self,
        renderer: Renderer,
        world_T_camera: Motor,
        time_s: float,
        time_ns: int,
        *,
        measured: bool,
    ) -> _Drawn:
        """The figures and their shade at one moment, as the footage's camera sees them."""
        moved, grounds = [], []
        for k, figure in enumerate(self.figures):
            own_m, normals = figure.at(time_s, time_ns)
            ground = figure.performer.world_T_ground(time_ns)
            if not figure.seen(time_s):  # all of it at one point: nothing to draw
                own_m = np.broadcast_to(own_m.mean(axis=0), own_m.shape)
            renderer.move(k, ground.apply(own_m), ground.rotor.apply(normals))
            moved.append(own_m)
            grounds.append(ground)
        self._follow(renderer, moved[0], grounds[0], time_ns)
        pinhole = self.lens.pinhole
        layer = self.lens.layer(renderer.render(pinhole, world_T_camera))
        camera_T_world = world_T_camera.inverse()
        there = [figure.seen(time_s) for figure in self.figures]
        shades = [
            self._shade(figure, own_m, camera_T_world, ground)
            for figure, own_m, ground, here in zip(self.figures, moved, grounds, there, strict=True)
            if here
        ]
        seen = [one for one in shades if one is not None]
        # One sun throws them: where shadows lie over one another it is hidden once.
        shade = np.maximum.reduce(seen) if seen else None
        stand = self.ground.world_T_ground(time_ns)
        if measured:
            camera_T_ground = camera_T_world @ stand
            ground_m = ground_depth(pinhole, camera_T_ground).astype(np.float32)
            eye_m = float(camera_T_ground.inverse().translation_m[2])
            return _Drawn(layer, shade, self.lens.depth(ground_m), None, eye_m)
        corners = [
            ground.apply(box_corners(own_m)) for own_m, ground in zip(moved, grounds, strict=True)
        ]
        hull_m = np.concatenate(corners)
        known = known_depth(pinhole, world_T_camera, hull_m, self.prints, stand)
        return _Drawn(layer, shade, None, None if known is None else self.lens.depth(known))

    def _follow(self, renderer: Renderer, own_m: FloatArray, ground: Motor, time_ns: int) -> None:
        """Light that goes where one that walks alone goes, or all go on one ground that moves."""
        first = self.figures[0]
        alone = len(self.figures) == 1 and first.travels
        motions = {id(figure.performer.ground_motion) for figure in self.figures}
        together = len(motions) == 1 and first.performer.ground_motion is not None
        if first.performer.motion is not None or not (alone or together):
            return
        stand = first.performer.placement.world_T_character
        center_m = first.center_m(own_m) if alone else np.zeros(3)
        light = self.lighting.translated_by(ground.apply(center_m) - stand.translation_m)
        ball_m = (ground @ stand.inverse()).apply(self.lighting.shadow_center_m)
        x, y, z = (ball_m + ground.rotor.apply(center_m)).tolist()
        renderer.relight(replace(light, shadow_center_m=(x, y, z)))

    def _shade(
        self, figure: DrawnFigure, own_m: FloatArray, camera_T_world: Motor, ground: Motor
    ) -> FloatArray | None:
        """The share of the stored values that a figure takes from each pixel's ground."""
        sun, strength = figure.sun_on(ground, self.lighting)
        center_m = figure.shade_center_m(own_m, sun)
        shade = ground_shade(
            own_m - center_m,
            figure.character.triangles,
            sun,
            figure.half_width_m,
            self.look,
            strength,
        )
        camera_T_shade = camera_T_world @ ground @ Motor.from_translation(center_m)
        seen = shade_in_picture(shade, figure.half_width_m, self.lens.pinhole, camera_T_shade)
        return seen if seen is None else self.lens.smooth(seen)

    def laid_over(
        self,
        frame: ImageArray,
        drawn: list[_Drawn],
        depth_m: DepthArray | None,
        matching: Matching,
        gain: float,
        rng: np.random.Generator,
    ) -> ImageArray:
        """One frame: the shade on the ground, then the character over it."""
        layer = exposed(blended([one.layer for one in drawn]), gain * matching.gain)
        layer = greyed(layer) if is_grey(frame) else layer
        middle = drawn[len(drawn) // 2]
        hiding_m = middle.known_m if depth_m is None else depth_m
        raised_m = None
        if depth_m is not None and middle.ground_m is not None:
            raised_m = raised(depth_m, middle.ground_m, middle.eye_m)
            hiding_m = np.where(raised_m < SOLE * self.height_m, np.float32(0.0), depth_m)
        if hiding_m is not None:
            layer = Layer(layer.rgba, _depth_to_the_rim(layer))
        sigma = frame_noise(frame) if matching.noise is None else matching.noise
        shades = [one.shade for one in drawn if one.shade is not None]
        if shades:
            shade = shades[0] if len(shades) == 1 else np.mean(shades, axis=0)
            if raised_m is not None:
                shade = shade * share_on_ground(raised_m, LOW * self.height_m)
            frame = darken(frame, shade)
        return noisy(over(frame, layer, hiding_m), layer.rgba[..., 3] / 255.0, sigma, rng)


def _depth_to_the_rim(layer: Layer) -> DepthArray:
    """Depth of a layer, with its partly covered rim given the depth next to it."""
    wider = cv2.dilate(layer.depth_m, np.ones((3, 3), dtype=np.uint8))
    return np.asarray(np.where(layer.depth_m > 0.0, layer.depth_m, wider), dtype=np.float32)
