"""Blending: poses mixed by any method, in layers, along blend spaces and across transitions."""

from motorcade.animation.blend.alignment import (
    GroundedMotion,
    blend_motions,
    grounded,
    in_step,
    planted,
)
from motorcade.animation.blend.locomotion import BlendSpace, RootMotion
from motorcade.animation.blend.methods import (
    BlendMethod,
    PoseLayer,
    Poses,
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
    PoseSource,
    Shifted,
    blend_clips,
    differences_m,
)

__all__ = [
    "BlendMethod",
    "BlendSpace",
    "CrossFade",
    "GroundedMotion",
    "Inertialized",
    "PoseLayer",
    "PoseSource",
    "Poses",
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
    "planted",
    "stacked",
]
