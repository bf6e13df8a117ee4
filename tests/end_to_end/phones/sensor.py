"""A phone's camera: lens, rolling shutter, exposure, focus that breathes, noise; all truth exact.

Along rays the panels' texture coordinates divided by depth are nearly affine in the image, so
they are computed on a grid of every eighth pixel, each with its own line's pose, and interpolated.
Motion blur is one line for the whole image, centred: it moves no edge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import Camera
from tests.textured_room.scene import Panel

__all__ = ["PhoneCamera", "Studio"]

Path = Callable[[FloatArray], Motor]
"""world_T_camera at times in seconds."""
_STEP = 8
_LEVELS = 5
_NOISES = 6
_SOFT_PX = 0.6


@dataclass(frozen=True)
class PhoneCamera:
    """How a phone films, in upright images.

    Fields:
        camera: at rest.
        readout_s: from left to right, and from top to bottom.
        exposure_s: of a line.
        breathing: amplitude of the relative change of the focal length; period_s: of it.
        noise: grey levels.
    """

    camera: Camera
    readout_s: tuple[float, float] = (0.0, 0.0)
    exposure_s: float = 0.004
    breathing: float = 0.0
    period_s: float = 5.0
    noise: float = 2.0

    def at(self, time_s: float) -> Camera:
        """The camera of a frame; the breathing's mean over a period is the camera at rest."""
        if not self.breathing:
            return self.camera
        wave = 1.0 + self.breathing * np.sin(2.0 * np.pi * time_s / self.period_s)
        return replace(self.camera, fx=self.camera.fx * wave, fy=self.camera.fy * wave)

    def project(self, path: Path, time_s: float, points: FloatArray) -> FloatArray:
        """Where points ``(n, 3)`` of the world are seen ``(n, 2)`` in the frame of a time."""
        camera, size = self.at(time_s), np.array([self.camera.width, self.camera.height])
        late = np.full(len(points), time_s)
        for _ in range(6):
            px = camera.project(path(late).inverse().apply(points), allow_nan=True)
            line = np.clip(np.nan_to_num((px + 0.5) / size - 0.5), -1.0, 1.0)
            late = time_s + line @ np.array(self.readout_s)
        return px


