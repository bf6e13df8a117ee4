"""Light of footage: from depth where there is some, else by paper, shadows and faces.

Without depth, a printed board or marker tells how bright the light is and of what colour. Where
there is no print, colour is guessed by shades of grey (Finlayson and Trezzi, "Shades of gray and
colour constancy", 2004) and brightness by a scene whose mean is middle grey; half of either guess
is believed. Three things tell where light comes from, and every direction of the sky is weighed by
all:

- shadows beside what stands on the ground (`cast_shadows`) say from which side, and how high by
  how long they are;
- paper on faces of known planes, turned several ways, says how much light each gets: ambient and
  one lamp by Lambert's law say from where;
- a print on the ground that is brighter towards one side has its light on that side, be it because
  a lamp is near or because ink and paper gleam (weakly, for either may be otherwise).

The sun stands there, and takes as much light away as shadows in the footage do. Where the remaining
directions are farther apart than `MOST_DOUBT_RAD` the light made for the viewer keeps its direction
and shape, brightened and tinted, and what was missing is said.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorcade.animation import Placement
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.composite import as_rgb
from motorcade.render.light.cast import CastShadow, cast_shadows, things_seen
from motorcade.render.light.estimate import ShadedPoints, estimate_light, shaded_points
from motorcade.render.light.ground import GroundMap, Prints, ground_map, light_on_paper
from motorcade.render.light.lamps import (
    certainty,
    character_lighting,
    estimated_lighting,
    light_on,
    sunlight_direction,
)
from motorcade.render.scene import BRIGHTEST, DepthArray, ImageArray, Lamp, Lighting, Sun
from motorcade.tracking.cameras.camera import Camera

ENOUGH = 500
"""Points; fewer say more about the sensor than about the light."""


def lighting_of_footage(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    height_m: float,
) -> tuple[Lighting, str] | None:
    """The light that falls on a placed character, estimated from frames with depth.

    About eight frames, spread over the recording, are enough; every one that is given is used.

    Args:
        frames: stamp in ns, image, and depth in metres or None.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: of the character.
        height_m: of the placed character; surfaces two heights away count half.

    Returns:
        sun and ambient light, and what of them was assumed; or None where too few points with depth
        were seen: without depth there are no surfaces to tell light from paint by. Where surfaces
        hardly tell where light comes from, it comes from where the fixed light does.

    Raises:
        ValueError: sizes that differ, or a camera with distortion.
    """
    parts = []
    for time_ns, image, depth_m in frames:
        if depth_m is None:
            continue
        if world_T_camera.time_ns[0] <= time_ns <= world_T_camera.time_ns[-1]:
            pose = world_T_camera.motors_at(np.int64(time_ns))
            parts.append(shaded_points(as_rgb(image), depth_m, camera, pose))
    if sum(len(part.points_m) for part in parts) < ENOUGH:
        return None
    stand = placement.world_T_character
    middle = stand.apply(np.array([0.0, 0.0, 0.5 * height_m]))
    estimate = estimate_light(ShadedPoints.joined(parts), middle, 2.0 * height_m)
    assumed = sunlight_direction(placement, world_T_camera.motors)
    sure = certainty(estimate)
    summary = "light estimated from surfaces with depth"
    if sure < 1.0:
        summary += ", its direction assumed" if sure == 0.0 else ", its direction in part assumed"
    return estimated_lighting(placement, height_m, estimate, assumed), summary


POINTS, FEWEST = 400, 40
LEAST_LIGHT = 0.03
MOST = 4.0
"""A camera's exposure changes by no more than this in footage that shows the same ground."""


