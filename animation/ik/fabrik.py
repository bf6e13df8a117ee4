"""FABRIK: a chain of points brought to a target by passes up and down, in CGA.

Each step moves one joint onto the sphere around its neighbour, where the line through both meets
it (the kernel ``reach``, generated from that meet). A joint whose bones may bend only so far is
then turned back by a rotor in their common plane. Passes from the target to the base and back go on
until the end lies at the target. Where limits make the passes stall, the chain is perturbed: bent a
little out of its plane, by seeded random rotors, and tried again.
Source: Aristidou and Lasenby, "FABRIK: a fast, iterative solver for the inverse kinematics problem"
(2011), and "Inverse kinematics solutions using conformal geometric algebra" (2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.vectors import length, perpendicular, shortest_turn, unit
from motorcade.ga import Rotor, kernels
from motorcade.ga.arrays import FloatArray, checked_floats

ROUNDS, PERTURBATIONS, HALVINGS = 40, 12, 48
# Bones and distances shorter than this share of the chain have no direction.
_NOTHING = 1e-9


@dataclass(frozen=True, eq=False)
class Reached:
    """A solved chain.

    Fields:
        points: ``(*, N, 3)`` joints, base first; bones keep their lengths.
        error_m: ``(*)`` distance of the end from the target.
        rounds: the most rounds that any of the chains took.

    >>> from motorcade.animation.ik import fabrik
    >>> reached = fabrik([[0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]], [0, 3.0, 0])  # 1 m out of reach
    >>> float(reached.error_m.round(3))
    1.0
    """

    points: FloatArray
    error_m: FloatArray
    rounds: int


def fabrik(
    points: ArrayLike,
    target: ArrayLike,
    max_bend_rad: ArrayLike = np.pi,
    *,
    base_direction: ArrayLike | None = None,
    max_swing_rad: float = np.pi,
    tolerance: float = 1e-5,
    seed: int = 0,
) -> Reached:
    """Bring the end of chains to targets; the base stays.

    A target out of reach has the chain stretched straight towards it, as far as limits let it.

    Args:
        points: ``(*, N, 3)`` joints before, base first, metres; N at least 2. Bones of no length
            are kept so.
        target: ``(*, 3)``.
        max_bend_rad: the angle that each inner joint's two bones may make at most, one number or
            ``(N - 2,)``.
        base_direction: ``(*, 3)`` direction that the first bone may leave by at most
            `max_swing_rad`; none by default.
        max_swing_rad: see there.
        tolerance: of the end, as a share of the chain's length.
        seed: of the perturbations; the same seed gives the same chains.

    Raises:
        ValueError: shapes that do not fit, NaN or infinity, a chain of no length, limits outside
            0 to π.

    >>> from motorcade.animation.ik import fabrik
    >>> reached = fabrik([[0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]], [0, 1.0, 0])
    >>> reached.points[-1].round(3), bool(reached.error_m < 1e-4)
    (array([0., 1., 0.]), True)
    """
    start, goal = checked_floats(points, "points", (3,)), checked_floats(target, "target", (3,))
    if start.ndim < 2 or start.shape[-2] < 2:
        raise ValueError(f"fabrik(points): expected shape (*, N, 3), N >= 2, got {start.shape}")
    batch = np.broadcast_shapes(start.shape[:-2], goal.shape[:-1])
    chains = np.broadcast_to(start, (*batch, *start.shape[-2:])).reshape(-1, *start.shape[-2:])
    limits = _limits(max_bend_rad, max_swing_rad, start.shape[-2], base_direction is not None)
    along = np.zeros(3) if base_direction is None else base_direction
    axes = np.broadcast_to(checked_floats(along, "base_direction", (3,)), (*batch, 3))
    problem = _Problem(
        chains.copy(),
        np.broadcast_to(goal, (*batch, 3)).reshape(-1, 3),
        axes.reshape(-1, 3),
        limits,
        tolerance,
    )
    rounds = problem.solve(np.random.default_rng(seed))
    shaped = problem.best.reshape(*batch, *start.shape[-2:])
    return Reached(shaped, problem.error_m.reshape(batch), rounds)


def _limits(bend: ArrayLike, swing: float, count: int, swings: bool) -> FloatArray:
    """The largest angle at each joint ``(N - 1,)``: of the first to the base's direction."""
    given = checked_floats(bend, "max_bend_rad", ())
    if given.ndim > 1 or (given.ndim == 1 and given.shape != (count - 2,)):
        raise ValueError(
            f"fabrik(max_bend_rad): expected one angle or {count - 2}, got shape {given.shape}"
        )
    first = swing if swings else np.pi
    limits = np.concatenate([[first], np.broadcast_to(given, (count - 2,))])
    if np.any(limits < 0.0) or np.any(limits > np.pi):
        raise ValueError("fabrik(max_bend_rad, max_swing_rad): expected angles from 0 to pi")
    return limits


