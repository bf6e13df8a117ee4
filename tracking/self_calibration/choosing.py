"""Which lens model a clip bears, how sure the focal length is, and what a reader must be told.

Every second segment of the clip is fitted, the other is predicted: the simplest lens whose
prediction is as good as the best within its scatter wins, of those that are told as far as the
image's corners. How sure the focal length is follows from errors that corners have in common,
and from how far the lenses differ that predict no worse.

Least squares takes each corner's error for its own. They are not: neighbouring views show a print
from one side and with one blur, and a print that is bent is so in all views. So the fit's scores
are summed over what errs alike, once over segments of the clip and once over the print's points,
and the scatter of these sums says how far the focal length may be off. Glare lies in one part of
the image throughout: an offset of each part's corners is estimated as a random effect.

Sources: Cameron, Gelbach & Miller 2011 (standard errors clustered two ways); Bell & McCaffrey 2002
(each cluster left out, for few of them).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.progress import track
from motorcade.tracking.self_calibration.bodies import (
    BodyFit,
    BodyObservations,
    BodyReprojection,
    BodyState,
    fit,
)
from motorcade.tracking.self_calibration.lens import (
    FOCAL_SPREAD,
    KINDS,
    LEAST_FOCAL,
    MOST_FOCAL,
    LensKind,
)
from motorcade.tracking.self_calibration.result import (
    Basis,
    ReadoutAxis,
    SelfCalibration,
    SelfCalibrationError,
    ShutterReadout,
)
from motorcade.tracking.self_calibration.zooming import (
    FollowedZoom,
    focal_range,
    follow_zoom,
    may_zoom,
    zoom_doubt,
)

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


_DOUBTFUL_FOCAL = 0.01
_SURE_FOCAL = 0.001
"""No clip tells it better: focus and stabilisation move it, and pixels are as square as that."""
_LEANT_ON = 0.3  # of the usual cameras' spread: from there on they are part of the answer
_AS_GOOD = 1.02  # a simpler lens may predict so much worse than the best
_SCATTERS = 2.0
_TOLD_BEND = 0.05
"""Standard deviation, as a share of the distance from the middle, to which terms must tell where
the image's corners lie: lenses are that near to having no terms."""
_HEAD_ON_DEG = 15.0
_READOUT_SIGMA_S = 0.002
_BREATHING_BINS, _BREATHING_LEAST, _BREATHING_SIGMAS = 8, 0.01, 4.0
_BREATHING_ROUNDS = 3
_LEFT_ALIKE = 0.5  # of the errors in common: what breathing explains leaves no more
_BREATHING_SPREAD = 0.03  # of the focal length: what autofocus does to lenses
_ZOOM_LEAVES = 0.8  # of the noise of one focal length: a curve that explains more is no accident
_POOR_RMS_PX = 1.5
_FAR_ENOUGH = 0.55  # of the way from the middle to a corner: beyond the short side