class ExposureMeter:
    """Exposure of one image after another, 1 for the usual one of a ground's images.

    Where an image shows too little of the ground that is flat and not overexposed, the exposure is
    held to be that of the image before.

    Args:
        ground: whose light is compared with.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.render.light import ExposureMeter
    >>> from motorcade.render.light.ground import GroundMap
    >>> none, light = np.zeros((8, 8), bool), np.full((8, 8), 0.5)
    >>> seen = np.log(light)[None], np.array([[0.0, 0.0, 1.0]])
    >>> lawn = GroundMap(Motor.identity(), 0.1, light, 0 * light, none, none, 0.1, *seen)
    >>> len(ExposureMeter(lawn).points_m)
    64
    """

    def __init__(self, ground: GroundMap) -> None:
        rows, columns = np.nonzero(ground.flat & ~ground.full & (ground.light > LEAST_LIGHT))
        some = np.unique(np.linspace(0, max(len(rows) - 1, 0), POINTS).astype(int))
        some = some[: len(rows)]
        self.points_m = ground.points_m()[rows[some], columns[some]]
        self._light = ground.light[rows[some], columns[some]]
        self._last = 1.0

    def gain(self, image: ImageArray, camera: Camera, world_T_camera: Motor) -> float:
        """Light of an image (h, w) or (h, w, 3) over what it usually is, vignetting aside."""
        if not len(self.points_m):
            return self._last
        own = world_T_camera.inverse().apply(self.points_m)
        ahead = own[:, 2] > 1e-3
        if not ahead.any():
            return self._last
        x, y = np.rint(camera.project(own[ahead])).astype(np.int64).T
        inside = (x >= 0) & (y >= 0) & (x < camera.width) & (y < camera.height)
        shown = image[y[inside], x[inside]]
        grey = shown.mean(axis=1) if shown.ndim == 2 else shown
        fit = grey < BRIGHTEST
        if np.count_nonzero(fit) >= FEWEST:
            ratio = to_linear(grey[fit] / 255.0) / self._light[ahead][inside][fit]
            self._last = float(np.clip(np.median(ratio), 1.0 / MOST, MOST))
        return self._last


MIDDLE_GREY = 0.18
MINKOWSKI = 6.0
BELIEVED = 0.5
GAINS = (0.05, 4.0)
SHARE, UNTOLD = 0.5, 0.35
"""Of the light on the ground that the sun has where no shadow shows how much, and where shadows
contradict each other: indoors it is between none and three quarters, and too dark a shadow that
falls the wrong way is the worse mistake."""
SHARES = (0.15, 0.9)
SHADOWLESS = 2
"""So many things without a shadow show that light comes from all sides."""
SOFT_RAD = 0.35
"""Apparent radius of a light whose direction nothing tells: a window's, or a ceiling's lamps'."""
RADII_RAD = (0.0047, 0.35)
"""Of the light: the sun's, and a window's; wider ones are sky, which the even light is."""
USUAL_RADIUS2, DARK_SIGMA = (0.015, 0.05), 0.05
"""Square of a light's radius, and its deviation, before shadows are asked; and by how much shadows
differ in darkness, be they as sure as they may."""
STEEP = 0.25
"""Least height of the sun, as a sine: lower ones throw shadows that nobody believes."""


def lighting_without_depth(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    height_m: float,
    prints: Prints | None = None,
    ground: GroundMap | None = None,
) -> tuple[Lighting, str]:
    """The light as bright, of the colour and, where they tell it, from where the images show.

    Where exposure changes over the recording, the median frame's counts. Six images or more from
    places apart are needed for the direction, which is looked for on the ground about the placement
    and on prints; see `light_direction` for when it is unknown.

    Args:
        frames: stamp in ns, image, and a depth that is not looked at.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: of the character.
        height_m: of the placed character.
        prints: that are known in the world.
        ground: as from `ground_of_footage`, which is asked where it is not given.

    Returns:
        the light, and what was taken from the images and what assumed.

    Raises:
        ValueError: a camera with distortion.
    """
    if camera.model != "pinhole":
        raise ValueError(f"lighting_without_depth(camera): expected pinhole, got {camera.model}")
    seen = _posed(frames, world_T_camera)
    cameras = world_T_camera.motors
    usual = character_lighting(placement, cameras, height_m, sunlight_direction(placement, cameras))
    if not seen:
        return usual, "a fixed light"
    on_prints = _on_prints(seen, camera, prints)
    if ground is None:
        ground = ground_map(seen, camera, placement.world_T_character, prints)
    direction = _direction(ground, placement, prints, on_prints)
    shaped = _from(direction, usual, placement, _share(direction, ground))
    where = f"its direction assumed ({direction.reason})"
    if direction.towards is not None:
        where = f"its direction {direction.reason}, ±{np.rad2deg(direction.doubt_rad):.0f}°"
    if prints is not None and on_prints:
        gain = _gain_by_paper(shaped, prints, on_prints)
        summary = f"brightness and colour of light by printed paper, {where}"
    else:
        gain = _gain_by_grey(shaped, placement, np.median([_grey(one) for one, _ in seen], axis=0))
        summary = f"brightness and colour of light guessed from a grey world, {where}"
    return _brightened(shaped, np.clip(gain, *GAINS)), summary


def ground_of_footage(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    prints: Prints | None = None,
) -> GroundMap | None:
    """The ground about a placement as footage shows it; frames outside the path are ignored."""
    seen = _posed(frames, world_T_camera)
    return ground_map(seen, camera, placement.world_T_character, prints)


