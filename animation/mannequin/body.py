"""Assembles the mannequin's parts into one skinned mesh in the rest pose.

Convention of the mesh: character space (z up, facing +x, soles at z = 0), metres, triangles
counter-clockwise seen from outside, vertex colours sRGB 0 to 1, four joint influences a vertex.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motorcade.animation.mannequin.lofts import loft, vertex_normals
from motorcade.animation.mannequin.parts import TONES, Part, all_parts, sweep_axes
from motorcade.ga.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Body:
    """A skinned mesh before it meets its skeleton; shapes as in `Character`."""

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    colors: FloatArray
    joints: IntArray
    weights: FloatArray


def build_body(world_T_joint: Mapping[str, FloatArray], index: Mapping[str, int]) -> Body:
    """Sweep every part and set it into the rest pose.

    Args:
        world_T_joint: (4, 4) rest pose of every joint by name.
        index: the number of every joint by name.

    Returns:
        The whole mesh; parts are closed surfaces of their own that overlap at the joints.
    """
    pieces = [_piece(part, world_T_joint[part.frame], index) for part in all_parts()]
    offsets = np.cumsum([0] + [len(piece.vertices) for piece in pieces])[:-1]
    triangles = [piece.triangles + k for piece, k in zip(pieces, offsets, strict=True)]
    return Body(
        np.concatenate([piece.vertices for piece in pieces]),
        np.concatenate([piece.normals for piece in pieces]),
        np.concatenate(triangles),
        np.concatenate([piece.colors for piece in pieces]),
        np.concatenate([piece.joints for piece in pieces]),
        np.concatenate([piece.weights for piece in pieces]),
    )


def _piece(part: Part, world_T_frame: FloatArray, index: Mapping[str, int]) -> Body:
    """One part in character space."""
    swept, triangles, station = loft(part.shape, part.sides, part.rings, part.cap_rings)
    turn = world_T_frame[:3, :3] @ sweep_axes(part.sweep)
    vertices = swept @ turn.T + world_T_frame[:3, 3]
    if part.ground:
        vertices[:, 2] = np.maximum(vertices[:, 2], 0.0)
    joints, weights = _influences(part, station, index)
    return Body(
        vertices,
        vertex_normals(vertices, triangles),
        triangles,
        np.tile(TONES[part.tone], (len(vertices), 1)),
        joints,
        weights,
    )


def _influences(
    part: Part, station: FloatArray, index: Mapping[str, int]
) -> tuple[IntArray, FloatArray]:
    """Joint numbers and weights (V, 4) along the sweep, handed over by smoothsteps."""
    joints = np.zeros((len(station), 4), dtype=np.int64)
    weights = np.zeros((len(station), 4))
    passed = [_smoothstep((station - at) / half) for at, half in part.changes_m]
    share = np.ones_like(station)
    for k, name in enumerate(part.joints):
        beyond = passed[k] if k < len(passed) else np.zeros_like(station)
        joints[:, k] = index[name]
        weights[:, k] = share * (1.0 - beyond)
        share = share * beyond
    return joints, weights


def _smoothstep(x: FloatArray) -> FloatArray:
    """0 below −1, 1 above +1, and a cubic with level ends between."""
    u = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))
