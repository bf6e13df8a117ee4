"""Pictures of markers undistorted and rectified by their poses."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor

__all__ = ["grid_points", "rectified"]


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
    pictures: Tensor, matrix: Tensor, poses: Tensor, extent_m: Tensor, side_m: Tensor, samples: int
) -> Tensor:
    """Channels ``(b, c, s, s)`` of the pictures at the samples of the markers' grids.

    Args:
        pictures: ``(b, c, h, w)``, cut out round the markers.
        matrix: ``(b, 3, 3)`` of the pinhole, of the cut-outs' own pixels.
        poses: ``(b, 4, 4)`` camera_T_marker.
        extent_m: ``(b,)`` side of each grid.
        side_m: ``(b,)`` side of each marker.
        samples: along each side of the grids.
    """
    import torch

    from motorcade.tracking.markers.photometric.libraries import homography_warp

    height, width = pictures.shape[-2:]
    # From a grid's own -1 to 1 (y down) to its plane, to pixels, to the picture's own -1 to 1.
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
        pictures, homography, (samples, samples), padding_mode="border", align_corners=True
    )
    return warped
