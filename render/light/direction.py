"""Where the light of footage comes from, told without depth: by shadows, faces and shading.

Three things tell, each with its own doubt, and every direction of the sky is weighed by all:

- shadows beside what stands on the ground (`cast_shadows`) say from which side, not how high;
- paper on faces of known planes, turned several ways, says how much light each gets: ambient and
  one lamp by Lambert's law say from where;
- a print on the ground that is brighter towards one side has its light on that side, be it because
  a lamp is near or because ink and paper gleam (weakly, for either may be otherwise).

Where the directions that remain are farther apart than `MOST_DOUBT_RAD` nothing is told but why.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.render.light.cast import CastShadow
from motorcade.render.light.ground import GroundMap

MOST_DOUBT_RAD = np.deg2rad(25.0)
DIRECTIONS = 1500
ELEVATIONS_RAD = np.deg2rad([15.0, 75.0])
"""Lamps and windows are seldom lower or higher; all between are as likely."""
SELDOM = 0.1
SHADOW_RAD, SLOPE_RAD = np.deg2rad(20.0), np.deg2rad(35.0)
WRONG = 0.25
"""Of shadows, slopes and faces: so many are something else, and say nothing."""
PAPERS, FEWEST_FACES = 0.25, 5
"""Papers differ in what they reflect, and the light differs from face to face, by this share."""
LIGHTS = 20
"""Strengths of ambient light and of the lamp that faces are weighed by."""
SLOPED = 0.15
"""Change of light over a print's half, as a share: less is vignetting and bounced light."""


@dataclass(frozen=True, eq=False)
class LightDirection:
    """What the pictures say of where light comes from.

    Attributes:
        towards: (3,) unit, world, to the light; None where it is unknown.
        doubt_rad: root mean square angle between it and all directions that remain.
        darkening: share of light that is gone from the ground close beside things, in their
            shadow; None where none is seen.
        told: by what, or why it is unknown.
        lamp_radius_rad: apparent radius of the light by the rims of shadows; None where none tells.

    >>> from motorcade.render.light import LightDirection
    >>> LightDirection(None, 1.2, None, "no shadow beside anything").towards is None
    True
    """

    towards: FloatArray | None
    doubt_rad: float
    darkening: float | None
    told: str
    lamp_radius_rad: float | None = None


def light_direction(
    ground: GroundMap | None,
    shadows: Sequence[CastShadow],
    normals: FloatArray,
    falling: FloatArray,
    up: FloatArray,
) -> LightDirection:
    """Weigh what tells where the light comes from.

    Args:
        ground: as several pictures show it; None where it is not seen.
        shadows: beside what stands on it.
        normals: (K, 3) of faces with paper, world, unit.
        falling: (K,) light that falls on each.
        up: (3,) of the world, unit.

    Returns:
        The direction, or why there is none.
    """
    sky = _sky(up)
    height = np.arcsin(np.clip(sky @ up, -1.0, 1.0))
    usual = (height > ELEVATIONS_RAD[0]) & (height < ELEVATIONS_RAD[1])
    weight = np.where(usual, 1.0, SELDOM) / np.maximum(np.cos(height), 0.1)
    by: list[str] = []
    if ground is not None:
        x, y = ground.world_T_ground.rotor.apply(np.eye(3)[:2])
        side = np.arctan2(sky @ y, sky @ x)
        for shadow in shadows:
            turn = np.arctan2(shadow.towards[1], shadow.towards[0])
            weight = weight * _near(side - turn, SHADOW_RAD) ** shadow.weight
        if shadows:
            by.append("1 shadow" if len(shadows) == 1 else f"{len(shadows)} shadows")
        slope = _slope(ground)
        if slope is not None:
            weight = weight * _near(side - np.arctan2(slope[1], slope[0]), SLOPE_RAD)
            by.append("the slope of light over a print")
    if _several(normals):
        weight = weight * _by_faces(sky, normals, falling)
        by.append(f"{len(normals)} faces of paper")
    middle = weight @ sky
    length = float(np.linalg.norm(middle))
    if not by or length == 0.0:
        return LightDirection(None, np.pi, None, "no shadow, slope or faces of several planes tell")
    towards = middle / length
    apart = np.arccos(np.clip(sky @ towards, -1.0, 1.0))
    doubt = float(np.sqrt(np.average(apart**2, weights=weight)))
    named = " and ".join(by)
    if doubt > MOST_DOUBT_RAD:
        why = f"{named} leave directions {np.rad2deg(doubt):.0f}° apart"
        return LightDirection(None, doubt, *_shadow_look(ground, shadows, None, why))
    look = _shadow_look(ground, shadows, towards, f"by {named}")
    return LightDirection(np.asarray(towards), doubt, *look)


