"""Whether camera and shutter as described, and the poses, fit what images of the board show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from motorcade.fusion.metrics import most_by_chance
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking import Board, BoardTrack, Camera, SelfCalibrationError
from motorcade.tracking.audit import AuditFinding, Verdict, centre_finding, said_camera, scatter_px
from motorcade.tracking.board_tracking.flatness import PrintShape
from motorcade.tracking.board_tracking.witness import pixel_offsets
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import choose_lens, try_lenses, view_error_px
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.mapping.estimate import MappedRecording
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.self_calibration.boards import board_observations, tag_observations
from motorcade.tracking.self_calibration.bodies import READOUT_SIGMA_S, fit, spread_runs
from motorcade.tracking.self_calibration.choosing import ChosenFit, as_kind, weighed_fit
from motorcade.tracking.self_calibration.lens import KINDS, PINHOLE, start_numbers

_VIEWS, _CALIBRATED, _OUTLIERS = 90, 20, 0.1
_TERMS = next(kind for kind in KINDS if kind.name == "radtan with k1 k2")
_FOCAL_SHARE = 0.02
"""A focal length wrong by so much puts a corner of the image several pixels off."""
_SIGMAS, _SHUTTER_SIGMAS = 3.0, 4.0
_SEPARABLE = 0.1
"""Views that would not deny a focal length off by so much do not confirm one either."""
_SHUTTER_S = 0.002
"""A read-out that is off by less moves nobody's corner by what it can scatter."""
_WORSE_PX, _TIMES = 0.2, 1.5


def audited_board(
    recording: Recording, board: Board, tracked: BoardTrack, noise_px: float
) -> tuple[tuple[AuditFinding, ...], FloatArray, FloatArray]:
    """Compare the camera and its shutter with the tracked board.

    Args:
        recording: with its camera as stated.
        board: that was tracked.
        tracked: where.
        noise_px: how far corners can scatter, of which residuals may show less.

    Returns:
        the findings; by how much ``(2,)`` the shutter's read-out is off, as `Recording.shutter_s`,
        0 unless the images deny it; and the mean square ``(2, 2)`` of what then is left of it.
    """
    camera = camera_of(recording)
    of_camera, best = _camera(camera, board, tracked, recording.focal_sigma, noise_px)
    shutter, off_s, left_s2 = _readout(recording, best, "the board's views")
    return (of_camera, *shutter), off_s, left_s2


def audited_markers(
    recording: Recording, stream: CornerStream, mapped: MappedRecording, noise_px: float
) -> tuple[tuple[AuditFinding, ...], FloatArray, FloatArray]:
    """Compare the shutter with loose markers, as `audited_board` does with a board.

    Args:
        recording: with its camera as stated.
        stream: what it saw of markers.
        mapped: where these are, and where it was.
        noise_px: how far corners can scatter, of which residuals may show less.
    """
    camera, rows = stream.camera, np.unique(stream.frame)
    px = _flat(camera, stream.corners_px)
    some = np.isin(stream.frame, rows[spread_runs(len(rows), _VIEWS)])
    some &= np.isfinite(px).all(axis=(1, 2))
    size = camera.width, camera.height
    pinhole = PINHOLE.camera(start_numbers(_focal(camera), size), size)
    try:
        flat = replace(stream.where(some), camera=pinhole, corners_px=px[some])
        seen, start = tag_observations(flat, mapped)
        best = _alike_as(weighed_fit(seen, start, readout=True), noise_px)
    except SelfCalibrationError:
        best = None
    return _readout(recording, best, "the markers")


