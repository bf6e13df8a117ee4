"""Stage `board_poses`: camera poses by a board in view.

If the board in the images looks unlike the one described, the log says so; nothing is corrected.
What is stated of a board's markers is compared with the images before anything is tracked.
"""

from __future__ import annotations

import logging
import time

import numpy as np

from motorcade.ga.lookahead import ahead
from motorcade.ga.progress import track
from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.board_audit import audited_board, pixels_finding
from motorcade.replays.stages.camera.offered import camera_of, require_images, spread_frames
from motorcade.replays.stages.values.camera_poses import BoardPoses
from motorcade.tracking import (
    Board,
    BoardTrack,
    PoseMeasurements,
    TrackingError,
    track_board,
)
from motorcade.tracking.audit import AuditFinding, scatter_px
from motorcade.tracking.board_tracking.tracker import guessed_turns
from motorcade.tracking.images import corner_noise_px
from motorcade.tracking.rolling import unrolled_track
from motorcade.tracking.targets.stated import compare_layout, name_target

log = logging.getLogger("motorcade.camera_poses")

_LARGEST_M = 5.0
_SIZELESS = ", whose size is not known: lengths have no unit"


def warn_of_size(board: Board) -> None:
    """Warn of a board so wide that its lengths were hardly meant as metres."""
    if max(board.size_m) > _LARGEST_M:
        width, height = board.size_m
        log.warning(
            "camera_poses: the board is %g x %g m large; are its lengths in metres?", width, height
        )


def warn_of_contradictions(audit: tuple[AuditFinding, ...]) -> None:
    """Warn of what the images contradict: poses from a wrong board or camera are wrong."""
    for finding in audit:
        if finding.verdict == "contradicted":
            log.warning("camera_poses: %s; %s", finding.summary, finding.advice)


def _guessed_turns(board: Board, tracked: BoardTrack) -> tuple[AuditFinding, ...]:
    """Doubt where a board that looks the same turned round was lost from sight between frames."""
    guessed = guessed_turns(board, tracked)
    if not guessed:
        return ()
    summary = (
        f"the board looks the same turned round, and jumps {guessed} times so far from one frame "
        "to the next that its turn is a guess"
    )
    advice = "give the frames in their order and at a higher rate, or print a board of odd by even"
    return (AuditFinding("board_turns", "doubtful", float(guessed), "frames", summary, advice),)


def board_poses(recording: Recording) -> BoardPoses:
    """Track the board that the recording names, through all its images.

    Raises:
        NotOffered: no camera, no images, or no board known.
        TrackingError: no frame shows the board.
    """
    camera = camera_of(recording)
    require_images(recording)
    board, frames = recording.board, recording.frames
    if board is None:
        raise NotOffered(f"{recording.name}: no board known; describe it in a manifest")
    if recording.metric:
        warn_of_size(board)
    start = time.perf_counter()
    shown = {frame.time_ns: frame.gray() for frame in spread_frames(recording)}
    sample = list(shown.values())
    layout = compare_layout(board, sample, camera)
    before = () if layout is None else (layout,)
    warn_of_contradictions(before)
    images = ahead(
        lambda frame: (frame.time_ns, frame.gray()), track(frames, "tracking", len(frames))
    )
    try:
        tracked = track_board(images, camera, board)
    except TrackingError as fault:
        reasons = [finding.sentence for finding in before if not finding.passed] or [
            name_target(sample, board)
        ]
        raise TrackingError("; ".join([str(fault), *filter(None, reasons)])) from fault
    rolled, shutter_s = tracked, recording.shutter_s
    if recording.readout_s:
        tracked = unrolled_track(rolled, board, camera, shutter_s)
    audit, off_s = audited_board(recording, board, tracked)
    if off_s is not None:
        tracked = unrolled_track(rolled, board, camera, shutter_s + off_s)
    seen = {sighted.time_ns: sighted for sighted in rolled.observations if sighted.time_ns in shown}
    noise_px = corner_noise_px(
        [shown[stamp] for stamp in seen], [sighted.corners_px for sighted in seen.values()]
    )
    path = tracked.measurements.trajectory
    drawn = ((shown[stamp], board, path.motors_at(np.int64(stamp))) for stamp in seen)
    pixels = pixels_finding(drawn, camera, scatter_px(camera, noise_px))
    seconds = time.perf_counter() - start
    warn_of_contradictions(audit)
    audit = (pixels, *before, *audit, *_guessed_turns(board, tracked))
    on_board = tracked.measurements
    in_world = on_board.trajectory.transformed_by(left=recording.world_T_board)
    return BoardPoses(
        PoseMeasurements(in_world, on_board.covariance),
        frames.time_ns,
        tracked.error_px,
        "board",
        f"tracked by the {board.name} in the images" + ("" if recording.metric else _SIZELESS),
        metric=recording.metric,
        audit=audit,
        seconds=seconds,
        corner_px=noise_px,
        track=tracked,
    )
