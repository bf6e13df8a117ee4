"""Focal lengths that a clip tells badly or not at all, drawn towards what cameras usually have.

The prior is log-normal: a focal length that was measured badly is drawn towards it, and one that
was measured well is not.
"""

from __future__ import annotations

import math

from motorcade.tracking.self_calibration.lens import FOCAL_SPREAD, USUAL_FOCAL


def with_prior(focal: float, sigma: float) -> tuple[float, float]:
    """A focal length in longer sides and its relative standard deviation, with what is usual.

    >>> with_prior(2.0, float("inf"))
    (0.8, 0.35)
    >>> [round(number, 3) for number in with_prior(1.0, 0.05)]
    [0.996, 0.049]
    """
    own, usual = 1.0 / sigma**2 if sigma > 0.0 else math.inf, 1.0 / FOCAL_SPREAD**2
    if math.isinf(own):
        return focal, sigma
    if math.isnan(own):
        return USUAL_FOCAL, FOCAL_SPREAD
    mean = (own * math.log(max(focal, 1e-3)) + usual * math.log(USUAL_FOCAL)) / (own + usual)
    return math.exp(mean), (own + usual) ** -0.5


def view_deg(focal: float) -> float:
    """Angle that is seen along the longer side.

    >>> round(view_deg(USUAL_FOCAL))
    64
    """
    return math.degrees(2.0 * math.atan(0.5 / focal))


def doubt_of(focal: float, sigma: float) -> str:
    """The range of a view that is hardly known, in words.

    >>> print(doubt_of(0.8, 0.35))
    how wide it sees is hardly known: 64 degrees, likely 48 to 83
    """
    wide, narrow = view_deg(focal * math.exp(-sigma)), view_deg(focal * math.exp(sigma))
    return (
        f"how wide it sees is hardly known: {view_deg(focal):.0f} degrees, likely {narrow:.0f} to "
        f"{wide:.0f}"
    )