class _Problem:
    """Chains ``(B, N, 3)`` on their way; the best of each is kept."""

    def __init__(
        self,
        chains: FloatArray,
        target: FloatArray,
        axes: FloatArray,
        limits: FloatArray,
        tolerance: float,
    ) -> None:
        bones = np.diff(chains, axis=1)
        self.lengths = np.linalg.norm(bones, axis=-1)
        self.total = np.sum(self.lengths, axis=-1)
        if not np.all(self.total > 0.0):
            raise ValueError("fabrik(points): expected chains longer than 0")
        self.base, self.target, self.axes = chains[:, 0].copy(), target, unit(axes)
        self.limits, self.tolerance = limits, tolerance * self.total
        self.best = chains
        self.error_m = np.full(len(chains), np.inf)

    def solve(self, rng: np.random.Generator) -> int:
        """Straight where the target is out of reach; else in rounds, whose number is returned."""
        everyone = np.arange(len(self.best))
        chains = self._up(self._stretched(), everyone)
        self._keep(chains, everyone)
        chains = self._up(self.best.copy(), everyone)
        rounds = 0
        far = np.linalg.norm(self.target - self.base, axis=-1) >= self.total
        left = everyone[~far & (self.error_m > self.tolerance)]
        for perturbation in range(PERTURBATIONS + 1):
            if not left.size:
                break
            current = (
                self._start[left] if perturbation == 0 else self._perturbed(left, perturbation, rng)
            )
            for _ in range(ROUNDS):
                rounds += 1
                current = self._up(self._down(current, left), left)
                self._keep(current, left)
                going = self.error_m[left] > self.tolerance[left]
                left, current = left[going], current[going]
                if not left.size:
                    break
            if left.size:
                self._keep(self._up(self._with_reach(current, left), left), left)
                left = left[self.error_m[left] > self.tolerance[left]]
        return rounds

    def _stretched(self) -> FloatArray:
        """The chains laid straight towards their targets."""
        self._start = self.best.copy()
        ahead = unit(self.target - self.base, unit(self.best[:, -1] - self.base))
        ends = np.concatenate([np.zeros((len(self.best), 1)), np.cumsum(self.lengths, -1)], -1)
        laid: FloatArray = self.base[:, None] + ends[..., None] * ahead[:, None]
        return laid

    def _perturbed(
        self, which: NDArray[np.int64], perturbation: int, rng: np.random.Generator
    ) -> FloatArray:
        """Chains whose bones are all turned at random, more with every perturbation."""
        bones = np.diff(self.best[which], axis=1)
        noise = rng.standard_normal(bones.shape) * (0.15 * perturbation)
        turned = unit(bones, np.ones(3)) + noise
        steps = unit(turned) * self.lengths[which][..., None]
        offsets = np.concatenate([np.zeros_like(steps[:, :1]), np.cumsum(steps, axis=1)], axis=1)
        return self._up(self.base[which][:, None] + offsets, which)

    def _with_reach(self, chains: FloatArray, which: NDArray[np.int64]) -> FloatArray:
        """Chains with all bends scaled alike until they are as long as the target is far, then
        turned to it. Close to straight, where the passes creep, one step of this is the solution.
        """
        away = self.target[which] - self.base[which]
        distance = np.linalg.norm(away, axis=-1)
        low, high = np.zeros(len(which)), _largest_factor(chains, self.limits)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            long = _extent(_scaled(chains, middle)) > distance
            low, high = np.where(long, middle, low), np.where(long, high, middle)
        made = _scaled(chains, 0.5 * (low + high))
        return _aimed(made, away)

    def _keep(self, chains: FloatArray, which: NDArray[np.int64]) -> None:
        error = np.linalg.norm(chains[:, -1] - self.target[which], axis=-1)
        better = error < self.error_m[which]
        self.best[which[better]] = chains[better]
        self.error_m[which[better]] = error[better]

    def _down(self, chains: FloatArray, which: NDArray[np.int64]) -> FloatArray:
        """From the target to the base."""
        made = chains.copy()
        made[:, -1] = self.target[which]
        before = np.zeros_like(made[:, 0])
        for k in range(made.shape[1] - 2, -1, -1):
            limit = self.limits[k + 1] if k + 1 < len(self.limits) else np.pi
            made[:, k] = self._placed(
                made[:, k + 1], made[:, k], self.lengths[which, k], before, limit
            )
            before = unit(made[:, k] - made[:, k + 1], before)
        return made

    def _up(self, chains: FloatArray, which: NDArray[np.int64]) -> FloatArray:
        """From the base to the end; limits hold when it is done."""
        made = chains.copy()
        made[:, 0] = self.base[which]
        before = self.axes[which]
        for k in range(made.shape[1] - 1):
            made[:, k + 1] = self._placed(
                made[:, k], made[:, k + 1], self.lengths[which, k], before, self.limits[k]
            )
            before = unit(made[:, k + 1] - made[:, k], before)
        return made

    @staticmethod
    def _placed(
        fixed: FloatArray, moving: FloatArray, bone_m: FloatArray, before: FloatArray, limit: float
    ) -> FloatArray:
        """The moving joint on the sphere around the fixed one, within the limit of its bones."""
        fallback = np.where(length(before) > 0.0, before, [1.0, 0.0, 0.0])
        apart = moving - fixed
        long = length(apart) > _NOTHING * (bone_m[:, None] + 1e-30)
        towards = np.where(long, moving, fixed + fallback)
        if limit < np.pi:
            towards = fixed + _turned_back(unit(towards - fixed), before, limit)
        made = np.empty_like(fixed)
        kernels.function("reach")(
            np.ascontiguousarray(fixed), np.ascontiguousarray(towards), bone_m, made
        )
        return made


