"""Weights of the figure's skin: heat that flows from the bones over the surface.

Every vertex takes heat from the bone that it lies on, the more the closer that is, and passes heat
on to its neighbours; a joint's weight is the temperature where its bones alone are hot. Thick limbs
so get wide transitions and fingers narrow ones. The bone a vertex lies on is the nearest by the
bone's own thickness, so that the flank beside an arm belongs to the chest.
Source: Baran and Popović, "Automatic rigging and animation of 3D characters" (2007), section 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from docs.making.figure.shape.surface import SymmetricMesh
from motorcade.animation.easing import smoothstep
from motorcade.animation.skeleton import Skeleton
from motorcade.ga.arrays import FloatArray, IntArray

# How sharply weights fall off across a joint; 1 in the source.
SHARPNESS = 1.6
HEAD_FROM_M, HEAD_OVER_M = 1.215, 0.115
FINGERS = ("thumb", "index", "middle", "little")


@dataclass(frozen=True)
class Bone:
    """A part of the body that moves with a joint: start and end (3,) m, thickness m."""

    joint: str
    start_m: FloatArray
    end_m: FloatArray
    radius_m: float


def influences(mesh: SymmetricMesh, skeleton: Skeleton) -> tuple[IntArray, FloatArray]:
    """Joint numbers and weights (V, 4) of a mesh in the rest pose.

    Weights beyond the fourth are not cut off: the fifth is taken from all, which keeps them
    continuous along the surface.
    """
    warm = _temperatures(mesh, _bones(skeleton), skeleton)
    order = np.argsort(-warm, axis=1, kind="stable")[:, :5]
    largest = np.take_along_axis(warm, order, axis=1)
    kept = np.maximum(largest[:, :4] - largest[:, 4:], 0.0)
    weights = kept / kept.sum(axis=1, keepdims=True)
    return np.where(weights > 0.0, order[:, :4], order[:, :1]), weights


def _temperatures(mesh: SymmetricMesh, bones: Sequence[Bone], skeleton: Skeleton) -> FloatArray:
    """Temperatures (V, J) in balance, one column for each joint; rows sum to 1."""
    from scipy.sparse import coo_matrix, diags
    from scipy.sparse.linalg import splu

    count, edges = len(mesh.vertices), mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    distance, nearest = _nearest(mesh.vertices, bones)
    length = np.sum((mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]]) ** 2, axis=1)
    # the umbrella over a vertex is a quarter of its mean squared edge times the Laplacian
    area = np.bincount(edges[:, 0], length, count) / 4.0
    heat = SHARPNESS * area / (distance**2 + area)
    links = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (count, count))
    degree = np.bincount(edges[:, 0], minlength=count)
    system = (diags(degree + heat) - links).tocsc()
    solver = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    owner = np.array([skeleton.index(bone.joint) for bone in bones])[nearest]
    warm = np.zeros((count, len(skeleton)))
    for joint, name in enumerate(skeleton.names):
        if not name.startswith("right_"):
            warm[:, joint] = solver.solve(np.where(owner == joint, heat, 0.0))
    for joint, name in enumerate(skeleton.names):
        if name.startswith("right_"):
            warm[:, joint] = warm[mesh.twins, skeleton.index(name.replace("right_", "left_"))]
    return np.maximum(warm, 0.0)


def _nearest(points: FloatArray, bones: Sequence[Bone]) -> tuple[FloatArray, IntArray]:
    """Distance (V,) m to the bone a point lies on, at least half its radius, and its number."""
    best, nearest = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
    distance = np.zeros(len(points))
    for number, bone in enumerate(bones):
        along = bone.end_m - bone.start_m
        share = np.clip((points - bone.start_m) @ along / max(float(along @ along), 1e-12), 0, 1)
        away = np.linalg.norm(points - bone.start_m - share[:, None] * along, axis=1)
        closer = away / bone.radius_m < best
        best = np.where(closer, away / bone.radius_m, best)
        distance = np.where(closer, np.maximum(away, 0.5 * bone.radius_m), distance)
        nearest = np.where(closer, number, nearest)
    return distance, nearest


def _bones(skeleton: Skeleton) -> list[Bone]:
    """All bones of both sides, in the rest pose."""
    at = dict(zip(skeleton.names, skeleton.rest_world.translation_m, strict=True))
    aside = np.array([0.0, 0.10, 0.0])
    bones = [
        Bone("hips", at["hips"] - 0.8 * aside, at["hips"] + 0.8 * aside, 0.115),
        Bone("waist", at["waist"] - 0.7 * aside, at["waist"] + 0.7 * aside, 0.130),
        Bone("spine", at["spine"] - 0.6 * aside, at["spine"] + 0.6 * aside, 0.120),
        Bone("chest", at["chest"] + [0, 0, 0.05], at["neck"] - [0.0, 0.0, 0.11], 0.120),
        Bone("neck", at["neck"] - [0.0, 0.0, 0.02], at["head"] - [0.0, 0.0, 0.01], 0.095),
        Bone("head", at["head"] + [0.0, 0.0, 0.14], at["head"] + [0.0, 0.0, 0.26], 0.200),
        Bone("head", at["head"] + [0.05, -0.06, 0.12], at["head"] + [0.05, 0.06, 0.12], 0.135),
    ]
    for side in ("left", "right"):
        bones += [*_arm(at, side), *_hand(at, side), *_leg(at, side)]
    return bones


def _arm(at: dict[str, FloatArray], side: str) -> list[Bone]:
    inner = 0.7 * at[f"{side}_clavicle"] + 0.3 * at[f"{side}_upper_arm"]
    return [
        Bone(f"{side}_clavicle", inner, at[f"{side}_upper_arm"], 0.054),
        Bone(f"{side}_upper_arm", at[f"{side}_upper_arm"], at[f"{side}_forearm"], 0.060),
        Bone(f"{side}_forearm", at[f"{side}_forearm"], at[f"{side}_hand"], 0.054),
    ]


def _hand(at: dict[str, FloatArray], side: str) -> list[Bone]:
    bones = []
    for finger in FINGERS:
        first, second, third = (at[f"{side}_{finger}_{k}"] for k in (1, 2, 3))
        tip = third + 0.8 * (third - second)
        if finger != "thumb":
            bones.append(Bone(f"{side}_hand", at[f"{side}_hand"], first, 0.032))
        chain = (first, second, third, tip)
        for k in range(3):
            bones.append(Bone(f"{side}_{finger}_{k + 1}", chain[k], chain[k + 1], 0.018))
    return bones


def _leg(at: dict[str, FloatArray], side: str) -> list[Bone]:
    ankle, toes = at[f"{side}_foot"], at[f"{side}_toes"]
    return [
        Bone(f"{side}_thigh", at[f"{side}_thigh"], at[f"{side}_calf"], 0.086),
        Bone(f"{side}_calf", at[f"{side}_calf"], ankle + np.array([0.0, 0.0, 0.05]), 0.080),
        Bone(f"{side}_foot", ankle - [0.03, 0.0, 0.05], toes - [0.04, 0.0, 0.0], 0.066),
        Bone(f"{side}_foot", ankle - [0.0, 0.0, 0.03], ankle - [0.040, 0.0, 0.06], 0.066),
        Bone(f"{side}_toes", toes - [0.012, 0.0, 0.0], toes - [-0.05, 0.0, 0.0], 0.066),
    ]


def rigid_head(
    mesh: SymmetricMesh, skeleton: Skeleton, joints: IntArray, weights: FloatArray
) -> FloatArray:
    """Weights (V, J) of all joints, the face wholly the head's: what sits on it must not slide."""
    dense = np.zeros((len(weights), len(skeleton)))
    for k in range(4):
        np.add.at(dense, (np.arange(len(weights)), joints[:, k]), weights[:, k])
    share = smoothstep((mesh.vertices[:, 2] - HEAD_FROM_M) / HEAD_OVER_M)
    dense *= 1.0 - share[:, None]
    dense[:, skeleton.index("head")] += share
    return dense
