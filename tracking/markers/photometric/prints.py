"""Prints of markers as grids of levels, and the same as a blurred picture shows them."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.families import marker_cells, side_cells

if TYPE_CHECKING:
    from torch import Tensor

__all__ = ["MARGIN_CELLS", "blurred", "grid_extent", "prints"]

MARGIN_CELLS = 0.5
"""Of the white round the border that is looked at too; families ask for one cell at least."""
_FINE = 16


def grid_extent(family: str) -> float:
    """How much wider the grid is than the marker's side."""
    return 1.0 + 2.0 * MARGIN_CELLS / side_cells(family)


def prints(family: str, marker_ids: IntArray, samples: int) -> FloatArray:
    """Prints with their margin, ``(m, samples, samples)``: 1 white, 0 black, rows downwards."""
    return np.stack([_print(family, int(one), samples) for one in marker_ids])


@cache
def _print(family: str, marker_id: int, samples: int) -> FloatArray:
    """Each sample is the mean of the square round it."""
    cells = np.pad(marker_cells(family, marker_id), 1, constant_values=True)
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
