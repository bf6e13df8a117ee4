"""Prints of black on white whose place is known, and the light that their paper shows.

What lies between paper and ink in an image is the light that falls on the print, channel by
channel, less what lens and sensor add everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.animation.appearance import to_linear
from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.render.scene import BRIGHTEST, ImageArray
from motorcade.tracking.cameras.camera import Camera

PAPER, INK = 0.85, 0.05
# Samples along each side of a print, how many of them must be seen, and how much brighter paper
# is than ink where a print is seen at all.
SAMPLES, FEWEST, LEAST_CONTRAST = 24, 200, 2.5
# Within the brighter and the darker half: between the edges' blur and what gleams.
WHITE_AT, BLACK_AT = 0.6, 0.4
# Where paper is overexposed ink tells the light, were there no veil over it; half of that is
# believed, and no more than so many times what the paper shows at least.
BELIEVED, MOST_OVER = 0.5, 2.0


@dataclass(frozen=True, eq=False)
class Prints:
    """Flat prints of black on white: boards, markers.

    Attributes:
        world_T_print: Motor (P,); z comes out of the printed face.
        low_m: (P, 2) least x and y of what is printed, in its own frame.
        high_m: (P, 2) greatest.
        margin_m: how far the paper reaches beyond that on every side; it hides things too.

    Raises:
        ValueError: shapes that differ, a print of no size, or a margin below 0.

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
    margin_m: float = 0.0

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m"):
            values = checked_floats(getattr(self, name), f"Prints.{name}", (2,))
            if values.ndim != 2 or self.world_T_print.shape != (len(values),):
                raise ValueError(
                    f"Prints.{name}: expected one row a print, got {values.shape} for poses of "
                    f"shape {self.world_T_print.shape}"
                )
            object.__setattr__(self, name, frozen(values))
        if not np.all(self.high_m > self.low_m):
            raise ValueError("Prints.high_m: expected more than low_m")
        if not 0.0 <= self.margin_m < np.inf:
            raise ValueError(f"Prints.margin_m: expected 0 or more, got {self.margin_m}")

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


def light_on_paper(
    image: ImageArray, camera: Camera, world_T_camera: Motor, prints: Prints
) -> list[tuple[int, FloatArray]]:
    """Number of each print that is seen, and the light (3,) on it, linear, 1 for white to white.

    Overexposed paper tells the least that it may be, and ink the most: the mean of their
    logarithms, for as much of the paper as is overexposed.
    """
    points = prints.points_m()
    own = world_T_camera.inverse().apply(points)
    towards = world_T_camera.translation_m - points.mean(axis=1)
    facing = np.sum(towards * prints.normals, axis=1) > 0.0
    light = []
    for k in np.flatnonzero(facing & np.all(own[..., 2] > 0.0, axis=1)):
        x, y = np.rint(camera.project(own[k])).astype(np.int64).T
        inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
        if np.count_nonzero(inside) < FEWEST:
            continue
        shown = to_linear(image[y[inside], x[inside]] / 255.0)
        grey = shown.mean(axis=1)
        bright = grey > 0.5 * np.sum(np.quantile(grey, [0.05, 0.95]))
        if not 0.2 < np.mean(bright) < 0.9:
            continue
        white = np.quantile(shown[bright], WHITE_AT, axis=0)
        black = np.quantile(shown[~bright], BLACK_AT, axis=0)
        if white.mean() > LEAST_CONTRAST * black.mean():
            least = np.maximum(white - black, 1e-4) / (PAPER - INK)
            full = np.mean(shown[bright] >= to_linear(np.array(BRIGHTEST / 255.0)), axis=0)
            over = np.clip(black / INK / least, 1.0, MOST_OVER)
            light.append((int(k), least * over ** (BELIEVED * full)))
    return light
