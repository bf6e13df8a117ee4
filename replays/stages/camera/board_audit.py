"""Whether board, camera and shutter as described, and poses, fit what images of the board show."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

import numpy as np

from motorcade.fusion.metrics import most_by_chance
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.recording import Recording
from motorcade.tracking import Board, BoardTrack, Camera, Checkerboard, SelfCalibrationError
from motorcade.tracking.audit import AuditFinding, Verdict
from motorcade.tracking.board_tracking.witness import pixel_offsets
from motorcade.tracking.boards.checkerboard import extent_in_picture, extent_seen
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.self_calibration.boards import board_sightings
from motorcade.tracking.self_calibration.bodies import spread_runs
from motorcade.tracking.self_calibration.choosing import ChosenFit, as_kind, weighed_fit
from motorcade.tracking.self_calibration.fitting import fit
from motorcade.tracking.self_calibration.lens import KINDS

_PICTURES, _OUTLIERS = 3, 0.1
_VIEWS = 90
_TERMS = next(kind for kind in KINDS if kind.name == "radtan with k1 k2")
_FOCAL_SHARE = 0.02
"""A focal length wrong by so much puts a corner of the picture several pixels off."""
_SIGMAS, _SHUTTER_SIGMAS = 3.0, 4.0
_SHUTTER_S = 0.002
"""A read-out that is off by less moves nobody's corner by what it can scatter."""
_WORSE_PX, _TIMES = 0.2, 1.5


def audited_board(
    recording: Recording, board: Board, tracked: BoardTrack
) -> tuple[tuple[AuditFinding, ...], FloatArray | None]:
    """Compare the board's described corners, the camera and its shutter with the tracked board.

    Returns:
        the findings; and by how much ``(2,)`` the shutter's read-out is off, as
        `Recording.shutter_s`, where the images deny it.
    """
    findings, off_s = [], None
    if isinstance(board, Checkerboard):
        findings.append(_extent(recording, board, tracked))
    if recording.camera is not None:
        camera = recording.camera
        found, best = _camera(camera, board, tracked, recording.focal_sigma)
        findings.append(found)
        if best is not None:
            shutter, off_s = _shutter(recording, best)
            findings.append(shutter)
    return tuple(findings), off_s


def _shutter(recording: Recording, best: ChosenFit) -> tuple[AuditFinding, FloatArray | None]:
    """The shutter's read-out, stated or none, against what the views say is left of it."""
    name, state = "shutter", best.fit.state
    sigmas = np.sqrt(np.diag(best.covariance)[len(state.numbers) :][:2])
    ratios = np.abs(state.readout_s) / sigmas
    axis = int(np.argmax(ratios))
    left_s, sigma_s = float(state.readout_s[axis]), float(sigmas[axis])
    stated_s = recording.shutter_s
    said = f"a read-out of {1e3 * stated_s[axis]:.1f} ms is stated"
    summary = (
        f"the board's views say {1e3 * (stated_s[axis] + left_s):.1f} ± {1e3 * sigma_s:.1f} ms "
        f"{('to the right', 'downwards')[axis]} where {said}"
    )
    figure = float(0.5 * ratios[axis] ** 2)
    if ratios[axis] > _SHUTTER_SIGMAS and abs(left_s) > _SHUTTER_S:
        advice = "that was taken; state readout_s, and which way the camera was held"
        off_s = left_s * np.eye(2)[axis]
        return AuditFinding(name, "contradicted", figure, "log ratio", summary, advice), off_s
    verdict: Verdict = "consistent" if sigma_s < _SHUTTER_S else "unknown"
    return AuditFinding(name, verdict, figure, "log ratio", summary), None


def pixels_finding(
    frames: Iterable[tuple[GrayImage, Board, Motor]], camera: Camera, limit_px: float
) -> AuditFinding:
    """How far what is drawn lies from the pixels, where no corner had a part in the pose.

    Args:
        frames: images, a print in each and its ``print_T_camera``.
        camera: whose images.
        limit_px: by how much a print may be off.
    """
    name = "pixels"
    offsets = [pixel_offsets(image, board, camera, pose) for image, board, pose in frames]
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


