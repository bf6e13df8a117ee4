"""BVH: a skeleton and its motion as Euler angles, without a mesh.

Joints turn by the angles of their channels in the order in which these stand (intrinsic). Neither
the unit nor the axis that is up is stated.
Source: Meredith and Maddock, Motion Capture File Formats Explained (2001).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from motorcade.animation.formats.limits import (
    MAX_DEPTH,
    MAX_NODES,
    MAX_POSES,
    MAX_TEXT_BYTES,
    FormatError,
    expected,
    numbers_in,
    read_bounded,
)
from motorcade.animation.formats.rig.values import NodeTree, Rig, RigClip, Transforms
from motorcade.animation.vectors import turn_x, turn_y, turn_z
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

POSITIONS = {"Xposition": 0, "Yposition": 1, "Zposition": 2}
ROTATIONS = {"Xrotation": turn_x, "Yrotation": turn_y, "Zrotation": turn_z}


class _Hierarchy:
    """Reads the joints of a file: names, parents, offsets, channels."""

    def __init__(self, words: list[str]) -> None:
        self.names: list[str] = []
        self.parents: list[int] = []
        self.offsets: list[list[float]] = []
        self.channels: list[list[str]] = []
        self._open: list[int] = []
        self._words = words
        self._at = 0
        if self._word() != "HIERARCHY":
            raise expected("file", "HIERARCHY", words[0])
        while self._at < len(words):
            self._entry(self._word())
        if self._open or not self.names:
            raise expected("HIERARCHY", "joints with closed braces", f"{len(self._open)} open")

    def _word(self) -> str:
        self._at += 1
        if self._at > len(self._words):
            raise expected("HIERARCHY", "a closing brace", "the end of the section")
        return self._words[self._at - 1]

    def _entry(self, kind: str) -> None:
        if kind in ("ROOT", "JOINT"):
            self._joint(kind)
        elif kind == "OFFSET" and self._open:
            self.offsets[self._open[-1]] = [_number(self._word()) for _ in range(3)]
        elif kind == "CHANNELS" and self._open:
            self.channels[self._open[-1]] = self._channels()
        elif kind == "End" and self._open:
            self._end()
        elif kind == "}" and self._open:
            self._open.pop()
        else:
            raise expected("HIERARCHY", "a joint, OFFSET, CHANNELS, End or a brace", kind)

    def _joint(self, kind: str) -> None:
        if (kind == "ROOT") != (not self._open):
            raise expected("HIERARCHY", "ROOT outside and JOINT inside of joints", kind)
        name = self._word()
        while (word := self._word()) != "{":
            name += " " + word
        self.names.append(name[:200])
        self.parents.append(self._open[-1] if self._open else -1)
        self.offsets.append([0.0, 0.0, 0.0])
        self.channels.append([])
        self._open.append(len(self.names) - 1)
        if len(self._open) > MAX_DEPTH or len(self.names) > MAX_NODES:
            raise expected("HIERARCHY", f"{MAX_DEPTH} levels, {MAX_NODES} joints", "more")

    def _channels(self) -> list[str]:
        count = _number(self._word())
        if count not in range(7):
            raise expected("CHANNELS", "0 to 6", count)
        names = [self._word() for _ in range(int(count))]
        if any(one not in POSITIONS and one not in ROTATIONS for one in names):
            raise expected("CHANNELS", "names such as Xrotation", names)
        return names

    def _end(self) -> None:
        """Pass over the end of a limb, which is no joint."""
        for wanted in ("Site", "{", "OFFSET"):
            got = self._word()
            if got != wanted:
                raise expected("End Site", wanted, got)
        for _ in range(3):
            _number(self._word())
        got = self._word()
        if got != "}":
            raise expected("End Site", "a closing brace", got)


def read_bvh(path: Path) -> Rig:
    """Read a `.bvh`.

    The rest pose is that of all angles zero, its root where the file's offset puts it.

    Raises:
        FormatError: a file that is not consistent.
    """
    text = read_bounded(path, MAX_TEXT_BYTES).decode("utf-8", "replace")
    head, separator, body = text.partition("MOTION")
    if not separator:
        raise FormatError("file: expected a section MOTION, got none")
    words = head.split()
    if len(words) > 40 * MAX_NODES:
        raise expected("HIERARCHY", f"at most {MAX_NODES} joints", "more")
    tree = _Hierarchy(words)
    width = sum(map(len, tree.channels))
    times, values, beyond = _frames(body, width)
    rig = _rig(tree, times, values, path.stem[:200])
    if not beyond:
        return rig
    rows = f"{beyond / max(width, 1):g} rows more than its {len(times)} frames"
    return replace(rig, notices=(f"the file holds {rows}, which are left out",))


def _frames(body: str, width: int) -> tuple[FloatArray, FloatArray, int]:
    """Times (F,), channel values (F, C), and how many numbers stand behind those of the frames."""
    words = body.split(None, 6)
    if len(words) < 5 or words[0] != "Frames:" or words[2:4] != ["Frame", "Time:"]:
        raise expected("MOTION", "Frames: and Frame Time:", " ".join(words[:4]))
    count, step = _number(words[1]), _number(words[4])
    if count != int(count) or not 1 <= count <= MAX_POSES or not 1e-6 <= step <= 1e4:
        raise expected("MOTION", "a count of frames and a time of 1e-6 s or more", words[1])
    rest = body.split(None, 5)[5] if len(words) > 5 else ""
    frames = int(count)
    if frames * max(width, 1) > 8 * MAX_POSES:
        raise expected("MOTION", f"at most {8 * MAX_POSES} numbers", f"{frames} x {width}")
    values = numbers_in(rest, "MOTION")
    if len(values) < frames * width:
        raise expected("MOTION", f"{frames} frames of {width} numbers", f"{len(values)} numbers")
    beyond, values = len(values) - frames * width, values[: frames * width]
    return np.linspace(0.0, (frames - 1) * step, frames), values.reshape(frames, width), beyond


def _rig(tree: _Hierarchy, times: FloatArray, values: FloatArray, name: str) -> Rig:
    joints = len(tree.names)
    offsets = np.array(tree.offsets)
    wxyz = np.zeros((len(times), joints, 4))
    wxyz[..., 0] = 1.0
    places = np.repeat(offsets[None], len(times), axis=0)
    start = 0
    for joint, channels in enumerate(tree.channels):
        columns = values[:, start : start + len(channels)]
        start += len(channels)
        turn = Rotor.identity()
        for column, channel in zip(columns.T, channels, strict=True):
            if channel in POSITIONS:
                places[:, joint, POSITIONS[channel]] = column
                continue
            turn = turn @ ROTATIONS[channel](np.radians(column))
        wxyz[:, joint] = turn.as_quaternion()

    clip = RigClip.of_all_nodes(name, times, wxyz, places)
    rest = Transforms.from_parts(
        np.tile([1.0, 0.0, 0.0, 0.0], (joints, 1)), offsets, np.ones((joints, 3))
    )
    parents = np.array(tree.parents)
    return Rig(
        NodeTree(tuple(tree.names), parents, rest),
        tuple(range(joints)),
        (),
        (clip,),
        up=None,
        forward=None,
        unit_m=None,
    )


def _number(word: str) -> float:
    """A finite number. Raises FormatError: anything else."""
    try:
        value = float(word)
    except ValueError as fault:
        raise expected("HIERARCHY", "a number", word) from fault
    if not abs(value) < 1e9:
        raise expected("HIERARCHY", "a finite number up to 1e9", word)
    return value
