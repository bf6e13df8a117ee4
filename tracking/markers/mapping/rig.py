"""What the cameras of a rig saw together: one list of observations by frame, camera and marker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.disambiguate import (
    MarkerObservations,
    best_single,
    pose_stream,
    resolve,
)
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.pose import TrackingError

_AGREE_RAD = np.radians(10.0)
_MOST = 200


def agreed(motions: Motor, weight: FloatArray, reach_m: FloatArray) -> tuple[Motor, float]:
    """The guess with the most weight near it, and that weight.

    A choice, not a mean: guesses that are quite wrong, such as flipped poses, do not move it.

    Args:
        motions: Motor ``(n,)``; of more than 200, so many spread evenly are looked at.
        weight: ``(n,)``.
        reach_m: ``(n,)`` how far another may be from each guess to agree with it, beside 10° of
            turn.
    """
    chosen = np.linspace(0, len(weight) - 1, min(len(weight), _MOST)).astype(np.int64)
    motions = motions[chosen]
    apart = motions[:, None].inverse() @ motions[None, :]
    near = apart.rotor.angle() < _AGREE_RAD
    near &= np.linalg.norm(apart.translation_m, axis=-1) < reach_m[chosen][:, None]
    support = near @ weight[chosen]
    best = int(np.argmax(support))
    return motions[best], float(support[best])


@dataclass(frozen=True, eq=False)
class RigObservations:
    """N observations of M markers by C cameras in F frames of a rig.

    Args:
        time_ns: ``(F,)`` stamps, strictly increasing; a frame without markers counts.
        cameras: the cameras.
        rig_T_camera: Motor ``(C,)``.
        stated: ``(C,)`` bool, which of those were; the others are estimated.
        marker_ids: ``(M,)`` rising.
        side_m: ``(M,)``.
        frame: ``(N,)``, of the observations, never falling.
        camera: ``(N,)``.
        marker: ``(N,)``.
        corners_px: ``(N, 4, 2)``.
        camera_T_marker: Motor ``(N,)``, the candidate that was chosen over time.
        probability: ``(N,)`` of that choice.
    """

    time_ns: IntArray
    cameras: tuple[Camera, ...]
    rig_T_camera: Motor
    stated: NDArray[np.bool_]
    marker_ids: IntArray
    side_m: FloatArray
    frame: IntArray
    camera: IntArray
    marker: IntArray
    corners_px: FloatArray
    camera_T_marker: Motor
    probability: FloatArray

    def __len__(self) -> int:
        """Number of observations."""
        return len(self.frame)

    @property
    def rig_T_marker(self) -> Motor:
        """Motor ``(N,)``."""
        return self.rig_T_camera[self.camera] @ self.camera_T_marker

    @property
    def points_m(self) -> FloatArray:
        """``(N, 4, 3)`` corners in the marker's own frame."""
        return marker_points_m(self.side_m[self.marker])

    def only(self, rows: IntArray) -> RigObservations:
        """Some observations ``(n,)`` of the same rig, frames and markers."""
        names = ("frame", "camera", "marker", "corners_px", "camera_T_marker", "probability")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def gather(
    streams: Mapping[str, CornerStream],
    rig_T_camera: Mapping[str, Motor],
    side_m: Mapping[int, float],
    sync_s: float,
    over_time: bool = True,
    posed: Mapping[str, MarkerObservations] | None = None,
) -> RigObservations:
    """Bring the streams of a rig's cameras together, planar poses resolved over time.

    Args:
        streams: by camera.
        rig_T_camera: of at least one of them; the others follow from markers that two cameras see
            in one frame.
        side_m: side of each marker's black square, metres, by id.
        sync_s: stamps so near are one frame; the rig counts as still meanwhile.
        over_time: choose between planar poses over the whole recording; otherwise by the smaller
            reprojection error of each single observation.
        posed: by camera, both planar poses of its detections where something better than their
            corners has found them.

    Raises:
        ValueError: no camera with a pose, a marker without a size, a time below 0.
        TrackingError: a camera that never sees a marker together with the others.
    """
    names = list(streams)
    has_pose = np.array([name in rig_T_camera for name in names], dtype=bool)
    if not has_pose.any():
        raise ValueError("rig_T_camera: expected the pose of at least one camera, got none")
    if not 0.0 <= sync_s < np.inf:
        raise ValueError(f"sync_s: expected seconds of at least 0, got {sync_s}")
    frame_ns, frames = merged_frames([streams[name].time_ns for name in names], sync_s)
    parts = [
        (
            frames[which],
            np.int64(which),
            *_resolved(streams[name], side_m, over_time, (posed or {}).get(name)),
        )
        for which, name in enumerate(names)
    ]
    frame = np.concatenate([own[rows] for own, _, rows, *_ in parts])
    camera = np.concatenate([np.full(len(ids), which) for _, which, _, ids, *_ in parts])
    ids, corners, poses, probability = (
        np.concatenate([part[column] for part in parts]) for column in (3, 4, 5, 6)
    )
    order = np.lexsort((ids, camera, frame))
    marker_ids, marker = np.unique(ids[order], return_inverse=True)
    seen = RigObservations(
        frame_ns,
        tuple(streams[name].camera for name in names),
        Motor.stack([rig_T_camera.get(name, Motor.identity()) for name in names]),
        has_pose,
        marker_ids,
        np.array([side_m[int(one)] for one in marker_ids], np.float64),
        frame[order],
        camera[order],
        marker,
        corners[order],
        Motor(poses[order]),
        probability[order],
    )
    return replace(seen, rig_T_camera=_rig_poses(seen, names))


