"""Scenes and recorded gestures: broken JSON, replayed on versors and on Euler angles."""

from __future__ import annotations

import contextlib
import copy
import json
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring import (
    SceneEditor,
    read_gestures,
    read_scene,
    scene_of,
    scene_text,
)
from motorcade.animation.authoring.scene import Scene
from motorcade.ga import Rotor
from tests.animation.authoring.made import BUSY, busy_scene, drawn_gesture
from tests.fuzz.mutations import changed_tree, mutated, one_of
from tests.fuzz.own import RefusedError, ended, refusals
from tests.fuzz.runner import Feed

__all__ = ["prepare"]

NAMES = ["table", "cup", "spoon", "ü", "a.b"]
NUMBERS = [0, 1, -1, 0.5, 1e-9, 1e8, 9.9e8, -3.2, 1e-320, 90, 180]


def prepare(folder: Path) -> Feed:
    """A scene and gestures that fit it, with faults; read, replayed, written and read again."""

    def feed(rng: np.random.Generator) -> str:
        if rng.random() < 0.5:
            scene, lines = _scene(rng), [_drag(rng) for _ in range(int(rng.integers(1, 8)))]
        else:
            scene, busy = copy.deepcopy(BUSY), busy_scene()
            lines = [drawn_gesture(rng, busy) for _ in range(int(rng.integers(1, 8)))]
        if rng.random() < 0.5:
            changed_tree(one_of([scene, lines], rng), rng)
        texts = [json.dumps(scene).encode(), b"\n".join(json.dumps(x).encode() for x in lines)]
        if rng.random() < 0.2:
            which = int(rng.integers(2))
            texts[which] = mutated(".json", texts[which], rng)
        (folder / "scene.json").write_bytes(texts[0])
        (folder / "gestures.jsonl").write_bytes(texts[1])
        return ended(lambda: _used(folder, rng.random() < 0.3))

    return feed


def _used(folder: Path, on_euler_angles: bool) -> None:
    scene = read_scene(folder / "scene.json")
    scene = scene.on_euler_angles() if on_euler_angles else scene
    editor = SceneEditor(scene)
    for gesture in read_gestures(folder / "gestures.jsonl"):
        with contextlib.suppress(RefusedError), refusals():  # what the scene does not have
            editor.do(gesture)
        _written(editor.scene)
    states = 0
    while editor.can_undo:
        editor.undo()
        states += 1
    if scene_text(editor.scene) != scene_text(scene):
        raise AssertionError(f"{states} steps do not lead back")


def _written(scene: Scene) -> None:
    for name in scene.parents:
        if not np.isfinite(scene.world_T_object(name, 1.0).coefficients).all():
            raise AssertionError(f"{name} is not finite")
    try:
        again = scene_of(json.loads(scene_text(scene)), "again")
    except ValueError as fault:
        raise AssertionError(f"what was written is refused: {fault}") from fault
    if list(again.parents.items()) != list(scene.parents.items()):
        raise AssertionError("objects were lost")


def _numbers(rng: np.random.Generator, count: int) -> list[float]:
    return [one_of(NUMBERS, rng) if rng.random() < 0.3 else rng.normal() for _ in range(count)]


def _scene(rng: np.random.Generator) -> dict[str, Any]:
    objects: list[dict[str, Any]] = []
    for name in NAMES[: int(rng.integers(1, len(NAMES) + 1))]:
        one: dict[str, Any] = {"name": name}
        if objects and rng.random() < 0.7:
            one["parent"] = one_of(objects, rng)["name"]
        for key, make in (
            ("position_m", lambda: _numbers(rng, 3)),
            ("scale", lambda: one_of([0.5, 1, 1e6, 1e-6, 3.0], rng)),
        ):
            if rng.random() < 0.6:
                one[key] = make()
        turned = one_of(["", "wxyz", "euler_deg"], rng)
        if turned == "wxyz":
            one[turned] = Rotor.random(rng, ()).as_quaternion().tolist()
        elif turned:
            one[turned] = _numbers(rng, 3)
        objects.append(one)
    return {"objects": objects}


def _drag(rng: np.random.Generator) -> dict[str, Any]:
    kind = one_of(["rotate", "rotate", "translate", "translate", "scale", "undo", "redo"], rng)
    if kind in ("undo", "redo"):
        return {"do": kind}
    amounts = {"rotate": "amounts_rad", "translate": "amounts_m", "scale": "factors"}[kind]
    made = {
        "object": one_of(NAMES[: 1 + int(rng.integers(5))], rng),
        "do": kind,
        amounts: _numbers(rng, 3),
    }
    if kind == "scale":
        made[amounts] = [abs(x) + 0.1 for x in made[amounts]]
    if rng.random() < 0.7:
        made["axis"] = one_of([[0, 0, 1], [1, 0, 0], [1, 1, 0], _numbers(rng, 3)], rng)
    if rng.random() < 0.5:
        made["frame"] = one_of(["local", "global", "parent"], rng)
    return made