def _posed(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]], world_T_camera: Trajectory
) -> list[tuple[ImageArray, Motor]]:
    """Images in colour and their poses."""
    first, last = world_T_camera.time_ns[0], world_T_camera.time_ns[-1]
    return [
        (as_rgb(image), world_T_camera.motors_at(np.int64(time_ns)))
        for time_ns, image, _ in frames
        if first <= time_ns <= last
    ]


def _on_prints(
    seen: list[tuple[ImageArray, Motor]], camera: Camera, prints: Prints | None
) -> list[tuple[int, FloatArray]]:
    if prints is None:
        return []
    return [one for image, pose in seen for one in light_on_paper(image, camera, pose, prints)]


def _direction(
    ground: GroundMap | None,
    placement: Placement,
    prints: Prints | None,
    on_prints: list[tuple[int, FloatArray]],
) -> LightDirection:
    """By the ground about the placement, and by what paper shows on each print."""
    shadows = [] if ground is None else cast_shadows(ground)
    faces = sorted({number for number, _ in on_prints})
    normals, falling = np.zeros((0, 3)), np.zeros(0)
    if prints is not None and faces:
        normals = prints.normals[faces]
        falling = np.array(
            [np.median([np.mean(one) for k, one in on_prints if k == face]) for face in faces]
        )
    return light_direction(ground, shadows, normals, falling, placement.up)


def _share(direction: LightDirection, ground: GroundMap | None) -> float | None:
    """The sun's, of the light on the ground; None where nothing tells."""
    if direction.towards is None:
        if direction.darkening is not None:
            return UNTOLD
        shadowless = ground is not None and things_seen(ground) >= SHADOWLESS
        return SHARES[0] if shadowless else None
    if direction.darkening is None:
        return SHARE
    return float(np.clip(direction.darkening, *SHARES))


def _from(
    direction: LightDirection, usual: Lighting, placement: Placement, share: float | None
) -> Lighting:
    """Sun and light from all sides, of which the sun has a share; it is as wide as the rims of
    shadows say. What is not told is the usual light's, but soft.
    """
    if share is None:
        return replace(usual, sun=replace(usual.sun, radius_rad=SOFT_RAD))
    towards, up, radius = -np.array(usual.sun.direction), placement.up, SOFT_RAD
    if direction.towards is not None:
        towards, radius = direction.towards, usual.sun.radius_rad
        if direction.lamp_radius_rad is not None:
            radius = float(np.clip(direction.lamp_radius_rad, *RADII_RAD))
    height = max(float(towards @ up), STEEP)
    x, y, z = (-towards).tolist()
    ambient = 1.0 - share
    return replace(
        usual,
        ambient=(ambient, ambient, ambient),
        sun=Sun((x, y, z), np.pi * share / height, radius_rad=radius),
        lamps=(),
    )


def _gain_by_paper(
    usual: Lighting, prints: Prints, light_of: list[tuple[int, FloatArray]]
) -> FloatArray:
    """Light that was found over the usual light, (3,): the median over frames, mean of prints."""
    middles = prints.points_m().mean(axis=1)
    gains = []
    for k in sorted({number for number, _ in light_of}):
        there = np.median([light for number, light in light_of if number == k], axis=0)
        direct, other = light_on(usual, middles[k], prints.normals[k])
        gains.append(np.log(there / (direct + other)))
    return np.asarray(np.exp(np.mean(gains, axis=0)))


def _grey(image: ImageArray) -> FloatArray:
    """(4,) mean brightness of an image, and the colour of its light by shades of grey, mean 1."""
    shown = to_linear(image[::4, ::4].reshape(-1, 3) / 255.0)
    norm = np.maximum(np.mean(shown**MINKOWSKI, axis=0) ** (1.0 / MINKOWSKI), 1e-4)
    return np.concatenate([[shown.mean()], norm / norm.mean()])


def _gain_by_grey(usual: Lighting, placement: Placement, grey: FloatArray) -> FloatArray:
    there = max(float(grey[0]), 1e-4) / MIDDLE_GREY * grey[1:]
    direct, other = light_on(usual, placement.world_T_character.translation_m, placement.up)
    return np.asarray((there / (direct + other)) ** BELIEVED)


