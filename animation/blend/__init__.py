"""Blending: poses mixed by any method, in layers, along blend spaces and across transitions."""

from motorcade.animation.blend.alignment import blend_motions, grounded, in_step
from motorcade.animation.blend.locomotion import BlendSpace, RootMotion
from motorcade.animation.blend.methods import (
    BlendMethod,
    PoseLayer,
    added,
    additive,
    blend_layers,
    blend_poses,
    closed,
    stacked,
)
from motorcade.animation.blend.transitions import (
    CrossFade,
    Inertialized,
    Shifted,
    blend_clips,
    differences_m,
)

__all__ = [
    "BlendMethod",
    "BlendSpace",
    "CrossFade",
    "Inertialized",
    "PoseLayer",
    "RootMotion",
    "Shifted",
    "added",
    "additive",
    "blend_clips",
    "blend_layers",
    "blend_motions",
    "blend_poses",
    "closed",
    "differences_m",
    "grounded",
    "in_step",
    "stacked",
]