def _resolved(
    stream: CornerStream,
    side_m: Mapping[int, float],
    over_time: bool,
    posed: MarkerObservations | None,
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
    """Frame, id, corners, chosen pose and its probability of each observation with a pose."""
    seen = pose_stream(stream, side_m) if posed is None else posed
    answer = resolve(seen) if over_time else best_single(seen)
    keys = zip(stream.frame.tolist(), stream.marker_ids.tolist(), strict=True)
    place = {key: row for row, key in enumerate(keys)}
    rows = [place[key] for key in zip(seen.frame.tolist(), seen.marker_ids.tolist(), strict=True)]
    corners = stream.corners_px[np.array(rows, np.int64)]
    poses = answer.camera_T_marker.coefficients
    return seen.frame, seen.marker_ids, corners, poses, answer.probability


def merged_frames(stamps: list[IntArray], sync_s: float) -> tuple[IntArray, list[IntArray]]:
    """Stamps of the rig's frames, and the rig's frame of each camera's own.

    A frame begins with the first stamp that belongs to none yet, and ends before a camera would be
    in it twice. Its stamp is that of the first camera that is in it; where that is the next frame's
    as well, the earliest in it.
    """
    camera = np.concatenate([np.full(len(one), which) for which, one in enumerate(stamps)])
    row = np.concatenate([np.arange(len(one)) for one in stamps])
    time_ns = np.concatenate(stamps)
    frames = [np.zeros(len(one), np.int64) for one in stamps]
    members: list[dict[int, int]] = []
    begin = 0
    for index in np.lexsort((camera, time_ns)):
        stamp, who = int(time_ns[index]), int(camera[index])
        if not members or stamp - begin > sync_s * 1e9 or who in members[-1]:
            members.append({})
            begin = stamp
        members[-1][who] = stamp
        frames[who][row[index]] = len(members) - 1
    stamp_ns = [together[min(together)] for together in members]
    for k, (stamp, following) in enumerate(pairwise(stamp_ns)):
        if stamp == following:
            stamp_ns[k] = min(members[k].values())
    return np.array(stamp_ns), frames


def _rig_poses(seen: RigObservations, names: list[str]) -> Motor:
    """Poses of all cameras: the given ones, then those that see markers together with known ones.

    Raises:
        TrackingError: a camera that sees none.
    """
    poses, known = list(seen.rig_T_camera), seen.stated.copy()
    by_key: dict[tuple[int, int], list[int]] = {}
    for row, key in enumerate(zip(seen.frame.tolist(), seen.marker.tolist(), strict=True)):
        by_key.setdefault(key, []).append(row)
    while not known.all():
        pairs_by_camera: dict[int, list[tuple[int, int]]] = {}
        for rows in by_key.values():
            for a in rows:
                for b in rows:
                    if known[seen.camera[a]] and not known[seen.camera[b]]:
                        pairs_by_camera.setdefault(int(seen.camera[b]), []).append((a, b))
        if not pairs_by_camera:
            lost = names[int(np.argmin(known))]
            raise TrackingError(f"{lost}: expected a marker seen together with another camera")
        which = max(pairs_by_camera, key=lambda camera: len(pairs_by_camera[camera]))
        a, b = np.array(pairs_by_camera[which]).T
        placed = Motor.stack(poses)[seen.camera[a]] @ seen.camera_T_marker[a]
        motions = placed @ seen.camera_T_marker[b].inverse()
        weight = seen.probability[a] * seen.probability[b]
        reach_m = 0.1 * np.linalg.norm(seen.camera_T_marker[b].translation_m, axis=-1)
        poses[which] = agreed(motions, weight, reach_m)[0]
        known[which] = True
    return Motor.stack(poses)