@dataclass(frozen=True, eq=False)
class ChosenFit:
    """The fit of all views with the lens that predicts best.

    Fields:
        fit: of all views; reason: why this lens.
        alike: by how much corners that err alike make its errors larger (`error_inflation`).
        spread: relative standard deviation of the focal length over lenses that predict no worse.
    """

    fit: BodyFit
    reason: str
    alike: float
    spread: float

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the numbers that views share, for corners that err alike."""
        return self.alike**2 * self.fit.covariance


@dataclass(frozen=True, eq=False)
class _Tried:
    """A lens model on a clip; `errors` of unseen segments, log px; `fault` why it is no choice."""

    chosen: ChosenFit
    errors: FloatArray
    fault: str


def choose_lens(seen: BodyObservations, start: BodyState, *, readout: bool) -> ChosenFit:
    """Fit the lens models in turn, and choose the simplest of those that predict best.

    A model that folds back in the image, or whose terms do not tell where its corners lie, is not
    taken: it was seen too near the middle.

    Args:
        seen: at least four views.
        start: a state near, of the kind of lens that starts.
        readout: whether a rolling shutter is looked for.
    """
    tried: list[_Tried] = []
    for kind in track(KINDS, "trying lenses", len(KINDS)):
        try:
            tried.append(_try_lens(seen, as_kind(start, kind), readout=readout))
        except SelfCalibrationError:  # corners beyond where it folds back
            if kind is KINDS[0]:
                raise
    fit_ones = [one for one in tried if not one.fault]
    best = min(fit_ones, key=lambda lens: float(lens.errors.mean()))
    chosen = next(one for one in fit_ones if _predicts_as(one, best))
    rivals = [one.chosen.fit.state.numbers[0] for one in tried if _predicts_as(one, chosen)]
    focal = chosen.chosen.fit.state.numbers[0]
    listed = ", ".join(
        f"{lens.chosen.fit.state.kind.name} {np.exp(lens.errors.mean()):.3f}{lens.fault}"
        for lens in tried
    )
    name = chosen.chosen.fit.state.kind.name
    return replace(
        chosen.chosen,
        reason=f"{name}: the simplest that predicts unseen frames best ({listed} px)",
        spread=0.5 * float(np.abs(np.array(rivals) / focal - 1.0).max()),
    )


def _try_lens(seen: BodyObservations, start: BodyState, *, readout: bool) -> _Tried:
    chosen = weighed_fit(seen, start, readout=readout)
    state, alike = chosen.fit.state, chosen.alike
    segment = segments(len(seen.time_s))
    errors = np.zeros(segment[-1] + 1)
    for parity in (0, 1):
        views, others = np.flatnonzero(segment % 2 == parity), np.flatnonzero(segment % 2 != parity)
        near = _of_views(state, others)
        known = fit(seen.only(others), near, readout=readout, alike=alike)
        predicted = _predicted_px(seen.only(views), _of_views(state, views), known)
        for number in range(parity, len(errors), 2):
            errors[number] = np.log(np.median(predicted[segment[views] == number]))
    bend = np.pad(state.kind.bend(state.numbers, seen.size), (0, len(chosen.covariance)))
    bend = bend[: len(chosen.covariance)]
    if chosen.fit.camera(seen.size).folds():
        fault = " (folds back in the image)"
    elif float(bend @ chosen.covariance @ bend) > _TOLD_BEND**2:
        fault = " (does not tell the corners)"
    else:
        fault = ""
    return _Tried(chosen, errors, fault)


def weighed_fit(seen: BodyObservations, start: BodyState, *, readout: bool) -> ChosenFit:
    """All views fitted, what is expected of lenses weighed by how much corners tell together."""
    fitted, alike = fit(seen, start, readout=readout), 1.0
    for _ in range(2):
        alike = error_inflation(seen, fitted)
        fitted = fit(seen, fitted.state, readout=readout, alike=alike)
    return ChosenFit(fitted, "", alike, 0.0)


def _predicts_as(lens: _Tried, other: _Tried) -> bool:
    """Whether it predicts as well as another, or better, within the scatter over segments."""
    worse = lens.errors - other.errors
    scatter = float(worse.std(ddof=1)) / np.sqrt(len(worse))
    return bool(worse.mean() <= max(np.log(_AS_GOOD), _SCATTERS * scatter))


def _of_views(state: BodyState, views: IntArray) -> BodyState:
    return replace(state, world_T_camera=state.world_T_camera[views])


def as_kind(state: BodyState, kind: LensKind) -> BodyState:
    """The same with another lens model; terms of another model begin at zero."""
    same = state.kind.model == kind.model or state.kind.model == "pinhole"
    numbers = kind.start(state.numbers, state.kind.terms if same else 0)
    return replace(state, kind=kind, numbers=numbers)


def _predicted_px(seen: BodyObservations, near: BodyState, known: BodyFit) -> FloatArray:
    """Median error ``(V,)`` of views with a lens and bodies from others, their poses fitted."""
    start = replace(known.state, world_T_camera=near.world_T_camera)
    fitted = fit(seen, start, lens=False, bodies=False)
    size = np.linalg.norm(fitted.residuals_px, axis=-1)
    return np.array([np.median(part) for part in np.split(size, seen.starts[1:])])


def calibration_of(
    chosen: ChosenFit, seen: BodyObservations, basis: Basis, start_ns: int
) -> SelfCalibration:
    """What is given: camera, its doubts and what else the fit tells.

    `start_ns` is the stamp of the observations' zero.

    Raises:
        SelfCalibrationError: views from which no camera's focal length follows.
    """
    zoom, apart, breathing, unsure = None, None, 0.0, 0.0
    if (followed := _followed(chosen, seen)) is not None:
        chosen, curve = followed
        seen, unsure = curve.seen, curve.sigma
        zoom = replace(curve.zoom, time_s=curve.zoom.time_s + 1e-9 * start_ns)
    elif apart := focal_range(len(seen.time_s), partial(_focal_of, chosen.fit.state, seen)):
        unsure = 0.5 * float(np.log(apart[1] / apart[0]))
    else:
        chosen, breathing = _with_breathing(chosen, seen)
    fitted = chosen.fit
    focal = float(fitted.state.numbers[0])
    formal = float(np.sqrt(chosen.covariance[0, 0])) / focal
    sigma = float(np.linalg.norm([formal, chosen.spread, _SURE_FOCAL, unsure]))
    if not LEAST_FOCAL <= focal / max(seen.size) <= MOST_FOCAL:
        raise SelfCalibrationError(
            f"{basis}: expected a focal length of {LEAST_FOCAL:g} to {MOST_FOCAL:g} long sides of "
            f"the image, got {focal / max(seen.size):.2g}: no camera sees it like that"
        )
    doubts = (zoom_doubt(*apart),) if apart else _doubts(fitted, sigma, breathing, basis)
    if zoom is not None:
        longest = focal * float(zoom.ratio.max())
        said = f"the lens zooms from {focal:.0f} to {longest:.0f} px and is followed to {sigma:.1%}"
        doubts = (f"{said}; how it distorts is taken to stay", *doubts)
    return SelfCalibration(
        fitted.camera(seen.size),
        basis,
        sigma,
        chosen.reason,
        fitted.rms_px,
        len(seen.time_s),
        _readout(chosen),
        breathing,
        (*doubts, *_reach(seen)),
        zoom,
    )


def _followed(chosen: ChosenFit, seen: BodyObservations) -> tuple[ChosenFit, FollowedZoom] | None:
    """The lens chosen anew where its zoom is undone, and that zoom; None where there is none."""
    if not may_zoom(seen, chosen.fit):
        return None
    state = chosen.fit.state
    plain = replace(as_kind(state, KINDS[0]), readout_s=np.zeros(2), bent=np.zeros(len(state.bent)))
    try:
        followed = follow_zoom(seen, plain)
        if followed is None:
            return None
        again = choose_lens(followed.seen, followed.state, readout=True)
        followed = follow_zoom(seen, again.fit.state, followed.log_focal)
        if followed is None:
            return None
        last = weighed_fit(followed.seen, followed.state, readout=True)
    except SelfCalibrationError:
        return None
    # What is left as it is: its robust measure has a floor, and passes over what one lens lacks.
    by_one, left = (each.rms_px / each.state.numbers[0] for each in (chosen.fit, last.fit))
    if left > _ZOOM_LEAVES * by_one:
        return None
    return replace(again, fit=last.fit, alike=last.alike), followed


def _focal_of(
    state: BodyState, seen: BodyObservations, views: IntArray
) -> tuple[float, float] | None:
    """What some views alone tell of the focal length, and its deviation, for a lens like all."""
    try:
        alone = fit(seen.only(views), _of_views(state, views), bodies=False)
    except SelfCalibrationError:
        return None
    return float(alone.state.numbers[0]), float(np.sqrt(alone.covariance[0, 0]))


def _readout(chosen: ChosenFit) -> ShutterReadout | None:
    """The shutter's, along the axis that shows it; None where neither is sure."""
    state = chosen.fit.state
    sigmas = np.sqrt(np.diag(chosen.covariance)[len(state.numbers) :][:2])
    if not len(sigmas):
        return None
    axis = int(np.argmax(np.abs(state.readout_s)))
    seconds, sigma = float(state.readout_s[axis]), float(sigmas[axis])
    if sigma > _READOUT_SIGMA_S:
        return None
    names: tuple[tuple[ReadoutAxis, ReadoutAxis], ...] = (("right", "left"), ("down", "up"))
    return ShutterReadout(abs(seconds), sigma, names[axis][int(seconds < 0.0)])


