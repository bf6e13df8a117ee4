"""Which lens model a clip bears, how sure the focal length is, and what a reader must be told.

Every second stretch of the clip is fitted, the other is predicted: the simplest lens whose
prediction is as good as the best wins. The two halves' focal lengths show what the residuals
cannot: errors that neighbouring corners and pictures have in common.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.self_calibration.bodies import BodySightings, BodyState
from motorcade.tracking.self_calibration.fitting import BodyFit, fit
from motorcade.tracking.self_calibration.lens import KINDS, LensKind
from motorcade.tracking.self_calibration.result import (
    Basis,
    ReadoutAxis,
    SelfCalibration,
    SelfCalibrationError,
    ShutterReadout,
)

WORST_FOCAL = 0.05
"""Relative standard deviation of a focal length beyond which none is given."""
_DOUBTFUL_FOCAL = 0.01
_AS_GOOD = 1.02  # a simpler lens may predict so much worse than the best
_STRETCHES = 8
_LEAST_TURN_DEG = 5.0
_READOUT_SIGMA_S = 0.002
_BREATHING_BINS, _BREATHING_LEAST, _BREATHING_SIGMAS = 8, 0.01, 4.0
_BREATHING_ROUNDS = 3
_POOR_RMS_PX = 1.5
_FAR_ENOUGH = 0.55  # of the way from the middle to a corner: beyond the short side


@dataclass(frozen=True, eq=False)
class ChosenFit:
    """The fit of all views with the lens that predicts best.

    Fields:
        fit: of all views; reason: why this lens.
        halves: ``(2,)`` focal lengths of the two halves of the clip.
    """

    fit: BodyFit
    reason: str
    halves: FloatArray


def choose_lens(seen: BodySightings, start: BodyState, *, readout: bool) -> ChosenFit:
    """Fit the lens models in turn, and all views with the one that predicts best.

    Args:
        seen: at least four views.
        start: a state near, of the kind of lens that starts.
        readout: whether a rolling shutter is looked for.
    """
    halves = _halves(len(seen.time_s))
    parts = [seen.only(half) for half in halves]
    states = [_of_views(start, half) for half in halves]
    errors: list[float] = []
    focal: list[FloatArray] = []
    for kind in KINDS:
        tried = [_as_kind(state, kind) for state in states]
        try:
            fits = [
                fit(part, state, readout=readout) for part, state in zip(parts, tried, strict=True)
            ]
            tried = [one.state for one in fits]
            if any(one.camera(seen.size).folds() for one in fits):
                raise SelfCalibrationError(f"{kind.name}: folds back within the picture")
            error = [_predicted_px(parts[1 - k], tried[1 - k], fits[k]) for k in (0, 1)]
        except SelfCalibrationError:  # a lens that folds back
            if kind is KINDS[0]:
                raise
            errors.append(np.inf)
            focal.append(focal[-1])
            continue
        states = tried
        focal.append(np.array([one.state.numbers[0] for one in fits]))
        errors.append(float(np.mean(error)))
    best = min(errors)
    chosen = next(k for k, error in enumerate(errors) if error <= _AS_GOOD * best)
    kind = KINDS[chosen]
    whole = fit(seen, _as_kind(_with_lens(start, states[0]), kind), readout=readout)
    listed = ", ".join(f"{one.name} {error:.3f}" for one, error in zip(KINDS, errors, strict=True))
    return ChosenFit(
        whole,
        f"{kind.name}: the simplest that predicts unseen frames best ({listed} px)",
        focal[chosen],
    )


def _halves(views: int) -> list[IntArray]:
    """Every second of `_STRETCHES` stretches of neighbouring views, and the others."""
    which = np.arange(views) * min(_STRETCHES, views) // views % 2
    return [np.flatnonzero(which == one) for one in (0, 1)]


def _of_views(state: BodyState, views: IntArray) -> BodyState:
    return replace(state, world_T_camera=state.world_T_camera[views])


def _as_kind(state: BodyState, kind: LensKind) -> BodyState:
    """The same with another lens model; terms of another model begin at zero."""
    same = state.kind.model == kind.model or state.kind.model == "pinhole"
    numbers = kind.start(state.numbers, state.kind.terms if same else 0)
    return replace(state, kind=kind, numbers=numbers)


def _with_lens(state: BodyState, like: BodyState) -> BodyState:
    return replace(state, kind=like.kind, numbers=like.numbers, readout_s=like.readout_s)


def _predicted_px(seen: BodySightings, near: BodyState, known: BodyFit) -> float:
    """Error of views with a lens and bodies from other views, their poses alone fitted."""
    start = _with_lens(replace(near, world_T_body=known.state.world_T_body), known.state)
    found = fit(seen, start, lens=False, bodies=False)
    return float(np.sqrt(np.median((found.residuals_px**2).sum(axis=-1))))


def calibration_of(chosen: ChosenFit, seen: BodySightings, basis: Basis) -> SelfCalibration:
    """What is given: camera, its doubts and what else the fit tells.

    Raises:
        SelfCalibrationError: views from which the focal length does not follow.
    """
    found, breathing = _with_breathing(chosen.fit, seen)
    focal = float(found.state.numbers[0])
    formal = float(np.sqrt(found.covariance[0, 0])) / focal
    between = float(abs(np.diff(chosen.halves)[0])) / (2.0 * focal)
    sigma = max(formal, between)
    turn_deg = largest_turn_deg(found.state)
    if turn_deg < _LEAST_TURN_DEG:
        raise SelfCalibrationError(
            f"{basis}: expected it at different angles, got {turn_deg:.1f} degrees between any "
            "two frames at most; the focal length does not follow from parallel views: walk "
            "around it, or tilt it by 30 degrees and more"
        )
    if not sigma <= WORST_FOCAL:
        raise SelfCalibrationError(
            f"{basis}: expected frames that fix the focal length to {WORST_FOCAL:.0%}, got "
            f"{focal:.0f} pixels +- {sigma:.1%}; film it nearer, and from more sides"
        )
    return SelfCalibration(
        found.camera(seen.size),
        basis,
        sigma,
        chosen.reason,
        found.rms_px,
        len(seen.time_s),
        _readout(found),
        breathing,
        (*_doubts(found, sigma, breathing, basis), *_reach(seen)),
    )


def largest_turn_deg(state: BodyState) -> float:
    """The largest angle between the directions from which any two views see the first body."""
    normals = state.world_T_camera.rotor.inverse().apply([0.0, 0.0, 1.0])
    return float(np.degrees(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0).min())))


def _readout(found: BodyFit) -> ShutterReadout | None:
    """The shutter's, along the axis that shows it; None where neither is sure."""
    lens = len(found.state.numbers)
    if len(found.covariance) < lens + 2:
        return None
    sigmas = np.sqrt(np.diag(found.covariance)[lens:])
    axis = int(np.argmax(np.abs(found.state.readout_s)))
    seconds, sigma = float(found.state.readout_s[axis]), float(sigmas[axis])
    if sigma > _READOUT_SIGMA_S:
        return None
    names: tuple[tuple[ReadoutAxis, ReadoutAxis], ...] = (("right", "left"), ("down", "up"))
    return ShutterReadout(abs(seconds), sigma, names[axis][int(seconds < 0.0)])