def _readout(
    recording: Recording, best: ChosenFit | None, seen: str
) -> tuple[tuple[AuditFinding, ...], FloatArray, FloatArray]:
    """The finding on the shutter, by how much it is off, and what then is left of it."""
    if best is None:
        return (), np.zeros(2), READOUT_SIGMA_S**2 * np.eye(2)
    lens, left_s = len(best.fit.state.numbers), best.fit.state.readout_s
    spread_s2 = best.covariance[lens : lens + 2, lens : lens + 2]
    stated_s, sigmas_s = recording.shutter_s, np.sqrt(np.diag(spread_s2))
    ratios = np.abs(left_s) / sigmas_s
    axis = int(np.argmax(ratios))
    off_s, sigma_s = left_s[axis] * np.eye(2)[axis], float(sigmas_s[axis])
    said_s = (stated_s + off_s)[axis]
    summary = (
        f"{seen} say {1e3 * said_s:.1f} ± {1e3 * sigma_s:.1f} ms "
        f"{('to the right', 'downwards')[axis]} where a read-out of {1e3 * stated_s[axis]:.1f} ms "
        "is stated"
    )
    figure = float(0.5 * ratios[axis] ** 2)
    verdict: Verdict = "consistent" if sigma_s < _SHUTTER_S else "unknown"
    if denied := ratios[axis] > _SHUTTER_SIGMAS and abs(left_s[axis]) > _SHUTTER_S:
        verdict = "contradicted"
    advice = "that was taken; state readout_s, and which way the camera was held"
    off_s = denied * off_s
    finding = AuditFinding("shutter", verdict, figure, "log ratio", summary, advice)
    return (finding,), off_s, spread_s2 + np.outer(left_s - off_s, left_s - off_s)


def pixels_finding(
    frames: Iterable[tuple[GrayImage, Board, Motor]],
    camera: Camera,
    limit_px: float,
    corners_m: FloatArray | None = None,
) -> AuditFinding:
    """How far what is drawn lies from the pixels, where no corner had a part in the pose.

    Args:
        frames: images, a print in each and its ``print_T_camera``.
        camera: whose images.
        limit_px: by how much a print may be off.
        corners_m: ``(n, 3)`` its corners, if it is not flat.
    """
    name = "pixels"
    offsets = [
        pixel_offsets(image, board, camera, pose, corners_m) for image, board, pose in frames
    ]
    off = np.array([np.sqrt(np.mean(np.sum(one**2, axis=-1))) for one in offsets if len(one)])
    if not len(off):
        summary = "no print lies open enough for what is drawn to be compared with its pixels"
        return AuditFinding(name, "unknown", None, "px", summary)
    beyond, allowed = int(np.count_nonzero(off > limit_px)), most_by_chance(len(off), _OUTLIERS)
    median = float(np.median(off))
    summary = (
        f"what is drawn lies {median:.2f} px off the pixels in the median of {len(off)} prints, "
        f"in {beyond} of them (up to {allowed} may) more than {limit_px:.2g} px"
    )
    verdict: Verdict = "consistent" if beyond <= allowed else "doubtful"
    advice = "look at the board or markers as stated, at the camera, and at what stands there twice"
    return AuditFinding(name, verdict, median, "px", summary, advice)


def flatness_finding(shape: PrintShape, board: Board, limit_px: float) -> AuditFinding:
    """Whether the print lies in a plane, which is what is taken of it; one that is bent is used so.

    Args:
        shape: of the tracked print.
        board: that was tracked.
        limit_px: how far corners may scatter.
    """
    name, share = "flatness", 100.0 * shape.height_m / max(board.size_m)
    if not shape.is_bent:
        summary = f"the print is flat, as far as views of {shape.flat_px:.2f} px RMS tell"
        return AuditFinding(name, "consistent", shape.flat_px, "px", summary)
    summary = (
        f"the print is not flat: from its lowest corner to its highest are {share:.1f} % of its "
        f"width, which explains views that had no part in that to {shape.bent_px:.2f} px RMS, a "
        f"plane to {shape.flat_px:.2f}; that was taken"
    )
    advice = "lay the print on something stiff and flat"
    verdict: Verdict = "contradicted" if shape.flat_px > limit_px else "consistent"
    return AuditFinding(name, verdict, shape.flat_px, "px", summary, advice)


