"""Figures on their way into a picture: skinned at a moment, and the ground that they may shade."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorcade.animation import Character, Clip, Placement, skin
from motorcade.animation.skin import Skinner
from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.render.scene import Lighting, Surface
from motorcade.render.shadow import shade_step_m

# Half-width of the ground that can take a shadow, in heights of the character.
SHADOW_REACH = 1.6
# A clip travels when the figure comes farther than this from its place, in heights, at one of these
# many moments.
TRAVELS, MOMENTS = 0.4, 64
# How far a body reaches from its joints at most, in heights.
FLESH = 0.15


@dataclass(frozen=True, eq=False)
class Performer:
    """A character, what it does from the first frame on, and where it stands.

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


class DrawnFigure:
    """A figure with what stays the same over all frames."""

    def __init__(self, figure: Performer) -> None:
        self.character, self.clip, self.placement = (
            figure.character,
            figure.clip,
            figure.placement,
        )
        self._shaped = self.character.shaped()
        self._skinner = Skinner(self._shaped, "linear")
        self.stand = self.placement.world_T_character
        self.height_m = self.placement.scale * self.character.height_m
        self.half_width_m = SHADOW_REACH * self.height_m
        self.travels = self._travels()
        self.surface = Surface(
            self.placement.apply(self.character.vertices),
            self.stand.rotor.apply(self.character.normals),
            self.character.triangles,
            self.character.colors,
            roughness=0.42,
            appearance=self.character.appearance,
        )

    def at(self, time_s: float) -> tuple[FloatArray, FloatArray]:
        """Vertices in metres and normals (V, 3) in the frame of the placement, at a moment."""
        vertices, normals = self._skinned(self.clip.at(time_s), self.clip.morph_weights(time_s))
        return self.placement.scale * vertices, normals

    def hull_m(self, own_m: FloatArray) -> FloatArray:
        """Corners (8, 3) in the world of a box about vertices in the frame of the placement."""
        return self.stand.apply(box_corners(own_m))

    def center_m(self, own_m: FloatArray) -> FloatArray:
        """Where on the ground light and shadow are made for: (3,) under a figure that travels.

        It moves by whole cells of the shadow's coarsest grid, so that a shadow never shimmers.
        """
        if not self.travels:
            return np.zeros(3)
        step_m = shade_step_m(self.half_width_m)
        middle = 0.5 * (own_m[:, :2].min(axis=0) + own_m[:, :2].max(axis=0))
        return np.append(step_m * np.rint(middle / step_m), 0.0)

    def joints_m(self) -> FloatArray:
        """Joints (MOMENTS, J, 3) in the world, spread over the clip."""
        moments = np.linspace(0.0, self.clip.duration_s, MOMENTS) + self.clip.time_s[0]
        at_m = self.character.skeleton.world(self.clip.at(moments)).translation_m
        return self.placement.apply(at_m)

    def _travels(self) -> bool:
        """Whether the clip takes the character away from where it was placed."""
        moments = np.linspace(0.0, self.clip.duration_s, MOMENTS)
        places_m = self.character.skeleton.world(self.clip.at(moments)).translation_m[..., :2]
        middle_m = 0.5 * (places_m.min(axis=1) + places_m.max(axis=1))
        return bool(np.linalg.norm(middle_m, axis=-1).max() > TRAVELS * self.character.height_m)

    def _skinned(
        self, pose: Motor | Similarity, weights: FloatArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals in character space, compiled where joints are rigid."""
        if isinstance(pose, Similarity) or weights is not None:
            shaped = self._shaped if weights is None else self.character.shaped(weights)
            return skin(shaped, pose)
        vertices, normals = self._skinner.skin(pose)
        return vertices.astype(np.float64), normals.astype(np.float64)


def lit_together(lighting: Lighting, figures: Sequence[DrawnFigure]) -> Lighting:
    """The light of the first figure for all of them, over all that they do; of one, as it is.

    Its shadows are then made for a ball that holds them wherever they go, and its lamps stand
    about the middle of that.
    """
    if len(figures) == 1:
        return lighting
    points_m = np.concatenate([figure.joints_m().reshape(-1, 3) for figure in figures])
    middle_m = 0.5 * (points_m.min(axis=0) + points_m.max(axis=0))
    reach_m = float(np.linalg.norm(points_m - middle_m, axis=-1).max())
    reach_m += FLESH * max(figure.height_m for figure in figures)
    moved = lighting.translated_by(middle_m - np.array(lighting.shadow_center_m))
    return replace(moved, shadow_radius_m=reach_m)
