"""Which of the two planar poses is true: over a whole recording, or a few frames late.

`window` says what decides. The online resolver sees the last frames only. Earlier ones are kept as
one summary per marker, so neither memory nor time grow with the length of the recording.

One segment of frames resolved: cameras, how markers hang, which candidate is true.

Where a camera looks is put to the vote: a marker seen before and now offers four rotations of the
camera, of which at most one is true. The true ones of all markers agree; the false ones scatter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.checks import check_count
from motorcade.tracking.markers.disambiguate.observations import MarkerObservations
from motorcade.tracking.markers.disambiguate.orientations import (
    Orientations,
    seeded,
    settle,
    updated,
    weighed,
)
from motorcade.tracking.markers.disambiguate.states import (
    Chains,
    chain_cost,
    chain_probabilities,
    chains_of,
    empty_memory,
    forward_messages,
    most_probable,
)
from motorcade.tracking.markers.disambiguate.window import Memory, Window, corner_noise_px

# How far two true candidates of one marker disagree, whatever their noise.
_AGREEMENT_RAD = np.radians(5.0)
# A camera in the hand turns so fast; decides only where the votes are split.
_TURN_RAD_S = np.radians(60.0)
_WORST_TURN = 8.0
_LONE = 12.0  # what a marker that agrees with nobody costs, nats
_MOST_VOTERS = 40
_SOLVED_ROUNDS = 5


def vote(
    before: Rotor,
    evidence_before: FloatArray,
    now: Rotor,
    evidence_now: FloatArray,
    last: Rotor,
    elapsed_s: float,
) -> Rotor:
    """The camera's orientation in the world, by K markers.

    Args:
        before: Rotor ``(K, 2)``, world orientation of each marker by either earlier candidate.
        evidence_before: ``(K, 2)`` against those candidates, nats.
        now: Rotor ``(K, 2)``, orientation before the camera by either candidate.
        evidence_now: ``(K, 2)`` against those.
        last: one Rotor, the camera's orientation `elapsed_s` ago.
        elapsed_s: seconds, above zero.
    """
    against = evidence_before[:, :, None] + evidence_now[:, None, :]
    voters = np.argsort(-np.abs(evidence_now[:, 0] - evidence_now[:, 1]), kind="stable")
    voters = np.sort(voters[:_MOST_VOTERS])
    before, now, against = before[voters], now[voters], against[voters]
    proposed = (before[:, :, None] @ now[:, None, :].inverse()).reshape(-1)
    vector = _disagreement(proposed, before, now)
    half = 0.5 * np.sum(vector**2, axis=-1) / _AGREEMENT_RAD**2
    votes = np.minimum(half, _LONE) + against
    turned = (last.inverse() @ proposed).angle() / (_TURN_RAD_S * elapsed_s)
    cost = votes.min(axis=(-1, -2)).sum(axis=-1) + np.minimum(0.5 * turned**2, _WORST_TURN)
    best = proposed[int(np.argmin(cost))]
    for _ in range(_SOLVED_ROUNDS):
        vector = _disagreement(best.reshape(1), before, now)[0]
        half = 0.5 * np.sum(vector**2, axis=-1) / _AGREEMENT_RAD**2
        weight = np.exp(-(half + against))
        weight = weight / (weight.sum(axis=(-1, -2), keepdims=True) + np.exp(-_LONE))
        step = np.einsum("kac,kaci->i", weight, vector) / max(weight.sum(), np.exp(-_LONE))
        best = best @ Rotor.from_rotation_vector(step)
    return best


def _disagreement(world_R_camera: Rotor, before: Rotor, now: Rotor) -> FloatArray:
    """Rotation vectors ``(P, K, 2, 2, 3)``, camera axes: from each candidate to where it stood."""
    expected = world_R_camera.inverse()[:, None, None] @ before[None]
    turn = expected[..., None] @ now[None, :, None, :].inverse()
    return turn.as_rotation_vector()


@dataclass(frozen=True, eq=False)
class Solution:
    """What a window says, given the memory.

    Args:
        window, before: what it was made from; `before` holds the orientations as remembered.
        orientations: of cameras and markers.
        chains: the costs that were weighed.
        choice: ``(N,)`` candidate of each observation in the most probable sequence.
        candidates: ``(N, 2)`` probability of either candidate.
    """

    window: Window
    before: Orientations
    orientations: Orientations
    chains: Chains
    choice: IntArray
    candidates: FloatArray

    @property
    def cost(self) -> float:
        """What all evidence says against these orientations, nats."""
        return float(chain_cost(self.chains.first, self.chains.unary, self.chains.steps).sum())


def solve(window: Window, cameras: Rotor, memory: Memory, rounds: int) -> Solution:
    """Settle the orientations, then find the most probable states of every marker."""
    before = seeded(window, cameras, memory)
    orientations = settle(window, before, memory, rounds)
    chains = chains_of(window, orientations, memory)
    path = most_probable(chains.first, chains.unary, chains.steps)
    states = chain_probabilities(chains.first, chains.unary, chains.steps)
    own = (window.marker, chains.row)
    both = states[own].reshape(len(chains.row), -1, 2).sum(axis=1)
    return Solution(window, before, orientations, chains, path[own] % 2, both)


class Recent:
    """Where each marker stood when it was last seen, for the vote on the next frame."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[FloatArray, FloatArray]] = {}

    def see(self, window: Window, world_R_camera: Rotor, against: FloatArray) -> None:
        """Take in a frame's observations, with what speaks against their candidates ``(n, 2)``."""
        turned = (world_R_camera.reshape(1, 1) @ window.camera_R_marker).coefficients
        for marker, rotors, nats in zip(
            window.observations.marker_ids.tolist(), turned, against, strict=True
        ):
            self._seen[marker] = (rotors, nats)

    def vote(self, window: Window, last: Rotor, elapsed_s: float) -> Rotor:
        """The camera's orientation in a new frame; the last one where no marker is known."""
        ids = window.observations.marker_ids.tolist()
        known = [row for row, marker in enumerate(ids) if marker in self._seen]
        if not known:
            return last
        last_seen = [self._seen[ids[row]] for row in known]
        before = Rotor(np.stack([rotors for rotors, _ in last_seen]))
        against = np.stack([nats for _, nats in last_seen])
        now = window.camera_R_marker[known]
        return vote(before, against, now, window.evidence[known], last, elapsed_s)


