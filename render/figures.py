"""Figures on their way into an image: skinned at a moment, and what the image shows of them.

What is seen is counted on the layers laid over the footage, after what hides them. Of several
figures each pixel belongs to the nearest whose projected vertices lie around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation import Character, Clip, Placement
from motorcade.animation.skin import Skinner
from motorcade.animation.vectors import UP
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.lens import LensWarp, Window
from motorcade.render.light import sun_share
from motorcade.render.scene import Layer, Lighting, Surface
from motorcade.render.shadow import shade_step_m

# Half-width of the ground that can take a shadow, in heights of the character: at least, beyond the
# shadow of its top, and at most.
SHADOW_REACH = 1.6, 0.4, 4.5
# A clip travels when the figure comes farther than this from its place, in heights, at one of these
# many moments.
TRAVELS, MOMENTS = 0.4, 64
# How far a body reaches from its joints at most, in heights.
FLESH = 0.15
# A sun that falls less than this on a ground that moves throws no shadow there.
LEAST_FALL = 0.05


@dataclass(frozen=True, eq=False)
class Performer:
    """A character or a prop, what it does from the first frame on, and where it stands.

    Args:
        character: who or what.
        clip: what its joints do; its clock begins with the first frame.
        placement: the ground below it, and its scale.
        motion: `placement_T_character`, similarities from the stamp of the first frame on; None
            where it stays in the placement's origin. Before its first stamp and after its last it
            is as it is there.
        ground_motion: of a ground that moves: the motion that takes the placement from where it
            says to where it is at that time, in the world; likewise.
        visible_s: from when to when it is seen, seconds after the first frame; None for always.

    >>> from motorcade.animation import Clip, Placement, mannequin
    >>> from motorcade.ga import Motor
    >>> from motorcade.render import Performer
    >>> who = mannequin()
    >>> place = Placement(Motor.from_translation([0.5, 0, 0]), 0.1)
    >>> beside = Performer(who, who.clip("wave"), place)
    >>> beside.clip.name
    'wave'
    """

    character: Character
    clip: Clip
    placement: Placement
    motion: Trajectory | None = None
    ground_motion: Trajectory | None = None
    visible_s: tuple[float, float] | None = None

    def world_T_ground(self, time_ns: IntArray | int) -> Motor:
        """Where the placement's frame is ``(*)`` at stamps ``(*)``."""
        stand = self.placement.world_T_character
        if self.ground_motion is None:
            return stand.reshape(1)[np.zeros(np.shape(time_ns), dtype=np.int64)]
        return self.ground_motion.motors_at(_held(time_ns, self.ground_motion)) @ stand

    def world_T_character(self, time_ns: IntArray | int) -> Similarity:
        """From character space to the world ``(*)`` at stamps ``(*)``, with its scale."""
        ground = Similarity.from_motor_scale(self.world_T_ground(time_ns), self.placement.scale)
        return ground if self.motion is None else ground @ _similarities(self.motion, time_ns)

    def seen(self, time_s: float) -> bool:
        """Whether it is there so long after the first frame."""
        return self.visible_s is None or self.visible_s[0] <= time_s <= self.visible_s[1]


def _held(time_ns: IntArray | int, path: Trajectory) -> IntArray:
    return np.clip(np.asarray(time_ns, dtype=np.int64), path.time_ns[0], path.time_ns[-1])


def _similarities(motion: Trajectory, time_ns: IntArray | int) -> Similarity:
    poses = motion.at(_held(time_ns, motion))
    return poses if isinstance(poses, Similarity) else Similarity.from_motor_scale(poses)


