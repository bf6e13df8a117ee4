"""Light without depth: how bright, of what colour and from where, by paper, shadows and faces.

A printed board or marker is white paper and black ink, whatever stands around it: it tells how
bright the light is and of what colour. Where there is no print, colour is guessed by shades of grey
(Finlayson and Trezzi, "Shades of gray and colour constancy", 2004) and brightness by a scene whose
mean is middle grey, and half of either guess is believed, for neither is a law. Where the pictures
tell where the light comes from (`light_direction`), the sun stands there, and takes as much light
away as shadows in the footage do; else the light made for the viewer keeps its direction and shape,
brightened and tinted, and what was missing is said.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from motorcade.animation import Placement
from motorcade.animation.srgb import to_linear
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render.composite import as_rgb
from motorcade.render.light.cast import HIDDEN_SKY, cast_shadows, things_seen
from motorcade.render.light.direction import LightDirection, light_direction
from motorcade.render.light.ground import GroundMap, ground_map
from motorcade.render.light.lamps import character_lighting, light_on, sunlight_direction
from motorcade.render.light.prints import Prints, light_on_paper
from motorcade.render.scene import DepthArray, ImageArray, Lamp, Lighting, Sun
from motorcade.tracking.cameras.camera import Camera

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
RADII_RAD = (0.05, 0.2)
"""Of a lamp or window, at least and at most: wider ones are sky, which the even light is; the rims
of low, round things tell too much, since their own hidden sky adds to the rim."""
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
    """The light as bright, of the colour and, where they tell it, from where the pictures show.

    Where exposure changes over the recording, the median frame's counts. Six pictures or more from
    places apart are needed for the direction, which is looked for on the ground about the placement
    and on prints; see `light_direction` for when it is unknown.

    Args:
        frames: stamp in ns, picture, and a depth that is not looked at.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: of the character.
        height_m: of the placed character.
        prints: that are known in the world.
        ground: as from `ground_of_footage`, which is asked where it is not given.

    Returns:
        the light, and what was taken from the pictures and what assumed.

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
    found = _direction(ground, placement, prints, on_prints)
    shaped = _from(found, usual, placement, _share(found, ground))
    where = f"its direction assumed ({found.told})"
    if found.towards is not None:
        where = f"its direction {found.told}, ±{np.rad2deg(found.doubt_rad):.0f}°"
    if prints is not None and on_prints:
        gain = _gain_by_paper(shaped, prints, on_prints)
        summary = f"brightness and colour of light by printed paper, {where}"
    else:
        gain = _gain_by_grey(shaped, placement, np.median([_grey(one) for one, _ in seen], axis=0))
        summary = f"brightness and colour of light guessed from a grey world, {where}"
    return _brightened(shaped, np.clip(gain, *GAINS)), summary


def found_direction(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    prints: Prints | None = None,
) -> LightDirection:
    """Where the light comes from by pictures alone, as `lighting_without_depth` takes it.

    Args:
        frames: stamp in ns, picture, and a depth that is not looked at.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: whose ground is looked at.
        prints: that are known in the world.
    """
    seen = _posed(frames, world_T_camera)
    ground = ground_map(seen, camera, placement.world_T_character, prints)
    return _direction(ground, placement, prints, _on_prints(seen, camera, prints))


def ground_of_footage(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    prints: Prints | None = None,
) -> GroundMap | None:
    """The ground about a placement as footage shows it; arguments as `found_direction` has them."""
    seen = _posed(frames, world_T_camera)
    return ground_map(seen, camera, placement.world_T_character, prints)


def _posed(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]], world_T_camera: Trajectory
) -> list[tuple[ImageArray, Motor]]:
    """Pictures in colour and their poses."""
    first, last = world_T_camera.time_ns[0], world_T_camera.time_ns[-1]
    return [
        (as_rgb(picture), world_T_camera.motors_at(np.int64(time_ns)))
        for time_ns, picture, _ in frames
        if first <= time_ns <= last
    ]


def _on_prints(
    seen: list[tuple[ImageArray, Motor]], camera: Camera, prints: Prints | None
) -> list[tuple[int, FloatArray]]:
    if prints is None:
        return []
    return [one for picture, pose in seen for one in light_on_paper(picture, camera, pose, prints)]


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


def _share(found: LightDirection, ground: GroundMap | None) -> float | None:
    """The sun's, of the light on the ground; None where nothing tells."""
    if found.towards is None:
        if found.darkening is not None:
            return UNTOLD
        shadowless = ground is not None and things_seen(ground) >= SHADOWLESS
        return SHARES[0] if shadowless else None
    if found.darkening is None:
        return SHARE
    own = (found.darkening - HIDDEN_SKY) / (1.0 - HIDDEN_SKY)
    return float(np.clip(own, *SHARES))


def _from(
    found: LightDirection, usual: Lighting, placement: Placement, share: float | None
) -> Lighting:
    """Sun and light from all sides, of which the sun has a share; it is as wide as the rims of
    shadows say. What is not told is the usual light's, but soft.
    """
    if share is None:
        return replace(usual, sun=replace(usual.sun, radius_rad=SOFT_RAD))
    towards, up, radius = -np.array(usual.sun.direction), placement.up, SOFT_RAD
    if found.towards is not None:
        towards, radius = found.towards, usual.sun.radius_rad
        if found.lamp_radius_rad is not None:
            radius = float(np.clip(found.lamp_radius_rad, *RADII_RAD))
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
    usual: Lighting, prints: Prints, found: list[tuple[int, FloatArray]]
) -> FloatArray:
    """Light that was found over the usual light, (3,): the median over frames, mean of prints."""
    middles = prints.points_m().mean(axis=1)
    gains = []
    for k in sorted({number for number, _ in found}):
        there = np.median([light for number, light in found if number == k], axis=0)
        direct, other = light_on(usual, middles[k], prints.normals[k])
        gains.append(np.log(there / (direct + other)))
    return np.asarray(np.exp(np.mean(gains, axis=0)))


def _grey(picture: ImageArray) -> FloatArray:
    """(4,) mean brightness of a picture, and the colour of its light by shades of grey, mean 1."""
    shown = to_linear(picture[::4, ::4].reshape(-1, 3) / 255.0)
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
