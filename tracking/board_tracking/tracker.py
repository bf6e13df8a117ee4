"""Tracking a board through a recording: detect once, track cheaply, detect again when in doubt.

The board frame is called ``world``; poses are ``world_T_camera``. A frame is ``detected`` where the
whole image was searched, ``tracked`` where the corners came from the frame before, ``lost``
where no pose was found. No random numbers: the same images give the same bytes.

`BoardTracker` reads from `update` downward: `_located` tracks or detects corners, `_solved` fits a
pose to them without outliers (`inliers`), and `choose_pose` decides which of the two poses that a
flat board allows is the true one. That choice is a shortest path (Viterbi 1967), computed online:
each candidate costs what its pixels say against it, and each step costs the rotation between the
frames. So clear images decide for the unclear ones after them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.boards import Board, BoardCorners, GrayImage
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import check_count, checked_gray
from motorcade.tracking.images import track_corners
from motorcade.tracking.measurements import MarkerObservation, PoseMeasurements
from motorcade.tracking.pose import (
    SIGMA_FLOOR_PX,
    PlanarCandidates,
    RefinedPose,
    TrackingError,
    planar_candidates,
    refine,
)

# Corner noise per coordinate, and how fast a hand-held camera rotates. Both only decide between
# candidates that the pixels hardly separate.
_SIGMA_PX = 0.2
_TURN_RAD_S = np.radians(150.0)
# Most that a step may cost, and the evidence from which on pixels alone decide; log likelihoods.
_WORST_STEP = 20.0
_CLEAR = 200.0

# How long an earlier pose still helps to choose between candidates and numberings.
_CONTINUITY_NS = 500_000_000
# Search the whole image again, at most every so many frames, where less than this share of the
# corners of the last search is left; or at once where the error is above both limits.
_RETRY_FRAMES = 5
_GOOD_SHARE = 0.75
# What keeps fewer corners from one frame to the next is no board, but what happens to look so.
_LEAST_SHARE = 0.5
_GOOD_ERROR_PX = 1.0
_WORSE_FACTOR = 2.0
# An outlier lies this far off, and this many times the median error; RANSAC allows more.
_OUTLIER_PX = 0.5
_OUTLIER_FACTOR = 5.0
_RANSAC_PX = 1.5
# How far from its expected place a corner that was missed may be found.
_NEAR_PX = 1.0


@dataclass(frozen=True, eq=False)
class PoseChoice:
    """The chosen pose, and what the next image needs to know of both.

    Args:
        pose: the chosen candidate, refined on all corners.
        candidates: Motor ``(2,)``, both ``world_T_camera``, the better reprojection first.
        costs: ``(2,)`` of the cheapest paths that end in them (negative log likelihoods).
    """

    pose: RefinedPose
    candidates: Motor
    costs: FloatArray


def choose_pose(
    candidates: PlanarCandidates,
    corners: BoardCorners,
    camera: Camera,
    before: PoseChoice | None = None,
    elapsed_s: float = 0.0,
) -> PoseChoice:
    """Choose between the two planar poses and refine the chosen one.

    Args:
        candidates: both planar poses of these corners.
        corners: what was seen.
        camera: what it was seen with.
        before: the choice in an earlier image of the same board; without one the smaller
            reprojection error decides, and for small or distant boards it may be wrong.
        elapsed_s: seconds since then, above zero where `before` is given.

    Raises:
        ValueError: an elapsed time that is not above zero.
        TrackingError: a candidate that cannot be refined.
    """
    if before is not None and not elapsed_s > 0.0:
        raise ValueError(f"elapsed_s: expected seconds above 0, got {elapsed_s}")
    poses = [refine(corners, camera, candidates.world_T_camera[0])]
    second, error_px = candidates.world_T_camera[1], float(candidates.error_px[1])
    if _evidence(poses[0].error_px, error_px, len(corners)) < _CLEAR:
        poses.append(refine(corners, camera, second))
        poses.sort(key=lambda pose: pose.error_px)
        second, error_px = poses[1].world_T_camera, poses[1].error_px
    both = Motor.stack([poses[0].world_T_camera, second])
    costs = np.array([0.0, min(_evidence(poses[0].error_px, error_px, len(corners)), _CLEAR)])
    if before is not None:
        turns = (before.candidates[:, None].inverse() @ both[None, :]).rotor.angle()
        steps = np.minimum(0.5 * (turns / (_TURN_RAD_S * elapsed_s)) ** 2, _WORST_STEP)
        costs = costs + (before.costs[:, None] + steps).min(axis=0)
        costs = costs - costs.min()
    chosen = int(np.argmin(costs))
    pose = poses[chosen] if chosen < len(poses) else refine(corners, camera, second)
    return PoseChoice(pose, both, costs)


def inliers(corners: BoardCorners, camera: Camera, limit_px: float) -> BoardCorners:
    """The largest set of corners that one homography explains to `limit_px`, found by RANSAC.

    OpenCV seeds its search with a constant, so the answer is always the same.

    Raises:
        TrackingError: no homography at all.
    """
    straight = camera.undistort(corners.corners_px)
    corners = corners.keep(np.isfinite(straight[:, 0]))  # a plane shows nothing from 90 degrees on
    straight = straight[np.isfinite(straight[:, 0])]
    if len(corners) < 4:
        raise TrackingError("corners: expected four that one pose explains, got none")
    homography, mask = cv2.findHomography(
        corners.points_m[:, :2], straight, cv2.RANSAC, limit_px, maxIters=500, confidence=0.999
    )
    if homography is None:
        raise TrackingError("corners: expected four that one pose explains, got none")
    return corners.keep(mask.ravel() == 1)


def _evidence(better_px: float, worse_px: float, count: int) -> float:
    """Log likelihood ratio of two poses for root mean square errors over `count` corners."""
    return float(count * (worse_px**2 - better_px**2) / (2.0 * _SIGMA_PX**2))


@dataclass(frozen=True, eq=False)
class BoardFrame:
    """One frame in which the board was seen.

    Args:
        observation: corners and both planar candidates.
        world_T_camera: the chosen candidate, refined on all corners.
        covariance: ``(6, 6)``, see `pose`.
        error_px: root mean square reprojection error of the refined pose.
        state: how the corners were found.
    """

    observation: MarkerObservation
    world_T_camera: Motor
    covariance: FloatArray
    error_px: float
    state: Literal["detected", "tracked"]


@dataclass(frozen=True, eq=False)
class _Fit:
    corners: BoardCorners
    candidates: PlanarCandidates
    choice: PoseChoice

    @property
    def pose(self) -> RefinedPose:
        return self.choice.pose


class BoardTracker:
    """Tracks one board through images that arrive in order of time.

    Args:
        camera: the camera that took the images.
        board: the board to look for.
        redetect_every: frames after which the whole image is searched even if all is well.

    Raises:
        ValueError: a `redetect_every` below 1.

    >>> import numpy as np
    >>> from motorcade.tracking import BoardTracker, Camera, SingleMarker
    >>> board = SingleMarker("tag36h11", 7, side_m=0.1)
    >>> image, _ = board.draw(pixels_per_m=1000.0)
    >>> camera = Camera(image.shape[1], image.shape[0], 200.0, 200.0, 69.5, 69.5)
    >>> tracker = BoardTracker(camera, board)
    >>> frames = [tracker.update(image, time_ns) for time_ns in (0, 33_000_000)]
    >>> [frame.state for frame in frames]
    ['detected', 'tracked']
    >>> frames[1].world_T_camera.translation_m[2].round(2)  # before the printed face
    np.float64(0.2)
    """

    def __init__(self, camera: Camera, board: Board, *, redetect_every: int = 30) -> None:
        check_count(redetect_every, "BoardTracker.redetect_every", 1)
        self.camera = camera
        self.board = board
        self.redetect_every = redetect_every
        self._time_ns = 0
        self._started = False
        self._image: GrayImage | None = None  # of the frame before, if the board was seen there
        self._fit: _Fit | None = None  # of the last frame in which the board was seen
        self._fit_ns = 0
        self._since_search = 0
        self._search_count = 0
        self._search_error_px = 0.0

    def update(self, image: GrayImage, time_ns: int) -> BoardFrame | None:
        """Take the next image; None where the board is not seen in it.

        Args:
            image: ``(height, width)`` uint8 grey, of the camera's size.
            time_ns: its stamp, later than that of the image before.

        Raises:
            ValueError: another type or size of image, or a stamp that is not later.
        """
        self._check(image, time_ns)
        self._time_ns, self._started = int(time_ns), True
        if self._fit is not None and self._time_ns - self._fit_ns > _CONTINUITY_NS:
            self._fit = self._image = None
        fit, state = self._located(image)
        self._image = None if fit is None else image.copy()
        if fit is None:
            return None
        self._fit, self._fit_ns = fit, self._time_ns
        return BoardFrame(
            observation=MarkerObservation(
                time_ns=self._time_ns,
                ids=fit.corners.ids,
                corners_px=fit.corners.corners_px,
                candidates=fit.candidates.world_T_camera,
                candidate_error_px=fit.candidates.error_px,
            ),
            world_T_camera=fit.pose.world_T_camera,
            covariance=fit.pose.covariance,
            error_px=fit.pose.error_px,
            state=state,
        )

    def _check(self, image: GrayImage, time_ns: int) -> None:
        size = (self.camera.height, self.camera.width)
        if checked_gray(image).shape != size:
            raise ValueError(
                f"image: expected {size[1]} x {size[0]} pixels as the camera has, "
                f"got {image.shape[1]} x {image.shape[0]}"
            )
        if isinstance(time_ns, bool) or not isinstance(time_ns, (int, np.integer)):
            raise ValueError(f"time_ns: expected whole nanoseconds, got {time_ns!r}")
        if self._started and time_ns <= self._time_ns:
            raise ValueError(f"time_ns: expected more than {self._time_ns}, got {time_ns}")

    # Where the board is ------------------------------------------------------------------------

    def _located(self, image: GrayImage) -> tuple[_Fit | None, Literal["detected", "tracked"]]:
        """Track the board, search for it where that fails or is due, and keep the better."""
        tracked = self._tracked(image)
        worst_px = max(_GOOD_ERROR_PX, _WORSE_FACTOR * self._search_error_px)
        if tracked is not None and tracked.pose.error_px > worst_px:
            tracked = None
        self._since_search += 1
        if tracked is not None and not self._search_due(tracked):
            return tracked, "tracked"
        detected = self._detected(image)
        self._since_search = 0
        if tracked is not None and self._left_share(tracked) < _LEAST_SHARE:
            tracked = None
        if tracked is not None and (
            detected is None or len(detected.corners) < len(tracked.corners)
        ):
            return tracked, "tracked"
        if detected is not None:
            self._search_count, self._search_error_px = (
                len(detected.corners),
                detected.pose.error_px,
            )
        return detected, "detected"

    def _search_due(self, tracked: _Fit) -> bool:
        if self._since_search >= self.redetect_every or self._left_share(tracked) < _GOOD_SHARE:
            return True
        few = len(tracked.corners) < _GOOD_SHARE * self._search_count
        return few and self._since_search >= _RETRY_FRAMES

    def _left_share(self, tracked: _Fit) -> float:
        """How many corners are left of those in the frame before."""
        return len(tracked.corners) / len(self._fit.corners) if self._fit else 1.0

    def _detected(self, image: GrayImage) -> _Fit | None:
        corners = self.board.detect(image, self.camera)
        if corners is None:
            return None
        if self._fit is not None:
            expected = self._expected_px(self._fit.pose.world_T_camera)
            if np.isfinite(expected).all():
                corners = self.board.aligned(corners, expected)
        return self._completed(image, self._solved(corners))

    def _tracked(self, image: GrayImage) -> _Fit | None:
        if self._image is None or self._fit is None:
            return None
        before = self._fit.corners
        px, kept = track_corners(
            self._image, image, before.corners_px, before.corners_px, return_px=1.0, border_px=0.0
        )
        corners = before.at(np.where(kept[:, None], px, before.corners_px)).keep(kept)
        if not corners.spanning:
            return None
        fit = self._completed(
            image, self._solved(self.board.refine_corners(image, corners, self.camera))
        )
        if fit is None:
            return None
        camera_T_world = fit.pose.world_T_camera.inverse()
        project = lambda points: self.camera.project(camera_T_world.apply(points))  # noqa: E731
        return fit if self.board.confirms(image, fit.corners, project) else None

    def _completed(self, image: GrayImage, fit: _Fit | None) -> _Fit | None:
        """The fit with corners that were missed, refined from where the pose expects them."""
        if fit is None or len(fit.corners) == len(self.board.points_m):
            return fit
        expected_px = self._expected_px(fit.pose.world_T_camera)
        limit = (self.camera.width - 1, self.camera.height - 1)
        seen = np.all((expected_px >= 0.0) & (expected_px <= limit), axis=-1)
        seen[fit.corners.ids] = True
        if np.count_nonzero(seen) == len(fit.corners):
            return fit
        expected_px[fit.corners.ids] = fit.corners.corners_px
        ids = np.flatnonzero(seen)
        tried = BoardCorners(ids, expected_px[ids], self.board.points_m[ids])
        refined = self.board.refine_corners(image, tried, self.camera)
        shift_px = np.linalg.norm(refined.corners_px - expected_px[refined.ids], axis=-1)
        near = refined.keep(shift_px <= max(_NEAR_PX, _OUTLIER_FACTOR * fit.pose.error_px))
        return (self._solved(near) or fit) if len(near) > len(fit.corners) else fit

    def _expected_px(self, world_T_camera: Motor) -> FloatArray:
        return self.camera.project(world_T_camera.inverse().apply(self.board.points_m))

    # The pose ----------------------------------------------------------------------------------

    def _solved(self, corners: BoardCorners) -> _Fit | None:
        """Pose of the corners, without outliers; None where no pose follows from them."""
        corners = corners.keep(np.isfinite(self.camera.bearings(corners.corners_px)[:, 0]))
        if not corners.spanning:
            return None
        try:
            fit = self._posed(corners)
            errors = self._errors_px(corners, fit)
            limit = _outlier_px(errors)
            if len(corners) == 4 or not np.any(errors > limit):
                return fit
            explained = inliers(corners, self.camera, max(limit, _RANSAC_PX))
            errors = self._errors_px(corners, self._posed(explained))
            return self._posed(corners.keep(errors <= _outlier_px(errors)))
        except TrackingError:
            return None

    def _errors_px(self, corners: BoardCorners, fit: _Fit) -> FloatArray:
        """Distance ``(n,)`` of each corner from where the fitted pose has it."""
        expected = self._expected_px(fit.pose.world_T_camera)[corners.ids]
        errors: FloatArray = np.linalg.norm(corners.corners_px - expected, axis=-1)
        return np.nan_to_num(errors, nan=np.inf)

    def _posed(self, corners: BoardCorners) -> _Fit:
        candidates = planar_candidates(corners, self.camera)
        if self._fit is None:
            return _Fit(corners, candidates, choose_pose(candidates, corners, self.camera))
        elapsed_s = 1e-9 * (self._time_ns - self._fit_ns)
        before = self._fit.choice
        choice = choose_pose(candidates, corners, self.camera, before, elapsed_s)
        return _Fit(corners, candidates, choice)


def _outlier_px(errors_px: FloatArray) -> float:
    """Beyond this distance from its reprojection a corner is an outlier."""
    return max(_OUTLIER_PX, _OUTLIER_FACTOR * float(np.median(errors_px)))


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
    own, joined = _noise_px2(board_track)
    measured = board_track.measurements
    covariance = measured.covariance * (joined / own)[:, None, None]
    return replace(board_track, measurements=PoseMeasurements(measured.trajectory, covariance))


def with_least_noise(board_track: BoardTrack, least_px: float) -> BoardTrack:
    """The track with covariances for corners that scatter at least so far, residuals or not.

    A pose follows what moves all corners of a print alike, as blur does: nothing of that is left.

    Args:
        board_track: with pooled noise.
        least_px: standard deviation of a corner's coordinate.
    """
    measured, (_, joined) = board_track.measurements, _noise_px2(board_track)
    covariance = measured.covariance * np.maximum(least_px**2 / joined, 1.0)[:, None, None]
    return replace(board_track, measurements=PoseMeasurements(measured.trajectory, covariance))


def _noise_px2(board_track: BoardTrack) -> tuple[FloatArray, FloatArray]:
    """Variances ``(N,)`` of a coordinate: each frame's own, and joined with the recording's."""
    count = np.array([len(observation.ids) for observation in board_track.observations])
    squares, freedom = count * board_track.error_px**2, np.maximum(2 * count - 6, 1)
    usual = float(squares.sum() / freedom.sum())
    least = SIGMA_FLOOR_PX**2
    own = np.maximum(squares / freedom, least)
    return own, np.maximum((squares + _POOLED * usual) / (freedom + _POOLED), least)


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
