"""Animations of a glTF file that is being written.

Clips get keys so dense that turns and translations interpolated apart follow their screws.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.formats.gltf.writing.binary import BinaryBuffer
from motorcade.animation.formats.rig.sampling import divided, parts_of_steps
from motorcade.animation.morphs import MorphTrack
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

PARTING_M = 5e-6
"""How far between keys a written joint may leave its screw, in metres; see MOST_PARTS."""
STORED = 6e-8
"""Half a step of the file's 32-bit numbers at 1."""


class AnimationWriter:
    """One animation that is being put together.

    Args:
        buffer: where its keys go.
    """

    def __init__(self, buffer: BinaryBuffer) -> None:
        self._buffer = buffer
        self._samplers: list[dict[str, Any]] = []
        self._channels: list[dict[str, Any]] = []

    def clip(self, clip: Clip, first: int, character: Character, path: Trajectory | None) -> None:
        """Channels of all joints, the first being node `first`.

        What stays as it is at rest gets none, but for the first joint, which tells how long the
        clip lasts.
        """
        rest, reach_m = character.skeleton.rest, character.height_m
        if clip.morphs is not None:
            self._weights(clip, clip.morphs, first + clip.poses.shape[1], path)
        travels = _travels(clip.poses)
        for joints, times in (
            (np.flatnonzero(travels), _dense(clip.time_s, clip.poses[:, travels], reach_m)),
            (np.flatnonzero(~travels), clip.time_s),
        ):
            if len(joints):
                self._joints(clip, joints, times, first, rest, path)

    def _joints(
        self,
        clip: Clip,
        joints: IntArray,
        times: FloatArray,
        first: int,
        rest: Motor,
        path: Trajectory | None,
    ) -> None:
        """Channels of some joints (K,) that share their keys."""
        poses = clip.at(times)[:, joints]
        wxyz, places, scale = _parts(poses)
        still_wxyz, still_places = rest[joints].as_quaternion_translation()
        if path is not None:
            span_s = 1e-9 * float(path.time_ns[-1] - path.time_ns[0])
            times, rows = _repeated(times - times[0], span_s, looped=clip.looped)
            wxyz, places, scale = wxyz[rows], places[rows], scale[rows]
        keys = self._buffer.add(times, bounds=True)
        for column, joint in enumerate(joints.tolist()):
            node = first + joint
            turns, steps = wxyz[:, column], places[:, column]
            if joint == 0 or not _alike(turns, still_wxyz[column]):
                self._add(keys, node, "rotation", turns[:, [1, 2, 3, 0]])
            if joint == 0 or not _alike(steps, still_places[column]):
                self._add(keys, node, "translation", steps)
            if isinstance(poses, Similarity):
                self._add(keys, node, "scale", np.repeat(scale[:, column, None], 3, axis=1))

    def _weights(self, clip: Clip, track: MorphTrack, node: int, path: Trajectory | None) -> None:
        """A channel of the mesh's morph weights, on the clip's clock."""
        first, last = clip.time_s[0], clip.time_s[-1]
        times = np.unique(np.clip(np.concatenate([track.time_s, [first, last]]), first, last))
        weights = track.at(times)
        if path is not None:
            span_s = 1e-9 * float(path.time_ns[-1] - path.time_ns[0])
            times, rows = _repeated(times - first, span_s, looped=clip.looped)
            weights = weights[rows]
        self._add(self._buffer.add(times, bounds=True), node, "weights", weights.reshape(-1))

    def path(
        self, path: Trajectory, node: int, start_ns: int, before: Rotor, reach_m: float
    ) -> None:
        """Channels that carry a node, which reaches so far; `before` turns what it carries."""
        since_s = 1e-9 * (path.time_ns - path.time_ns[0]).astype(np.float64)
        inside = _dense(since_s, path.poses.reshape(-1, 1), reach_m)
        stamps = path.time_ns[0] + np.round(1e9 * inside).astype(np.int64)
        poses = path.at(stamps)
        wxyz, places, scale = _parts(poses)
        turned = Rotor.from_quaternion(wxyz) @ before
        keys = self._buffer.add(1e-9 * (stamps - start_ns), bounds=True)
        self._add(keys, node, "rotation", turned.as_quaternion()[:, [1, 2, 3, 0]])
        self._add(keys, node, "translation", places)
        if isinstance(poses, Similarity):
            self._add(keys, node, "scale", np.repeat(scale[:, None], 3, axis=1))

    def document(self, name: str, *, looped: bool) -> dict[str, Any]:
        """The animation as it stands in the file."""
        made: dict[str, Any] = {
            "name": name,
            "samplers": self._samplers,
            "channels": self._channels,
        }
        if looped:
            made["extras"] = {"looped": True}
        return made

    def _add(self, keys: int, node: int, path: str, values: FloatArray) -> None:
        self._channels.append(
            {"sampler": len(self._samplers), "target": {"node": node, "path": path}}
        )
        self._samplers.append({"input": keys, "output": self._buffer.add(values)})


def _dense(times: FloatArray, poses: Motor | Similarity, reach_m: float) -> FloatArray:
    """Times with keys between samples (F, J) where screws leave lines."""
    if len(times) < 2:
        return times
    return divided(times, parts_of_steps(*_parts(poses), reach_m, PARTING_M))


def _travels(poses: Motor | Similarity) -> NDArray[np.bool_]:
    """Which joints (J,) of poses (F, J) need keys between the samples: those that change place.

    A joint that only turns follows its screw as its turns are interpolated.
    """
    if isinstance(poses, Similarity):
        return np.ones(poses.shape[1], dtype=bool)
    places = poses.translation_m
    return np.asarray(np.abs(places - places[:1]).max(axis=(0, 2)) > STORED)


def _alike(values: FloatArray, still: FloatArray) -> bool:
    """Whether all rows (F, K) are one (K,), as exactly as the file holds them."""
    return bool(np.abs(values - still).max() <= STORED)


def _parts(poses: Motor | Similarity) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quaternions wxyz (*, 4), translations (*, 3) and scales (*)."""
    scale = poses.scale if isinstance(poses, Similarity) else np.ones(poses.shape)
    return poses.rotor.as_quaternion(), poses.translation_m, scale


MOST_KEYS = 200_000
"""Of a loop that is played again and again along a path."""


def _repeated(
    times: FloatArray, span_s: float, *, looped: bool
) -> tuple[FloatArray, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Times and rows of a clip played again and again until `span_s`; once if it is no loop.

    Raises:
        ValueError: more keys than `MOST_KEYS`.
    """
    rows = np.arange(len(times))
    period = float(times[-1])
    if not looped or period <= 0.0:
        return times, rows
    keys = span_s / period * (len(times) - 1)
    if keys > MOST_KEYS:
        raise ValueError(
            f"write_gltf(world_T_character): expected a path along which the clip has at most "
            f"{MOST_KEYS} keys, got {keys:.6g} over {span_s:.6g} s; cut it at its gaps"
        )
    count = max(int(np.ceil(span_s / period)), 1)
    starts = np.repeat(np.arange(count) * period, len(times) - 1)
    made = np.concatenate([times[:1], starts + np.tile(times[1:], count)])
    return made, np.concatenate([rows[:1], np.tile(rows[1:], count)])
