"""What stays true of a clip whose images were scaled, cropped, mirrored, or given other times."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray

__all__ = ["cropped", "mirrored", "of_frames", "scaled"]

Truth = Mapping[str, NDArray[np.float64]]


def of_frames(truth: Truth, rows: IntArray, time_s: FloatArray) -> dict[str, FloatArray]:
    """Some frames ``(n,)``, shown at other times ``(n,)``."""
    kept = {name: np.asarray(truth[name]) for name in truth}
    for name in ("world_T_camera", "anchors_px", "focal_px"):
        kept[name] = kept[name][rows]
    return kept | {"time_s": np.asarray(time_s, np.float64)}


def scaled(truth: Truth, scale: tuple[float, float]) -> dict[str, FloatArray]:
    """Images made smaller, across and down; pixel (0, 0) is a centre."""
    px = (truth["anchors_px"] + 0.5) * scale - 0.5
    return dict(truth) | {"anchors_px": px, "focal_px": scale[0] * truth["focal_px"]}


def cropped(truth: Truth, left: int, top: int) -> dict[str, FloatArray]:
    """Images cut out of larger ones."""
    return dict(truth) | {"anchors_px": truth["anchors_px"] - (left, top)}


def mirrored(truth: Truth, width: int) -> dict[str, FloatArray]:
    """Images whose left is right: those of a world that is a mirror image, x for -x."""
    flip = np.diag([-1.0, 1.0, 1.0])
    poses = Motor(truth["world_T_camera"])
    turned = Rotor.from_matrix(flip @ poses.rotor.as_matrix() @ flip)
    path = Motor.from_rotor_translation(turned, poses.translation_m @ flip)
    px = truth["anchors_px"] * (-1.0, 1.0) + (width - 1.0, 0.0)
    return dict(truth) | {
        "world_T_camera": path.coefficients,
        "anchors_m": truth["anchors_m"] @ flip,
        "anchors_px": px,
    }
