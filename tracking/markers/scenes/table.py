"""MarkerObservations of a scene's markers, and one table of all poses that they depend on.

A corner is seen through a chain of four poses, ``camera_T_marker = (world_T_carrier @
carrier_T_camera).inverse() @ world_T_body @ body_T_marker``. The table holds a row for each camera,
each marker, each body that stands still, each frame of each body that moves, and each frame of each
camera that wiggles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.audit import scatter_px
from motorcade.tracking.cameras.camera import Camera, reproject
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate.resolving import corner_noise_or
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.mapping.rig import merged_frames
from motorcade.tracking.markers.planar import planar_poses
from motorcade.tracking.markers.scenes.scene import MarkerScene

_WORST_PX = 1e3
CAMERA, CARRIER, BODY, MARKER = range(4)
"""Columns of the chain."""


@dataclass(frozen=True, eq=False)
class SceneObservations:
    """N observations, and where the poses of their chains stand in the table.

    Fields:
        time_ns: ``(F,)``.
        names: of the cameras.
        cameras: of each.
        marker_ids: ``(M,)`` rising.
        side_m: ``(M,)``.
        marker_body: ``(M,)`` row of the body that each marker is on.
        first_row: ``(B,)`` row of the table where each body begins.
        frame_of: ``(P,)`` the frame that each row belongs to; -1 where the pose stays.
        frame, camera, marker: ``(N,)``.
        chain: ``(N, 4)`` rows of the table.
        usual_camera: ``(N,)`` the row of the camera's usual pose, wiggle it or not.
        corners_px: ``(N, 4, 2)``.
        camera_T_marker: Motor ``(N, 2)``, both planar poses.
        probability: ``(N, 2)`` of each, by how well it reprojects.
        noise_px: of a corner's coordinate, by the better poses' errors.
    """

    time_ns: IntArray
    names: tuple[str, ...]
    cameras: tuple[Camera, ...]
    marker_ids: IntArray
    side_m: FloatArray
    marker_body: IntArray
    first_row: IntArray
    frame_of: IntArray
    frame: IntArray
    camera: IntArray
    marker: IntArray
    chain: IntArray
    usual_camera: IntArray
    corners_px: FloatArray
    camera_T_marker: Motor
    probability: FloatArray
    noise_px: float

    def __len__(self) -> int:
        """Number of observations."""
        return len(self.frame)

    @property
    def rows(self) -> int:
        """How many the table has."""
        return len(self.frame_of)

    @property
    def usual_chain(self) -> IntArray:
        """``(N, 4)`` rows of the table, no camera wiggling."""
        chain = self.chain.copy()
        chain[:, CAMERA] = self.usual_camera
        return chain

    @property
    def points_m(self) -> FloatArray:
        """``(N, 4, 3)`` corners in the marker's own frame."""
        return marker_points_m(self.side_m[self.marker])

    def residuals_px(self, which: IntArray, in_camera: FloatArray) -> FloatArray:
        """Reprojection of points ``(n, 4, 3)`` minus the corners of observations ``(n,)``."""
        residuals = np.full((len(which), 4, 2), np.nan)
        for row, camera in enumerate(self.cameras):
            mine = self.camera[which] == row
            residuals[mine] = camera.project(in_camera[mine]) - self.corners_px[which[mine]]
        return residuals

    def linearised(
        self, poses: Motor, rows: NDArray[np.int64] | slice = slice(None)
    ) -> tuple[FloatArray, FloatArray, tuple[FloatArray, ...]]:
        """Residuals ``(N, 8)``, derivatives ``(N, 8, 6)`` by the camera's pose, and what these are
        multiplied by, ``(N, 6, 6)`` each, for those by the three others of the chain.
        """
        chain = self.chain[rows]
        camera_T_carrier = poses[chain[:, CAMERA]].inverse()
        carrier_T_body = poses[chain[:, CARRIER]].inverse() @ poses[chain[:, BODY]]
        camera_T_body = camera_T_carrier @ carrier_T_body
        camera_T_marker = camera_T_body @ poses[chain[:, MARKER]]
        in_camera = camera_T_marker[:, None].apply(self.points_m[rows])
        residuals = np.full((len(chain), 4, 2), np.nan)
        by_corner = np.zeros((len(chain), 4, 2, 6))
        for row, camera in enumerate(self.cameras):
            mine = self.camera[rows] == row
            pixels, by_corner[mine], _ = reproject(camera, in_camera[mine])
            residuals[mine] = pixels - self.corners_px[rows][mine]
        flat, own = residuals.reshape(-1, 8), by_corner.reshape(-1, 8, 6)
        hidden = ~np.isfinite(flat).all(-1) | ~np.isfinite(own).all((-1, -2))
        flat[hidden], own[hidden] = 0.0, 0.0
        others = (
            camera_T_carrier.adjoint(),
            -camera_T_body.adjoint(),
            -camera_T_marker.adjoint(),
        )
        return flat, own, others

    def errors_px(self, poses: Motor) -> FloatArray:
        """``(N,)`` root mean square reprojection errors; infinite where a corner has no image."""
        chain = self.chain
        camera_T_world = (poses[chain[:, CARRIER]] @ poses[chain[:, CAMERA]]).inverse()
        camera_T_marker = camera_T_world @ poses[chain[:, BODY]] @ poses[chain[:, MARKER]]
        residuals = self.residuals_px(
            np.arange(len(self)), camera_T_marker[:, None].apply(self.points_m)
        )
        errors = np.sqrt(np.sum(residuals**2, axis=(-1, -2)) / 4.0)
        return np.where(np.isfinite(errors), errors, np.inf)

    def limits_px(self, sigma_px: float) -> FloatArray:
        """``(N,)`` most that an observation may be off, whatever the others are (`scatter_px`)."""
        by_camera = np.array([scatter_px(camera, sigma_px) for camera in self.cameras])
        return np.asarray(by_camera[self.camera], np.float64)


