"""Frame by frame: where the points of the map are in the next image, and the pose that results.

The pose is predicted at constant velocity, corners are tracked from their predicted places, and the
pose is refined on them. If the prediction does not explain the image, the pose is searched from
scratch. A pose is returned only if there are enough inliers, spread widely enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera, project
from motorcade.tracking.images import track_corners
from motorcade.tracking.slam.features import SlamImage, grid_cells
from motorcade.tracking.slam.geometry import (
    BoolArray,
    FittedPose,
    in_world,
    is_native,
    points_in_world,
    pose_by_sampling,
    refine_pose,
)

_FEWEST_INLIERS = 25
_LEAST_SHARE = 0.4
_GOOD_SHARE = 0.75
_CELLS, _FEWEST_CELLS = 48, 6
_EPIPOLAR_PX = 3.0
_NEIGHBOURS = 3
_KEPT_SHARE = 0.8
_MOTION_SHARE = 0.06
_FEW_POINTS = 150


def is_reliable(fit: FittedPose | None, px: FloatArray, shape: tuple[int, ...]) -> bool:
    """Whether a pose stands on enough inliers, in number, as a share, and over the image.

    Args:
        fit: the pose; None is never reliable.
        px: ``(n, 2)`` the corners it was fitted to.
        shape: (height, width) of the image.
    """
    if fit is None:
        return False
    count = int(np.count_nonzero(fit.inliers))
    if count < max(_FEWEST_INLIERS, _LEAST_SHARE * len(px)):
        return False
    cells = len(np.unique(grid_cells(px[fit.inliers], shape, _CELLS)))
    return cells >= _FEWEST_CELLS and bool(np.isfinite(fit.covariance).all())


@dataclass(frozen=True, eq=False)
class TrackedPoints:
    """Points of the map in one image, as they are tracked from there.

    What the tracker knows of the map is copied here, so the map may change meanwhile.

    Args:
        image: the image; world_T_camera: its pose.
        ids: ``(n,)`` numbers of the points; px: ``(n, 2)`` where they are seen.
        points: ``(n, 3)`` where they are in the world, NaN where that is not known yet.
    """

    image: SlamImage
    world_T_camera: Motor
    ids: IntArray
    px: FloatArray
    points: FloatArray

    @property
    def located(self) -> BoolArray:
        """Which points ``(n,)`` are located."""
        known: BoolArray = np.isfinite(self.points[:, 0])
        return known


@dataclass(frozen=True, eq=False)
class _Moment:
    time_ns: int
    world_T_camera: Motor


class Tracker:
    """Tracks points of the map through images; it never looks at the map itself.

    Args:
        camera: the pinhole.
    """

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self._tracked: TrackedPoints | None = None
        self._reference: TrackedPoints | None = None
        self._located_then = 0
        self._moments: list[_Moment] = []

    @property
    def tracked(self) -> TrackedPoints:
        """What is tracked, in the newest image.

        Raises:
            RuntimeError: nothing is tracked.
        """
        if self._tracked is None:
            raise RuntimeError("Tracker.tracked: expected an image that was tracked, got none")
        return self._tracked

    @property
    def is_weak(self) -> bool:
        """Whether half of the located corners in the newest image would be too few."""
        px = self.tracked.px[self.tracked.located]
        cells = np.unique(grid_cells(px, self.tracked.image.gray.shape, _CELLS))
        return len(px) < 2 * _FEWEST_INLIERS or len(cells) < 2 * _FEWEST_CELLS

    def restart(self, tracked: TrackedPoints) -> None:
        """Go on from a pose that was found otherwise; what the motion was is forgotten."""
        self._moments = []
        self._reference = tracked
        self._accept(tracked)

    def anchor(self, keyframe: TrackedPoints, before: Motor, stretch: float | None = None) -> None:
        """Take over what the map made of an image that was tracked: the newest, or one before.

        New points are tracked from the keyframe to the newest image; poses since then move as
        the keyframe moved.

        Args:
            keyframe: the keyframe with its points, as the map has it now.
            before: world_T_camera the keyframe had when it was tracked.
            stretch: by how much lengths around it grew since, where a loop moved the map as a
                whole; None where it was only adjusted, by less than poses are predicted to.
        """
        self._reference = keyframe
        self._located_then = int(np.count_nonzero(keyframe.located))
        last = self._tracked
        if last is None:
            return
        newest = last.image.time_ns == keyframe.image.time_ns
        now = Similarity.from_motor_scale(keyframe.world_T_camera, stretch or 1.0)
        correction = now @ Similarity.from_motor_scale(before).inverse()
        if stretch is not None or not newest:
            self._moments = [
                _Moment(moment.time_ns, in_world(correction, moment.world_T_camera))
                for moment in self._moments
            ]
        if newest:
            self._accept(keyframe)
            return
        pose = in_world(correction, last.world_T_camera)
        _, rows, last_rows = np.intersect1d(
            keyframe.ids, last.ids, assume_unique=True, return_indices=True
        )
        px = self._guess(keyframe, pose)
        px[rows] = last.px[last_rows]
        new = np.setdiff1d(np.arange(len(px)), rows)
        images = keyframe.image.pyramid, last.image.pyramid
        px[new], tracked = track_corners(*images, keyframe.px[new], px[new])
        kept = np.sort(np.concatenate([rows, new[tracked]]))
        self._tracked = TrackedPoints(
            last.image, pose, keyframe.ids[kept], px[kept], keyframe.points[kept]
        )

    def rescale(self, world_T_map: Similarity) -> None:
        """Go on in another world, to which the map was taken."""
        self._moments = [
            _Moment(old.time_ns, in_world(world_T_map, old.world_T_camera)) for old in self._moments
        ]
        for name in ("_tracked", "_reference"):
            held: TrackedPoints | None = getattr(self, name)
            if held is not None:
                pose = in_world(world_T_map, held.world_T_camera)
                points = points_in_world(world_T_map, held.points)
                setattr(self, name, replace(held, world_T_camera=pose, points=points))

    def lose(self) -> None:
        """Forget what was tracked."""
        self._tracked, self._moments = None, []

    def wants_keyframe(self) -> bool:
        """Whether the newest image should become a keyframe, by what is tracked in it."""
        now, then = self.tracked, self._reference
        located = int(np.count_nonzero(now.located))
        if then is None or located < max(_FEW_POINTS, _KEPT_SHARE * self._located_then):
            return True
        _, old, new = np.intersect1d(then.ids, now.ids, assume_unique=True, return_indices=True)
        motion = np.linalg.norm(then.px[old] - now.px[new], axis=1)
        return bool(np.median(motion) > _MOTION_SHARE * now.image.gray.shape[1])

    def step(self, image: SlamImage, predicted: Motor | None = None) -> FittedPose | None:
        """Find the pose of the next image; None where it is lost.

        Where nothing else predicts the pose, the motion is taken to go on as it was.
        On success `tracked` holds the inliers; on failure what it held before.
        """
        before = self._tracked
        if before is None:
            return None
        if predicted is None:
            predicted = self._predicted(image.time_ns)
        guess = self._guess(before, predicted)
        px, tracked = track_corners(before.image.pyramid, image.pyramid, before.px, guess)
        ids, points = before.ids[tracked], before.points[tracked]
        px, old_px = px[tracked], before.px[tracked]
        located = np.isfinite(points[:, 0])
        fit = self._fitted(predicted, points[located], px[located])
        if not is_reliable(fit, px[located], image.gray.shape) or fit is None:
            return None
        kept = np.ones(len(ids), dtype=np.bool_)
        kept[located] = fit.inliers
        kept[~located] = self._on_epipolar_line(fit, old_px[~located], px[~located])
        pose = fit.world_T_camera
        self._accept(TrackedPoints(image, pose, ids[kept], px[kept], points[kept]))
        return fit

    def _accept(self, tracked: TrackedPoints) -> None:
        """Take this image, pose and corners as where the next image is tracked from."""
        self._tracked = tracked
        time_ns = tracked.image.time_ns
        moment = _Moment(time_ns, tracked.world_T_camera)
        if self._moments and self._moments[-1].time_ns == time_ns:
            self._moments.pop()
        self._moments = [*self._moments[-1:], moment]

    def _predicted(self, time_ns: int) -> Motor:
        """The pose at a stamp if the motion goes on as it was."""
        last = self._moments[-1]
        pose = last.world_T_camera
        if len(self._moments) > 1:
            first = self._moments[0]
            share = (time_ns - last.time_ns) / (last.time_ns - first.time_ns)
            motion = (first.world_T_camera.inverse() @ pose).as_twist()
            pose = pose.retract(min(share, 3.0) * motion)
        return pose

    def _guess(self, start: TrackedPoints, pose: Motor) -> FloatArray:
        """Where corners should be: by their point, or else moved as located neighbours."""
        from scipy.spatial import KDTree

        located = start.located
        points = start.points[located]
        there, _ = project(self.camera, pose, points)
        motion = there - project(self.camera, start.world_T_camera, points)[0]
        usable = np.isfinite(motion[:, 0])
        guess = start.px.copy()
        if np.count_nonzero(usable) < _NEIGHBOURS:
            return guess
        known = start.px[located][usable]
        rows = np.flatnonzero(located)[usable]
        unlocated = np.setdiff1d(np.arange(len(guess)), rows)
        near = KDTree(known).query(guess[unlocated], _NEIGHBOURS)[1]
        guess[unlocated] += np.median(motion[usable][near], axis=1)
        guess[rows] = known + motion[usable]
        return guess

    def _fitted(self, predicted: Motor, points: FloatArray, px: FloatArray) -> FittedPose | None:
        if len(points) < _FEWEST_INLIERS:
            return None
        refined = refine_pose(predicted, points, px, self.camera)
        if np.count_nonzero(refined.inliers) >= _GOOD_SHARE * len(points):
            return refined
        sampled = pose_by_sampling(points, px, self.camera)
        better = sampled is not None and np.count_nonzero(sampled.inliers) > np.count_nonzero(
            refined.inliers
        )
        return sampled if better else refined

    def _on_epipolar_line(self, fit: FittedPose, old_px: FloatArray, px: FloatArray) -> BoolArray:
        """Corners ``(n,)`` that are not located and moved as the new pose allows."""
        last = self._moments[-1].world_T_camera
        relative = (fit.world_T_camera.inverse() @ last).as_matrix()
        x, y, z = relative[:3, 3]
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        if is_native(self.camera):
            planes = self.camera.bearings(old_px) @ (cross @ relative[:3, :3]).T
            length = np.linalg.norm(planes, axis=1) * _EPIPOLAR_PX / self.camera.fx
            sine = np.abs(np.sum(planes * self.camera.bearings(px), axis=1))
            return np.asarray(sine <= length + 1e-12)
        to_plane = np.linalg.inv(self.camera.matrix)
        fundamental = to_plane.T @ cross @ relative[:3, :3] @ to_plane
        lines = np.concatenate([old_px, np.ones((len(px), 1))], axis=1) @ fundamental.T
        length = np.linalg.norm(lines[:, :2], axis=1)
        offset = np.abs(np.sum(lines[:, :2] * px, axis=1) + lines[:, 2])
        # Without motion there is no line, and nothing speaks against the corner.
        near: BoolArray = offset <= _EPIPOLAR_PX * length + 1e-12
        return near