def _board_looks(recording: Recording, board: Checkerboard, tracked: BoardTrack) -> tuple[int, int]:
    """Columns and rows of inner corners that a checkerboard is seen to have.

    Fewer than described by what was tracked, more by the first three pictures that show it whole.
    """
    whole = [one for one in tracked.observations if len(one.ids) == len(board.points_m)]
    if not whole:
        return extent_seen(board, tracked.observations)
    corners = {one.time_ns: one.corners_px for one in whole[:_PICTURES]}
    shown = (frame for frame in recording.frames if frame.time_ns in corners)
    extents = [
        extent_in_picture(board, frame.gray(), corners[frame.time_ns])
        for frame in islice(shown, len(corners))
    ]
    return max((columns for columns, _ in extents)), max((rows for _, rows in extents))


def _extent(recording: Recording, board: Checkerboard, tracked: BoardTrack) -> AuditFinding:
    looks, described = _board_looks(recording, board, tracked), (board.columns, board.rows)
    off = float(max(abs(looks[0] - described[0]), abs(looks[1] - described[1])))
    seen = "the board looks like {} x {} inner corners".format(*looks)
    if looks == described:
        return AuditFinding("board_corners", "consistent", off, "corners", f"{seen}, as described")
    summary = "{}, not {} x {} as described".format(seen, *described)
    advice = "describe the board that is seen: poses from a wrong board are wrong"
    return AuditFinding("board_corners", "contradicted", off, "corners", summary, advice)


def _camera(
    camera: Camera, board: Board, tracked: BoardTrack, found_sigma: float
) -> tuple[AuditFinding, ChosenFit | None]:
    """The camera against what the same corners say, its own lens and read-out being taken.

    Corners are brought to where its focal length alone shows them; fitted with a free focal length,
    and with free terms, they say by how much they want both otherwise.

    Args:
        camera: that the board was tracked with.
        board: that was tracked.
        tracked: where.
        found_sigma: of the camera's focal length where it was found in these pictures, relative; 0
            where it was stated.
    """
    name, focal = "camera_on_board", float(np.sqrt(camera.fx * camera.fy))
    size = camera.width, camera.height
    some = [tracked.observations[row] for row in spread_runs(len(tracked.observations), _VIEWS)]
    flat = [
        focal * camera.unproject(one.corners_px)[:, :2] + 0.5 * np.array(size) - 0.5 for one in some
    ]
    views = [
        (row, view)
        for row, (one, px) in enumerate(zip(some, flat, strict=True))
        if np.isfinite(px).all()
        and (view := BoardCorners(one.ids, px, board.points_m[one.ids])).spanning
    ]
    try:
        seen, start = board_sightings(views, np.array([one.time_ns for one in some]), size, focal)
        held = fit(seen, start, readout=True, lens=False)
        free = weighed_fit(seen, start, readout=True)
        bent = weighed_fit(seen, as_kind(free.fit.state, _TERMS), readout=True)
    except SelfCalibrationError as why:
        summary = f"the board's views do not tell the camera ({why})"
        return AuditFinding(name, "unknown", None, "share", summary), None
    best_px = bent.fit.rms_px
    worse = held.rms_px > max(_TIMES * best_px, best_px + _WORSE_PX)
    best = bent if worse else free
    ratio = float(best.fit.state.numbers[0]) / focal
    sigma = float(np.sqrt(best.covariance[0, 0])) / focal
    off = abs(ratio - 1.0)
    stated = f"{camera.fx:.1f} is stated"
    if found_sigma:
        stated = f"{camera.fx:.1f} ± {found_sigma * camera.fx:.1f} was found"
    summary = (
        f"the board's views say fx {ratio * camera.fx:.1f} ± {sigma * camera.fx:.1f} px where "
        f"{stated}, off by {off:.1%}; they fit to {best_px:.2f} px, {held.rms_px:.2f} as it is"
    )
    if (off > _FOCAL_SHARE and off > _SIGMAS * np.hypot(sigma, found_sigma)) or worse:
        advice = "calibrate the camera, or state its focal length and distortion as they are"
        return AuditFinding(name, "contradicted", off, "share", summary, advice), best
    return AuditFinding(name, "consistent", off, "share", summary), best
