"""Which of the two planar poses is true, frame by frame as they come, a few frames late.

The same thoughts as over a whole recording (`window`), on the last frames only. What lies further
back is kept as one summary a marker, so neither memory nor time grow with the recording's length.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga import Rotor
from motorcade.tracking.checks import check_count
from motorcade.tracking.markers.disambiguate.resolving import (
    Resolution,
    corner_noise_or,
    explained,
)
from motorcade.tracking.markers.disambiguate.sightings import Sightings
from motorcade.tracking.markers.disambiguate.solving import Recent, Solution, remembered, solve
from motorcade.tracking.markers.disambiguate.states import empty_memory
from motorcade.tracking.markers.disambiguate.window import Window

__all__ = ["FixedLagResolver", "resolve_online"]

_ROUNDS = 4
_ERRORS_KEPT = 1000
_LEAST_PROBABILITY = 1e-20


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
    >>> sightings, resolver = pose_stream(stream, {7: 0.1}), FixedLagResolver(lag_frames=1)
    >>> resolver.update(sightings.of_frames(np.array([0]))) is None  # not due yet
    True
    >>> resolver.update(sightings.of_frames(np.array([1]))).choice  # of the first frame
    array([0])
    """

    def __init__(self, lag_frames: int, sigma_px: float | None = None) -> None:
        check_count(lag_frames, "FixedLagResolver.lag_frames", 0)
        corner_noise_or(np.zeros(0), sigma_px)
        self.lag_frames = lag_frames
        self._sigma_px = sigma_px
        self._errors_px: list[float] = []
        self._frames: list[Sightings] = []
        self._cameras: list[Rotor] = []
        self._last: tuple[int, Rotor] | None = None
        self._memory = empty_memory()
        self._recent = Recent()
        self._answers: list[Resolution] = []

    def update(self, frame: Sightings) -> Resolution | None:
        """Take the sightings of the next frame; give the frame that is due, None before the first.

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

    def _solve(self, frame: Sightings, sigma_px: float) -> Solution | None:
        """Place the new frame by vote, then settle all frames that wait."""
        now = Window.of(frame, sigma_px)
        camera = Rotor.identity()
        if self._last is not None:
            elapsed_s = 1e-9 * float(frame.time_ns[0] - self._last[0])
            camera = self._recent.vote(now, self._last[1], elapsed_s)
        self._frames.append(frame)
        self._cameras.append(camera)
        window = Window.of(Sightings.joined(self._frames), sigma_px)
        if len(window.sightings) == 0:
            return None
        cameras = Rotor.stack(self._cameras)
        if len(self._memory.marker_ids) == 0:
            solution = explained(window, cameras, _ROUNDS)
        else:
            solution = solve(window, cameras, self._memory, _ROUNDS)
        settled = solution.orientations.world_R_camera
        self._cameras = [settled[row] for row in range(len(settled))]
        newest = solution.candidates[window.sightings.of_frame(len(settled) - 1)]
        against = -np.log(np.maximum(newest, _LEAST_PROBABILITY))
        self._recent.see(now, self._cameras[-1], against)
        return solution


def _answer(frame: Sightings, solution: Solution | None, row: int) -> Resolution:
    """What the solution says of one of its frames."""
    if solution is None or len(frame) == 0:
        return Resolution(frame, np.zeros(len(frame), np.int64), np.ones(len(frame)))
    own = solution.window.sightings.of_frame(row)
    choice = solution.choice[own]
    return Resolution(frame, choice, solution.candidates[own, choice])


def resolve_online(
    sightings: Sightings, lag_frames: int, sigma_px: float | None = None
) -> Resolution:
    """A recording resolved as `FixedLagResolver` would have done while it was taken.

    Raises:
        ValueError: a lag below 0, or a noise that is not above zero.
    """
    resolver = FixedLagResolver(lag_frames, sigma_px)
    frames = range(len(sightings.time_ns))
    answers = [resolver.update(sightings.of_frames(np.array([row]))) for row in frames]
    done = [one for one in answers if one is not None] + list(resolver.finish())
    return Resolution(
        sightings,
        np.concatenate([one.choice for one in done]) if done else np.zeros(0, np.int64),
        np.concatenate([one.probability for one in done]) if done else np.zeros(0),
    )