def _with_breathing(chosen: ChosenFit, seen: BodyObservations) -> tuple[ChosenFit, float]:
    """The fit where the focal length may change over the clip, if it does, and by which share.

    One focal length for all is not their mean: distances make up for what it lacks. So corners are
    brought to where the mean focal length shows them, and all is fitted again, in turns. Whether it
    changed is then asked of what that fit is sure of: a part of the clip that shows a print head on
    tells no focal length apart from a distance. And it must explain what errors had in common.
    """
    if len(seen.time_s) < 2 * _BREATHING_BINS:
        return chosen, 0.0
    even, alike, readout = chosen.fit, chosen.alike, bool(np.any(chosen.fit.state.readout_s))
    change = np.zeros(len(seen.time_s))
    for _ in range(_BREATHING_ROUNDS):
        centres, means, sigma = _by_bins(even, seen, alike)
        spread = _BREATHING_SPREAD * even.state.numbers[0]
        means *= spread**2 / (spread**2 + sigma**2)
        change += np.interp(seen.time_s, centres, means)
        lasting = np.linspace(seen.time_s[0], seen.time_s[-1], 64)
        change -= np.interp(lasting, seen.time_s, change).mean()
        high, low = int(np.argmax(change)), int(np.argmin(change))
        if change[high] - change[low] < _BREATHING_LEAST * even.state.numbers[0]:
            return chosen, 0.0
        focal, middle = even.state.numbers[0], even.state.numbers[1:3]
        ratio = (focal / (focal + change))[seen.view][:, None]
        at_mean = replace(seen, px=middle + (seen.px - middle) * ratio)
        even = fit(at_mean, even.state, readout=readout, alike=alike)
        alike = error_inflation(at_mean, even)
    _, _, sigma = _by_bins(even, seen, alike)
    ends = np.interp(seen.time_s[[high, low]], centres, sigma)
    sure = float(np.ptp(change)) > _BREATHING_SIGMAS * float(np.hypot(*ends))
    if not sure or alike > _LEFT_ALIKE * chosen.alike:
        return chosen, 0.0
    share = float(np.ptp(change) / even.state.numbers[0])
    # No frame has the mean: what is said of it covers theirs.
    spread = float(np.hypot(chosen.spread, change.std() / even.state.numbers[0]))
    return replace(chosen, fit=even, alike=alike, spread=spread), share


