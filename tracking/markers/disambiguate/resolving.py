"""Which of the two planar poses is true, for every sighting of a recording that lies before us."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.tracking.markers.disambiguate.sightings import Sightings
from motorcade.tracking.markers.disambiguate.solving import Recent, Solution, solve
from motorcade.tracking.markers.disambiguate.states import empty_memory
from motorcade.tracking.markers.disambiguate.window import Window, corner_noise_px

__all__ = ["Resolution", "best_single", "corner_noise_or", "explained", "resolve"]

_ROUNDS = 12
# Against the candidates of the first explanation where the second one is looked for, nats.
_REVERSED = 6.0
_CERTAIN = 500.0


@dataclass(frozen=True, eq=False)
class Resolution:
    """The chosen candidates of N sightings.

    Args:
        sightings: what was to be resolved.
        choice: ``(N,)`` 0 or 1, row of ``camera_T_marker``.
        probability: ``(N,)`` of the chosen candidate, given all that was used. It takes for granted
            that one of the two is true; where corners are quite wrong neither is.

    Raises:
        ValueError: shapes that do not agree, choices other than 0 and 1.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.markers.disambiguate import Resolution, Sightings
    >>> two = Motor.from_euler_translation([[3, 0.2, 0], [3, -0.2, 0]], [[0, 0, 0.6]] * 2)
    >>> seen = Sightings([0, 50_000_000], [0, 1], [7, 7], Motor.stack([two, two]),
    ...     [[0.2, 0.9], [0.3, 0.4]], np.broadcast_to(1e-4 * np.eye(3), (2, 2, 3, 3)))
    >>> chosen = Resolution(seen, [0, 1], [0.99, 0.75])
    >>> chosen.camera_T_marker.shape, chosen.frame_ambiguity.round(2)
    ((2,), array([0.01, 0.25]))
    """

    sightings: Sightings
    choice: IntArray
    probability: FloatArray

    def __post_init__(self) -> None:
        choice = np.array(self.choice, np.int64)
        probability = frozen(checked_floats(self.probability, "Resolution.probability", ()))
        shape = (len(self.sightings),)
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
        return self.sightings.camera_T_marker[np.arange(len(self.choice)), self.choice]

    @property
    def frame_ambiguity(self) -> FloatArray:
        """``(F,)`` how probably the least sure choice of each frame is false; 0 without markers."""
        worst = np.zeros(len(self.sightings.time_ns))
        np.maximum.at(worst, self.sightings.frame, 1.0 - self.probability)
        return worst


def resolve(sightings: Sightings, sigma_px: float | None = None) -> Resolution:
    """The most probable candidates of a whole recording.

    Small markers seen from afar leave two explanations of everything: the scene, and the scene with
    all candidates exchanged and the camera turning the other way (Necker's reversal). Both are
    tried, and weighed by all evidence together.

    Breaks down where every marker of a frame is ambiguous and none was seen before, and where
    markers are moved one by one; the probabilities say so.

    Args:
        sightings: of one camera.
        sigma_px: noise of corners a coordinate; None estimates it from the reprojection errors.

    Raises:
        ValueError: a noise that is not above zero.
    """
    if len(sightings) == 0:
        return Resolution(sightings, np.zeros(0, np.int64), np.zeros(0))
    window = Window.of(sightings, corner_noise_or(sightings.error_px[:, 0], sigma_px))
    solution = explained(window, _placed(window, window.evidence), _ROUNDS)
    chosen = np.take_along_axis(solution.candidates, solution.choice[:, None], axis=-1)[:, 0]
    return Resolution(sightings, solution.choice, chosen)


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
    """Every frame's camera by vote against the markers' last sightings."""
    stamps = window.sightings.time_ns
    recent, cameras = Recent(), [Rotor.identity()]
    for row in range(len(stamps)):
        rows = window.sightings.of_frame(row)
        now = replace(window.of_frame(row), evidence=evidence[rows])
        if row:
            elapsed_s = 1e-9 * float(stamps[row] - stamps[row - 1])
            cameras.append(recent.vote(now, cameras[-1], elapsed_s))
        recent.see(now, cameras[-1], now.evidence)
    return Rotor.stack(cameras)


def best_single(sightings: Sightings, sigma_px: float | None = None) -> Resolution:
    """What each sighting says alone: the smaller reprojection error, and how probable that is.

    Raises:
        ValueError: a noise that is not above zero.
    """
    if len(sightings) == 0:
        return Resolution(sightings, np.zeros(0, np.int64), np.zeros(0))
    window = Window.of(sightings, corner_noise_or(sightings.error_px[:, 0], sigma_px))
    choice = np.argmin(window.evidence, axis=-1)
    return Resolution(sightings, choice, 1.0 / np.exp(-window.evidence).sum(axis=-1))


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
