"""Frames on their way through the overlay: figures posed, drawn, hidden, and laid over footage.

Only the part of an image that figures and their shade can change is distorted, shaded and mixed.
Without measured depth, a board or a marker with a known pose is a rectangle and the ground is a
plane; both have a depth in every image, and hide things by the same rule as measured depth does.
Measured depth also shows how high things stand on the ground.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
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
    seen_share,
)
from motorcade.render.figures import DrawnFigure, FigureSeen, Performer, figures_seen, lit_together
from motorcade.render.lens import (
    WHOLE,
    Extent,
    LensWarp,
    Window,
    plane_homography,
    seen_extent,
)
from motorcade.render.light import ExposureMeter, Prints
from motorcade.render.light.ground import MOST_OVER, PAPER
from motorcade.render.light.lamps import light_on
from motorcade.render.occluders import SceneOccluders
from motorcade.render.scene import DepthArray, ImageArray, Layer, Lighting
from motorcade.render.shadow import (
    NEAREST_M,
    ShadeArray,
    ShadowLook,
    ground_depth,
    ground_shade,
    shade_extent,
    shade_in_image,
)
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.sweep import SceneViews
from motorcade.tracking.masks import fill_masked, standing_depth

# In heights of the character: what is farther than this from the ground, above or below, takes no
# shadow; what is lower than this is the ground, as a sensor has it, and hides no foot.
LOW, SOLE = 0.1, 0.05


class StampedFrame(NamedTuple):
    """A frame to draw into; a plain tuple of the first ones serves as well.

    Fields:
        time_ns: its stamp.
        image: grey or RGB, as the lens took it.
        depth_m: ``(h, w)`` along the axis, 0 where it is unknown.
        mask: ``(h, w)`` uint8, 255 where somebody is before the scene.
        zoom: its focal length over the camera's.
    """

    time_ns: int
    image: ImageArray
    depth_m: DepthArray | None = None
    mask: ImageArray | None = None
    zoom: float = 1.0


AnyFrame = StampedFrame | tuple[int, ImageArray] | tuple[int, ImageArray, DepthArray | None]


@dataclass(frozen=True, eq=False)
class _PosedFigure:
    """A figure at a moment: its mesh on its ground, and what it takes from that about a centre.

    No shade where it is not there, nor on a ground that has none.
    """

    figure: DrawnFigure
    world_T_ground: Motor
    own_m: FloatArray
    normals: FloatArray
    shade: ShadeArray | None
    center_m: FloatArray

    def camera_T_shade(self, world_T_camera: Motor) -> Motor:
        """Where what it takes from the ground lies before a camera."""
        ground = self.world_T_ground @ Motor.from_translation(self.center_m)
        return world_T_camera.inverse() @ ground

    def hull_m(self) -> FloatArray:
        """Corners (8, 3) of a box about it, world."""
        return self.world_T_ground.apply(box_corners(self.own_m))


@dataclass(frozen=True, eq=False)
class _Moment:
    """All figures at a moment, before the camera."""

    time_ns: int
    world_T_camera: Motor
    figures: list[_PosedFigure]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """One moment in a window of the footage's pixels: layer, shade, where depth was measured the
    depth of the ground and the camera's height above it, and where not the depth of what is known
    to hide the figure.
    """

    layer: Layer
    shade: ShadeArray | None
    ground_m: DepthArray | None
    known_m: DepthArray | None
    figures: list[_PosedFigure]
    world_T_camera: Motor
    time_ns: int
    eye_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame, and what is to be laid over a window of it: nothing where there is no pose."""

    image: ImageArray
    lens: LensWarp
    drawn: list[_Drawn] | None = None
    window: Window = WHOLE
    depth_m: DepthArray | None = None
    gain: float = 1.0
    white: float = 1.0
    masked: tuple[ImageArray, DepthArray] | None = None


