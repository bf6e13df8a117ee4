"""What a blink and a smile move: steps of the vertices of eyes, brows and mouth."""

from __future__ import annotations

import numpy as np

from docs.making.figure.shape.fields import BodyField
from docs.making.figure.shape.pieces import mouth, pieces
from motorcade.ga.arrays import FloatArray

CLOSED, BROWS_UP_M = 0.10, 0.010


def expressions(field: BodyField) -> dict[str, dict[str, FloatArray]]:
    """By name of the target and of the piece: (V, 3) metres, left vertices then right ones."""
    eye, brow, plain = (
        next(one for one in pieces(field) if one.name == name) for name in ("eye", "brow", "mouth")
    )
    middle = 0.5 * (eye.vertices.min(axis=0) + eye.vertices.max(axis=0))
    blink = np.zeros_like(eye.vertices)
    blink[:, 2] = (CLOSED - 1.0) * (eye.vertices[:, 2] - middle[2]) - 0.004
    glad = np.zeros_like(eye.vertices)
    glad[:, 2] = -0.16 * (eye.vertices[:, 2] - middle[2]) + 0.002
    smile = mouth(field, wide=0.26, curve=0.115).vertices - plain.vertices
    up = np.tile([-0.002, 0.0, BROWS_UP_M], (len(brow.vertices), 1))
    flip = np.array([1.0, -1.0, 1.0])
    return {
        "blink": {"eye": np.concatenate([blink, blink * flip])},
        "smile": {
            "eye": np.concatenate([glad, glad * flip]),
            "brow": np.concatenate([up, up * flip]),
            "mouth": smile,
        },
    }
