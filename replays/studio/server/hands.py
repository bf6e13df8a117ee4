"""Who holds what: an object is moved by one browser at a time, with all that hangs on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from motorcade.animation.authoring import Scene


@dataclass
class Hands:
    """What the visitors of a scene hold in their hands.

    >>> from motorcade.animation.authoring import Scene, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> from motorcade.replays.studio.server.hands import Hands
    >>> still = VersorObjectPose(Similarity.identity())
    >>> scene = Scene({"table": None, "cup": "table"}, {"table": still, "cup": still})
    >>> hands = Hands()
    >>> hands.take(1, "cup", scene)
    >>> hands.take(2, "table", scene)
    Traceback (most recent call last):
    ValueError: Somebody else is moving cup.
    """

    held: dict[int, str] = field(default_factory=dict)

    def take(self, visitor: int, name: str, scene: Scene) -> None:
        """Take hold of an object.

        Raises:
            ValueError: no such object, or another holds it, what it hangs on or what hangs on it.
        """
        self.require_free(visitor, name, scene)
        self.held[visitor] = name

    def require_free(self, visitor: int, name: str, scene: Scene) -> None:
        """Refuse what another visitor's gesture is about; raises as `take`."""
        scene.pose(name)
        for other, held in self.held.items():
            if other != visitor and (above(scene, name, held) or above(scene, held, name)):
                raise ValueError(f"Somebody else is moving {held}.")

    def require_all_free(self, visitor: int) -> None:
        """Refuse what concerns the whole scene while another visitor moves something.

        Raises:
            ValueError: somebody does.
        """
        for other, held in self.held.items():
            if other != visitor:
                raise ValueError(f"Somebody else is moving {held}.")

    def let_go(self, visitor: int) -> None:
        """Hold nothing any more."""
        self.held.pop(visitor, None)


def above(scene: Scene, name: str, other: str) -> bool:
    """Whether an object is another, or hangs on it."""
    parents: Mapping[str, str | None] = scene.parents
    at: str | None = name
    while at is not None and at != other:
        at = parents.get(at)
    return at is not None
