"""Light without depth: how bright and of what colour, by paper that is known, else by grey world.

A printed board or marker is white paper and black ink, whatever stands around it: what lies between
the two in a picture is the light that falls on it, channel by channel, less what lens and sensor
add everywhere. It is one plane, so it does not tell where that light comes from: direction and
shape stay those of the light made for the viewer, which is brightened and tinted until it lights
the paper as much. Where there is no print, colour is guessed by shades of grey (Finlayson and
Trezzi, "Shades of gray and colour constancy", 2004) and brightness by a scene whose mean is middle
grey, and half of either guess is believed, for neither is a law.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from motorcade.animation import Placement
from motorcade.animation.srgb import to_linear
from motorcade.animation.vectors import UP
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.render.composite import as_rgb
from motorcade.render.light.lamps import character_lighting, light_on, sunlight_direction
from motorcade.render.scene import DepthArray, ImageArray, Lamp, Lighting
from motorcade.tracking.cameras.camera import Camera

PAPER, INK = 0.85, 0.05
MIDDLE_GREY = 0.18
MINKOWSKI = 6.0
BELIEVED = 0.5
GAINS = (0.05, 4.0)
# Samples along each side of a print, how many of them must be seen, and how much brighter paper
# is than ink where a print is seen at all.
SAMPLES, FEWEST, LEAST_CONTRAST = 24, 200, 2.5
# Within the brighter and the darker half: between the edges' blur and what gleams.
WHITE_AT, BLACK_AT = 0.6, 0.4


@dataclass(frozen=True, eq=False)
class Prints:
    """Flat prints of black on white: boards, markers.

    Attributes:
        world_T_print: Motor (P,); z comes out of the printed face.
        low_m: (P, 2) least x and y of what is printed, in its own frame.
        high_m: (P, 2) greatest.

    Raises:
        ValueError: shapes that differ, or a print of no size.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.render.light import Prints
    >>> sheets = Prints(Motor.identity((1,)), np.array([[0.0, 0.0]]), np.array([[0.2, 0.3]]))
    >>> len(sheets), sheets.normals
    (1, array([[0., 0., 1.]]))
    """

    world_T_print: Motor
    low_m: FloatArray
    high_m: FloatArray

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m"):
            given = checked_floats(getattr(self, name), f"Prints.{name}", (2,))
            if given.ndim != 2 or self.world_T_print.shape != (len(given),):
                raise ValueError(
                    f"Prints.{name}: expected one row a print, got {given.shape} for poses of "
                    f"shape {self.world_T_print.shape}"
                )
            object.__setattr__(self, name, frozen(given))
        if not np.all(self.high_m > self.low_m):
            raise ValueError("Prints.high_m: expected more than low_m")

    def __len__(self) -> int:
        """Number of prints."""
        return len(self.low_m)

    def points_m(self) -> FloatArray:
        """(P, S, 3) points spread over each print, world."""
        u = (np.arange(SAMPLES) + 0.5) / SAMPLES
        grid = np.stack(np.meshgrid(u, u), axis=-1).reshape(1, -1, 2)
        own = self.low_m[:, None] + grid * (self.high_m - self.low_m)[:, None]
        flat = np.pad(own, ((0, 0), (0, 0), (0, 1)))
        return self.world_T_print[:, None].apply(flat)

    @property
    def normals(self) -> FloatArray:
        """(P, 3) out of the printed faces, world."""
        return self.world_T_print.rotor.apply(UP)


def lighting_without_depth(
    frames: Iterable[tuple[int, ImageArray, DepthArray | None]],
    camera: Camera,
    world_T_camera: Trajectory,
    placement: Placement,
    height_m: float,
    prints: Prints | None = None,
) -> tuple[Lighting, str]:
    """The light made for the viewer, as bright and of the colour that the pictures show.

    Where exposure changes over the recording, the median frame's counts.

    Args:
        frames: stamp in ns, picture, and a depth that is not looked at.
        camera: pinhole, of the frames' size.
        world_T_camera: its path; frames outside its span are passed over.
        placement: of the character.
        height_m: of the placed character.
        prints: that are known in the world.

    Returns:
        the light, and what was taken from the pictures and what assumed.

    Raises:
        ValueError: a camera with distortion.
    """
    if camera.model != "pinhole":
        raise ValueError(f"lighting_without_depth(camera): expected pinhole, got {camera.model}")
    cameras = world_T_camera.motors
    direction = sunlight_direction(placement, cameras)
    usual = character_lighting(placement, cameras, height_m, direction)
    on_prints: list[tuple[int, FloatArray]] = []
    greys: list[FloatArray] = []
    for time_ns, picture, _ in frames:
        if world_T_camera.time_ns[0] <= time_ns <= world_T_camera.time_ns[-1]:
            seen = as_rgb(picture)
            greys.append(_grey(seen))
            if prints is not None:
                pose = world_T_camera.motors_at(np.int64(time_ns))
                on_prints += _paper(seen, camera, pose, prints)
    if prints is not None and on_prints:
        gain = _gain_by_paper(usual, prints, on_prints)
        summary = "brightness and colour of light by printed paper, its direction assumed"
    elif greys:
        gain = _gain_by_grey(usual, placement, np.median(greys, axis=0))
        summary = "brightness and colour of light guessed from a grey world, its direction assumed"
    else:
        return usual, "a fixed light"
    return _brightened(usual, np.clip(gain, *GAINS)), summary


def _paper(
    picture: ImageArray, camera: Camera, world_T_camera: Motor, prints: Prints
) -> list[tuple[int, FloatArray]]:
    """Number of each print that is seen, and the light (3,) on it, linear, 1 for white to white."""
    points = prints.points_m()
    own = world_T_camera.inverse().apply(points)
    towards = world_T_camera.translation_m - points.mean(axis=1)
    facing = np.sum(towards * prints.normals, axis=1) > 0.0
    found = []
    for k in np.flatnonzero(facing & np.all(own[..., 2] > 0.0, axis=1)):
        x, y = np.rint(camera.project(own[k])).astype(np.int64).T
        inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
        if np.count_nonzero(inside) < FEWEST:
            continue
        shown = to_linear(picture[y[inside], x[inside]] / 255.0)
        grey = shown.mean(axis=1)
        bright = grey > 0.5 * np.sum(np.quantile(grey, [0.05, 0.95]))
        if not 0.2 < np.mean(bright) < 0.9:
            continue
        white = np.quantile(shown[bright], WHITE_AT, axis=0)
        black = np.quantile(shown[~bright], BLACK_AT, axis=0)
        if white.mean() > LEAST_CONTRAST * black.mean():
            found.append((int(k), np.maximum(white - black, 1e-4) / (PAPER - INK)))
    return found


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
