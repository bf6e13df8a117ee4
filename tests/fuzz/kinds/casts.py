"""Casts: TOML of characters, right or wrong, read, and now and then acted by the mannequin.

Keys come from the reader's own lists, so that a new one is fed too.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.behaviour import LookTarget
from motorcade.ga import Motor
from motorcade.replays.io.readers.manifest import cast
from motorcade.replays.stages.view.acting import check_cast, played
from tests.fuzz.hostile import write_hostile
from tests.fuzz.kinds.manifests import toml
from tests.fuzz.mutations import mutated, one_of
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed

__all__ = ["KEYS", "RIGHT", "prepare"]

KEYS = {"": cast._TOP, "characters": cast._CHARACTER, "layers": cast._LAYER}
RIGHT: dict[str, list[Any]] = {
    "gap_m": [0.0, 0.02, 1e4],
    "name": ["guide", "ü", "<script>", "a" * 100],
    "file": ["mannequin"],
    "up": ["z", "-y"],
    "front": ["x", "-z"],
    "motions": [[], ["salute.bvh"]],
    "height_m": [0.1, 1.75, 1e-6],
    "start": [[0.0, 0.0], [3.0, -1.0], [9e3, 9e3]],
    "path": [[[0.0, 0.0], [0.3, 0.0]], [[0, 0], [1, 1], [0, 1], [0, 0]], [[0, 0], [1e-5, 0]]],
    "heading_deg": [0, -360.0, 90],
    "facing_deg": [0, 360.0, -45.5],
    "look_at": ["camera", [1.0, 0.0, 0.5], [0, 0, 0], [-1e4, 0, 1e4]],
    "gaits": [["walk"], ["walk", "jog"], ["run", "run"], []],
    "speed_m_s": [1.4, 2.0, 1e-6, 9.0],
    "idle": ["idle", "walk", "wave"],
    "acts": [[], ["wave"], ["turn", "wave"], ["salute"]],
    "waits_s": [0.0, 0.5, 600],
    "clip": ["wave", "idle", "none"],
    "joints": list(cast.MASKS),
    "during": list(cast.LASTING),
    "weight": [0.0, 0.5, 1],
    "additive": [True, False],
}
WRONG: list[Any] = [
    -1, 2**63, 10**400, 1e308, float("nan"), float("inf"), True, "", "x" * 5000, "a\nb", [], [[]],
    [1.0] * 200, [[1e300, 0.0]] * 3, {}, {"a": 1}, [float("nan")] * 3, "\u202e",
]  # fmt: skip
BVH = """HIERARCHY
ROOT Hips
{ OFFSET 0 1 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Head { OFFSET 0 0.5 0 CHANNELS 3 Zrotation Xrotation Yrotation
    End Site { OFFSET 0 0.2 0 } } }
MOTION
Frames: 2
Frame Time: 0.1
0 1 0 0 0 0 0 0 0
0 1 0 0 0 0 0 9 0
"""
# Of those that can be acted: what is acted takes most of the time.
ACTED, CHECKED = 0.05, 0.4


def prepare(folder: Path) -> Feed:
    """A cast with up to three faults; read, checked, and acted."""
    (folder / "salute.bvh").write_text(BVH)
    names = ("salute.bvh", *write_hostile(folder))
    camera = LookTarget(np.array([0.0, 1.0]), np.array([[0.0, -1.0, 0.5], [0.5, -1.0, 0.5]]))

    def feed(rng: np.random.Generator) -> str:
        text = _cast(rng, names)
        (folder / "cast.toml").write_bytes(text)
        return ended(lambda: _used(folder / "cast.toml", rng))

    def _used(file: Path, rng: np.random.Generator) -> None:
        asked = cast.read_cast(file)
        if rng.random() < CHECKED:
            check_cast(asked)
        if rng.random() < ACTED and len(asked.members) < 3:
            parts, apart_m = played(asked, Motor.identity(), 0.2, camera, 1.0)
            if np.isnan(apart_m) or not all(
                np.isfinite(one.poses.coefficients).all() for one in parts
            ):
                raise AssertionError("not finite")

    return feed


def _cast(rng: np.random.Generator, names: tuple[str, ...]) -> bytes:
    count = int(rng.choice([1, 1, 2, 3, 9]))
    members = [
        _table(rng, "characters", ("path" if rng.random() < 0.4 else "start",))
        for _ in range(count)
    ]
    for number, member in enumerate(members):
        for key in ("start", "path"):
            if key in member and rng.random() < 0.9:
                shift = [5.0 * number, 0.0]
                member[key] = (np.array(member[key], dtype=float) + shift).tolist()
        if rng.random() < 0.8:
            member["name"] = f"{number}"
        if rng.random() < 0.2:
            member["layers"] = [
                _table(rng, "layers", ("clip",)) for _ in range(int(rng.integers(3)))
            ]
    top: dict[str, Any] = {"gap_m": 0.0} if rng.random() < 0.3 else {}
    for _ in range(int(rng.choice(4, p=[0.4, 0.3, 0.2, 0.1]))):
        listed = (one.get("layers") for one in members)
        layers = [x for one in listed if isinstance(one, list) for x in one if isinstance(x, dict)]
        _spoil(rng, one_of([top, *members, *layers], rng), names)
    lines = [f"{key} = {toml(value)}" for key, value in top.items()]
    for member in members:
        lines += ["[[characters]]", *(f"{json.dumps(k)} = {toml(v)}" for k, v in member.items())]
    text = "\n".join(lines).encode("utf-8", "surrogatepass")
    return mutated(".toml", text, rng) if rng.random() < 0.1 else text


def _table(rng: np.random.Generator, title: str, needed: tuple[str, ...]) -> dict[str, Any]:
    """The keys that are needed, and some that may be."""
    others = [k for k in KEYS[title] if k in RIGHT and k not in ("start", "path", "name")]
    wanted = (*needed, *(k for k in others if rng.random() < 0.2))
    return {key: one_of(RIGHT[key], rng) for key in dict.fromkeys(wanted)}


def _spoil(rng: np.random.Generator, table: dict[str, Any], names: tuple[str, ...]) -> None:
    key = one_of([*table, *RIGHT, "layers", "nothing"], rng)
    kind = rng.random()
    if kind < 0.2:
        table.pop(key, None)
    elif kind < 0.6 or key not in RIGHT:
        table[key] = one_of(WRONG, rng)
    else:
        table[key] = one_of([one_of(names, rng), [one_of(names, rng)]], rng)
