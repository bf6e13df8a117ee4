"""The ground as it is seen from above, put together from several images of a moving camera.

What lies flat on the ground is at one place in all of them; what stands on it is not, since it
hides another part of the ground in each. So the scatter over the images tells the two apart
without depth, and what is flat also shows how exposure changes from one image to the next.

Prints are boards and markers whose place is known: what lies between paper and ink in an image is
the light that falls on the print, less what lens and sensor add everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import to_linear
from motorcade.animation.vectors import UP
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, checked_floats, frozen
from motorcade.render.lens import plane_homography
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


CELLS = 256
"""Along a side of the map."""
SPAN = 1.2
"""Half the map's side, in distances between the cameras and its middle."""
FEWEST_VIEWS = 4
SCATTER, USUAL = 0.03, 5.0
"""In the logarithm of light: what scatters by more is not flat, nor by more than so many times what
is usual in these images."""
FAR_OFF, MOST_FALL = 0.25, 3.0
"""What differs by more than the first tells no vignetting; the fall of light with the square of the
angle from the axis: cos⁴ has 2, lenses that are wide open more."""
VEIL = 0.02
"""Of paper's light, added before the logarithm is taken: what is darker is noise."""
_LINEAR = to_linear(np.arange(256) / 255.0).astype(np.float32)
# Of the steepest view that still shows a cell: the ray's fall.
GRAZING = 0.15


@dataclass(frozen=True, eq=False)
class GroundMap:
    """Square cells of the ground, row along +y, column along +x of its frame.

    Attributes:
        world_T_ground: z = 0 is the ground; the map's middle lies at its origin.
        cell_m: side of a cell.
        light: (n, n) linear, median over the images, exposures evened; NaN where seen too seldom.
        scatter: (n, n) of the logarithm of light over the images.
        full: (n, n) whether more than half of the images are overexposed there.
        printed: (n, n) what is known to be a print that lies there.
        bound: the scatter from which on a cell is not flat.
        levels: (K, n, n) logarithm of the light that each image shows, `VEIL` added, exposures
            evened; NaN where it is not seen.
        eyes_m: (K, 3) where each was taken, in the ground's frame.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.render.light.ground import GroundMap
    >>> even = np.full((4, 4), 0.5)
    >>> none = np.zeros((4, 4), bool)
    >>> seen = np.log(even)[None], np.array([[0.0, 0.0, 1.0]])
    >>> lawn = GroundMap(Motor.identity(), 0.1, even, 0.0 * even, none, none, 0.1, *seen)
    >>> bool(lawn.flat.all()), lawn.points_m()[0, 0].round(3)
    (True, array([-0.15, -0.15,  0.  ]))
    """

    world_T_ground: Motor
    cell_m: float
    light: FloatArray
    scatter: FloatArray
    full: NDArray[np.bool_]
    printed: NDArray[np.bool_]
    bound: float
    levels: NDArray[np.float32]
    eyes_m: FloatArray

    @property
    def flat(self) -> NDArray[np.bool_]:
        """(n, n) whether a cell is seen, and alike in all images."""
        with np.errstate(invalid="ignore"):
            return np.isfinite(self.light) & (self.scatter < self.bound)

    def points_m(self) -> FloatArray:
        """(n, n, 3) middles of the cells, world."""
        n = len(self.light)
        own = (np.arange(n) + 0.5 - 0.5 * n) * self.cell_m
        x, y = np.meshgrid(own, own)
        return self.world_T_ground.apply(np.stack([x, y, np.zeros_like(x)], axis=-1))


def ground_map(
    seen: Iterable[tuple[ImageArray, Motor]],
    camera: Camera,
    world_T_ground: Motor,
    prints: Prints | None = None,
) -> GroundMap | None:
    """Look at the ground from above.

    Args:
        seen: images (h, w, 3) uint8 sRGB and their poses `world_T_camera`.
        camera: pinhole, of that size.
        world_T_ground: z = 0 is the ground; the map is made about its origin.
        prints: of which those count that lie on the ground.

    Returns:
        The map; None where fewer than `FEWEST_VIEWS` images were taken from above the ground.
    """
    pairs = [(image, pose) for image, pose in seen]
    if not pairs:
        return None
    eyes = (world_T_ground.inverse() @ Motor.stack([pose for _, pose in pairs])).translation_m
    above = eyes[:, 2] > 0.0
    if np.count_nonzero(above) < FEWEST_VIEWS:
        return None
    half_m = SPAN * float(np.median(np.linalg.norm(eyes[above], axis=1)))
    cell_m = 2.0 * half_m / CELLS
    first = cell_m * (0.5 - 0.5 * CELLS)
    to_ground = np.array([[cell_m, 0.0, first], [0.0, cell_m, first], [0.0, 0.0, 1.0]])
    logs, full, squares = [], [], []
    for (image, pose), eye in zip(pairs, eyes, strict=True):
        if eye[2] > 0.0:
            shown = _from_above(image, camera, pose.inverse() @ world_T_ground, to_ground, eye)
            logs.append(shown[0])
            full.append(shown[1])
            squares.append(shown[2])
    stack, bright, square = np.stack(logs), np.stack(full), np.stack(squares)
    often = np.count_nonzero(np.isfinite(stack), axis=0) >= FEWEST_VIEWS
    if not often.any():
        return None
    level, scatter, overexposed = (np.full(often.shape, np.nan) for _ in range(3))
    stack[:, often], level[often], scatter[often], overexposed[often] = _evened(
        stack[:, often], bright[:, often], square[:, often]
    )
    printed = _printed(world_T_ground, cell_m, prints)
    bound = max(SCATTER, USUAL * float(np.median(scatter[often])))
    light, full_there = np.exp(level) - VEIL, overexposed > 0.5
    return GroundMap(
        world_T_ground,
        cell_m,
        light,
        scatter,
        full_there,
        printed,
        bound,
        stack.astype(np.float32),
        eyes[above],
    )