class Studio:
    """Draws panels as a phone sees them.

    Args:
        panels: what there is.
        phone: what films it.
        path: how it is held.
        rng: of the noise.
    """

    def __init__(
        self, panels: Sequence[Panel], phone: PhoneCamera, path: Path, rng: np.random.Generator
    ) -> None:
        self._phone, self._path, self._rng = phone, path, rng
        self._panels = panels
        self._pyramids = [_pyramid(panel.texture) for panel in panels]
        shape = (phone.camera.height, phone.camera.width)
        self._noises = [
            phone.noise * rng.standard_normal(shape, dtype=np.float32) for _ in range(_NOISES)
        ]

    def frame(self, time_s: float) -> NDArray[np.uint8]:
        """The upright grey image of a time, which is its middle line's."""
        width, height = self._phone.camera.width, self._phone.camera.height
        image = np.full((height, width), 96, np.uint8)
        near = np.zeros((height, width), np.float32)
        rays, place = self._rays(time_s)
        for panel, pyramid in zip(self._panels, self._pyramids, strict=True):
            _draw(panel, pyramid, rays, place, image, near)
        seen = cv2.filter2D(image.astype(np.float32), -1, self._blur(time_s))
        noise = self._noises[int(self._rng.integers(_NOISES))]
        noise = np.roll(noise, int(self._rng.integers(height)), axis=0)
        return np.asarray(np.clip(seen + noise + 0.5, 0, 255), np.uint8)

    def _rays(self, time_s: float) -> tuple[FloatArray, FloatArray]:
        """Directions and origins ``(rows, columns, 3)`` of a grid a step over the edges."""
        phone = self._phone
        camera = phone.at(time_s)
        x = _STEP * np.arange(-1, camera.width // _STEP + 1) + 0.5 * (_STEP - 1)
        y = _STEP * np.arange(-1, camera.height // _STEP + 1) + 0.5 * (_STEP - 1)
        grid = np.stack(np.meshgrid(x, y), axis=-1)
        rays = camera.bearings(grid)
        across = (x + 0.5) / camera.width - 0.5
        down = (y + 0.5) / camera.height - 0.5
        if phone.readout_s[0]:
            poses = self._path(time_s + phone.readout_s[0] * across)
            turned = np.einsum("cij,rcj->rci", poses.rotor.as_matrix(), rays)
            return turned, np.broadcast_to(poses.translation_m, rays.shape)
        poses = self._path(time_s + phone.readout_s[1] * down)
        turned = np.einsum("rij,rcj->rci", poses.rotor.as_matrix(), rays)
        return turned, np.broadcast_to(poses.translation_m[:, None], rays.shape)

    def _blur(self, time_s: float) -> NDArray[np.float32]:
        """The line that the image's middle draws while it is exposed, softened by the lens."""
        phone, half = self._phone, 0.5 * self._phone.exposure_s
        pose = self._path(np.array(time_s))
        ahead = pose.apply(np.array([[0.0, 0.0, 1.0]]))
        still = replace(phone, readout_s=(0.0, 0.0), breathing=0.0)
        ends = [still.project(self._path, time_s + at, ahead)[0] for at in (-half, half)]
        length = float(np.linalg.norm(ends[1] - ends[0]))
        reach = int(np.ceil(0.5 * length + 3.0 * _SOFT_PX))
        y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(np.float64)
        along = np.linspace(-0.5, 0.5, max(int(4 * length), 1))[:, None] * (ends[1] - ends[0])
        spots = (x - along[:, 0, None, None]) ** 2 + (y - along[:, 1, None, None]) ** 2
        kernel = np.exp(-0.5 * spots / _SOFT_PX**2).sum(axis=0)
        return np.asarray(kernel / kernel.sum(), np.float32)


def _pyramid(texture: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    levels = [texture]
    while len(levels) < _LEVELS and min(levels[-1].shape) > 16:
        half = (levels[-1].shape[1] // 2, levels[-1].shape[0] // 2)
        levels.append(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA))
    return levels


def _draw(
    panel: Panel,
    pyramid: list[NDArray[np.uint8]],
    rays: FloatArray,
    place: FloatArray,
    image: NDArray[np.uint8],
    near: NDArray[np.float32],
) -> None:
    """Draw what of a panel is nearer than what was drawn."""
    normal = np.cross(panel.right_m, panel.down_m)
    if normal @ (panel.corner_m - place[0, 0]) <= 0.0:
        return  # its back
    # s, t and 1 over the ray's length, from v = s' right + t' down + n (corner - place).
    depth = (panel.corner_m - place) @ normal
    nearness = (rays @ normal) / depth
    inverse = np.linalg.pinv(np.stack([panel.right_m, panel.down_m], axis=-1))
    flat = (rays - nearness[..., None] * (panel.corner_m - place)) @ inverse.T
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = flat[..., 0] / nearness, flat[..., 1] / nearness
        hit = (nearness > 1e-6) & (s > -0.1) & (s < 1.1) & (t > -0.1) & (t < 1.1)
    if not hit.any():
        return
    rows, columns = np.flatnonzero(hit.any(axis=1)), np.flatnonzero(hit.any(axis=0))
    top, bottom = max(rows[0] - 1, 1), min(rows[-1] + 2, hit.shape[0] - 1)
    left, right = max(columns[0] - 1, 1), min(columns[-1] + 2, hit.shape[1] - 1)
    if top >= bottom or left >= right:
        return
    part = np.concatenate([flat, nearness[..., None]], axis=-1)
    part = part[top - 1 : bottom + 1, left - 1 : right + 1].astype(np.float32)
    size = (part.shape[1] * _STEP, part.shape[0] * _STEP)
    fine = cv2.resize(part, size, interpolation=cv2.INTER_LINEAR)[_STEP:-_STEP, _STEP:-_STEP]
    box = np.s_[(top - 1) * _STEP : (bottom - 1) * _STEP, (left - 1) * _STEP : (right - 1) * _STEP]
    own = np.ascontiguousarray(fine[..., 2])
    with np.errstate(divide="ignore", invalid="ignore"):
        fine_s, fine_t = fine[..., 0] / own, fine[..., 1] / own
    inside = (own > 1e-6) & (own > near[box])
    inside &= (fine_s >= 0.0) & (fine_s <= 1.0) & (fine_t >= 0.0) & (fine_t <= 1.0)
    if not inside.any():
        return
    texture = pyramid[_level(fine_s, fine_t, inside, pyramid)]
    high, wide = texture.shape
    seen = cv2.remap(
        texture,
        np.asarray(fine_s * wide - 0.5, np.float32),
        np.asarray(fine_t * high - 0.5, np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    np.copyto(image[box], seen, where=inside)
    np.copyto(near[box], own, where=inside)


def _level(
    s: FloatArray, t: FloatArray, inside: NDArray[np.bool_], pyramid: list[NDArray[np.uint8]]
) -> int:
    """Which level has about one texel a pixel where the panel is seen."""
    high, wide = pyramid[0].shape
    rows = np.flatnonzero(inside.any(axis=1))
    row = int(rows[len(rows) // 2])
    seen = np.flatnonzero(inside[row])
    if len(seen) < 2:
        return 0
    ends = seen[[0, -1]]
    texels = np.hypot(
        (s[row, ends[1]] - s[row, ends[0]]) * wide, (t[row, ends[1]] - t[row, ends[0]]) * high
    )
    rate = float(texels) / float(ends[1] - ends[0])
    return int(np.clip(np.floor(np.log2(max(rate, 1.0)) + 0.3), 0, len(pyramid) - 1))
