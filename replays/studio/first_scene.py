"""The scene in which an editor opens a run: those that the run itself put into its footage.

A run's scene is taken as it is. A character or a cast becomes objects on the run's own ground. Of a
cast that is not all: who turned to somebody at the goal, looked at the camera or made room for
another does not in a scene, which has no words for it.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from os.path import relpath
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.authoring import Scene, read_scene, scene_of
from motorcade.animation.authoring.fields import anchor_json
from motorcade.ga import Motor
from motorcade.replays.io.readers.manifest.cast import (
    MANNEQUIN,
    NOBODY,
    Cast,
    CastMember,
    file_of,
    read_cast,
)
from motorcade.replays.stages.characters.acted import cast_as
from motorcade.replays.stages.characters.acting import IDLE, character_named
from motorcade.replays.stages.values.view import PlacedCharacter, PlayedPart
from motorcade.replays.studio.filmed import Filmed
from motorcade.replays.studio.props import GROUND

log = logging.getLogger("motorcade.studio")


def first_scene(filmed: Filmed, folder: Path) -> Scene:
    """Those of a run as objects of a scene, or none beside its ground where it put nobody there.

    Args:
        filmed: the run.
        folder: of the scene's file, which names others from there.

    Raises:
        ValueError: a file of the run that cannot be read any more.
    """
    placed, knobs = filmed.placed, filmed.knobs
    if placed is not None and str(knobs.get("scene", NOBODY)) != NOBODY:
        return _named_from(Path(knobs["scene"]), folder)
    ground, objects = {GROUND: anchor_json(filmed.first)}, []
    for entry in [] if placed is None else _entries(filmed, placed):
        file = entry["file"]
        own = file if file == MANNEQUIN else relpath(file, folder.absolute())
        try:
            scene = scene_of({"anchors": ground, "objects": [{**entry, "file": own}]}, "run")
            cast_as(scene, entry["name"], folder)
        except (ValueError, OSError) as fault:
            log.warning("%s is not in the first scene: %s", entry["name"], fault)
            continue
        objects.append({**entry, "file": own})
    return scene_of({"anchors": ground, "objects": objects}, "run")


def _named_from(path: Path, folder: Path) -> Scene:
    """A scene with its files named from another folder."""
    scene, old = read_scene(path), path.absolute().parent
    parts = {
        name: part
        if part.file in ("", MANNEQUIN)
        else replace(part, file=relpath(file_of(part, old), folder.absolute()))
        for name, part in scene.parts.items()
    }
    return replace(scene, parts=parts)


def _entries(filmed: Filmed, placed: PlacedCharacter) -> list[dict[str, Any]]:
    """Entries of a scene file, their files by whole names."""
    if str(filmed.knobs.get("cast", NOBODY)) != NOBODY:
        cast: Cast = read_cast(Path(filmed.knobs["cast"]))
        parts = {part.name: part for part in placed.parts}
        known = [member for member in cast.members if member.name in parts]
        plane = filmed.ground(filmed.first).world_T_plane
        return [_of_cast(member, parts[member.name], plane) for member in known]
    entry = _standing(placed.character, placed.plane_T_character, filmed.height_m)
    if placed.clip != IDLE and not len(placed.path_m):
        entry["clip"] = placed.clip
    if len(placed.path_m):
        entry["walk"] = {"path_m": placed.path_m.tolist(), "gaits": [placed.clip]}
    if placed.up or placed.front or placed.hide:
        log.warning("the first scene has no words for placed.up, front and hide: %s", entry["file"])
        return []
    return [{"name": "character", **entry}]


def _standing(character: str, plane_T_character: Motor, height_m: float) -> dict[str, Any]:
    heading_rad = float(plane_T_character.rotor.as_euler()[2])
    return {
        "kind": "character",
        "file": character if character == MANNEQUIN else str(Path(character).absolute()),
        "parent": GROUND,
        "height_m": height_m,
        "position_m": plane_T_character.translation_m.tolist(),
        "euler_deg": [0.0, 0.0, float(np.degrees(heading_rad))],
    }


def _of_cast(member: CastMember, part: PlayedPart, plane: Motor) -> dict[str, Any]:
    """One of a cast: walks as it walked, and layers at the times of its acts."""
    own = character_named(part.character, part.up, part.front).height_m
    plane_T_character: Motor = plane.inverse() @ part.placement.world_T_character
    entry = _standing(member.file, plane_T_character, part.placement.scale * own)
    entry |= {"name": member.name, "clip": member.idle}
    x, y = member.path_m[0].tolist()
    entry["position_m"] = [x, y, 0.0]
    if len(member.path_m) > 1:
        starts_s = [state.start_s for state in part.states if state.state == "walk"]
        entry["walk"] = {
            "path_m": member.path_m.tolist(),
            "start_s": min(starts_s, default=member.waits_s),
            "gaits": list(member.gaits),
            **({} if member.speed_m_s is None else {"speed_m_s": member.speed_m_s}),
        }
    entry["layers"] = _layers(member, part)
    return entry


def _layers(member: CastMember, part: PlayedPart) -> list[Mapping[str, Any]]:
    """What it did at its goal, and what it did meanwhile, at the times at which it did."""
    layers: list[Mapping[str, Any]] = []
    for state in part.states:
        span = {"start_s": state.start_s, "end_s": state.end_s}
        if not state.end_s > state.start_s:
            continue
        if state.state == "act":
            layers.append({"clip": state.clip, "joints": "whole", **span})
        layers += [
            {
                "clip": layer.clip,
                "joints": layer.joints,
                "weight": layer.weight,
                "additive": layer.additive,
                **span,
            }
            for layer in member.layers
            if layer.during == state.state
        ]
    return layers