def _sky(up: FloatArray) -> FloatArray:
    """Directions (N, 3) spread evenly over the half sphere above."""
    k = np.arange(DIRECTIONS) + 0.5
    z, turn = 1.0 - k / DIRECTIONS, k * np.pi * (3.0 - np.sqrt(5.0))
    level = np.sqrt(1.0 - z * z)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(up, x), up])
    return np.asarray(np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1) @ frame)


def _near(angle: FloatArray, doubt_rad: float) -> FloatArray:
    """Likelihood of an angle about the vertical that may be no light's at all."""
    off = np.abs(np.angle(np.exp(1j * angle)))
    return np.asarray(
        (1.0 - WRONG) * np.exp(-0.5 * (off / doubt_rad) ** 2) + WRONG * doubt_rad / np.pi
    )


def _several(normals: FloatArray) -> bool:
    """Whether faces look several ways."""
    return len(normals) >= FEWEST_FACES and bool(np.min(normals @ normals.T) < 0.9)


def _by_faces(sky: FloatArray, normals: FloatArray, falling: FloatArray) -> FloatArray:
    """Likelihood of each direction (N,), over all ambient light and lamps, neither below zero.

    A face may be something else: in a shadow, or so small that its paper and ink blur.
    """
    facing = np.maximum(sky @ normals.T, 0.0)
    most = 2.0 * float(falling.max())
    lights = (np.arange(LIGHTS) + 0.5) / LIGHTS * most
    total = np.zeros(len(sky))
    for ambient in lights:
        for lamp in lights:
            expected = ambient + lamp * facing
            spread = PAPERS * expected
            like = np.exp(-0.5 * ((falling - expected) / spread) ** 2)
            like *= (1.0 - WRONG) / (np.sqrt(2.0 * np.pi) * spread)
            total += np.prod(most * like + WRONG, axis=1)
    return np.asarray(total / total.max())


def _slope(ground: GroundMap) -> FloatArray | None:
    """(2,) on the ground, towards where a print is brighter; None where it is even."""
    rows, columns = np.nonzero(ground.printed & ground.flat & ~ground.full)
    if len(rows) < 200:
        return None
    light = ground.light[rows, columns]
    ink = light < 0.5 * (np.quantile(light, 0.1) + np.quantile(light, 0.9))
    at = np.stack([columns, rows], axis=1) - [columns.mean(), rows.mean()]
    reach = float(np.sqrt(len(rows) / np.pi))
    found = np.zeros(2)
    for kind in (ink, ~ink):  # what is overexposed tells little, so each kind counts by its cells
        if np.count_nonzero(kind) >= 100:
            basis = np.column_stack([at[kind] / reach, np.ones(np.count_nonzero(kind))])
            level = light[kind] / np.median(light[kind])
            keep = np.abs(level - 1.0) < 0.8
            fitted = np.linalg.lstsq(basis[keep], level[keep], rcond=None)[0]
            found += np.mean(kind) * fitted[:2]
    return found if np.linalg.norm(found) > SLOPED else None


def _shadow_look(
    ground: GroundMap | None, shadows: Sequence[CastShadow], towards: FloatArray | None, told: str
) -> tuple[float | None, str, float | None]:
    """How dark, and of how wide a lamp, shadows are that fall away from the light: the middle of
    those that are seen out to their ends, if there are such, since of others the rim alone may be.
    """
    if ground is None:
        return None, told, None
    own = None if towards is None else ground.world_T_ground.rotor.inverse().apply(towards)[:2]
    kept = [one for one in shadows if own is None or one.towards @ own > 0.5 * np.linalg.norm(own)]
    whole = [one for one in kept if one.lamp_radius_rad is not None]
    radii = [one.lamp_radius_rad for one in whole if one.lamp_radius_rad is not None]
    dark = float(np.median([one.darkening for one in whole or kept])) if kept else None
    return dark, told, float(np.median(radii)) if radii else None