def _turned_back(direction: FloatArray, before: FloatArray, limit: float) -> FloatArray:
    """Unit directions within an angle of those before, turned back in their common plane.

    The rotor ``exp(-½ excess plane)`` in closed form, by what of the direction is at right angles
    to the one before. Where there is none before (zero), nothing is turned.
    """
    cosine = np.sum(direction * before, axis=-1, keepdims=True)
    across = direction - cosine * before
    # Folded right back there is no plane: any will do.
    across = unit(np.where(length(across) > 1e-9, across, perpendicular(before)))
    turned = np.cos(limit) * before + np.sin(limit) * across
    held = (cosine >= np.cos(limit)) | (length(before) == 0.0)
    return np.where(held, direction, turned)


def _bends(chains: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit bones ``(B, N - 1, 3)`` and rotation vectors ``(B, N - 2, 3)`` from each to the next."""
    bones = unit(np.diff(chains, axis=1))
    return bones, shortest_turn(bones[:, :-1], bones[:, 1:]).as_rotation_vector()


def _largest_factor(chains: FloatArray, limits: FloatArray) -> FloatArray:
    """The factor on all bends ``(B,)`` at which the first of them meets its limit."""
    angles = np.linalg.norm(_bends(chains)[1], axis=-1)
    factors = limits[1:] / np.maximum(angles, 1e-12)
    most: FloatArray = np.min(factors, axis=-1, initial=1e9)
    return most


def _scaled(chains: FloatArray, factor: FloatArray) -> FloatArray:
    """The same chains with all their bends times a factor ``(B,)``."""
    bones, bends = _bends(chains)
    lengths = np.linalg.norm(np.diff(chains, axis=1), axis=-1, keepdims=True)
    changed, turned = Rotor.identity((len(chains),)), [bones[:, 0]]
    for k in range(bends.shape[1]):
        extra = Rotor.from_rotation_vector((factor[:, None] - 1.0) * bends[:, k])
        changed = changed @ extra
        turned.append(changed.apply(bones[:, k + 1]))
    steps = lengths * np.stack(turned, axis=1)
    offsets = np.concatenate([np.zeros_like(steps[:, :1]), np.cumsum(steps, axis=1)], axis=1)
    made: FloatArray = chains[:, :1] + offsets
    return made


def _aimed(chains: FloatArray, away: FloatArray) -> FloatArray:
    """Chains turned about their bases until their ends lie along vectors ``(B, 3)``."""
    rotor = shortest_turn(chains[:, -1] - chains[:, 0], away).reshape(-1, 1)
    return chains[:, :1] + rotor.apply(chains - chains[:, :1])


def _extent(chains: FloatArray) -> FloatArray:
    distance: FloatArray = np.linalg.norm(chains[:, -1] - chains[:, 0], axis=-1)
    return distance
