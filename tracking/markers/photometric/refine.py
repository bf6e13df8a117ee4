"""Photometric refinement: the rectified marker against its known print, both candidates at once.

Corners use a few dozen pixels along the border; the print has edges all over. Every candidate pose
straightens the image of its marker (kornia's homography warp), a linear change of light is taken
out, and Levenberg-Marquardt on the pose's twist makes what is left agree with the print, which is
blurred as the lens and the pixels blur it. All candidates of all markers run in one batch, on the
GPU where there is one. The remaining misfit of the two candidates of a marker is evidence for the
choice between them.

On drawn markers (`make bench SUITE=tracking`) it halves the error of corners and the jitter of
poses, at 96 pixels a side as at 20. It does not settle flips: at 20 pixels the misfit of the print
chooses no better than that of the corners, and both leave them to the motion over time. It costs
30 to 150 milliseconds a marker on one core, far more than detection does: worth it where
steadiness counts, and not for flips.

Breaks down where a marker is partly covered, where it is not flat, where motion blurs it more one
way than another, and on gloss: nothing is robust against other contents than the print. A candidate
that wanders by more than half a cell is put back where it was, and so are both where even the
better leaves a tenth of the contrast unexplained.

Sources: Baker & Matthews 2004 (alignment by Gauss-Newton); Golub & Pereyra 1973 (light projected
out); Olson 2011 (families).

Observations whose candidates were refined on the image, for whatever takes those of corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, checked_gray
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate.observations import (
    MarkerObservations,
    rotation_covariance,
)
from motorcade.tracking.markers.families import layout, marker_points_m
from motorcade.tracking.markers.photometric.prints import (
    PhotometricUnavailable,
    best_device,
    blurred,
    grid_extent,
    grid_points,
    one_thread,
    prints,
    rectified,
    require,
)
from motorcade.tracking.markers.planar import planar_poses
from motorcade.tracking.pose import SIGMA_FLOOR_PX

if TYPE_CHECKING:
    from torch import Tensor

__all__ = ["PhotometricPoses", "PhotometricUnavailable", "refine_photometric"]

_ROUNDS = 12
_BLURS_PX = (0.3, 0.5, 0.7, 0.95, 1.3, 1.8, 2.5)
_BLURRED_AFTER = (1, 4)
_FEWEST, _MOST = 24, 72
_DAMPING = 1e-3
_WANDER_CELLS = 0.5
# What is whole and flat stays below 0.06 even in noise; a covered corner is above 0.13.
_LARGEST_MISMATCH = 0.1
_AROUND = 0.3  # of a marker's size, cut out round it


@dataclass(frozen=True, eq=False)
class PhotometricPoses:
    """Refined candidates of m markers.

    Fields:
        camera_T_marker: Motor ``(m, 2)``, in the order given.
        mismatch: ``(m, 2)`` share of the image's contrast that the print leaves unexplained.
        refined: ``(m, 2)`` whether the pose was changed; otherwise it is the one given.
        pixels: ``(m,)`` how many pixels of the image each marker covers.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.photometric.refine import PhotometricPoses
    >>> refined = PhotometricPoses(Motor.identity((1, 2)), mismatch=np.array([[0.04, 0.31]]),
    ...     refined=np.array([[True, True]]), pixels=np.array([2500.0]))
    >>> refined.mismatch.argmin(axis=1)  # the first candidate explains the print
    array([0])
    """

    camera_T_marker: Motor
    mismatch: FloatArray
    refined: NDArray[np.bool_]
    pixels: FloatArray


def refine_photometric(
    image: GrayImage,
    camera: Camera,
    family: str,
    marker_ids: IntArray,
    side_m: FloatArray,
    camera_T_marker: Motor,
    device: str | None = None,
) -> PhotometricPoses:
    """Refine both candidate poses of every marker on the image itself.

    Args:
        image: ``(height, width)`` uint8, of the camera's size.
        camera: who took it; its lens is taken out first.
        family: of all markers.
        marker_ids: ``(m,)``.
        side_m: ``(m,)`` sides of the black squares, metres.
        camera_T_marker: Motor ``(m, 2)`` to start from, right to about a quarter of a cell.
        device: "cpu" or "cuda"; None takes the GPU where there is one.

    Raises:
        ValueError: shapes that do not agree, or an image of another size.
        PhotometricUnavailable: torch or kornia is not installed.
    """
    count = len(marker_ids)
    if camera_T_marker.shape != (count, 2) or np.shape(side_m) != (count,):
        raise ValueError(
            f"camera_T_marker, side_m: expected {(count, 2)} poses and {(count,)} sides, got "
            f"{camera_T_marker.shape} and {np.shape(side_m)}"
        )
    require()
    if count == 0:
        nothing = np.zeros((0, 2))
        return PhotometricPoses(camera_T_marker, nothing, nothing > 0, np.zeros(0))
    straight = camera.undistort_image(checked_gray(image))
    with one_thread():
        return _Batch.of(
            straight,
            camera,
            family,
            np.asarray(marker_ids),
            np.asarray(side_m, np.float64),
            camera_T_marker,
            device or best_device(),
        ).refined()


class _Batch:
    """All candidates of all markers of one image: 2 m rows, the candidates of one together."""

    def __init__(
        self,
        cuts: Tensor,
        matrix: Tensor,
        prints_: Tensor,
        extent_m: Tensor,
        side_m: Tensor,
        start: Motor,
        sizes_px: FloatArray,
        cells: float,
    ) -> None:
        self.cuts, self.matrix, self.prints = cuts, matrix, prints_
        self.extent_m, self.side_m = extent_m, side_m
        self.start, self.sizes_px, self.cells = start, sizes_px, cells
        self.samples = int(prints_.shape[-1])
        self.points = grid_points(self.samples, extent_m, side_m)
        self.plane = _plane(self.samples, cuts.device)
        self.levels = prints_

    @classmethod
    def of(
        cls,
        straight: GrayImage,
        camera: Camera,
        family: str,
        ids: IntArray,
        side_m: FloatArray,
        camera_T_marker: Motor,
        device: str,
    ) -> _Batch:
        torch = require()
        start = Motor(camera_T_marker.coefficients.reshape(-1, 8))
        sides = np.repeat(side_m, 2)
        corners = camera.undistorted().project(start[:, None].apply(marker_points_m(sides)))
        sizes = np.ptp(corners, axis=1).max(axis=-1)
        cuts, matrix = _cut(straight, camera, corners)
        samples = int(np.clip(np.ceil(1.2 * np.nanmax(sizes)), _FEWEST, _MOST))

        def tensor(array: Any) -> Tensor:
            return torch.as_tensor(np.asarray(array), dtype=torch.float32, device=device)

        return cls(
            tensor(cuts),
            tensor(matrix),
            tensor(np.repeat(prints(family, ids, samples), 2, 0)),
            tensor(sides * grid_extent(family)),
            tensor(sides),
            start,
            sizes,
            layout(family).side_cells,
        )

    def refined(self) -> PhotometricPoses:
        """Choose the blur, step, choose it again, and step until nothing falls any more."""
        torch = require()
        poses = self.start
        damping = np.full(len(poses), _DAMPING)
        view, _ = self._view(poses)
        self._choose_blur(view, poses)
        score = self._score(view[:, 0])
        for turn in range(_ROUNDS):
            step = self._step(poses, view, damping)
            tried = poses @ Motor.from_twist(step)
            tried_view, tried_score = self._view(tried)
            better = (tried_score < score).cpu().numpy()
            poses = _where(better, tried, poses)
            chosen = torch.as_tensor(better, device=view.device)
            view = torch.where(chosen[:, None, None, None], tried_view, view)
            score = torch.where(chosen, tried_score, score)
            damping = np.clip(np.where(better, 0.2 * damping, 10.0 * damping), 1e-7, 1e4)
            if turn in _BLURRED_AFTER:
                self._choose_blur(view, poses)
                score = self._score(view[:, 0])
            if not better.any() and turn > _BLURRED_AFTER[-1]:
                break
        return self._result(poses, score)

    def _result(self, poses: Motor, score: Tensor) -> PhotometricPoses:
        matrix = self.matrix.double().cpu().numpy()
        corners = marker_points_m(self.side_m.double().cpu().numpy())
        apart = np.linalg.norm(
            _pixels(matrix, poses, corners) - _pixels(matrix, self.start, corners), axis=-1
        ).max(axis=-1)
        kept = apart <= _WANDER_CELLS * self.sizes_px / self.cells
        fits = score.cpu().numpy().reshape(-1, 2).min(axis=-1) <= _LARGEST_MISMATCH
        kept &= np.repeat(fits, 2)
        final = _where(kept, poses, self.start)
        _, last = self._view(final)
        area = _area(_pixels(matrix, final, corners))
        return PhotometricPoses(
            Motor(final.coefficients.reshape(-1, 2, 8)),
            last.double().cpu().numpy().reshape(-1, 2),
            (kept & (apart > 0.0)).reshape(-1, 2),
            area.reshape(-1, 2).mean(axis=-1),
        )

    def _poses(self, poses: Motor) -> Tensor:
        torch = require()
        matrices = np.ascontiguousarray(poses.as_matrix())
        return torch.as_tensor(matrices, dtype=torch.float32, device=self.cuts.device)

    def _view(self, poses: Motor) -> tuple[Tensor, Tensor]:
        """Levels and their slopes by pixel ``(b, 3, s, s)``, and the misfit ``(b,)``."""
        view = rectified(
            self.cuts, self.matrix, self._poses(poses), self.extent_m, self.side_m, self.samples
        )
        return view, self._score(view[:, 0])

    def _score(self, levels: Tensor) -> Tensor:
        """1 less the squared correlation with the print, light's slope taken out of both."""
        own, print_ = self._less_plane(levels), self._less_plane(self.levels)
        cross = (own * print_).sum(-1)
        power = (own * own).sum(-1) * (print_ * print_).sum(-1)
        return 1.0 - cross.clamp(min=0.0) ** 2 / power.clamp(min=1e-9)

    def _less_plane(self, levels: Tensor) -> Tensor:
        flat = levels.reshape(len(levels), -1)
        return flat - (flat @ self.plane.T) @ self.plane

    def _step(self, poses: Motor, view: Tensor, damping: FloatArray) -> FloatArray:
        """Damped Gauss-Newton step ``(b, 6)`` of every candidate."""
        torch = require()
        own, print_ = self._less_plane(view[:, 0]), self._less_plane(self.levels)
        gain = (own * print_).sum(-1) / (print_ * print_).sum(-1).clamp(min=1e-9)
        residual = own - gain[:, None] * print_
        slopes = view[:, 1:].flatten(2).swapaxes(1, 2)
        by_twist = (slopes[:, :, None] @ self._pixel_by_twist(poses))[:, :, 0]
        by_twist = by_twist - torch.einsum(
            "kp,bki->bpi", self.plane, torch.einsum("kp,bpi->bki", self.plane, by_twist)
        )
        information = (by_twist.swapaxes(1, 2) @ by_twist).double()
        pull = (by_twist.swapaxes(1, 2) @ residual[:, :, None]).double()
        weight = torch.as_tensor(damping, device=information.device)[:, None]
        diagonal = information.diagonal(dim1=1, dim2=2)
        information = information + torch.diag_embed(weight * diagonal + 1e-9)
        step: FloatArray = -torch.linalg.solve(information, pull)[:, :, 0].cpu().numpy()
        return step

    def _pixel_by_twist(self, poses: Motor) -> Tensor:
        """Derivative ``(b, s * s, 2, 6)`` of the samples' pixels by a twist on the right."""
        torch = require()
        pose = self._poses(poses)
        x, y = self.points[..., 0], self.points[..., 1]
        zero = torch.zeros_like(x)
        in_camera = (
            x[..., None] * pose[:, None, :3, 0]
            + y[..., None] * pose[:, None, :3, 1]
            + pose[:, None, :3, 3]
        )
        depth = in_camera[..., 2]
        fx, fy = self.matrix[:, 0, 0, None], self.matrix[:, 1, 1, None]
        by_point = torch.stack(
            [
                torch.stack([fx / depth, zero, -fx * in_camera[..., 0] / depth**2], -1),
                torch.stack([zero, fy / depth, -fy * in_camera[..., 1] / depth**2], -1),
            ],
            -2,
        )
        by_own = by_point @ pose[:, None, :3, :3]
        a, b, c = by_own.unbind(-1)
        x, y = x[..., None], y[..., None]
        by_turn = torch.stack([c * y, -c * x, b * x - a * y], -1)  # dX = w x X + v, X = (x, y, 0)
        return torch.cat([by_turn, by_own], -1)

    def _choose_blur(self, view: Tensor, poses: Motor) -> None:
        """Blur the prints as the image is blurred: one width, which explains most of it.

        A print that is too sharp or too soft by 0.3 pixels draws its marker larger or smaller by
        0.05 pixels, so the best of a few widths is not good enough: a parabola through the best
        three says the one between.
        """
        shape = self._samples_by_pixel(poses)

        def unexplained(blur_px: float) -> float:
            self.levels = blurred(self.prints, blur_px**2 * shape)
            score = self._score(view[:, 0]).reshape(-1, 2).amin(-1).double().cpu().numpy()
            return float(np.log(np.maximum(score, 1e-6)) @ self.sizes_px[::2] ** 2)

        mismatches = np.array([unexplained(blur_px) for blur_px in _BLURS_PX])
        best = int(np.clip(np.argmin(mismatches), 1, len(mismatches) - 2))
        curve = np.polyfit(_BLURS_PX[best - 1 : best + 2], mismatches[best - 1 : best + 2], 2)
        bottom = -0.5 * curve[1] / curve[0] if curve[0] > 0.0 else _BLURS_PX[np.argmin(mismatches)]
        blur_px = float(np.clip(bottom, _BLURS_PX[0], _BLURS_PX[-1]))
        self.levels = blurred(self.prints, blur_px**2 * shape)

    def _samples_by_pixel(self, poses: Motor) -> Tensor:
        """Covariance ``(b, 2, 2)`` in samples of a blur of one pixel, at the marker's middle."""
        torch = require()
        middle = self._pixel_by_twist(poses)[:, :, :, 3:5].mean(1)
        # Metres in the marker's plane, then samples; rows run against y.
        to_samples = (self.samples / self.extent_m)[:, None, None] * torch.linalg.inv(middle)
        flip = torch.tensor([[1.0], [-1.0]], device=middle.device)
        back = flip * to_samples
        return back @ back.swapaxes(1, 2)