class DrawnFigure:
    """A figure with what stays the same over all frames."""

    def __init__(self, figure: Performer, lighting: Lighting) -> None:
        self.performer = figure
        self.character, self.clip, self.placement = (
            figure.character,
            figure.clip,
            figure.placement,
        )
        self._skinner = Skinner(self.character, "linear")
        self._weights = np.array([target.weight for target in self.character.morphs])
        self.height_m = self.placement.scale * self.character.height_m
        if figure.motion is not None:  # a prop may be wider than it is high, and grow
            grown = float(np.max(_similarities(figure.motion, figure.motion.time_ns).scale))
            wide_m = float(np.ptp(self.character.vertices, axis=0).max())
            self.height_m = self.placement.scale * grown * wide_m
        least, beyond, most = SHADOW_REACH
        sun, _ = self.sun_on(self.placement.world_T_character, lighting)
        length = float(np.hypot(*sun[:2])) / max(-float(sun[2]), 1.0 / most)
        self.half_width_m = min(max(length + beyond, least), most) * self.height_m
        self.travels = figure.motion is not None or self._travels()
        self.surface = Surface(
            self.placement.apply(self.character.vertices),
            self.placement.world_T_character.rotor.apply(self.character.normals),
            self.character.triangles,
            self.character.colors,
            roughness=0.42,
            appearance=self.character.appearance,
        )

    def at(self, time_s: float, time_ns: int = 0) -> tuple[FloatArray, FloatArray]:
        """Vertices in metres and normals (V, 3) in the frame of the placement, at a moment."""
        vertices, normals = self._skinned(self.clip.at(time_s), self.clip.morph_weights(time_s))
        if self.performer.motion is not None:
            pose = _similarities(self.performer.motion, time_ns)
            vertices, normals = pose.apply(vertices), pose.rotor.apply(normals)
        return self.placement.scale * vertices, normals

    def sun_on(self, ground: Motor, lighting: Lighting) -> tuple[FloatArray, float]:
        """The way the sun's light goes (3,) in the frame of its ground, and its share there.

        A ground that moves may turn from the sun, and then takes no shadow.
        """
        sun = np.array(lighting.sun.direction) / np.linalg.norm(lighting.sun.direction)
        own, up = ground.rotor.inverse().apply(sun), ground.rotor.apply(UP)
        moves = self.performer.motion is not None or self.performer.ground_motion is not None
        if moves and own[2] > -LEAST_FALL:
            return -UP, 0.0
        return own, sun_share(lighting, ground.translation_m, up)

    def center_m(self, own_m: FloatArray) -> FloatArray:
        """Where on the ground light and shadow are made for: (3,) under a figure that travels.

        It moves by whole cells of the shadow's coarsest grid, so that a shadow never shimmers.
        """
        if not self.travels:
            return np.zeros(3)
        step_m = shade_step_m(self.half_width_m)
        middle = 0.5 * (own_m[:, :2].min(axis=0) + own_m[:, :2].max(axis=0))
        return np.append(step_m * np.rint(middle / step_m), 0.0)

    def shade_center_m(self, own_m: FloatArray, sun: FloatArray) -> FloatArray:
        """The same (3,) where what hovers throws its shadow, in light that travels along `sun`."""
        hovers = self.performer.motion is not None
        hovers_m = max(float(own_m[:, 2].min()), 0.0) if hovers else 0.0
        return self.center_m(own_m + hovers_m / -sun[2] * np.append(sun[:2], 0.0))

    def reach_m(self) -> tuple[FloatArray, float]:
        """Joints (MOMENTS, J, 3) in the world over all that it does, and how far flesh reaches."""
        motion = self.performer.motion
        lasts_s = self.clip.duration_s
        if motion is not None:
            lasts_s = max(lasts_s, motion.duration_s)
        moments = np.linspace(0.0, lasts_s, MOMENTS)
        at_m = self.character.skeleton.world(self.clip.at(moments + self.clip.time_s[0]))
        if motion is None:
            return self.placement.apply(at_m.translation_m), FLESH * self.height_m
        stamps = motion.time_ns[0] + np.rint(1e9 * moments).astype(np.int64)
        poses = self.performer.world_T_character(stamps).reshape(-1, 1)
        # A prop has one joint, and all of it may lie to one side.
        return poses.apply(at_m.translation_m), self.height_m

    def _travels(self) -> bool:
        """Whether the clip takes the character away from where it was placed."""
        moments = np.linspace(0.0, self.clip.duration_s, MOMENTS)
        places_m = self.character.skeleton.world(self.clip.at(moments)).translation_m[..., :2]
        middle_m = 0.5 * (places_m.min(axis=1) + places_m.max(axis=1))
        return bool(np.linalg.norm(middle_m, axis=-1).max() > TRAVELS * self.character.height_m)

    def _skinned(
        self, pose: Motor | Similarity, weights: FloatArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals in character space, in weights of morph targets or those at rest."""
        vertices, normals = self._skinner.skin(pose, self._weights if weights is None else weights)
        return vertices.astype(np.float64), normals.astype(np.float64)


def lit_together(lighting: Lighting, figures: Sequence[DrawnFigure]) -> Lighting:
    """The light of the first figure for all of them, over all that they do; of one, as it is.

    Its shadows are then made for a ball that holds them wherever they go, and its lamps stand
    about the middle of that.
    """
    if len(figures) == 1 and figures[0].performer.motion is None:
        return lighting
    joints_m, flesh_m = zip(*(figure.reach_m() for figure in figures), strict=True)
    points_m = np.concatenate([one.reshape(-1, 3) for one in joints_m])
    middle_m = 0.5 * (points_m.min(axis=0) + points_m.max(axis=0))
    reach_m = float(np.linalg.norm(points_m - middle_m, axis=-1).max()) + max(flesh_m)
    moved = lighting.translated_by(middle_m - np.array(lighting.shadow_center_m))
    return replace(moved, shadow_radius_m=reach_m)


# So many vertices of a figure tell how large it is.
VERTICES = 2000


@dataclass(frozen=True)
class FigureSeen:
    """A figure in a frame.

    Fields:
        drawn_px: its pixels in the image, were nothing before it; parts of pixels at its edges.
        visible_px: those that are seen.
        inside: the share of its vertices that lies within the image.
        height_px: from its lowest to its highest vertex in the image; 0 out of view.
        bottom: how high its lowest point lies over its ground, in its heights.
    """

    drawn_px: float
    visible_px: float
    inside: float
    height_px: float
    bottom: float

    @property
    def hidden(self) -> float:
        """The share of its pixels in the image that something hides."""
        return 1.0 - self.visible_px / self.drawn_px if self.drawn_px > 0.0 else 0.0


def figures_seen(
    lens: LensWarp,
    window: Window,
    layer: Layer,
    visible: FloatArray | None,
    own_m: list[FloatArray],
    camera_T_ground: list[Motor],
    heights_m: list[float],
) -> tuple[FigureSeen, ...]:
    """Count what a layer shows of each figure.

    Args:
        lens: of the footage.
        window: the part of the image that the layer fills.
        layer: (h, w) of all figures.
        visible: (h, w) share of the layer that nothing hides; None for all of it.
        own_m: (V, 3) of each figure its vertices in metres, in the frame of its ground.
        camera_T_ground: of each.
        heights_m: of each.
    """
    alpha = layer.rgba[..., 3] / 255.0
    seen = alpha if visible is None else alpha * visible
    camera = lens.camera
    pixels, depths = [], []
    for vertices, pose in zip(own_m, camera_T_ground, strict=True):
        at = pose.apply(vertices[:: 1 + len(vertices) // VERTICES])
        px = camera.project(np.where(at[:, 2:] > 0.0, at, np.nan), allow_nan=True)
        with np.errstate(invalid="ignore"):
            inside = np.all((px > -0.5) & (px < [camera.width - 0.5, camera.height - 0.5]), axis=1)
        pixels.append((px, inside))
        depths.append(float(np.median(at[:, 2])))
    alone = len(own_m) == 1
    masks = [alpha] if alone else [_mask(px[inside], alpha.shape, window) for px, inside in pixels]
    order = np.argsort(depths)
    # A pixel is the nearest one's of those that lie around it, else of the next to it.
    apart = [
        cv2.distanceTransform((masks[k] == 0.0).astype(np.uint8), cv2.DIST_L2, 3) for k in order
    ]
    whose = order[np.argmin(apart, axis=0)]
    counted = [
        (
            float(alpha[whose == k].sum() + mask[(whose != k) & (alpha > 0.0)].sum()),
            float(seen[whose == k].sum()),
        )
        for k, mask in enumerate(masks)
    ]
    return tuple(
        FigureSeen(
            *counted[k],
            float(np.mean(inside)),
            float(np.ptp(px[inside, 1])) if np.any(inside) else 0.0,
            float(own_m[k][:, 2].min()) / heights_m[k],
        )
        for k, (px, inside) in enumerate(pixels)
    )


def _mask(px: FloatArray, shape: tuple[int, ...], window: Window) -> NDArray[np.float64]:
    """Where a figure is in a window (h, w): around its projected vertices (n, 2)."""
    mask = np.zeros(shape, np.uint8)
    if not len(px):
        return mask.astype(np.float64)
    start = np.array([window[1].start or 0, window[0].start or 0])
    column, row = (np.rint(px) - start).astype(np.int64).T
    within = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    mask[row[within], column[within]] = 1
    box = np.maximum(np.ptp(px, axis=0), 1.0)
    apart = int(2.0 * np.sqrt(box[0] * box[1] / len(px))) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (apart + 2, apart + 2))
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, kernel), dtype=np.float64)
