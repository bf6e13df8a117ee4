"""Motions of MD5 files: a base pose, and the numbers of each frame that differ from it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.animation.formats.errors import FormatError, expected
from motorcade.animation.formats.limits import MAX_NODES, MAX_POSES
from motorcade.animation.formats.md5.words import Words, opened
from motorcade.animation.formats.rig.transforms import Transforms
from motorcade.animation.formats.rig.values import NodeTree, Rig, RigClip
from motorcade.ga.arrays import FloatArray, IntArray


def orientation(xyz: FloatArray) -> FloatArray:
    """Unit quaternions wxyz (*, 4) from their last three parts (*, 3); the first is not positive.

    Raises:
        FormatError: parts longer than 1.
    """
    rest = 1.0 - np.sum(xyz * xyz, axis=-1, keepdims=True)
    if np.any(rest < -0.01):
        raise expected("orientation", "parts of a unit quaternion", "longer ones")
    wxyz = np.concatenate([-np.sqrt(np.maximum(rest, 0.0)), xyz], axis=-1)
    unit: FloatArray = wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True)
    return unit


def read_md5_motion(path: Path) -> Rig:
    """Read a `.md5anim` alone; the rest pose is its base frame.

    Raises:
        FormatError: a file that is not consistent.
    """
    names, parents, base, clip = _motion(path)
    tree = NodeTree(names, parents, base)
    return Rig(
        tree,
        tuple(range(len(names))),
        (),
        (clip,),
        up=(0.0, 0.0, 1.0),
        forward=None,
        unit_m=None,
    )


def read_clip(path: Path, names: tuple[str, ...], parents: IntArray) -> RigClip:
    """The clip of a `.md5anim` for these joints.

    Raises:
        FormatError: other joints, or a file that is not consistent.
    """
    try:
        own, above, _, clip = _motion(path)
    except FormatError as fault:
        raise FormatError(f"{path.name}: {fault}") from fault
    if own != names or not np.array_equal(above, parents):
        raise expected(path.name, "the joints of the mesh beside it", f"{len(own)} others")
    return clip


def _motion(path: Path) -> tuple[tuple[str, ...], IntArray, Transforms, RigClip]:
    words = opened(path)
    words.need("numFrames")
    frames = words.integer("numFrames", 1, MAX_POSES)
    words.need("numJoints")
    joints = words.integer("numJoints", 1, MAX_NODES)
    words.need("frameRate")
    rate = words.integer("frameRate", 1, 10_000)
    words.need("numAnimatedComponents")
    width = words.integer("numAnimatedComponents", 0, 6 * joints)
    if frames * joints > MAX_POSES:
        raise expected("numFrames", f"at most {MAX_POSES} poses", frames * joints)
    names, parents, flags, starts = _hierarchy(words, joints, width)
    words.need("bounds")
    words.skip_block()
    words.need("baseframe", "{")
    base = words.floats(6 * joints, "baseframe").reshape(joints, 6)
    words.need("}")
    values = np.repeat(base[None], frames, axis=0)
    for frame in range(frames):
        words.need("frame")
        words.integer("frame", frame, frame)
        words.need("{")
        row = words.floats(width, f"frame {frame}")
        words.need("}")
        for part in range(6):
            animated = np.flatnonzero(flags & (1 << part))
            before = np.array(
                [bin(int(flags[joint]) & ((1 << part) - 1)).count("1") for joint in animated],
                dtype=np.int64,
            )
            values[frame, animated, part] = row[starts[animated] + before]
    rest = Transforms(orientation(base[:, 3:]), base[:, :3], np.ones(joints))
    return names, parents, rest, _clip(path.stem[:200], values, rate)


def _hierarchy(
    words: Words, joints: int, width: int
) -> tuple[tuple[str, ...], IntArray, IntArray, IntArray]:
    """Names, parents, which of six numbers are animated as bits, and where these start."""
    words.need("hierarchy", "{")
    names, parents, flags, starts = [], [], [], []
    for joint in range(joints):
        names.append(words.word("joint name")[:200])
        parents.append(words.integer(f"parent of '{names[-1]}'", -1, joint - 1))
        flags.append(words.integer(f"flags of '{names[-1]}'", 0, 63))
        count = bin(flags[-1]).count("1")
        starts.append(words.integer(f"start of '{names[-1]}'", 0, max(width, 0)))
        if count and starts[-1] + count > width:
            raise expected(f"start of '{names[-1]}'", f"at most {width - count}", starts[-1])
    words.need("}")
    return tuple(names), np.array(parents), np.array(flags), np.array(starts)


def _clip(name: str, values: FloatArray, rate: int) -> RigClip:
    """A clip over frames (F, J, 6) of positions and orientations."""
    keys = np.arange(len(values)) / rate
    return RigClip.of_all_nodes(name, keys, orientation(values[..., 3:]), values[..., :3])
