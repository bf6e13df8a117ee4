"""A board tracked through a whole recording.

The board frame is called ``world``; poses are ``world_T_camera``.

What is drawn along a path moves against the footage by as much as the board's corners are off
where the path puts them: `registration_px` is the jitter and drift that a viewer sees.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.board_tracking.tracker import BoardFrame, BoardTracker
from motorcade.tracking.boards import Board, GrayImage
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.measurements import MarkerObservation, PoseMeasurements
from motorcade.tracking.pose import SIGMA_FLOOR_PX, TrackingError

FRAME_STATES = ("lost", "detected", "tracked")
_POOLED = 10


@dataclass(frozen=True, eq=False)
class BoardTrack:
    """What became of every frame, and what was measured in the frames that show the board.

    Args:
        time_ns: ``(F,)`` stamps of all frames, rising.
        states: ``(F,)`` text, each one of `FRAME_STATES`.
        observations: one for each of the N frames that are not lost, in order: corners, both
            planar candidates and their errors.
        measurements: N refined poses with covariances.
        error_px: ``(N,)`` root mean square reprojection errors of the refined poses.

    Raises:
        ValueError: lengths or stamps that do not agree, or an unknown state.

    >>> from motorcade.tracking import Camera, SingleMarker, track_board
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> blank = image * 0 + 255
    >>> track = track_board([(0, image), (33_000_000, blank)], camera, board)
    >>> len(track), track.count("lost"), len(track.observations)
    (2, 1, 1)
    >>> world_T_camera = track.measurements.trajectory.motors  # the board's frame is the world
    >>> world_T_camera.translation_m[:, 2].round(2)
    array([0.2])
    """

    time_ns: IntArray
    states: NDArray[np.str_]
    observations: tuple[MarkerObservation, ...]
    measurements: PoseMeasurements
    error_px: FloatArray

    def __post_init__(self) -> None:
        stamps, states = np.array(self.time_ns, np.int64), np.array(self.states, np.str_)
        if states.shape != stamps.shape or stamps.ndim != 1:
            raise ValueError(f"BoardTrack.states: expected {stamps.shape}, got {states.shape}")
        if not np.isin(states, FRAME_STATES).all():
            raise ValueError(f"BoardTrack.states: expected {', '.join(FRAME_STATES)} only")
        errors = frozen(checked_floats(self.error_px, "BoardTrack.error_px", ()))
        seen = stamps[states != "lost"]
        observed = np.array([observation.time_ns for observation in self.observations], np.int64)
        for name, stamps_ns in (
            ("observations", observed),
            ("measurements", self.measurements.trajectory.time_ns),
        ):
            if not np.array_equal(stamps_ns, seen):
                raise ValueError(
                    f"BoardTrack.{name}: expected the {len(seen)} stamps that are not lost, "
                    f"got {len(stamps_ns)}"
                )
        if errors.shape != seen.shape:
            raise ValueError(f"BoardTrack.error_px: expected {seen.shape}, got {errors.shape}")
        for array in (stamps, states):
            array.setflags(write=False)
        object.__setattr__(self, "time_ns", stamps)
        object.__setattr__(self, "states", states)
        object.__setattr__(self, "error_px", errors)

    def __len__(self) -> int:
        """Number of all frames."""
        return len(self.time_ns)

    def count(self, state: str) -> int:
        """How many frames are in one of the `FRAME_STATES`."""
        return int(np.count_nonzero(self.states == state))


def track_board(
    frames: Iterable[tuple[int, GrayImage]],
    camera: Camera,
    board: Board,
) -> BoardTrack:
    """Track a board through a recording.

    Args:
        frames: stamps in nanoseconds, strictly increasing, and grey uint8 images of the
            camera's size; read one by one.
        camera: the camera that took them.
        board: the board to look for.

    Returns:
        the track; frames without the board are "lost" and have no measurement.

    Raises:
        TrackingError: no frames, or none in which the board is seen.
        ValueError: images or stamps that `BoardTracker.update` refuses.

    >>> from motorcade.tracking import Camera, SingleMarker, track_board
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> frames = [(0, image), (33_000_000, image * 0 + 255), (66_000_000, image)]
    >>> track = track_board(frames, camera, board)
    >>> track.states.tolist(), len(track.measurements)
    (['detected', 'lost', 'detected'], 2)
    """
    tracker = BoardTracker(camera, board)
    stamps: list[int] = []
    tracked: list[BoardFrame | None] = []
    for time_ns, image in frames:
        tracked.append(tracker.update(image, time_ns))
        stamps.append(int(time_ns))
    seen = [frame for frame in tracked if frame is not None]
    if not seen:
        raise TrackingError(
            f"frames: expected some that show {board.name}, got it in none of {len(stamps)}"
        )
    states = ["lost" if frame is None else frame.state for frame in tracked]
    return with_pooled_noise(_collected(stamps, states, seen))


def _collected(stamps: list[int], states: list[str], seen: list[BoardFrame]) -> BoardTrack:
    trajectory = Trajectory(
        np.array([frame.observation.time_ns for frame in seen], np.int64),
        Motor.stack([frame.world_T_camera for frame in seen]),
    )
    return BoardTrack(
        time_ns=np.array(stamps, np.int64),
        states=np.array(states),
        observations=tuple(frame.observation for frame in seen),
        measurements=PoseMeasurements(trajectory, np.stack([frame.covariance for frame in seen])),
        error_px=np.array([frame.error_px for frame in seen]),
    )


def with_pooled_noise(board_track: BoardTrack) -> BoardTrack:
    """The track with covariances for a noise of corners that its frames tell together.

    Four corners leave two residuals beyond a pose, which by chance are ten times too small in one
    frame of a hundred. So each frame's own noise is joined with the recording's, which counts as
    much as `_POOLED` residuals (the mean of an inverse gamma distribution, as conjugate priors of a
    variance have it); where a board has many corners, it is the frame's own.

    Args:
        board_track: with covariances as `refine` gives them.
    """
    count = np.array([len(observation.ids) for observation in board_track.observations])
    squares, freedom = count * board_track.error_px**2, np.maximum(2 * count - 6, 1)
    usual = float(squares.sum() / freedom.sum())
    least = SIGMA_FLOOR_PX**2
    own = np.maximum(squares / freedom, least)
    joined = np.maximum((squares + _POOLED * usual) / (freedom + _POOLED), least)
    measured = board_track.measurements
    covariance = measured.covariance * (joined / own)[:, None, None]
    return replace(board_track, measurements=PoseMeasurements(measured.trajectory, covariance))


def guessed_turns(board: Board, board_track: BoardTrack) -> int:
    """In how many frames a board that looks the same turned jumps so far that either turn fits.

    Its numbering is the one whose corners lie nearest to where they were; that tells nothing where
    another one's lie less than twice as far. Always 0 for boards that look the same one way alone.
    """
    shown = board_track.observations
    if len(board.turns) == 1:
        return 0
    whole = np.full((len(shown), len(board.points_m), 2), np.nan)
    for row, observation in enumerate(shown):
        whole[row, observation.ids] = observation.corners_px
    steps = [np.linalg.norm(whole[1:, turn] - whole[:-1], axis=-1) for turn in board.turns]
    both = np.isfinite(steps).all(axis=0)
    apart = [np.where(both, step, 0.0).sum(axis=-1) for step in steps]
    return int(np.count_nonzero(2.0 * apart[0] > np.min(apart[1:], axis=0)))


def registration_px(
    path: Trajectory, board_track: BoardTrack, board: Board, camera: Camera, world_T_board: Motor
) -> FloatArray:
    """Root mean square distance between projected and found corners, a frame.

    Args:
        path: ``world_T_camera``; frames outside its span are left out.
        board_track: the corners found in each of the N frames that show the board.
        board: what they belong to.
        camera: who saw them, with its distortion.
        world_T_board: where the board is.

    Returns:
        ``(M,)`` pixels, M at most N; corners that fall behind the camera make a frame NaN.

    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera, SingleMarker, registration_px, track_board
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> track = track_board([(0, image), (33_000_000, image)], camera, board)
    >>> path = track.measurements.trajectory  # the board's frame is the world
    >>> errors_px = registration_px(path, track, board, camera, world_T_board=Motor.identity())
    >>> bool(errors_px.max() < 0.2)
    True
    """
    errors_px = []
    for seen in board_track.observations:
        if not path.time_ns[0] <= seen.time_ns <= path.time_ns[-1]:
            continue
        camera_T_board = path.motors_at(np.int64(seen.time_ns)).inverse() @ world_T_board
        expected = camera.project(camera_T_board.apply(board.points_m[seen.ids]))
        errors_px.append(np.sqrt(np.mean(np.sum((expected - seen.corners_px) ** 2, axis=-1))))
    return np.array(errors_px, dtype=np.float64)
