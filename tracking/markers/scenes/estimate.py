"""Where markers, cameras and bodies were, by all that was stated, measured and seen of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import IntArray
from motorcade.tracking.audit import AuditFinding
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.scenes.audit import (
    hand_eye,
    misfit_finding,
    odometry_finding,
    scene_audit,
)
from motorcade.tracking.markers.scenes.graph import adjust_scene
from motorcade.tracking.markers.scenes.mapped import MappedScene
from motorcade.tracking.markers.scenes.scene import MarkerScene
from motorcade.tracking.markers.scenes.start import Start
from motorcade.tracking.markers.scenes.table import BODY, CARRIER, SceneObservations, gather_scene
from motorcade.tracking.pose import TrackingError

_SYNC_S = 0.05
_ROUNDS = 2
_MISFIT = 13.8
"""χ² with two degrees of freedom, of eight residuals less six of the pose, exceeds it once in a
thousand: a wrong pose costs more than one frame of a thousand does."""


def map_scene(
    streams: Mapping[str, CornerStream], scene: MarkerScene, *, sync_s: float = _SYNC_S
) -> MappedScene:
    """Find all poses of a scene from the corners that its cameras saw.

    Poses are found one after another, then adjusted together on corners, stated poses, odometry
    and measured lengths. A frame that one observation alone places has no pose where this misfits.

    Args:
        streams: by camera.
        scene: what is known beforehand.
        sync_s: stamps of different cameras that are so near count as one frame.

    Raises:
        TrackingError: nothing seen.
        ValueError: no stream, or one of a camera that the scene does not know.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Rotor
        >>> from motorcade.tracking import Camera
        >>> from motorcade.tracking.markers.corner_stream import CornerStream
        >>> from motorcade.tracking.markers.families import marker_points_m
        >>> from motorcade.tracking.markers.scenes import FixedMarker, MarkerBody, MarkerScene
        >>> from motorcade.tracking.markers.scenes import StatedPose, map_scene
        >>> here = StatedPose(Motor.identity(), 1e-10 * np.eye(6))
        >>> table = MarkerBody("table", moves=False, stated=here,
        ...     markers={3: FixedMarker(0.1, here), 8: FixedMarker(0.1)})
        >>> scene = MarkerScene((table, MarkerBody("rig", moves=True)), {"camera": "rig"},
        ...     {"camera": here})
        >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
        >>> turn = Rotor.from_rotation_vector([np.pi - 0.4, 0.0, 0.0])
        >>> camera_T_table = Motor.from_rotor_translation(turn, [-0.1, 0.0, 0.6])
        >>> table_T_marker = Motor.from_translation([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
        >>> points = (camera_T_table @ table_T_marker)[:, None].apply(marker_points_m(0.1))
        >>> stream = CornerStream(camera, [0], [0, 0], [3, 8], camera.project(points))
        >>> found = map_scene({"camera": stream}, scene)
        >>> found.seen_from("camera").marker_map.world_T_marker[1].translation_m.round(3) + 0.0
        array([0.2, 0. , 0. ])
    """
    seen = gather_scene(streams, scene, sync_s)
    if len(seen) == 0:
        raise TrackingError("streams: expected markers of the scene, got none")
    scene, findings = _with_good_odometry(seen, scene)
    start = Start(seen, scene)
    start.fill()
    poses, _ = adjust_scene(seen, scene, Motor(start.poses), start.known, bounded=False, last=False)
    for left in reversed(range(_ROUNDS)):
        start.place_again(poses)
        poses, equations = adjust_scene(
            seen, scene, Motor(start.poses), start.known, bounded=True, last=left == 0
        )
    covariance = equations.covariance(np.repeat([1.0, 10.0], 3))
    misfit, alone, limit_px = _misfits(seen, scene, poses, start.known)
    start.known[misfit] = False
    if len(misfit):
        findings.append(misfit_finding(len(misfit), alone, limit_px))
    errors = np.where(start.known[seen.chain].all(axis=1), seen.errors_px(poses), np.inf)
    mapped = MappedScene(scene, seen, poses, start.known, errors, covariance)
    return replace(mapped, audit=(*findings, *scene_audit(mapped)))


def _misfits(
    seen: SceneObservations, scene: MarkerScene, poses: Motor, known: NDArray[np.bool_]
) -> tuple[IntArray, int, float]:
    """Rows of frames whose only observation misfits, how many have but one, and the limit."""
    limit_px = float(np.sqrt(_MISFIT / 4.0)) * scene.sigma_px
    free = np.array(
        [body.moves and body.odometry is None and body.still is None for body in scene.bodies]
    )
    used = np.flatnonzero(known[seen.chain].all(axis=1))
    rows = seen.chain[used][:, [CARRIER, BODY]]
    single = np.bincount(rows.ravel(), minlength=seen.rows)[rows] == 1
    owner = np.searchsorted(seen.first_row, rows, side="right") - 1
    single &= (seen.frame_of[rows] >= 0) & free[owner]
    off = seen.errors_px(poses)[used] > limit_px
    return rows[single & off[:, None]], int(np.count_nonzero(single)), limit_px


def _with_good_odometry(
    seen: SceneObservations, scene: MarkerScene
) -> tuple[MarkerScene, list[AuditFinding]]:
    """The scene without odometry that turns otherwise than what is seen, and what was found."""
    if not any(body.odometry for body in scene.bodies):
        return scene, []
    bare = replace(scene, bodies=tuple(replace(body, odometry=None) for body in scene.bodies))
    start = Start(seen, bare)
    start.fill()
    findings, bodies = [], []
    for first, body in zip(seen.first_row.tolist(), scene.bodies, strict=True):
        if body.odometry is not None and body.moves:
            frames = np.flatnonzero(start.known[first : first + len(seen.time_ns)])
            poses = Motor(start.poses)[first + frames]
            findings.append(
                odometry_finding(body.name, hand_eye(body.odometry, seen.time_ns[frames], poses))
            )
            if not findings[-1].passed:
                body = replace(body, odometry=None)
        bodies.append(body)
    return replace(scene, bodies=tuple(bodies)), findings
