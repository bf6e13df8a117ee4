"""Scenes and gestures drawn at random, for tests of the editor."""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.animation.authoring import Scene, scene_of
from motorcade.ga import Rotor, Similarity

BUSY: dict[str, Any] = {
    "anchors": {"table": {"on": "board"}, "box": {"on": "marker", "marker": 7}},
    "objects": [
        {"name": "frame", "parent": "table", "position_m": [0.1, 0, 0], "scale": 2.0},
        {"name": "guide", "kind": "character", "file": "mannequin", "parent": "frame",
         "euler_deg": [10, 20, 30], "clip": "idle"},
        {"name": "walker", "kind": "character", "file": "mannequin", "parent": "table",
         "walk": {"path_m": [[0, 0], [0.3, 0.1], [0.3, 0.5]]}},
        {"name": "bird", "kind": "prop", "file": "bird.glb", "parent": "box", "keyframes": [
            {"time_s": 0.5, "position_m": [0, 0, 1], "wxyz": [1, 0, 0, 0]},
            {"time_s": 2.0, "position_m": [1, 0, 1], "euler_deg": [0, 89.9, 120], "scale": 1.5}]},
        {"name": "cup", "kind": "prop", "file": "cup.glb", "parent": "guide"},
    ],
}  # fmt: skip


def busy_scene() -> Scene:
    """Anchors, a group, a walk, keyframes."""
    return scene_of(BUSY, "busy")


def drawn_gesture(rng: np.random.Generator, scene: Scene) -> dict[str, Any]:
    """A line that fits the scene, most of the time."""
    if rng.random() < 0.7 and scene.parents:
        return drawn_drag(rng, scene)
    return drawn_edit(rng, scene)


def drawn_drag(rng: np.random.Generator, scene: Scene) -> dict[str, Any]:
    name = str(rng.choice(list(scene.parents)))
    kind = str(rng.choice(["rotate", "translate", "scale", "similarity"]))
    key, made = {
        "rotate": ("amounts_rad", lambda: rng.normal(0, 2)),
        "translate": ("amounts_m", lambda: rng.normal(0, 0.3)),
        "scale": ("factors", lambda: float(np.exp(rng.normal(0, 0.1)))),
        "similarity": (
            "similarities",
            lambda: Similarity.random(rng, (), 0.2, 0.1).coefficients.tolist(),
        ),
    }[kind]
    line: dict[str, Any] = {
        "object": name,
        "do": kind,
        "frame": str(rng.choice(["local", "parent", "global"])),
        key: [made() for _ in range(int(rng.integers(1, 4)))],
    }
    if kind in ("rotate", "translate"):
        line["axis"] = rng.normal(size=3).tolist()
    if scene.part(name).keyframes or rng.random() < 0.3:
        line["time_s"] = float(rng.choice([0.5, 1.0, 2.0, rng.uniform(0, 3)]))
    return line


def drawn_edit(rng: np.random.Generator, scene: Scene) -> dict[str, Any]:
    names = list(scene.parents) or ["nobody"]
    name, other = (str(rng.choice(names)) for _ in range(2))
    new, time_s = f"new {rng.integers(1000)}", float(rng.uniform(0, 3))
    when = float(rng.choice([1.0, time_s]))
    turn = Rotor.random(rng, ()).as_quaternion().tolist()
    parents = [None, *scene.anchors, *names]
    return [
        {"do": "add", "object": {"name": new, "kind": "prop", "file": "a.glb", "wxyz": turn}},
        {"do": "remove", "object": name} if len(names) > 6 else {"do": "undo"},
        {"do": "copy", "object": name, "name": new} if len(names) < 30 else {"do": "redo"},
        {"do": "rename", "object": name, "name": new},
        {"do": "group", "objects": list({name, other}), "name": new},
        {"do": "ungroup", "object": name},
        {"do": "reparent", "object": name, "parent": parents[int(rng.integers(len(parents)))]},
        {"do": "set", "object": name, "visible": [0, 1 + time_s], "time_s": time_s},
        {"do": "set", "object": name, "position_m": [0.1, 0.2, time_s], "time_s": time_s},
        {"do": "keyframe", "object": name, "time_s": time_s, "wxyz": turn},
        {"do": "remove_keyframe", "object": name, "time_s": 0.5},
        {"do": "move_keyframe", "object": name, "time_s": 2.0, "to_s": time_s},
        {"do": "joints", "object": name, "time_s": when, "joints": {"left_hand": turn}},
        {"do": "move_joints", "object": name, "time_s": 1.0, "to_s": time_s},
        {"do": "end_joints", "object": name, "time_s": 1.0, "end_s": 1.5 + time_s},
        {"do": "remove_joints", "object": name, "time_s": 1.0},
        {"do": "layer", "object": name, "layer": {"clip": "wave", "weight": time_s / 3}},
        {"do": "layer", "object": name, "number": int(rng.integers(3)), "layer": None},
        {"do": "anchor", "name": "floor", "on": "floor", "floor_m": time_s},
        {"do": "remove_anchor", "name": "floor"},
        {"do": "together", "gestures": [drawn_drag(rng, scene) for _ in range(2)]}
        if scene.parents
        else {"do": "undo"},
        {"do": "anchors", "world_T_anchor": {
            "table": Similarity.random(rng, (), 1.0, 0.0).coefficients.tolist()}},
        {"do": "undo"},
        {"do": "redo"},
    ][int(rng.integers(24))]  # fmt: skip