def gather_scene(
    streams: Mapping[str, CornerStream], scene: MarkerScene, sync_s: float
) -> SceneObservations:
    """Bring the cameras' streams together.

    Markers that the scene ignores are left out, and those that cannot be seen at all: on the body
    that carries the camera, or through whose corners the lens model has no ray.

    Raises:
        ValueError: no stream, or one of a camera that the scene does not know.
    """
    names = tuple(streams)
    if not names:
        raise ValueError("streams: expected at least one camera, got none")
    strange = [name for name in names if name not in scene.camera_body]
    if strange:
        cameras = ", ".join(scene.camera_body)
        raise ValueError(f"streams: expected cameras of the scene ({cameras}), got {strange[0]}")
    time_ns, frames = merged_frames([streams[name].time_ns for name in names], sync_s)
    body_at = {body.name: row for row, body in enumerate(scene.bodies)}
    carriers = np.array([body_at[scene.camera_body[name]] for name in names])
    seen_ids = np.unique(np.concatenate([streams[name].marker_ids for name in names]))
    known = {int(tag): row for tag in seen_ids if (row := scene.body_of(int(tag))) is not None}
    sides = {tag: float(scene.side_m(tag) or 0.0) for tag in known}
    parts = [
        _posed(streams[name], which, int(carriers[which]), frames[which], known, sides)
        for which, name in enumerate(names)
    ]
    camera, frame, ids, corners, poses, errors = (
        np.concatenate([part[column] for part in parts]) for column in range(6)
    )
    marker_ids = np.array(sorted(known), np.int64)
    marker_body = np.array([known[int(tag)] for tag in marker_ids], np.int64)
    marker = np.searchsorted(marker_ids, ids)
    order = np.lexsort((marker, camera, frame))
    frame, camera, marker = frame[order], camera[order], marker[order]
    noise_px = corner_noise_or(errors[:, 0], None) if len(errors) else 1.0
    frame_of, first_row, first_wiggle = _layout(scene, names, len(marker_ids), len(time_ns))
    moves = np.array([body.moves for body in scene.bodies])
    chain = np.empty((len(frame), 4), np.int64)
    chain[:, MARKER] = len(names) + marker
    chain[:, CAMERA] = np.where(first_wiggle < 0, np.arange(len(names)), first_wiggle)[camera]
    chain[:, CAMERA] += np.where(first_wiggle[camera] < 0, 0, frame)
    for column, body in ((CARRIER, carriers[camera]), (BODY, marker_body[marker])):
        chain[:, column] = first_row[body] + np.where(moves[body], frame, 0)
    return SceneObservations(
        time_ns,
        names,
        tuple(streams[name].camera for name in names),
        marker_ids,
        np.array([sides[int(tag)] for tag in marker_ids], np.float64),
        marker_body,
        first_row,
        frame_of,
        frame,
        camera,
        marker,
        chain,
        camera,
        corners[order],
        Motor(poses[order]),
        _probabilities(errors[order], noise_px),
        noise_px,
    )


def _posed(
    stream: CornerStream,
    which: int,
    carrier: int,
    frames: IntArray,
    known: Mapping[int, int],
    sides: Mapping[int, float],
) -> tuple[NDArray[Any], ...]:
    """Camera, frame, id, corners, planar poses and their errors of what can be posed."""
    owner = np.array([known.get(int(tag), carrier) for tag in stream.marker_ids], np.int64)
    mine = np.flatnonzero(owner != carrier)
    side_m = np.array([sides[int(tag)] for tag in stream.marker_ids[mine]], np.float64)
    rows, both, error_px = planar_poses(stream.camera, stream.corners_px[mine], side_m)
    mine = mine[rows]
    return (
        np.full(len(mine), which),
        frames[stream.frame[mine]],
        stream.marker_ids[mine],
        stream.corners_px[mine],
        both.coefficients,
        error_px,
    )


def _layout(
    scene: MarkerScene, names: tuple[str, ...], markers: int, frames: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Frames of the table's rows, the first row of each body, and that of each camera's frames.

    The last is -1 for a camera that does not wiggle.
    """
    stays, passes = np.array([-1]), np.arange(frames)
    parts = [np.full(len(names) + markers, -1)]
    parts += [passes if body.moves else stays for body in scene.bodies]
    wiggling = np.array([name in scene.wiggle for name in names])
    parts += [passes for _ in range(np.count_nonzero(wiggling))]
    begins = np.cumsum([len(part) for part in parts[:-1]])
    first_wiggle = np.full(len(names), -1)
    first_wiggle[wiggling] = begins[len(scene.bodies) :]
    return np.concatenate(parts), begins[: len(scene.bodies)], first_wiggle


def _probabilities(errors_px: FloatArray, noise_px: float) -> FloatArray:
    """Of both planar poses ``(N, 2)``, whose four corners have so large errors."""
    better = 2.0 * np.diff(np.minimum(errors_px, _WORST_PX) ** 2, axis=-1) / noise_px**2
    first = 1.0 / (1.0 + np.exp(-np.minimum(better, 700.0)))
    return np.concatenate([first, 1.0 - first], axis=-1)
