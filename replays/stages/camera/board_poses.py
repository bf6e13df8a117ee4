"""Stage `board_poses`: camera poses by a board in view.

If the board in the images looks unlike the one described, the log says so; nothing is corrected.
What is stated of a board's markers is compared with the images before anything is tracked.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence

import numpy as np

from motorcade.ga.lookahead import ahead
from motorcade.ga.progress import track
from motorcade.replays.engine.stage import NotOffered
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.board_audit import (
    audited_board,
    flatness_finding,
    pixels_finding,
)
from motorcade.replays.stages.camera.offered import camera_of, require_images, spread_frames
from motorcade.replays.stages.values.camera_poses import BoardPoses
from motorcade.tracking import (
    Board,
    BoardTrack,
    MarkerGrid,
    PoseMeasurements,
    SingleMarker,
    TrackingError,
    track_board,
)
from motorcade.tracking.audit import AuditFinding, scatter_px
from motorcade.tracking.board_tracking.flatness import bent_track
from motorcade.tracking.board_tracking.tracker import guessed_turns, with_least_noise
from motorcade.tracking.boards.circles import CircleGrid
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.images import corner_noise_px, print_noise_px
from motorcade.tracking.markers.families import border_share
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.rolling import unrolled_track, with_unsure_shutter
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


def _noise_px(
    board: Board, images: Sequence[GrayImage], seen: Sequence[MarkerObservation]
) -> float:
    """How far corners can scatter in images of a board, by noise and by what blur mixes."""
    if isinstance(board, CircleGrid):
        return corner_noise_px(images, [sighted.corners_px for sighted in seen])
    border = 1.0
    if marked := isinstance(board, MarkerGrid | SingleMarker):
        border = border_share(board.family)
    across = 4 if marked else int(np.count_nonzero(board.points_m[:, 1] == board.points_m[0, 1]))
    quads = []
    for sighted in seen:
        px = np.full((len(board.points_m), 2), np.nan)
        px[sighted.ids] = sighted.corners_px
        grid = px.reshape(-1, across, 2)
        sides = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
        quad = grid if marked else np.stack(sides, axis=2).reshape(-1, 4, 2)
        quads.append(quad[np.isfinite(quad).all(axis=(1, 2))])
    return print_noise_px(images, quads, border)[0]


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
    seen = [sighted for sighted in rolled.observations if sighted.time_ns in shown]
    noise_px = _noise_px(board, [shown[sighted.time_ns] for sighted in seen], seen)
    audit, off_s, unsure_s2 = audited_board(recording, board, tracked, noise_px)
    if off_s.any():
        tracked = unrolled_track(rolled, board, camera, shutter_s + off_s)
    limit_px = scatter_px(camera, noise_px)
    tracked, corners_m, shape = bent_track(tracked, board.points_m, camera)
    flatness = () if shape is None else (flatness_finding(shape, board, limit_px),)
    path = tracked.measurements.trajectory
    drawn = ((shown[at.time_ns], board, path.motors_at(np.int64(at.time_ns))) for at in seen)
    pixels = pixels_finding(drawn, camera, limit_px, corners_m)
    audit = (*audit, *flatness)
    warn_of_contradictions(audit)
    audit = (pixels, *before, *audit, *_guessed_turns(board, tracked))
    sure = with_least_noise(tracked, noise_px)
    on_board = with_unsure_shutter(sure, board, camera, unsure_s2).measurements
    in_world = on_board.trajectory.transformed_by(left=recording.world_T_board)
    return BoardPoses(
        PoseMeasurements(in_world, on_board.covariance),
        frames.time_ns,
        tracked.error_px,
        "board",
        f"tracked by the {board.name} in the images" + ("" if recording.metric else _SIZELESS),
        metric=recording.metric,
        audit=audit,
        seconds=time.perf_counter() - start,
        corner_px=noise_px,
        track=tracked,
        corners_m=corners_m,
    )
