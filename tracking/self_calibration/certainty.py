"""How sure a fit is, judged by errors that many corners have in common.

Least squares takes each corner's error for its own. They are not: neighbouring views show a print
from one side and with one blur, and a print that is bent is so in all views. So the fit's scores
are summed over what errs alike, once over segments of the clip and once over the print's points,
and the scatter of these sums says how far the focal length may be off. Glare lies in one part of
the image throughout: an offset of each part's corners is estimated as a random effect.

Sources: Cameron, Gelbach & Miller 2011 (standard errors clustered two ways); Bell & McCaffrey 2002
(each cluster left out, for few of them).
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.self_calibration.bodies import BodyObservations, BodyReprojection
from motorcade.tracking.self_calibration.fitting import BodyFit

SEGMENTS = 8
"""A clip is cut into so many parts: few enough that their errors are independent."""
_PARTS, _POSE = 4, 6
"""What was seen of the image is cut into so many columns and rows; a pose has six numbers."""


def segments(views: int) -> IntArray:
    """Of each view the number of the segment of neighbours that it belongs to."""
    return np.arange(views) * min(SEGMENTS, views) // views


def error_inflation(seen: BodyObservations, fit: BodyFit) -> float:
    """How many times the error of the focal length is what independent corners would leave it.

    One at least. Linearised: each segment is left out in turn, without a fit of its own.
    """
    at = fit.evaluation
    reduced = _without_views(at, seen)
    _, point = np.unique(
        np.column_stack([seen.body, seen.points.round(6)]), axis=0, return_inverse=True
    )
    pull = at.weight[:, None] * at.residuals_px
    scores = np.einsum("nij,ni->nj", reduced, pull)
    segment = segments(len(seen.time_s))[seen.view]
    flat = np.sqrt(at.weight)[:, None, None] * reduced
    parts = [flat[segment == one].reshape(-1, flat.shape[-1]) for one in range(segment.max() + 1)]
    informations = [part.T @ part for part in parts]
    data = np.sum(informations, axis=0)
    whole = data + np.diag(at.expected_of(data.shape[0]))
    left_out = [
        np.linalg.lstsq(whole - information, scores[segment == k].sum(axis=0), rcond=None)[0][0]
        for k, information in enumerate(informations)
    ]
    count = len(left_out)
    by_focal = np.linalg.solve(whole, np.eye(len(whole))[0])
    by_point = np.bincount(point.ravel(), scores @ by_focal)
    scatter = (count - 1) / count * float(np.square(left_out).sum())
    scatter += float(np.square(by_point).sum())
    scatter += _by_place(at, seen, reduced @ by_focal, fit.sigma_px)
    expected = fit.sigma_px**2 * float(by_focal @ data @ by_focal)
    return float(np.sqrt(max(scatter / max(expected, 1e-300), 1.0)))


def _by_place(
    at: BodyReprojection, seen: BodyObservations, pulls: FloatArray, sigma_px: float
) -> float:
    """Variance of the focal length by what moves all corners of a part of the image alike.

    Glare does, and what no lens model explains. A fit hides such an error in its own direction, so
    its size is taken from what is left in the parts, and its effect from how they pull.
    """
    low, high = seen.px.min(axis=0), seen.px.max(axis=0)
    column, row = ((seen.px - low) / (high - low) * (_PARTS - 1e-9)).astype(np.int64).T
    _, part = np.unique(_PARTS * row + column, return_inverse=True)
    weight = np.bincount(part, at.weight)
    left = np.stack([np.bincount(part, at.weight * one) for one in at.residuals_px.T], -1)
    means = left / weight[:, None]
    pulled = np.stack([np.bincount(part, at.weight * one) for one in pulls.T], -1)
    free = max(means.size - len(at.free_numbers) - _POSE, 1)
    common = (np.square(means).sum() - 2.0 * (sigma_px**2 / weight).sum()) / free
    return float(max(common, 0.0) * np.square(pulled).sum())


def _without_views(at: BodyReprojection, seen: BodyObservations) -> FloatArray:
    """Derivative ``(N, 2, p)`` by all that views share, less what their poses make up for."""
    by_view, shared = at.by_view, at.by_all_shared
    pull = (by_view * at.weight[:, None, None]).swapaxes(-1, -2)
    own = np.add.reduceat(pull @ by_view, seen.starts, axis=0)
    common = np.add.reduceat(pull @ shared, seen.starts, axis=0)
    made_up = np.linalg.solve(own + 1e-9 * np.eye(6), common)
    return np.asarray(shared - by_view @ made_up[seen.view], np.float64)