def remembered(solution: Solution, memory: Memory) -> Memory:
    """The memory with the first frame of the solution's window taken in."""
    window, chains = solution.window, solution.chains
    rows = window.observations.of_frame(0)
    if len(rows) == 0:
        return memory
    marker = window.marker[rows]
    markers, information = _marker_of_first_frame(solution, rows)
    message = forward_messages(chains.first, chains.unary, chains.steps)[marker, 0]
    camera = solution.orientations.world_R_camera[:1]
    axes = camera.as_matrix()[:, None]
    fresh = Memory(
        window.marker_ids[marker],
        markers,
        information,
        message,
        np.full(len(rows), window.observations.time_ns[0]),
        camera[:, None] @ window.camera_R_marker[rows],
        axes @ window.covariance[rows] @ axes.swapaxes(-1, -2),
    )
    return _merged(memory, fresh)


def _marker_of_first_frame(solution: Solution, rows: IntArray) -> tuple[Rotor, FloatArray]:
    """Orientations and information as they were remembered, with one frame's observations added."""
    window, orientations = solution.window, solution.orientations
    marker = window.marker[rows]
    settled = orientations.world_R_marker[marker]
    known = solution.before.world_R_marker[marker]
    prior = solution.before.information[marker]
    vector, half = window.excess(orientations.world_R_camera, orientations.world_R_marker)
    vector, half = vector[rows], half[rows]
    axes = orientations.world_R_camera[:1].as_matrix()[0]
    seen = axes @ window.information[rows] @ axes.T
    weight, _ = weighed(half, window.evidence[rows])
    each = np.arange(len(rows))
    return updated(settled, known, prior, each, weight, seen, vector @ axes.T)


def _merged(old: Memory, fresh: Memory) -> Memory:
    """The fresh rows, and the old ones of other markers."""
    stay = ~np.isin(old.marker_ids, fresh.marker_ids)
    ids = np.concatenate([old.marker_ids[stay], fresh.marker_ids])
    order = np.argsort(ids)

    def joined(a: FloatArray, b: FloatArray) -> FloatArray:
        both: FloatArray = np.concatenate([a[stay], b])[order]
        return both

    return Memory(
        ids[order],
        Rotor(joined(old.world_R_marker.coefficients, fresh.world_R_marker.coefficients)),
        joined(old.information, fresh.information),
        joined(old.message, fresh.message),
        np.concatenate([old.last_ns[stay], fresh.last_ns])[order],
        Rotor(joined(old.last_R.coefficients, fresh.last_R.coefficients)),
        joined(old.last_covariance, fresh.last_covariance),
    )


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
    >>> from motorcade.tracking.markers.disambiguate import MarkerObservations
    >>> from motorcade.tracking.markers.disambiguate.resolving import Resolution
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
    >>> from motorcade.tracking.markers.disambiguate import pose_stream
    >>> from motorcade.tracking.markers.disambiguate.resolving import FixedLagResolver
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