def _evened(
    level: FloatArray, full: NDArray[np.bool_], square: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The logarithm of light (K, N), its median, scatter and the share of images overexposed, once
    exposure and vignetting are taken out, told by the median of what they make.
    """
    known = np.isfinite(level)
    away = square - np.nanmean(square, axis=0)
    for _ in range(2):
        off = np.where(full, np.nan, level - np.nanmedian(level, axis=0))
        off -= _middle(off)
        kept = np.isfinite(off) & (np.abs(off) < FAR_OFF)
        fall = np.sum(off[kept] * away[kept]) / max(float(np.sum(away[kept] ** 2)), 1e-9)
        level = level - np.where(full, 0.0, np.clip(fall, -MOST_FALL, 0.0) * square)
        off = np.where(full, np.nan, level - np.nanmedian(level, axis=0))
        level = level - np.where(full, 0.0, _middle(off))
    middle = np.nanmedian(level, axis=0)
    scatter = 1.4826 * np.nanmedian(np.abs(level - middle), axis=0)
    return level, middle, scatter, np.sum(full & known, axis=0) / np.sum(known, axis=0)


def _middle(off: FloatArray) -> FloatArray:
    """Median (K, 1) of what each image knows; 0 of one that shows nothing here."""
    known = np.isfinite(off).any(axis=1)
    middle = np.zeros((len(off), 1))
    middle[known] = np.nanmedian(off[known], axis=1, keepdims=True)
    return middle


def _printed(world_T_ground: Motor, cell_m: float, prints: Prints | None) -> NDArray[np.bool_]:
    """The cells of prints that lie on the ground."""
    covered = np.zeros((CELLS, CELLS), np.uint8)
    for k in range(0 if prints is None else len(prints)):
        assert prints is not None  # counted above
        (x0, y0), (x1, y1) = prints.low_m[k], prints.high_m[k]
        edge_m = cell_m + 0.15 * min(x1 - x0, y1 - y0)  # the rim is no corner's
        x0, y0, x1, y1 = x0 - edge_m, y0 - edge_m, x1 + edge_m, y1 + edge_m
        corners = np.array([[x0, y0, 0.0], [x1, y0, 0.0], [x1, y1, 0.0], [x0, y1, 0.0]])
        own = world_T_ground.inverse().apply(prints.world_T_print[k].apply(corners))
        if np.max(np.abs(own[:, 2])) < cell_m:
            cells = np.rint(own[:, :2] / cell_m + 0.5 * CELLS - 0.5).astype(np.int32)
            cv2.fillConvexPoly(covered, cells, 1)
    return covered > 0


def _from_above(
    image: ImageArray,
    camera: Camera,
    camera_T_ground: Motor,
    to_ground: FloatArray,
    eye: FloatArray,
) -> tuple[FloatArray, NDArray[np.bool_], FloatArray]:
    """The logarithm of light of every cell, NaN where it is not seen, what is overexposed, and the
    square of how far each lies from the image's middle, in focal lengths.
    """
    to_image = plane_homography(camera, camera_T_ground) @ to_ground
    n = np.arange(CELLS)
    x, y, depth = (row[0] * n[None, :] + row[1] * n[:, None] + row[2] for row in to_image)
    fall = eye[2] / np.hypot(
        np.hypot(to_ground[0, 0] * n + to_ground[0, 2] - eye[0], eye[2])[None, :],
        (to_ground[1, 1] * n + to_ground[1, 2] - eye[1])[:, None],
    )
    ahead = depth > 1e-6
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = np.where(ahead, x / depth, -9.0), np.where(ahead, y / depth, -9.0)
    inside = (x > 1.0) & (y > 1.0) & (x < camera.width - 2.0) & (y < camera.height - 2.0)
    inside &= fall > GRAZING
    grey = image if image.ndim == 2 else image.mean(axis=2).astype(np.uint8)
    seen = cv2.remap(
        _LINEAR[cv2.blur(grey, (3, 3))],
        x.astype(np.float32),
        y.astype(np.float32),
        cv2.INTER_LINEAR,
    )
    full = inside & (seen >= _LINEAR[BRIGHTEST])
    value = np.log(seen + VEIL)
    square = ((x - camera.cx) / camera.fx) ** 2 + ((y - camera.cy) / camera.fy) ** 2
    nothing = np.where(inside, 0.0, np.nan)
    return nothing + value, full, nothing + square