def _with_breathing(found: BodyFit, seen: BodySightings) -> tuple[BodyFit, float]:
    """The fit where the focal length may change over the clip, if it does, and by which share.

    One focal length for all is not their mean: distances make up for what it lacks. So corners are
    brought to where the mean focal length shows them, and all is fitted again, in turns.
    """
    share = _breathing(found, seen)
    if not share:
        return found, 0.0
    change, even = np.zeros(len(seen.time_s)), found
    for _ in range(_BREATHING_ROUNDS):
        centres, means, _ = _by_bins(even, seen)
        change += np.interp(seen.time_s, centres, means)
        lasting = np.linspace(seen.time_s[0], seen.time_s[-1], 64)
        change -= np.interp(lasting, seen.time_s, change).mean()
        focal, middle = even.state.numbers[0], even.state.numbers[1:3]
        ratio = (focal / (focal + change))[seen.view][:, None]
        at_mean = replace(seen, px=middle + (seen.px - middle) * ratio)
        readout = len(found.covariance) > len(found.state.numbers)
        even = fit(at_mean, even.state, readout=readout)
    return even, float(np.ptp(change) / even.state.numbers[0])


def _by_bins(found: BodyFit, seen: BodySightings) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, and mean change of the focal length and its standard deviation, by part of a clip."""
    bins = np.arange(len(seen.time_s)) * _BREATHING_BINS // len(seen.time_s)
    weight = found.focal_sigma**-2.0
    total, count = np.bincount(bins, weight, _BREATHING_BINS), np.bincount(bins)
    means = np.bincount(bins, weight * found.focal_by_view, _BREATHING_BINS) / total
    # Neighbouring pictures err alike: within a bin the scatter says how much.
    scatter = np.bincount(bins, weight * (found.focal_by_view - means[bins]) ** 2, _BREATHING_BINS)
    sigma = np.sqrt(np.maximum(scatter / total, 1.0 / total) / np.sqrt(count))
    return np.bincount(bins, seen.time_s, _BREATHING_BINS) / count, means, sigma


def _breathing(found: BodyFit, seen: BodySightings) -> float:
    """Relative change of the focal length over the clip where it is beyond doubt, else 0."""
    if len(seen.time_s) < 2 * _BREATHING_BINS:
        return 0.0
    _, means, sigma = _by_bins(found, seen)
    high, low = int(np.argmax(means)), int(np.argmin(means))
    change = float(means[high] - means[low])
    share = change / float(found.state.numbers[0])
    sure = change > _BREATHING_SIGMAS * float(np.hypot(sigma[high], sigma[low]))
    return share if sure and share > _BREATHING_LEAST else 0.0


def _reach(seen: BodySightings) -> tuple[str, ...]:
    """What to tell where nothing was seen near the picture's corners."""
    half = 0.5 * np.array(seen.size)
    share = float(np.percentile(np.linalg.norm((seen.px - half), axis=-1), 98))
    share /= float(np.linalg.norm(half))
    if share > _FAR_ENOUGH:
        return ()
    return (
        f"nothing was seen beyond {share:.0%} of the way from the picture's middle to its corners: "
        "how the lens bends there is a guess",
    )


def _doubts(found: BodyFit, sigma: float, breathing: float, basis: Basis) -> tuple[str, ...]:
    doubts = []
    if sigma > _DOUBTFUL_FOCAL:
        doubts.append(
            f"the focal length is known to {sigma:.1%} only: film it nearer, and from more sides"
        )
    if breathing:
        doubts.append(
            f"the focal length changes by {breathing:.1%} over the clip (autofocus breathing, or "
            "zoom); the camera is their mean: lock the focus for better"
        )
    if found.rms_px > _POOR_RMS_PX:
        doubts.append(
            f"the {basis} fit to {found.rms_px:.1f} px only: blurred pictures, a bent print, or "
            "something that moved or is not what it was taken for"
        )
    return tuple(doubts)