def _camera(
    camera: Camera, board: Board, tracked: BoardTrack, found_sigma: float, noise_px: float
) -> tuple[AuditFinding, ChosenFit | None]:
    """The camera against what the same corners say, its own lens and read-out being taken.

    Corners are brought to where its focal length alone shows them; fitted with a free focal length,
    and with free terms, they say by how much they want both otherwise.

    Args:
        camera: that the board was tracked with.
        board: that was tracked.
        tracked: where.
        found_sigma: of the camera's focal length where it was found in these images, relative; 0
            where it was stated.
        noise_px: how far corners can scatter.
    """
    name, focal, size = "camera_on_board", _focal(camera), (camera.width, camera.height)
    some = [tracked.observations[row] for row in spread_runs(len(tracked.observations), _VIEWS)]
    views = [
        (row, view)
        for row, sighted in enumerate(some)
        if np.isfinite(px := _flat(camera, sighted.corners_px)).all()
        and (view := BoardCorners(sighted.ids, px, board.points_m[sighted.ids])).spanning
    ]
    try:
        seen, start = board_observations(
            views, np.array([sighted.time_ns for sighted in some]), size, focal
        )
        held = fit(seen, start, readout=True, lens=False)
        free = weighed_fit(seen, start, readout=True)
        bent = weighed_fit(seen, as_kind(free.fit.state, _TERMS), readout=True)
    except SelfCalibrationError as why:
        summary = f"the board's views do not tell the camera ({why})"
        return AuditFinding(name, "unknown", None, "share", summary), None
    best_px = bent.fit.rms_px
    worse = held.rms_px > max(_TIMES * best_px, best_px + _WORSE_PX)
    best = _alike_as(bent if worse else free, noise_px)
    ratio = float(best.fit.state.numbers[0]) / focal
    sigma = float(np.sqrt(best.covariance[0, 0])) / focal
    off = abs(ratio - 1.0)
    prior = f"{camera.fx:.1f} is stated"
    if found_sigma:
        prior = f"{camera.fx:.1f} ± {found_sigma * camera.fx:.1f} was found"
    summary = (
        f"the board's views say fx {ratio * camera.fx:.1f} ± {sigma * camera.fx:.1f} px where "
        f"{prior}, off by {off:.1%}; they fit to {best_px:.2f} px, {held.rms_px:.2f} as it is"
    )
    if (off > _FOCAL_SHARE and off > _SIGMAS * np.hypot(sigma, found_sigma)) or worse:
        advice = _mend(camera, board, some)
        return AuditFinding(name, "contradicted", off, "share", summary, advice), best
    conclusive = best_px <= scatter_px(camera) and _SIGMAS * sigma <= _SEPARABLE
    verdict: Verdict = "consistent" if conclusive else "unknown"
    return AuditFinding(name, verdict, off, "share", summary), best


def _focal(camera: Camera) -> float:
    return float(np.sqrt(camera.fx * camera.fy))


def _flat(camera: Camera, px: FloatArray) -> FloatArray:
    """Where a camera of the same focal length without distortion, in the middle, shows pixels."""
    middle = 0.5 * np.array([camera.width, camera.height]) - 0.5
    return np.asarray(_focal(camera) * camera.unproject(px)[..., :2] + middle)


def _alike_as(chosen: ChosenFit, noise_px: float) -> ChosenFit:
    """The fit, no surer than corners are that scatter so far."""
    return replace(chosen, alike=max(chosen.alike, noise_px / chosen.fit.sigma_px))


def _mend(camera: Camera, board: Board, seen: Sequence[MarkerObservation]) -> str:
    """The keys of the camera that the views bear, if it shows those held out better than stated."""
    unknown = "calibrate the camera, or state its focal length and distortion as they are"
    views = [
        BoardCorners(sighted.ids, sighted.corners_px, board.points_m[sighted.ids])
        for sighted in seen
    ]
    views = [view for view in views if view.spanning]
    views = views[:: -(-len(views) // _CALIBRATED) or 1]
    try:
        lens = choose_lens(try_lenses(views, (camera.width, camera.height)))
        stated_px = float(np.median([view_error_px(view, camera) for view in views]))
    except ValueError:
        return unknown
    if lens.calibration is None or centre_finding(camera) is not None:
        return unknown
    sure = lens.calibration.deviation[0] <= _FOCAL_SHARE * lens.calibration.camera.fx
    return (
        said_camera(lens.calibration.camera)
        if sure and _TIMES * lens.typical_px < stated_px
        else unknown
    )