class FilmStage:
    """What stays the same over all frames: surfaces, light, and the ground with its shadows.

    Args:
        lighting: all the light, made for the first.
        look: of the shadows; None for the usual one.
        matching: how what is drawn is fitted to the footage; None for not at all.
        views: of the scene, to see what stands before the figures where no depth is measured.
    """

    def __init__(
        self,
        camera: Camera,
        performers: Sequence[Performer],
        lighting: Lighting,
        look: ShadowLook | None,
        prints: Prints | None,
        matching: Matching | None,
        views: SceneViews | None = None,
    ) -> None:
        self.lens = LensWarp(camera)
        self.figures = [DrawnFigure(figure, lighting) for figure in performers]
        self.lighting = lit_together(lighting, self.figures)
        self.height_m = max(figure.height_m for figure in self.figures)
        still = [figure for figure in self.figures if figure.performer.ground_motion is None]
        self.ground = (still or self.figures)[0].performer
        self.start_ns: int | None = None
        self._look, self._prints = look or ShadowLook(), prints
        self._occluders = None if views is None else SceneOccluders(views)
        self._matching = matching or Matching()
        stand = self.ground.placement
        light = np.add(*light_on(self.lighting, stand.world_T_character.translation_m, stand.up))
        self._paper = PAPER * float(np.mean(light))

    def shots(
        self,
        renderer: Renderer,
        frames: Iterable[AnyFrame],
        world_T_camera: Trajectory,
        meter: ExposureMeter | None,
    ) -> Iterator[Shot]:
        """Draw what is to be laid over each frame; the first one's stamp starts the clips.

        Raises ValueError: a frame of another size.
        """
        span_ns = int(world_T_camera.time_ns[0]), int(world_T_camera.time_ns[-1])
        unzoomed, matching = self.lens, self._matching
        for frame in frames:
            time_ns, image, depth_m, mask, zoom = StampedFrame(*frame)
            self.lens = unzoomed if zoom == 1.0 else unzoomed.zoomed(zoom)
            camera = self.lens.camera
            self.start_ns = time_ns if self.start_ns is None else self.start_ns
            if image.shape[:2] != (camera.height, camera.width):
                raise ValueError(
                    f"frames: expected {camera.width} x {camera.height} pixels, got "
                    f"{image.shape[1]} x {image.shape[0]} at {time_ns} ns"
                )
            if not span_ns[0] <= time_ns <= span_ns[1]:
                yield Shot(image, self.lens)
                continue
            moments = [
                self._posed(int(stamp_ns), world_T_camera.motors_at(stamp_ns))
                for stamp_ns in np.clip(matching.moments_ns(time_ns), *span_ns)
            ]
            window = self._window(moments)
            drawn = [self._draw(renderer, one, window, depth_m is not None) for one in moments]
            gain, white = matching.gain, 1.0
            pose = world_T_camera.motors_at(time_ns)
            if meter is not None:
                still = image if mask is None else fill_masked(image, mask)
                exposure = meter.gain(still, camera, pose)
                gain, white = (
                    gain * exposure,
                    float(np.clip(self._paper * exposure, 1.0, MOST_OVER)),
                )
            measured = None if depth_m is None else depth_m[window]
            if mask is None:
                yield Shot(image, self.lens, drawn, window, measured, gain, white)
                continue
            camera_T_ground = pose.inverse() @ self.ground.world_T_ground(time_ns)
            masked_m = standing_depth(mask, camera, camera_T_ground, depth_m)[window]
            masked = mask[window], masked_m
            yield Shot(image, self.lens, drawn, window, measured, gain, white, masked)

    def _posed(self, time_ns: int, world_T_camera: Motor) -> _Moment:
        """The figures, and what they take from their grounds."""
        time_s = 1e-9 * (time_ns - (self.start_ns or 0))
        figures = []
        for figure in self.figures:
            own_m, normals = figure.at(time_s, time_ns)
            ground = figure.performer.world_T_ground(time_ns)
            shade, center_m = None, np.zeros(3)
            if figure.performer.seen(time_s):
                sun, strength = figure.sun_on(ground, self.lighting)
                center_m = figure.shade_center_m(own_m, sun)
                shade = ground_shade(
                    own_m - center_m,
                    figure.character.triangles,
                    sun,
                    figure.half_width_m,
                    self._look,
                    strength,
                    self.lighting.sun.radius_rad,
                )
            else:  # all of it at one point: nothing to draw
                own_m = np.broadcast_to(own_m.mean(axis=0), own_m.shape)
            figures.append(_PosedFigure(figure, ground, own_m, normals, shade, center_m))
        return _Moment(time_ns, world_T_camera, figures)

    def _window(self, moments: Sequence[_Moment]) -> Window:
        """The part of the footage's images that figures and shade can change at some moments."""
        pinhole = self.lens.pinhole
        parts: list[Extent] = []
        for moment in moments:
            pose = moment.world_T_camera
            for figure in moment.figures:
                hull_m = pose.inverse().apply(figure.hull_m())
                parts.append(seen_extent(pinhole, hull_m, NEAREST_M, 1.0))
                if figure.shade is not None:
                    width_m, place = figure.figure.half_width_m, figure.camera_T_shade(pose)
                    part = shade_extent(figure.shade, width_m, pinhole, place)
                    parts += [] if part is None else [part]
        low, high = zip(*parts, strict=True)
        return self.lens.shown((np.min(low, axis=0), np.max(high, axis=0)))

    def _draw(self, renderer: Renderer, moment: _Moment, window: Window, measured: bool) -> _Drawn:
        """The figures and their shade, as the footage's camera sees them in a window."""
        for k, posed in enumerate(moment.figures):
            turn = posed.world_T_ground.rotor
            renderer.move(k, posed.world_T_ground.apply(posed.own_m), turn.apply(posed.normals))
        self._follow(renderer, moment.figures[0])
        pinhole, pose = self.lens.pinhole, moment.world_T_camera
        layer = self.lens.layer(renderer.render(pinhole, pose), window)
        part = self.lens.drawn(window)
        shades = [
            shade_in_image(
                figure.shade, figure.figure.half_width_m, pinhole, figure.camera_T_shade(pose), part
            )
            for figure in moment.figures
            if figure.shade is not None
        ]
        seen = [self.lens.smooth(one, window) for one in shades if one is not None]
        # One sun throws them: where shadows lie over one another it is hidden once.
        shade = np.maximum.reduce(seen) if seen else None
        stand = self.ground.world_T_ground(moment.time_ns)
        camera_T_ground = pose.inverse() @ stand
        hull_m = np.concatenate([one.hull_m() for one in moment.figures])
        known = None if measured else known_depth(pinhole, pose, hull_m, self._prints, stand)
        if known is None and not measured:
            return _Drawn(layer, shade, None, None, moment.figures, pose, moment.time_ns)
        ground_m = ground_depth(pinhole, camera_T_ground)
        eye_m = float(camera_T_ground.inverse().translation_m[2])
        known_m = None if known is None else self.lens.depth(known, window)
        stood_on_m = self.lens.depth(ground_m, window)
        return _Drawn(
            layer, shade, stood_on_m, known_m, moment.figures, pose, moment.time_ns, eye_m
        )

    def _follow(self, renderer: Renderer, posed: _PosedFigure) -> None:
        """Light that goes where one that walks alone goes, or all go on one ground that moves."""
        first, ground = self.figures[0], posed.world_T_ground
        alone = len(self.figures) == 1 and first.travels
        motions = {id(figure.performer.ground_motion) for figure in self.figures}
        together = len(motions) == 1 and first.performer.ground_motion is not None
        if first.performer.motion is not None or not (alone or together):
            return
        stand = first.performer.placement.world_T_character
        center_m = first.center_m(posed.own_m) if alone else np.zeros(3)
        light = self.lighting.translated_by(ground.apply(center_m) - stand.translation_m)
        ball_m = (ground @ stand.inverse()).apply(self.lighting.shadow_center_m)
        x, y, z = (ball_m + ground.rotor.apply(center_m)).tolist()
        renderer.relight(replace(light, shadow_center_m=(x, y, z)))

    def composed(
        self, rng: np.random.Generator, shot: Shot
    ) -> tuple[ImageArray, tuple[FigureSeen, ...] | None]:
        """A frame with all that lies over it, and what it shows of each figure.

        None without a pose.
        """
        frame = as_rgb(shot.image)
        if shot.drawn is None:
            return frame, None
        sigma = self._matching.noise
        sigma = frame_noise(shot.image) if sigma is None else sigma
        layer = exposed(blended([one.layer for one in shot.drawn]), shot.gain, self._matching.ends)
        layer = greyed(layer) if is_grey(frame) else layer
        part, visible = self._laid_over(frame[shot.window], layer, shot)
        alpha = layer.rgba[..., 3] / 255.0
        grained = alpha if visible is None else alpha * visible
        frame[shot.window] = noisy(part, grained, sigma, rng)
        middle = shot.drawn[len(shot.drawn) // 2]
        seen = figures_seen(
            shot.lens,
            shot.window,
            layer,
            visible,
            [one.own_m for one in middle.figures],
            [middle.world_T_camera.inverse() @ one.world_T_ground for one in middle.figures],
            [figure.height_m for figure in self.figures],
        )
        return frame, seen

    def _laid_over(
        self, frame: ImageArray, layer: Layer, shot: Shot
    ) -> tuple[ImageArray, FloatArray | None]:
        """A window of a frame: the shade on the ground, then the character over it; the share of
        that which nothing hides.
        """
        drawn, depth_m = shot.drawn or [], shot.depth_m
        middle = drawn[len(drawn) // 2]
        hiding_m = middle.known_m if depth_m is None else depth_m
        raised_m = None
        if depth_m is not None and middle.ground_m is not None:
            raised_m = raised(depth_m, middle.ground_m, middle.eye_m)
            hiding_m = np.where(raised_m < SOLE * self.height_m, np.float32(0.0), depth_m)
        visible, on_ground = None, np.ones(layer.depth_m.shape)
        if hiding_m is not None:
            visible = seen_share(_depth_to_the_rim(layer), hiding_m) / 256.0
        seen_before = None
        if self._occluders is not None and depth_m is None:
            seen_before = self._occluders.before(
                shot.image,
                shot.lens,
                shot.window,
                middle.time_ns,
                middle.world_T_camera,
                np.concatenate([one.hull_m() for one in middle.figures]),
                self.ground.world_T_ground(middle.time_ns),
            )
        if seen_before is not None:
            before, before_m = seen_before
            on_ground = 1.0 - before
            unhidden = np.where(before_m < _depth_to_the_rim(layer), on_ground, 1.0)
            visible = unhidden if visible is None else visible * unhidden
        if shot.masked is not None:
            unmasked, masked_m = 1.0 - shot.masked[0] / 255.0, shot.masked[1]
            on_ground = on_ground * unmasked
            before = np.where(masked_m < _depth_to_the_rim(layer), unmasked, 1.0)
            visible = before if visible is None else visible * before
        shades = [one.shade for one in drawn if one.shade is not None]
        if shades:
            shade = shades[0] if len(shades) == 1 else np.mean(shades, axis=0)
            if raised_m is not None:
                shade = shade * share_on_ground(raised_m, LOW * self.height_m)
            elif middle.known_m is not None and middle.ground_m is not None:
                shade = shade * share_beyond(middle.known_m, middle.ground_m)
            frame = darken(frame, shade * on_ground, shot.white)
        return over(frame, layer, visible=visible), visible


def _depth_to_the_rim(layer: Layer) -> DepthArray:
    """Depth of a layer, with its partly covered rim given the depth next to it."""
    wider = cv2.dilate(layer.depth_m, np.ones((3, 3), dtype=np.uint8))
    return np.asarray(np.where(layer.depth_m > 0.0, layer.depth_m, wider), dtype=np.float32)


# What has sunk into a plane by less than this share of its height is held to stand on it.
SUNK = 1e-3
# Planes through the eye, nearly, are seen edge on and hide nothing.
EDGE_ON = 1e12
# A thing is before the ground, and not on it, where it is nearer by this share.
NEARER = 1e-3
# Of the edge between what takes a shadow and what does not.
SOFT_PX = 1.5


def known_depth(
    camera: Camera,
    world_T_camera: Motor,
    figure_m: FloatArray,
    prints: Prints | None,
    world_T_ground: Motor,
) -> DepthArray | None:
    """Depth of the nearest thing that is known without a sensor, in every pixel.

    Args:
        camera: pinhole.
        world_T_camera: its pose, batch shape ().
        figure_m: (C, 3) corners of a hull of what is drawn, world: a plane that has it and the
            camera on one side hides nothing of it and is left out.
        prints: rectangles that hide from both sides.
        world_T_ground: a plane z = 0 without end that hides what lies beneath it; a camera that is
            beneath it itself sees through, for then it is no ground.

    Returns:
        (height, width) float32 metres along the optical axis, 0 where nothing is known; or None
        where nothing can hide the figure.
    """
    nearest = np.full((camera.height, camera.width), np.inf, dtype=np.float32)
    hides = False
    camera_T_world = world_T_camera.inverse()
    eye_m = world_T_camera.translation_m
    if _side(world_T_ground, eye_m) > 0.0 and _between(world_T_ground, eye_m, figure_m):
        hides = True
        nearest[:] = ground_depth(camera, camera_T_world @ world_T_ground)
    for k in range(0 if prints is None else len(prints)):
        assert prints is not None  # counted above
        world_T_print = prints.world_T_print[k]
        if _between(world_T_print, eye_m, figure_m):
            hides = True
            low, high = prints.low_m[k] - prints.margin_m, prints.high_m[k] + prints.margin_m
            _lay(nearest, camera, camera_T_world @ world_T_print, low, high)
    return np.where(np.isfinite(nearest), nearest, np.float32(0.0)) if hides else None


def _side(world_T_plane: Motor, points_m: FloatArray) -> FloatArray:
    """Heights (C,) above a plane, metres."""
    return np.asarray(world_T_plane.inverse().apply(points_m)[..., 2])


def _between(world_T_plane: Motor, eye_m: FloatArray, figure_m: FloatArray) -> bool:
    """Whether any of the figure lies beyond the plane, seen from the eye."""
    towards = 1.0 if _side(world_T_plane, eye_m) >= 0.0 else -1.0
    heights_m = towards * _side(world_T_plane, figure_m)
    return bool(np.min(heights_m) < -SUNK * np.ptp(heights_m))


def _lay(
    nearest: DepthArray, camera: Camera, camera_T_print: Motor, low: FloatArray, high: FloatArray
) -> None:
    """Take the depth of one rectangle wherever it is nearer than what was there."""
    to_image = plane_homography(camera, camera_T_print)
    if np.linalg.cond(to_image) > EDGE_ON:
        return
    corners = [[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])]
    first, last = seen_extent(camera, camera_T_print.apply(corners), NEAREST_M)
    rows, columns = np.arange(first[1], last[1] + 1), np.arange(first[0], last[0] + 1)
    from_image = np.linalg.inv(to_image)
    x, y, inverse_depth = (
        row[0] * columns[None, :] + row[1] * rows[:, None] + row[2] for row in from_image
    )
    # Over a positive inverse depth, low < x / inverse depth < high needs no division.
    inside = (inverse_depth > 0.0) & (x > low[0] * inverse_depth) & (x < high[0] * inverse_depth)
    inside &= (y > low[1] * inverse_depth) & (y < high[1] * inverse_depth)
    depth_m = (1.0 / inverse_depth[inside]).astype(np.float32)
    region = nearest[first[1] : last[1] + 1, first[0] : last[0] + 1]
    region[inside] = np.minimum(region[inside], depth_m)


def raised(depth_m: DepthArray, ground_m: DepthArray, eye_m: float) -> DepthArray:
    """How high above the ground each pixel's thing is, metres.

    Args:
        depth_m: (height, width) measured, along the optical axis; 0 and NaN are unknown.
        ground_m: of the plane, in the same pixels; infinite at and above the horizon.
        eye_m: the camera's height above the ground.

    Returns:
        (height, width) float32, below 0 beneath the ground, NaN where unknown or where the camera
        is not above the ground.
    """
    known = np.isfinite(depth_m) & (depth_m > 0.0) & (eye_m > 0.0)
    share = np.where(known, depth_m, np.nan) / np.maximum(ground_m, np.finfo(np.float32).tiny)
    return np.asarray(eye_m * (1.0 - share), dtype=np.float32)


def share_on_ground(raised_m: DepthArray, within_m: float) -> FloatArray:
    """How much of a shadow on the ground each pixel takes, by how far from the ground it is.

    All up to half the distance `within_m`, none from half as much again on; what the sensor does
    not tell goes by what is around it, and its noise leaves no ragged edges.
    """
    known = np.isfinite(raised_m)
    share = 1.0 - np.clip(np.abs(np.where(known, raised_m, 0.0)) / within_m - 0.5, 0.0, 1.0)
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), SOFT_PX)
    smooth = cv2.GaussianBlur((share * known).astype(np.float32), (0, 0), SOFT_PX)
    return np.where(weight > 1e-3, smooth / np.maximum(weight, 1e-3), 1.0).astype(np.float64)


def share_beyond(known_m: DepthArray, ground_m: DepthArray) -> FloatArray:
    """How much of each pixel's ground no known thing stands before, softened by a pixel.

    Args:
        known_m: (height, width) of `known_depth`.
        ground_m: of the plane, in the same pixels; infinite at and above the horizon.
    """
    before = (known_m > 0.0) & (known_m < (1.0 - NEARER) * ground_m)
    return np.asarray(1.0 - cv2.GaussianBlur(before.astype(np.float32), (0, 0), 0.5))
