"""Props that tests set into scenes, made of numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.animation import Character, Skeleton, write_gltf
from motorcade.ga import Motor


def box(size_m: float = 0.2, shade: float = 0.1) -> Character:
    """A cube on z = 0, its sides' normals at its corners."""
    corner = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij")).reshape(3, -1).T
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Character(
        Skeleton(("box",), np.array([-1]), Motor.identity((1,))),
        0.5 * size_m * (corner + np.array([0.0, 0.0, 1.0])),
        corner / np.sqrt(3.0),
        np.array(triangles),
        np.full((8, 3), shade),
        np.zeros((8, 4), dtype=int),
        np.tile([1.0, 0.0, 0.0, 0.0], (8, 1)),
    )


def ball(radius_m: float = 0.1, rings: int = 12) -> Character:
    """A globe on z = 0, with a stripe by which its turn is told."""
    polar = np.linspace(0.0, np.pi, rings + 1)
    around = np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)
    at, to = np.meshgrid(polar, around, indexing="ij")
    unit = np.stack([np.sin(at) * np.cos(to), np.sin(at) * np.sin(to), np.cos(at)], axis=-1)
    normals, wide = unit.reshape(-1, 3), 2 * rings + 1
    quads = [(i * wide + j, (i + 1) * wide + j) for i in range(rings) for j in range(2 * rings)]
    triangles = [t for a, b in quads for t in ((a, b, b + 1), (a, b + 1, a + 1))]
    striped = np.abs(normals[:, :1]) < 0.25
    return Character(
        Skeleton(("ball",), np.array([-1]), Motor.identity((1,))),
        radius_m * (normals + np.array([0.0, 0.0, 1.0])),
        normals,
        np.array(triangles),
        np.where(striped, [0.95, 0.95, 0.9], [0.8, 0.15, 0.1]),
        np.zeros((len(normals), 4), dtype=int),
        np.tile([1.0, 0.0, 0.0, 0.0], (len(normals), 1)),
    )


def write_props(folder: Path) -> None:
    """A cube of 0.2 m and a ball of as much as `box.glb` and `ball.glb`."""
    write_gltf(folder / "box.glb", box(shade=0.55))
    write_gltf(folder / "ball.glb", ball())