def _by_bins(
    fitted: BodyFit, seen: BodyObservations, alike: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, and mean change of the focal length and its standard deviation, by part of a clip."""
    bins = np.arange(len(seen.time_s)) * _BREATHING_BINS // len(seen.time_s)
    weight = fitted.focal_sigma**-2.0
    total, count = np.bincount(bins, weight, _BREATHING_BINS), np.bincount(bins)
    means = np.bincount(bins, weight * fitted.focal_by_view, _BREATHING_BINS) / total
    sigma = np.asarray(alike / np.sqrt(total), np.float64)
    return np.bincount(bins, seen.time_s, _BREATHING_BINS) / count, means, sigma


def _reach(seen: BodyObservations) -> tuple[str, ...]:
    """What to tell where nothing was seen near the image's corners."""
    half = 0.5 * np.array(seen.size)
    share = float(np.percentile(np.linalg.norm((seen.px - half), axis=-1), 98))
    share /= float(np.linalg.norm(half))
    if share > _FAR_ENOUGH:
        return ()
    return (
        f"nothing was seen beyond {share:.0%} of the way from the image's middle to its corners: "
        "how the lens bends there is a guess",
    )


def _doubts(fitted: BodyFit, sigma: float, breathing: float, basis: Basis) -> tuple[str, ...]:
    doubts = []
    if sigma > _DOUBTFUL_FOCAL:
        # Between the lens's axis and the print's normal, the largest of all views.
        normals = fitted.state.world_T_camera.rotor.inverse().apply([0.0, 0.0, 1.0])
        tilt_deg = np.degrees(np.arccos(np.clip(np.abs(normals[:, 2]), 0.0, 1.0))).max()
        why = "film it nearer, and from more sides"
        if basis == "board" and tilt_deg < _HEAD_ON_DEG:
            why = f"it is seen head on, to {tilt_deg:.0f} degrees: film it from more sides"
        if sigma > _LEANT_ON * FOCAL_SPREAD:
            why += "; what cameras usually have was taken into account"
        doubts.append(f"the focal length is known to {sigma:.1%} only: {why}")
    if breathing:
        doubts.append(
            f"the focal length changes by {breathing:.1%} over the clip (autofocus breathing, or "
            "zoom); the camera is their mean: lock the focus for better"
        )
    if fitted.rms_px > _POOR_RMS_PX:
        doubts.append(
            f"the {basis} fit to {fitted.rms_px:.1f} px only: blurred images, a bent print, or "
            "something that moved or is not what it was taken for"
        )
    return tuple(doubts)
