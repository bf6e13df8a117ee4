"""A scene as it was found: poses of its bodies, cameras and markers, and paths seen from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.markers.marker_map import MarkerMap
from motorcade.tracking.markers.scenes.scene import MarkerScene
from motorcade.tracking.markers.scenes.table import SceneObservations
from motorcade.tracking.measurements import PoseMeasurements
from motorcade.tracking.pose import TrackingError


@dataclass(frozen=True, eq=False)
class ScenePath:
    """Where a camera was, and the markers that do not move in the world of its path.

    Fields:
        measurements: ``world_T_camera`` at the frames in which a marker was seen, or that odometry
            reaches.
        marker_map: of that world.
        error_px: ``(n,)`` reprojection error of each of these frames; 0 where nothing was seen.
    """

    measurements: PoseMeasurements
    marker_map: MarkerMap
    error_px: FloatArray


@dataclass(frozen=True, eq=False)
class MappedScene:
    """A scene as it was found.

    Fields:
        scene: what was stated.
        seen: the observations.
        poses: Motor ``(P,)``, the table of `seen`.
        known: ``(P,)`` which of them were found.
        error_px: ``(N,)`` reprojection error of each observation; infinite where a pose is unknown.
        covariance: ``(P, 6, 6)`` of each pose; what stays and other frames taken as they stand.
        audit: whether what was stated agrees with what was seen.
    """

    scene: MarkerScene
    seen: SceneObservations
    poses: Motor
    known: NDArray[np.bool_]
    error_px: FloatArray
    covariance: FloatArray
    audit: tuple[AuditFinding, ...] = ()

    def body(self, name: str) -> PoseMeasurements:
        """``world_T_body`` of one that moves, at the frames in which it was found."""
        first, frames = self._frames(name)
        rows = first + frames
        path = Trajectory(self.seen.time_ns[frames], self.poses[rows], "world", name)
        return PoseMeasurements(path, self.covariance[rows])

    def still(self, name: str) -> Motor | None:
        """``world_T_body`` of one that stands still; None where it was not found."""
        row = int(self.seen.first_row[self._row(name)])
        return self.poses[row] if self.known[row] else None

    def camera(self, name: str) -> Motor | None:
        """``body_T_camera``, the usual one if it wiggles; None where it was not found."""
        row = self.seen.names.index(name)
        return self.poses[row] if self.known[row] else None

    @property
    def has_odometry(self) -> bool:
        """Whether odometry is in the poses."""
        return any(body.odometry is not None for body in self.scene.bodies)

    @property
    def left_out(self) -> tuple[int, ...]:
        """Markers that were seen and could not be connected."""
        first = len(self.seen.names)
        known = self.known[first : first + len(self.seen.marker_ids)]
        return tuple(self.seen.marker_ids[~known].tolist())

    def seen_from(self, camera: str) -> ScenePath:
        """``world_T_camera``, in the world or, where the camera stands still, from what moves.

        Of several bodies that move before such a camera, from the one whose markers were seen most.

        Raises:
            TrackingError: nothing moves, or the camera was not connected.
        """
        scene, row = self.scene, self.seen.names.index(camera)
        carrier = self._row(scene.camera_body[camera])
        if not self.known[row]:
            raise TrackingError(f"{camera}: expected it to be connected with markers, got it apart")
        if scene.bodies[carrier].moves:
            first, frames = self._frames(scene.bodies[carrier].name)
            rows, inside = first + frames, self.poses[row]
            poses, right = self.poses[rows] @ inside, inside.inverse().adjoint()
            markers = self._markers([k for k, one in enumerate(scene.bodies) if not one.moves])
        else:
            moving = [k for k, one in enumerate(scene.bodies) if one.moves]
            if not moving:
                raise TrackingError("scene: expected a body that moves, got none")
            seen = np.bincount(self.seen.marker_body[self.seen.marker], minlength=len(scene.bodies))
            base = max(moving, key=lambda k: int(seen[k]))
            first, frames = self._frames(scene.bodies[base].name)
            rows = first + frames
            stands = self.poses[int(self.seen.first_row[carrier])] @ self.poses[row]
            poses = self.poses[rows].inverse() @ stands
            right = poses.inverse().adjoint()
            markers = self._markers([base])
        covariance = right @ self.covariance[rows] @ right.swapaxes(-1, -2)
        covariance = 0.5 * (covariance + covariance.swapaxes(-1, -2))
        path = Trajectory(self.seen.time_ns[frames], poses, "world", "camera")
        return ScenePath(PoseMeasurements(path, covariance), markers, self._errors_px(frames))

    def _errors_px(self, frames: IntArray) -> FloatArray:
        """Root mean square over the observations of each frame."""
        good = np.isfinite(self.error_px)
        count = len(self.seen.time_ns)
        squares = np.bincount(self.seen.frame[good], self.error_px[good] ** 2, minlength=count)
        seen = np.bincount(self.seen.frame[good], minlength=count)
        return np.asarray(np.sqrt(squares / np.maximum(seen, 1))[frames], np.float64)

    def _markers(self, bodies: list[int]) -> MarkerMap:
        """Markers of bodies: in the world where these stand still, else on the one body."""
        first, body = len(self.seen.names), self.seen.marker_body
        moves = len(bodies) == 1 and self.scene.bodies[bodies[0]].moves
        rows = first + np.arange(len(body))
        kept = np.isin(body, bodies) & self.known[rows]
        if not moves:
            kept &= self.known[self.seen.first_row[body]]
        indices = np.flatnonzero(kept)
        poses = self.poses[rows[indices]]
        if not moves:
            poses = self.poses[self.seen.first_row[body[indices]]] @ poses
        return MarkerMap(
            self.seen.marker_ids[indices],
            self.seen.side_m[indices],
            poses.rotor,
            poses.translation_m,
        )

    def _row(self, name: str) -> int:
        return [body.name for body in self.scene.bodies].index(name)

    def _frames(self, name: str) -> tuple[int, IntArray]:
        row = self._row(name)
        first = int(self.seen.first_row[row])
        if not self.scene.bodies[row].moves:
            raise ValueError(f"{name}: expected a body that moves, got one that stands still")
        count = len(self.seen.time_ns)
        return first, np.flatnonzero(self.known[first : first + count])
