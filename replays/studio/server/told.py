"""What a page is told of a scene: its objects, where each is over the footage, what it does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from motorcade.animation.authoring import Scene
from motorcade.animation.authoring.fields import layer_json
from motorcade.replays.studio.look.packing import packed
from motorcade.replays.studio.server.filmed import Filmed, spoken
from motorcade.replays.studio.server.played import PlayedScene, rows
from motorcade.replays.studio.server.posing import joints_held_by
from motorcade.replays.studio.server.props import Props

MOST_POINTS = 400
"""Of the line that shows a way."""


@dataclass(frozen=True)
class ToldScene:
    """Objects as JSON for `editor.js`.

    Args:
        filmed: the footage.
        played: what objects do over it.
        props: what there is to choose from.
    """

    filmed: Filmed
    played: PlayedScene
    props: Props

    def about(self, scene: Scene, name: str, before: Scene | None) -> dict[str, Any]:
        """An object; where it stands is left out for one that stands as it did before.

        Raises:
            ValueError: a file, clip, joint or anchor that is not there.
        """
        part, parent = scene.part(name), scene.parents[name]
        about: dict[str, Any] = {
            "name": name,
            "kind": part.kind,
            "parent": parent,
            "on": self._label(scene, parent),
            "figure": None,
            "motion": None,
            "clip": part.clip,
            "clips": self.props.clips(part),
            "walk": part.walk is not None,
            "turns": [[one.time_s, one.end_s] for one in part.joint_keyframes],
            "layers": [layer_json(one) for one in part.layers],
            "keys": [one.time_s for one in part.keyframes],
            "interpolation": part.interpolation,
            "visible_s": None if part.visible_s is None else list(part.visible_s),
        }
        if part.kind != "group":
            number, one = self.played.acted(scene, name)
            about |= {"motion": number, "figure": self.played.figure(one)}
            if part.kind == "character":
                about["held_by"] = {
                    body: [number, one.character.skeleton.names[number]]
                    for body, number in joints_held_by(one.character.skeleton).items()
                }
        if before is None or not self.played.stands_alike(before, scene, name):
            track = self.played.world_T_object(scene, name)
            about["track"] = packed(rows(track), "f64")
            about["ground"] = packed(rows(self.played.world_T_parent(scene, name)), "f64")
            way = track.translation_m
            moves = len(way) > 1
            about["way"] = packed(way[:: -(-len(way) // MOST_POINTS)]) if moves else None
        return about

    def _label(self, scene: Scene, parent: str | None) -> str:
        if parent is None:
            return "the world"
        anchor = scene.anchors.get(parent)
        return parent if anchor is None else spoken(anchor).lower()
