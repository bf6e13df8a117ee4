"""Sets an animated character into footage: the picture that shows what the poses are worth."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import cv2
import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, Clip, Placement, skin
from motorcade.ga import Motor, Similarity, Trajectory, checked_floats
from motorcade.render.backends.renderer import Renderer, RendererName, new_renderer
from motorcade.render.composite import as_rgb, darken, over
from motorcade.render.light import character_lighting, sunlight_direction
from motorcade.render.scene import DepthArray, ImageArray, Layer, Surface
from motorcade.render.shadow import (
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
    renderer: RendererName = "fast",
) -> Iterator[ImageArray]:
    """Draw a placed character with its shadow into every frame that has a pose.

    Poses between stamps are interpolated. A frame outside the span of the trajectory comes back
    as it is. The clip starts at the first frame. The same input gives the same bytes on the same
    OpenGL driver.

    Args:
        frames: (stamp in ns, uint8 picture (h, w) or (h, w, 3) RGB without lens distortion) and,
            where it is known, the depth (h, w) in metres of what the camera saw: it hides the
            character where it is nearer.
        camera: pinhole, of the frames' size.
        world_T_camera: the camera's path, in the world of the placement.
        character: who is drawn.
        clip: what it does; one of its clips, or another for the same skeleton.
        placement: where it stands and how large it is.
        light_direction: (3,) the way the light travels in the world; by default from high over
            the viewer's left shoulder.
        renderer: one of `RENDERERS`.

    Yields:
        uint8 (h, w, 3) RGB, one a frame.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: a frame of another size, a camera with distortion, or light from below ground.
    """
    stage = _Stage(camera, world_T_camera.motors, character, placement, light_direction)
    first_ns, last_ns = int(world_T_camera.time_ns[0]), int(world_T_camera.time_ns[-1])
    start_ns: int | None = None
    with new_renderer(renderer, camera.width, camera.height) as drawing:
        drawing.show([stage.surface], stage.lighting)
        for time_ns, picture, *rest in frames:
            start_ns = time_ns if start_ns is None else start_ns
            frame = as_rgb(picture)
            if frame.shape[:2] != (camera.height, camera.width):
                raise ValueError(
                    f"frames: expected {camera.width} x {camera.height} pixels, got "
                    f"{frame.shape[1]} x {frame.shape[0]} at {time_ns} ns"
                )
            if not first_ns <= time_ns <= last_ns:
                yield frame
                continue
            pose = world_T_camera.motors_at(np.int64(time_ns))
            local = clip.at((time_ns - start_ns) * 1e-9)
            yield stage.draw(drawing, frame, rest[0] if rest else None, pose, local)


class _Stage:
    """What stays the same over all frames: surface, light, and the ground with its shadow."""

    def __init__(
        self,
        camera: Camera,
        cameras: Motor,
        character: Character,
        placement: Placement,
        light_direction: ArrayLike | None,
    ) -> None:
        self.camera, self.character, self.placement = camera, character, placement
        self.height_m = height_m = placement.scale * character.height_m
        if light_direction is None:
            direction = sunlight_direction(placement, cameras)
        else:
            given = checked_floats(light_direction, "light_direction", (3,))
            direction = given / np.linalg.norm(given)
        self.ground_light = placement.world_T_character.rotor.inverse().apply(direction)
        self.half_width_m = SHADOW_REACH * height_m
        self.look = ShadowLook()
        self.lighting = character_lighting(placement, cameras, height_m, direction)
        self.surface = Surface(
            placement.apply(character.vertices),
            placement.world_T_character.rotor.apply(character.normals),
            character.triangles,
            character.colors,
            roughness=0.42,
        )

    def draw(
        self,
        renderer: Renderer,
        frame: ImageArray,
        depth_m: DepthArray | None,
        world_T_camera: Motor,
        local_pose: Motor | Similarity,
    ) -> ImageArray:
        """One frame: shadow on the ground, then the character over it."""
        vertices, normals = skin(self.character, local_pose)
        stand = self.placement.world_T_character
        renderer.move(0, self.placement.apply(vertices), stand.rotor.apply(normals))
        layer = renderer.render(self.camera, world_T_camera)
        shade = ground_shade(
            self.placement.scale * vertices,
            self.character.triangles,
            self.ground_light,
            self.half_width_m,
            self.look,
        )
        camera_T_ground = world_T_camera.inverse() @ stand
        seen = shade_in_picture(shade, self.half_width_m, self.camera, camera_T_ground)
        if depth_m is not None:
            layer = Layer(layer.rgba, _depth_to_the_rim(layer))
            if seen is not None:
                ground = ground_depth(self.camera, camera_T_ground)
                above = (depth_m > 0.0) & (depth_m < ground - LOW * self.height_m)
                seen = np.where(above, 0.0, seen)
        if seen is not None:
            frame = darken(frame, seen)
        return over(frame, layer, depth_m)


def _depth_to_the_rim(layer: Layer) -> DepthArray:
    """Depth of a layer, with its partly covered rim given the depth next to it."""
    wider = cv2.dilate(layer.depth_m, np.ones((3, 3), dtype=np.uint8))
    return np.asarray(np.where(layer.depth_m > 0.0, layer.depth_m, wider), dtype=np.float32)
