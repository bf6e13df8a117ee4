"""Whether the camera that was stated fits what the images of the board show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorcade.replays.io.recording import Recording
from motorcade.tracking import (
    Board,
    BoardTrack,
    Camera,
    SelfCalibrationError,
)
from motorcade.tracking.audit import AuditFinding, centre_finding, said_camera
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import view_error_px
from motorcade.tracking.cameras.lens_choice import choose_lens, try_lenses
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.self_calibration.boards import board_sightings
from motorcade.tracking.self_calibration.bodies import spread_runs
from motorcade.tracking.self_calibration.choosing import as_kind, weighed_fit
from motorcade.tracking.self_calibration.fitting import fit
from motorcade.tracking.self_calibration.lens import KINDS

_VIEWS, _CALIBRATED = 90, 20
_TERMS = next(kind for kind in KINDS if kind.name == "radtan with k1 k2")
_FOCAL_SHARE = 0.02
"""A focal length wrong by so much puts a corner of the picture several pixels off."""
_SIGMAS = 3.0
_WORSE_PX, _TIMES = 0.2, 1.5


def audited_board(
    recording: Recording, board: Board, tracked: BoardTrack
) -> tuple[AuditFinding, ...]:
    """Compare the stated camera with the tracked board."""
    if recording.camera is None:
        return ()
    return (_camera(recording.camera, board, tracked, recording.focal_sigma),)


def _camera(camera: Camera, board: Board, tracked: BoardTrack, found_sigma: float) -> AuditFinding:
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
        focal * camera.unproject(sighted.corners_px)[:, :2] + 0.5 * np.array(size) - 0.5
        for sighted in some
    ]
    views = [
        (row, view)
        for row, (sighted, px) in enumerate(zip(some, flat, strict=True))
        if np.isfinite(px).all()
        and (view := BoardCorners(sighted.ids, px, board.points_m[sighted.ids])).spanning
    ]
    try:
        seen, start = board_sightings(
            views, np.array([sighted.time_ns for sighted in some]), size, focal
        )
        held = fit(seen, start, readout=True, lens=False)
        free = weighed_fit(seen, start, readout=True)
        bent = weighed_fit(seen, as_kind(free.fit.state, _TERMS), readout=True)
    except SelfCalibrationError as why:
        summary = f"the board's views do not tell the camera ({why})"
        return AuditFinding(name, "unknown", None, "share", summary)
    best_px = bent.fit.rms_px
    worse = held.rms_px > max(_TIMES * best_px, best_px + _WORSE_PX)
    best = bent if worse else free
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
        return AuditFinding(name, "contradicted", off, "share", summary, _mend(camera, board, some))
    return AuditFinding(name, "consistent", off, "share", summary)


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
