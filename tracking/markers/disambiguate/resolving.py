"""Which of the two planar poses is true: over a whole recording, or a few frames late.

`window` says what decides. The online resolver sees the last frames only. Earlier ones are kept as
one summary per marker, so neither memory nor time grow with the length of the recording.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.checks import check_count
from motorcade.tracking.markers.disambiguate.observations import MarkerObservations
from motorcade.tracking.markers.disambiguate.solving import Recent, Solution, remembered, solve
from motorcade.tracking.markers.disambiguate.states import empty_memory
from motorcade.tracking.markers.disambiguate.window import Window, corner_noise_px

_ROUNDS = 12
_LATE_ROUNDS = 4
# Against the candidates of the first explanation where the second one is looked for, nats.
_REVERSED = 6.0
_CERTAIN = 500.0
_ERRORS_KEPT = 1000
_LEAST_PROBABILITY = 1e-20


@dataclass(frozen=True, eq=False)
class Resolution:
    """The chosen candidates of N observations.

    Args:
        observations: what was to be resolved.
        choice: ``(N,)`` 0 or 1, row of ``camera_T_marker``.
        probability: ``(N,)`` of the chosen candidate, given all that was used. It takes for granted
            that one of the two is true; where corners are quite wrong neither is.

    Raises:
        ValueError: shapes that do not agree, choices other than 0 and 1.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.disambiguate import Resolution, MarkerObservations
    >>> two = Motor.from_euler_translation([[3, 0.2, 0], [3, -0.2, 0]], [[0, 0, 0.6]] * 2)
    >>> seen = MarkerObservations([0, 50_000_000], [0, 1], [7, 7], Motor.stack([two, two]),
    ...     [[0.2, 0.9], [0.3, 0.4]], np.broadcast_to(1e-4 * np.eye(3), (2, 2, 3, 3)))
    >>> chosen = Resolution(seen, [0, 1], [0.99, 0.75])
    >>> chosen.camera_T_marker.shape
    (2,)
    """

    observations: MarkerObservations
    choice: IntArray
    probability: FloatArray

    def __post_init__(self) -> None:
        choice = np.array(self.choice, np.int64)
        probability = frozen(checked_floats(self.probability, "Resolution.probability", ()))
        shape = (len(self.observations),)
        if choice.shape != shape or probability.shape != shape or not np.isin(choice, (0, 1)).all():
            raise ValueError(
                f"Resolution.choice, probability: expected {shape} of 0 and 1 and of "
                f"probabilities, got {choice.shape} and {probability.shape}"
            )
        choice.setflags(write=False)
        object.__setattr__(self, "choice", choice)
        object.__setattr__(self, "probability", probability)

    @property
    def camera_T_marker(self) -> Motor:
        """Motor ``(N,)``: the chosen poses."""
        return self.observations.camera_T_marker[np.arange(len(self.choice)), self.choice]


def resolve(observations: MarkerObservations, sigma_px: float | None = None) -> Resolution:
    """The most probable candidates of a whole recording.

    Small markers seen from afar leave two explanations of everything: the scene, and the scene with
    all candidates exchanged and the camera turning the other way (Necker's reversal). Both are
    tried, and weighed by all evidence together.

    Breaks down where every marker of a frame is ambiguous and none was seen before, and where
    markers are moved one by one; the probabilities say so.

    Args:
        observations: of one camera.
        sigma_px: noise of corners a coordinate; None estimates it from the reprojection errors.

    Raises:
        ValueError: a noise that is not above zero.
    """
    if len(observations) == 0:
        return Resolution(observations, np.zeros(0, np.int64), np.zeros(0))
    window = Window.of(observations, corner_noise_or(observations.error_px[:, 0], sigma_px))
    solution = explained(window, _placed(window, window.evidence), _ROUNDS)
    chosen = np.take_along_axis(solution.candidates, solution.choice[:, None], axis=-1)[:, 0]
    return Resolution(observations, solution.choice, chosen)


def explained(window: Window, cameras: Rotor, rounds: int) -> Solution:
    """The better of two explanations of a window without a past, with the doubt between them."""
    first = solve(window, cameras, empty_memory(), rounds)
    exchanged = _REVERSED * (np.arange(2) == first.choice[:, None])
    second = solve(window, _placed(window, exchanged), empty_memory(), rounds)
    ahead = np.clip(second.cost - first.cost, -_CERTAIN, _CERTAIN)
    share = 1.0 / (1.0 + np.exp(-ahead))
    both = share * first.candidates + (1.0 - share) * second.candidates
    return replace(first if ahead >= 0.0 else second, candidates=both)


def _placed(window: Window, evidence: FloatArray) -> Rotor:
    """Every frame's camera by vote against the markers' last observations."""
    stamps = window.observations.time_ns
    recent, cameras = Recent(), [Rotor.identity()]
    for row in range(len(stamps)):
        rows = window.observations.of_frame(row)
        now = replace(window.of_frame(row), evidence=evidence[rows])
        if row:
            elapsed_s = 1e-9 * float(stamps[row] - stamps[row - 1])
            cameras.append(recent.vote(now, cameras[-1], elapsed_s))
        recent.see(now, cameras[-1], now.evidence)
    return Rotor.stack(cameras)


def best_single(observations: MarkerObservations, sigma_px: float | None = None) -> Resolution:
    """What each observation says alone: the smaller reprojection error, and how probable that is.

    Raises:
        ValueError: a noise that is not above zero.
    """
    if len(observations) == 0:
        return Resolution(observations, np.zeros(0, np.int64), np.zeros(0))
    window = Window.of(observations, corner_noise_or(observations.error_px[:, 0], sigma_px))
    choice = np.argmin(window.evidence, axis=-1)
    return Resolution(observations, choice, 1.0 / np.exp(-window.evidence).sum(axis=-1))


def corner_noise_or(error_px: FloatArray, sigma_px: float | None) -> float:
    """The given noise of corners, or the one that the better errors ``(N,)`` tell of.

    Raises:
        ValueError: one that is not above zero.
    """
    if sigma_px is None:
        return corner_noise_px(error_px)
    if not 0.0 < sigma_px < np.inf:
        raise ValueError(f"sigma_px: expected pixels above 0, got {sigma_px}")
    return float(sigma_px)


class FixedLagResolver:
    """Resolves frames as they come, each after `lag_frames` more have been seen.

    Args:
        lag_frames: 0 answers at once.
        sigma_px: noise of corners a coordinate; None estimates it from what came so far.

    Raises:
        ValueError: a lag below 0, or a noise that is not above zero.

    >>> import numpy as np
    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.markers.corner_stream import CornerStream
    >>> from motorcade.tracking.markers.disambiguate import FixedLagResolver, pose_stream
    >>> from motorcade.tracking.markers.families import marker_points_m
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> turn = Rotor.from_rotation_vector([np.pi - 0.5, 0.0, 0.0])
    >>> camera_T_marker = Motor.from_rotor_translation(turn, [[0.0, 0.0, 0.6], [0.05, 0.0, 0.6]])
    >>> corners_px = camera.project(camera_T_marker[:, None].apply(marker_points_m(0.1)))
    >>> stream = CornerStream(camera, [0, 33_000_000], [0, 1], [7, 7], corners_px)
    >>> observations, resolver = pose_stream(stream, {7: 0.1}), FixedLagResolver(lag_frames=1)
    >>> resolver.update(observations.of_frames(np.array([0]))) is None  # not due yet
    True
    >>> resolver.update(observations.of_frames(np.array([1]))).choice  # of the first frame
    array([0])
    """

    def __init__(self, lag_frames: int, sigma_px: float | None = None) -> None:
        check_count(lag_frames, "FixedLagResolver.lag_frames", 0)
        corner_noise_or(np.zeros(0), sigma_px)
        self.lag_frames = lag_frames
        self._sigma_px = sigma_px
        self._errors_px: list[float] = []
        self._frames: list[MarkerObservations] = []
        self._cameras: list[Rotor] = []
        self._last: tuple[int, Rotor] | None = None
        self._memory = empty_memory()
        self._recent = Recent()
        self._answers: list[Resolution] = []

    def update(self, frame: MarkerObservations) -> Resolution | None:
        """Take the next frame's observations; give the frame that is due, None before the first.

        Raises:
            ValueError: not exactly one frame, or one that is not later.
        """
        if len(frame.time_ns) != 1:
            raise ValueError(f"frame: expected one frame, got {len(frame.time_ns)}")
        stamp = int(frame.time_ns[0])
        if self._last is not None and stamp <= self._last[0]:
            raise ValueError(f"frame: expected a stamp after {self._last[0]}, got {stamp}")
        self._errors_px = (self._errors_px + frame.error_px[:, 0].tolist())[-_ERRORS_KEPT:]
        solution = self._solve(frame, corner_noise_or(np.array(self._errors_px), self._sigma_px))
        self._answers = [_answer(one, solution, row) for row, one in enumerate(self._frames)]
        self._last = stamp, self._cameras[-1]
        if len(self._frames) <= self.lag_frames:
            return None
        if solution is not None:
            self._memory = remembered(solution, self._memory)
        del self._frames[0], self._cameras[0]
        return self._answers.pop(0)

    def finish(self) -> tuple[Resolution, ...]:
        """Answer the frames still waiting, in order, with what is known; begin anew after it."""
        waiting = tuple(self._answers)
        self.__init__(self.lag_frames, self._sigma_px)  # type: ignore[misc]
        return waiting

    def _solve(self, frame: MarkerObservations, sigma_px: float) -> Solution | None:
        """Place the new frame by vote, then settle all frames that wait."""
        now = Window.of(frame, sigma_px)
        camera = Rotor.identity()
        if self._last is not None:
            elapsed_s = 1e-9 * float(frame.time_ns[0] - self._last[0])
            camera = self._recent.vote(now, self._last[1], elapsed_s)
        self._frames.append(frame)
        self._cameras.append(camera)
        window = Window.of(MarkerObservations.joined(self._frames), sigma_px)
        if len(window.observations) == 0:
            return None
        cameras = Rotor.stack(self._cameras)
        if len(self._memory.marker_ids) == 0:
            solution = explained(window, cameras, _LATE_ROUNDS)
        else:
            solution = solve(window, cameras, self._memory, _LATE_ROUNDS)
        settled = solution.orientations.world_R_camera
        self._cameras = [settled[row] for row in range(len(settled))]
        newest = solution.candidates[window.observations.of_frame(len(settled) - 1)]
        against = -np.log(np.maximum(newest, _LEAST_PROBABILITY))
        self._recent.see(now, self._cameras[-1], against)
        return solution


def _answer(frame: MarkerObservations, solution: Solution | None, row: int) -> Resolution:
    """What the solution says of one of its frames."""
    if solution is None or len(frame) == 0:
        return Resolution(frame, np.zeros(len(frame), np.int64), np.ones(len(frame)))
    own = solution.window.observations.of_frame(row)
    choice = np.argmax(solution.candidates[own], axis=-1)
    return Resolution(frame, choice, solution.candidates[own, choice])
