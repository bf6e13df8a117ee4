"""The history of a scene: steps that hold what they changed, not whole scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from motorcade.animation.authoring.scene import Scene

_FIELDS = ("parents", "poses", "parts", "anchors")


@dataclass(frozen=True, eq=False)
class SceneStep:
    """What lies between two scenes: by field, entries by name, or all of it where order changed."""

    entries: Mapping[str, Mapping[str, tuple[Any, Any]]]
    whole: Mapping[str, tuple[Mapping[str, Any], Mapping[str, Any]]]

    @classmethod
    def between(cls, before: Scene, after: Scene) -> SceneStep | None:
        """The step from one scene to another; None where a scene file of both is the same."""
        entries, whole = {}, {}
        for field in _FIELDS:
            old, new = getattr(before, field), getattr(after, field)
            if old is new:
                continue
            if len(old) != len(new) or list(old) != list(new):
                whole[field] = (old, new)
                continue
            other = {name: (old[name], one) for name, one in new.items() if one is not old[name]}
            if other:
                entries[field] = other
        names = {name for field in entries.values() for name in field}
        if not whole and all(_alike(before, after, name) for name in names):
            return None
        return cls(entries, whole)

    def taken(self, scene: Scene, back: bool) -> Scene:
        """The scene on the other side of the step."""
        side = 0 if back else 1
        fields = {field: pair[side] for field, pair in self.whole.items()}
        for field, entries in self.entries.items():
            own = {name: pair[side] for name, pair in entries.items()}
            fields[field] = {**getattr(scene, field), **own}
        return scene.but(**fields)


def _alike(before: Scene, after: Scene, name: str) -> bool:
    if name in before.anchors:
        return before.anchors[name] == after.anchors[name]
    return before.object_json(name) == after.object_json(name)
