"""Recorded gestures replayed on a scene, by rotors and by Euler angles side by side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.animation.authoring import (
    Scene,
    SceneEditor,
    Snapping,
    read_gestures,
    read_scene,
    replay,
)


@dataclass(frozen=True, eq=False)
class Authored:
    """A scene after gestures.

    Fields:
        scene: by the writing that was asked for.
        gestures: how many were replayed.
        apart: by object, how far the other writing of rotations ends from it: degrees and metres
            in the world.
    """

    scene: Scene
    gestures: int
    apart: dict[str, tuple[float, float]]

    def as_json(self) -> dict[str, Any]:
        """A JSON-ready tree, units in the keys."""
        differences = {
            name: {"rotation_deg": degrees, "position_m": metres}
            for name, (degrees, metres) in self.apart.items()
        }
        return {
            "gestures": self.gestures,
            "scene": self.scene.as_json(),
            "rotors_against_euler": differences,
        }


def author(
    scene: Path,
    gestures: Path,
    rotations: Literal["rotor", "euler"] = "rotor",
    snapping: Snapping | None = None,
) -> Authored:
    """Replay gestures on a scene.

    Raises ValueError: a file that cannot be read, a gesture that the scene refuses.
    """
    start, recorded = read_scene(scene), read_gestures(gestures)
    ends = {
        "rotor": replay(SceneEditor(start, snapping), recorded),
        "euler": replay(SceneEditor(start.on_euler_angles(), snapping), recorded),
    }
    apart = {}
    for name in ends[rotations].parents:  # what gestures added too
        first, other = (end.world_T_object(name) for end in ends.values())
        angle = float((first.rotor.inverse() @ other.rotor).angle())
        shift = float(np.linalg.norm(first.translation_m - other.translation_m))
        apart[name] = (float(np.degrees(angle)), shift)
    return Authored(ends[rotations], len(recorded), apart)
