"""Edits: what is done to a scene besides drags, each as the line of JSON that a file of gestures
holds of it.

==================  ============================================================================
``do``              and its keys; those in brackets may be left out
==================  ============================================================================
``add``             ``object``: an entry as in a scene file
``remove``          ``object``: with all that hang on it
``copy``            ``object``, ``name``: with all that hang on it, in the same place
``rename``          ``object``, ``name``
``group``           ``objects``, ``name``, (``time_s``): a new frame amid them, in the first one's
                    parent
``ungroup``         ``object``, (``time_s``): what hangs on a group goes to the group's parent
``reparent``        ``object``, ``parent`` or null, (``time_s``): it stays where it is in the world
``set``             ``object``, (``time_s``), and any of an object's keys in a scene file
``keyframe``        ``object``, ``time_s``, and any of ``position_m``, ``wxyz``, ``euler_deg``,
                    ``scale``; the others are what they are at that time
``move_keyframe``   ``object``, ``time_s``, ``to_s``
``remove_keyframe`` ``object``, ``time_s``; after the last one it stays where that was
``joints``          ``object``, ``time_s``, ``joints``: ``wxyz`` by name, null to let one go
``move_joints``     ``object``, ``time_s``, ``to_s``: a pose of joints, its end with it
``end_joints``      ``object``, ``time_s``, ``end_s``: until when a pose is held, null for ever
``remove_joints``   ``object``, ``time_s``
``layer``           ``object``, (``number``), ``layer``: one as in a scene file, null to take it
                    away; without a number a new one on top
``anchor``          ``name``, ``on``, (``marker``, ``floor_m``): a new one, or another than it was
``remove_anchor``   ``name``, on which nothing hangs
==================  ============================================================================
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from motorcade.animation.authoring.editing import keyed, posed, trees
from motorcade.animation.authoring.fields import parsed_json, short, table
from motorcade.animation.authoring.scene import Scene
from motorcade.ga import Similarity

Anchors = Mapping[str, Similarity]
Change = Callable[[Scene, Anchors], Scene]
_KINDS: dict[str, tuple[tuple[str, ...], Callable[[Mapping[str, Any]], Change]]] = {
    "add": (("object",), trees.added),
    "remove": (("object",), trees.removed),
    "copy": (("object", "name"), trees.copied),
    "rename": (("object", "name"), trees.renamed),
    "group": (("objects", "name", "time_s"), trees.grouped),
    "ungroup": (("object", "time_s"), trees.ungrouped),
    "reparent": (("object", "parent", "time_s"), trees.reparented),
    "set": (("object", "time_s", *keyed.FIELDS), keyed.fields_set),
    "keyframe": (("object", "time_s", *keyed.POSE_KEYS), keyed.keyframe_set),
    "move_keyframe": (("object", "time_s", "to_s"), keyed.keyframe_moved),
    "remove_keyframe": (("object", "time_s"), keyed.keyframe_removed),
    "joints": (("object", "time_s", "joints"), posed.joints_set),
    "move_joints": (("object", "time_s", "to_s"), posed.joints_moved),
    "end_joints": (("object", "time_s", "end_s"), posed.joints_ended),
    "remove_joints": (("object", "time_s"), posed.joints_removed),
    "layer": (("object", "number", "layer"), posed.layer_set),
    "anchor": (("name", "on", "marker", "floor_m"), trees.anchor_set),
    "remove_anchor": (("name",), trees.anchor_removed),
}
EDITS = tuple(_KINDS)


@dataclass(frozen=True, eq=False)
class Edit:
    """A change of a scene that is no drag.

    Args:
        line: as the module lists them.

    Raises:
        ValueError: a line that is no edit; the message names the key.

    >>> from motorcade.animation.authoring import Edit, Scene, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> scene = Scene({"cup": None}, {"cup": VersorObjectPose(Similarity.identity())})
    >>> two = Edit({"do": "copy", "object": "cup", "name": "mug"}).applied(scene)
    >>> list(two.parents)
    ['cup', 'mug']
    >>> Edit({"do": "rename", "object": "cup", "name": "mug"}).applied(two)
    Traceback (most recent call last):
    ValueError: name: expected one that nothing else has, got 'mug'
    """

    line: Mapping[str, Any]
    _change: Change = field(init=False, repr=False)

    def __post_init__(self) -> None:
        own = self.line
        kind = own.get("do") if isinstance(own, Mapping) else None
        if not isinstance(kind, str) or kind not in _KINDS:
            raise ValueError(f"do: expected one of {', '.join(_KINDS)}, got {short(kind)}")
        keys, made = _KINDS[kind]
        try:
            own = parsed_json(json.dumps(dict(own)), kind)
        except (TypeError, RecursionError) as fault:
            raise ValueError(f"{kind}: expected what JSON holds, got {short(fault)}") from fault
        table(own, kind, ("do", *keys))
        object.__setattr__(self, "line", own)
        object.__setattr__(self, "_change", made(own))

    def applied(self, scene: Scene, world_T_anchor: Anchors = trees.NOWHERE) -> Scene:
        """The scene after it.

        Args:
            scene: which is changed.
            world_T_anchor: where anchors stand now; see `Scene.world_T_parent`.

        Raises:
            ValueError: what the scene does not have, or may not have.
        """
        return self._change(scene, world_T_anchor)

    def as_json(self) -> dict[str, Any]:
        """Its line."""
        return dict(self.line)
