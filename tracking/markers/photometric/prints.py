"""Prints of markers as grids of levels, as blurred images show them, and images rectified."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.families import layout, marker_cells

if TYPE_CHECKING:
    from torch import Tensor


class PhotometricUnavailable(RuntimeError):
    """Torch or kornia is not installed; the message says how to get them."""


def require() -> Any:
    """The module torch.

    Raises:
        PhotometricUnavailable: it or kornia is missing.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # kornia compiles scripts in a way torch has given up
            import kornia.geometry.transform  # noqa: F401
            import torch
    except ImportError as missing:
        raise PhotometricUnavailable(
            f"photometric refinement needs torch and kornia ({missing.name} is missing): "
            'pip install "motorcade[photometric]"'
        ) from missing
    return torch


def best_device() -> str:
    """The GPU where there is one, else the processor."""
    return "cuda" if require().cuda.is_available() else "cpu"


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch compute on one thread: on batches as small as these others only wait."""
    torch = require()
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def homography_warp(*arguments: Any, **keywords: Any) -> Any:
    """Kornia's, see there."""
    require()
    from kornia.geometry.transform import homography_warp as warp

    return warp(*arguments, **keywords)


MARGIN_CELLS = 0.5
"""Of what surrounds the border that is looked at too; families ask for one cell at least."""
_FINE = 16


def grid_extent(family: str) -> float:
    """How much wider the grid is than the marker's side."""
    return 1.0 + 2.0 * MARGIN_CELLS / layout(family).side_cells


def prints(family: str, marker_ids: IntArray, samples: int) -> FloatArray:
    """Prints with their margin, ``(m, samples, samples)``: 1 white, 0 black, rows downwards."""
    return np.stack([_print(family, int(one), samples) for one in marker_ids])


@cache
def _print(family: str, marker_id: int, samples: int) -> FloatArray:
    """Each sample is the mean of the square round it."""
    cells = np.pad(marker_cells(family, marker_id), 1, constant_values=True)
    beyond = layout(family).margin  # bits outside of the border, which are not looked at
    cells = cells[beyond : len(cells) - beyond, beyond : len(cells) - beyond]
    fine = np.kron(cells.astype(np.float32), np.ones((_FINE, _FINE), np.float32))
    cut = round((1.0 - MARGIN_CELLS) * _FINE)
    fine = fine[cut : fine.shape[0] - cut, cut : fine.shape[1] - cut]
    return np.asarray(cv2.resize(fine, (samples, samples), interpolation=cv2.INTER_AREA))


def blurred(prints_: Tensor, covariance: Tensor) -> Tensor:
    """Prints ``(b, s, s)`` after Gaussian blur, beyond their margin white for ever.

    Args:
        prints_: levels.
        covariance: ``(b, 2, 2)`` of the blur in samples squared, x (columns) before y.
    """
    import torch

    size = prints_.shape[-1]
    down = torch.fft.fftfreq(size, device=prints_.device)[:, None]
    across = torch.fft.rfftfreq(size, device=prints_.device)[None, :]
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    form = (
        xx[:, None, None] * across**2
        + 2.0 * xy[:, None, None] * across * down
        + yy[:, None, None] * down**2
    )
    spectrum = torch.fft.rfft2(prints_) * torch.exp(-2.0 * torch.pi**2 * form)
    return torch.fft.irfft2(spectrum, s=(size, size))


def grid_points(samples: int, extent_m: Tensor, side_m: Tensor) -> Tensor:
    """Places ``(b, s * s, 2)`` of the samples in the markers' planes, metres, rows downwards."""
    import torch

    inner = 1.0 - 1.0 / samples  # samples are the middles of squares that fill the grid
    steps = torch.linspace(-inner, inner, samples, device=side_m.device)
    y, x = torch.meshgrid(-steps, steps, indexing="ij")
    places = torch.stack([x, y], dim=-1).reshape(1, -1, 2)
    centre = side_m[:, None, None] * torch.tensor([0.5, -0.5], device=side_m.device)
    return centre + 0.5 * extent_m[:, None, None] * places


def rectified(
    images: Tensor, matrix: Tensor, poses: Tensor, extent_m: Tensor, side_m: Tensor, samples: int
) -> Tensor:
    """Channels ``(b, c, s, s)`` of the images at the samples of the markers' grids.

    Args:
        images: ``(b, c, h, w)``, cut out round the markers.
        matrix: ``(b, 3, 3)`` of the pinhole, of the cut-outs' own pixels.
        poses: ``(b, 4, 4)`` camera_T_marker.
        extent_m: ``(b,)`` side of each grid.
        side_m: ``(b,)`` side of each marker.
        samples: along each side of the grids.
    """
    import torch

    from motorcade.tracking.markers.photometric.prints import homography_warp

    height, width = images.shape[-2:]
    # From a grid's own -1 to 1 (y down) to its plane, to pixels, to the image's own -1 to 1.
    half, count = 0.5 * (1.0 - 1.0 / samples) * extent_m, len(poses)
    to_plane = torch.zeros(count, 3, 3, device=poses.device)
    to_plane[:, 0, 0], to_plane[:, 1, 1] = half, -half
    to_plane[:, 0, 2], to_plane[:, 1, 2] = 0.5 * side_m, -0.5 * side_m
    to_plane[:, 2, 2] = 1.0
    own = torch.tensor(
        [[2.0 / (width - 1), 0.0, -1.0], [0.0, 2.0 / (height - 1), -1.0], [0.0, 0.0, 1.0]],
        device=poses.device,
    )
    homography = own @ matrix @ poses[:, :3, [0, 1, 3]] @ to_plane
    warped: Tensor = homography_warp(
        images, homography, (samples, samples), padding_mode="border", align_corners=True
    )
    return warped
