"""Sets an animated character into footage: the picture that shows what the poses are worth."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip, Placement, skin
from motorcade.animation.skin import Skinner
from motorcade.ga import FloatArray, Motor, Similarity, Trajectory, checked_floats
from motorcade.render.backends.renderer import Renderer, RendererName, new_renderer
from motorcade.render.composite import as_rgb, darken, over
from motorcade.render.lens import LensWarp
from motorcade.render.light import character_lighting, sun_share, sunlight_direction
from motorcade.render.matching import Matching, blended, exposed, frame_noise, noisy
from motorcade.render.scene import DepthArray, ImageArray, Layer, Lighting, Surface
from motorcade.render.shadow import (
    BYTES_POWER,
    ShadowLook,
    ground_depth,
    ground_shade,
    shade_in_picture,
)
from motorcade.tracking.camera import Camera

# Half-width of the ground that can take a shadow, in heights of the character.
SHADOW_REACH = 1.6
# What stands higher than this above the ground, in heights of the character, takes no shadow.
LOW = 0.1

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
            is drawn is bent as its lens bends (see `LensWarp`).
        world_T_camera: the camera's path, in the world of the placement.
        character: who is drawn.
        clip: what it does; one of its clips, or another for the same skeleton.
        placement: where it stands and how large it is.
        light_direction: (3,) the way the light travels in the world; by default from high over
            the viewer's left shoulder.
        lighting: all the light, in place of one that is made for the viewer.
        look: of the shadow.
        matching: how what is drawn is fitted to the footage; its noise is the same in every run.
        renderer: that draws; see `new_renderer`.

    Yields:
        uint8 (h, w, 3) RGB, one a frame.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a frame of another size, light from below ground, a direction and a lighting
            both, a lens too wide to be bent, or an
            unknown renderer.
    """
    if light_direction is not None and lighting is not None:
        raise ValueError("render_overlay: expected light_direction or lighting, got both")
    light = lighting or _usual_light(placement, world_T_camera, character, light_direction)
    stage = _Stage(camera, character, clip, placement, light, look or ShadowLook())
    matched = matching or Matching()
    rng = np.random.default_rng(0)
    span_ns = int(world_T_camera.time_ns[0]), int(world_T_camera.time_ns[-1])
    start_ns: int | None = None
    pinhole = stage.lens.pinhole
    with new_renderer(renderer, pinhole.width, pinhole.height) as drawing:
        drawing.show([stage.surface], light)
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
                    drawing, world_T_camera.motors_at(moment), 1e-9 * (moment - start_ns),
                    with_ground=depth_m is not None,
                )
                for moment in np.clip(matched.moments_ns(time_ns), *span_ns)
            ]  # fmt: skip
            yield stage.laid_over(frame, drawn, depth_m, matched, rng)


def _usual_light(
    placement: Placement,
    world_T_camera: Trajectory,
    character: Character,
    light_direction: ArrayLike | None,
) -> Lighting:
    """Sun, fill and rim as they flatter the character."""
    cameras = world_T_camera.motors
    if light_direction is None:
        direction = sunlight_direction(placement, cameras)
    else:
        given = checked_floats(light_direction, "light_direction", (3,))
        length = np.linalg.norm(given)
        if length == 0.0:
            raise ValueError("light_direction: expected a vector with a length, got zeros")
        direction = given / length
    return character_lighting(placement, cameras, placement.scale * character.height_m, direction)


Drawn = tuple[Layer, FloatArray | None, DepthArray | None]
"""What is drawn at one moment: layer, shade in bytes, and where asked the depth of the ground."""


class _Stage:
    """What stays the same over all frames: surface, light, and the ground with its shadow."""

    def __init__(
        self,
        camera: Camera,
        character: Character,
        clip: Clip,
        placement: Placement,
        lighting: Lighting,
        look: ShadowLook,
    ) -> None:
        self.lens = LensWarp(camera)
        self._skinner = Skinner(character, "linear")
        self.character, self.clip, self.placement, self.look = character, clip, placement, look
        self.height_m = placement.scale * character.height_m
        stand = placement.world_T_character
        sun = np.array(lighting.sun.direction) / np.linalg.norm(lighting.sun.direction)
        self.ground_light = stand.rotor.inverse().apply(sun)
        up = stand.rotor.apply(np.array([0.0, 0.0, 1.0]))
        self.strength = sun_share(lighting, stand.translation_m, up)
        self.half_width_m = SHADOW_REACH * self.height_m
        self.surface = Surface(
            placement.apply(character.vertices),
            stand.rotor.apply(character.normals),
            character.triangles,
            character.colors,
            roughness=0.42,
        )

    def draw(
        self, renderer: Renderer, world_T_camera: Motor, time_s: float, *, with_ground: bool
    ) -> Drawn:
        """The character and its shade at one moment, as the footage's camera sees them."""
        vertices, normals = self._skinned(self.clip.at(time_s))
        stand = self.placement.world_T_character
        renderer.move(0, self.placement.apply(vertices), stand.rotor.apply(normals))
        pinhole = self.lens.pinhole
        layer = self.lens.layer(renderer.render(pinhole, world_T_camera))
        shade = ground_shade(
            self.placement.scale * vertices,
            self.character.triangles,
            self.ground_light,
            self.half_width_m,
            self.look,
            self.strength,
        )
        camera_T_ground = world_T_camera.inverse() @ stand
        stored = 1.0 - (1.0 - np.clip(shade, 0.0, 1.0)) ** BYTES_POWER
        seen = shade_in_picture(stored, self.half_width_m, pinhole, camera_T_ground)
        bent = seen if seen is None else self.lens.smooth(seen)
        if not with_ground:
            return layer, bent, None
        ground = ground_depth(pinhole, camera_T_ground).astype(np.float32)
        return layer, bent, self.lens.depth(ground)

    def _skinned(self, pose: Motor | Similarity) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals in character space, compiled where joints are rigid."""
        if isinstance(pose, Similarity):
            return skin(self.character, pose)
        vertices, normals = self._skinner.skin(pose)
        return vertices.astype(np.float64), normals.astype(np.float64)

    def laid_over(
        self,
        frame: ImageArray,
        drawn: list[Drawn],
        depth_m: DepthArray | None,
        matching: Matching,
        rng: np.random.Generator,
    ) -> ImageArray:
        """One frame: the shade on the ground, then the character over it."""
        layer = exposed(blended([one[0] for one in drawn]), matching.gain)
        shades = [one[1] for one in drawn if one[1] is not None]
        if depth_m is not None:
            layer = Layer(layer.rgba, _depth_to_the_rim(layer))
        sigma = frame_noise(frame) if matching.noise is None else matching.noise
        if shades:
            shade = shades[0] if len(shades) == 1 else np.mean(shades, axis=0)
            ground = drawn[len(drawn) // 2][2]
            if depth_m is not None and ground is not None:
                above = (depth_m > 0.0) & (depth_m < ground - LOW * self.height_m)
                shade = np.where(above, 0.0, shade)
            frame = darken(frame, shade)
        return noisy(over(frame, layer, depth_m), layer.rgba[..., 3] / 255.0, sigma, rng)


def _depth_to_the_rim(layer: Layer) -> DepthArray:
    """Depth of a layer, with its partly covered rim given the depth next to it."""
    wider = cv2.dilate(layer.depth_m, np.ones((3, 3), dtype=np.uint8))
    return np.asarray(np.where(layer.depth_m > 0.0, layer.depth_m, wider), dtype=np.float32)