def _cut(straight: GrayImage, camera: Camera, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Images ``(b, 3, h, w)`` (levels and slopes) round quads ``(b, 4, 2)``; their pinholes."""
    low, high = np.nanmin(corners, axis=1), np.nanmax(corners, axis=1)
    reach = int(np.ceil((0.5 + _AROUND) * (high - low).max())) + 4
    middle = np.rint(np.nan_to_num(0.5 * (low + high))).astype(int)
    padded = np.pad(straight.astype(np.float32), reach, mode="edge")
    limit = np.array(straight.shape[::-1]) - 1
    middle = np.clip(middle, 0, limit)
    slopes = [cv2.Scharr(padded, cv2.CV_32F, *axis) / 32.0 for axis in ((1, 0), (0, 1))]
    channels = np.stack([padded, *slopes])
    size = 2 * reach + 1
    cuts = np.stack([channels[:, y : y + size, x : x + size] for x, y in middle])
    matrix = np.tile(np.array(camera.matrix), (len(corners), 1, 1))
    matrix[:, :2, 2] -= middle - reach
    return cuts, matrix


def _plane(samples: int, device: Any) -> Tensor:
    """Orthonormal basis ``(3, s * s)`` of the planes over the grid."""
    torch = require()
    ramp = torch.linspace(-1.0, 1.0, samples, device=device)
    down, across = torch.meshgrid(ramp, ramp, indexing="ij")
    rows = torch.stack([torch.ones_like(down), across, down]).reshape(3, -1)
    return rows / rows.norm(dim=-1, keepdim=True)


def _pixels(matrix: FloatArray, poses: Motor, points: FloatArray) -> FloatArray:
    seen = poses[:, None].apply(points) @ matrix.swapaxes(-1, -2)
    return seen[..., :2] / seen[..., 2:]


def _area(quads: FloatArray) -> FloatArray:
    """Areas ``(b,)`` of quads ``(b, 4, 2)``."""
    first, second = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    return 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _where(chosen: NDArray[np.bool_], poses: Motor, others: Motor) -> Motor:
    return Motor(np.where(chosen[:, None], poses.coefficients, others.coefficients))


# Neighbouring pixels err together: so many of them tell as much as one.
_ALIKE = 4.0


@dataclass(frozen=True, eq=False)
class RefinedFrame:
    """Markers of one image after refinement.

    Args:
        marker_ids: ``(m,)`` of those that have a pose.
        side_m: ``(m,)``.
        corners_px: ``(m, 4, 2)`` where the better candidate puts the corners.
        camera_T_marker: Motor ``(m, 2)``, the candidate that fits the image better first.
        error_px: ``(m, 2)`` 0, and the reprojection error that would speak as clearly against the
            other candidate if corners with `SIGMA_FLOOR_PX` of noise had it.

    Where refinement failed (see `refine_photometric`) all of these are what the corners say.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.photometric import RefinedFrame
    >>> corners_px = np.array([[[10.0, 10.0], [60.0, 10.0], [60.0, 60.0], [10.0, 60.0]]])
    >>> frame = RefinedFrame(np.array([7]), np.array([0.1]), corners_px,
    ...     Motor.identity((1, 2)), error_px=np.array([[0.0, 3.2]]))
    >>> frame.marker_ids, float(frame.error_px[0, 1])  # the other candidate is clearly worse
    (array([7]), 3.2)
    """

    marker_ids: IntArray
    side_m: FloatArray
    corners_px: FloatArray
    camera_T_marker: Motor
    error_px: FloatArray


def refine_frame(
    image: GrayImage,
    camera: Camera,
    family: str,
    marker_ids: IntArray,
    corners_px: FloatArray,
    side_m: FloatArray,
    device: str | None = None,
) -> RefinedFrame:
    """Refine what was detected in one image; markers without a planar pose are left out.

    Args:
        image: see `refine_photometric`.
        camera: likewise.
        family: likewise.
        marker_ids: ``(n,)``.
        corners_px: ``(n, 4, 2)`` clockwise from the printed top-left corner.
        side_m: ``(n,)``.
        device: see `refine_photometric`.

    Raises:
        ValueError, PhotometricUnavailable: as `refine_photometric`.
    """
    rows, start, errors = planar_poses(camera, corners_px, side_m)
    ids, sides = marker_ids[rows], side_m[rows]
    refined = refine_photometric(image, camera, family, ids, sides, start, device)
    every, better = np.arange(len(ids))[:, None], np.argmin(refined.mismatch, axis=-1)
    sure = refined.refined[every[:, 0], better]
    order = np.argsort(np.where(sure[:, None], refined.mismatch, [0.0, 1.0]), axis=-1)
    poses = refined.camera_T_marker[every, order]
    less, more = np.maximum(np.sort(refined.mismatch, axis=-1), 1e-9).T
    nats = 0.5 * refined.pixels / _ALIKE * np.log(more / less)
    against = SIGMA_FLOOR_PX * np.sqrt(0.5 * nats)
    by_print = np.stack([np.zeros(len(ids)), against], axis=-1)
    return RefinedFrame(
        ids,
        sides,
        np.where(
            sure[:, None, None],
            camera.project(poses[:, 0][:, None].apply(marker_points_m(sides))),
            corners_px[rows],
        ),
        poses,
        np.where(sure[:, None], by_print, errors),
    )


def joined_frames(
    camera: Camera, time_ns: IntArray, frames: Sequence[RefinedFrame]
) -> tuple[CornerStream, MarkerObservations]:
    """All frames of a recording as corners, and as observations with both candidates.

    Args:
        camera: who saw them.
        time_ns: ``(F,)``.
        frames: F of them.
    """
    frame = np.repeat(np.arange(len(frames)), [len(one.marker_ids) for one in frames])
    ids = np.concatenate([one.marker_ids for one in frames])
    corners = np.concatenate([one.corners_px for one in frames])
    poses = Motor.concatenate([one.camera_T_marker for one in frames])
    points = marker_points_m(np.concatenate([one.side_m for one in frames]))
    errors = np.concatenate([one.error_px for one in frames])
    covariance = rotation_covariance(camera, poses, points[:, None])
    observations = MarkerObservations(time_ns, frame, ids, poses, errors, covariance)
    return CornerStream(camera, time_ns, frame, ids, corners), observations