def _brightened(lighting: Lighting, gain: FloatArray) -> Lighting:
    """All light times a gain (3,)."""

    def tinted(color: tuple[float, float, float]) -> tuple[float, float, float]:
        r, g, b = (np.array(color) * gain).tolist()
        return r, g, b

    lamps: list[Lamp] = [replace(lamp, color=tinted(lamp.color)) for lamp in lighting.lamps]
    return replace(
        lighting,
        ambient=tinted(lighting.ambient),
        sun=replace(lighting.sun, color=tinted(lighting.sun.color)),
        lamps=tuple(lamps),
    )


MOST_DOUBT_RAD = np.deg2rad(25.0)
DIRECTIONS = 1500
ELEVATIONS_RAD = np.deg2rad([15.0, 75.0])
"""Lamps and windows are seldom lower or higher; all between are as likely."""
SELDOM = 0.1
SHADOW_RAD, HEIGHT_RAD, SLOPE_RAD = np.deg2rad([4.0, 2.0, 35.0])
"""Of shadows beside what their fits say: things are no round posts."""
WITHIN = 0.68
LONE_RAD = 0.1
"""By a single shadow a light is believed that is no wider (10 cm at a metre): a softer one may be
the sky that two things hide from each other's foot."""
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
    """What the images say of where light comes from.

    Attributes:
        towards: (3,) unit, world, to the light; None where it is unknown.
        doubt_rad: angle about it within which 68 % of what remains lies.
        darkening: share of light that is gone from the ground close beside things, in their
            shadow; None where none is seen.
        reason: by what, or why it is unknown.
        lamp_radius_rad: apparent radius of the light by the rims of shadows; None where none tells.

    >>> from motorcade.render.light.monocular import LightDirection
    >>> LightDirection(None, 1.2, None, "no shadow beside anything").towards is None
    True
    """

    towards: FloatArray | None
    doubt_rad: float
    darkening: float | None
    reason: str
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
        ground: as several images show it; None where it is not seen.
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
    if len(shadows) == 1 and shadows[0].radius2 > LONE_RAD**2:
        shadows = []
    if ground is not None:
        x, y = ground.world_T_ground.rotor.apply(np.eye(3)[:2])
        side = np.arctan2(sky @ y, sky @ x)
        for shadow in shadows:
            turn = np.arctan2(shadow.towards[1], shadow.towards[0])
            weight = weight * _near(side - turn, float(np.hypot(shadow.turn_sigma_rad, SHADOW_RAD)))
            if shadow.elevation_rad is not None:
                doubt = float(np.hypot(shadow.elevation_sigma_rad, HEIGHT_RAD))
                weight = weight * _near(height - shadow.elevation_rad, doubt)
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
    order = np.argsort(apart)
    within = np.cumsum(weight[order]) >= WITHIN * weight.sum()
    doubt = float(apart[order][np.argmax(within)])
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
    slope = np.zeros(2)
    for kind in (ink, ~ink):  # what is overexposed tells little, so each kind counts by its cells
        if np.count_nonzero(kind) >= 100:
            basis = np.column_stack([at[kind] / reach, np.ones(np.count_nonzero(kind))])
            level = light[kind] / np.median(light[kind])
            keep = np.abs(level - 1.0) < 0.8
            fitted = np.linalg.lstsq(basis[keep], level[keep], rcond=None)[0]
            slope += np.mean(kind) * fitted[:2]
    return slope if np.linalg.norm(slope) > SLOPED else None


def _shadow_look(
    ground: GroundMap | None, shadows: Sequence[CastShadow], towards: FloatArray | None, text: str
) -> tuple[float | None, str, float | None]:
    """How dark shadows that fall away from the light are, and of how wide a lamp, each as sure as
    its fit is.
    """
    if ground is None:
        return None, text, None
    own = None if towards is None else ground.world_T_ground.rotor.inverse().apply(towards)[:2]
    kept = [one for one in shadows if own is None or one.towards @ own > 0.9 * np.linalg.norm(own)]
    if not kept:
        return None, text, None
    dark, dark_sigma, wide, wide_sigma = np.array(
        [(one.darkening, one.darkening_sigma, one.radius2, one.radius2_sigma) for one in kept]
    ).T
    order, counts = np.argsort(dark), 1.0 / (dark_sigma**2 + DARK_SIGMA**2)
    middle = np.searchsorted(np.cumsum(counts[order]), 0.5 * counts.sum())
    counts = 1.0 / wide_sigma**2
    usual, few = USUAL_RADIUS2
    radius2 = (counts @ wide + usual / few**2) / (counts.sum() + 1.0 / few**2)
    return float(dark[order][middle]), text, float(np.sqrt(max(radius2, 0.0)))
