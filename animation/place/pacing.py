"""How far a walker has come and in which phase of its cycle it is, from standing to standing.

It speeds up and slows down smoothly, its cycle in step with its way, so that standing feet go back
as fast as the body goes on. It starts and stops where one foot stands under the body while the
other passes: what passes is set down beside. So that a way of any length ends in that phase,
strides are made a little shorter or longer, by half a step over the whole way at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation.clip import Clip
from motorcade.animation.ik import Leg, bend_limb, find_stances
from motorcade.animation.skeleton import Skeleton
from motorcade.animation.vectors import UP
from motorcade.ga import Motor, Rotor, mean
from motorcade.ga.arrays import FloatArray

# Speeding up or slowing down takes half a cycle, but is no faster than this, for a person's size.
MOST_M_S2 = 4.0
# Of slowing down, when the walk is left for standing; and of a cycle, when after it that is done.
LEFT, DONE = 0.5, 0.15
SAMPLES = 240
# How much worse longer strides are than shorter ones: legs come short of them, and knees snap.
LONGER = 4.0
# How much lower hips stand than they rest, as a share of their height.
LOWER = 0.006


@dataclass(frozen=True)
class Pace:
    """A way of a length at a speed.

    Args:
        passing: times in the cycle when each foot stands under the body.
        starts: whether it starts from standing; else it comes walking.
        stops: whether it stops; else it walks on.
        most_m_s2: the fastest that it speeds up.
    """

    length_m: float
    speed_m_s: float
    period_s: float
    passing: tuple[float, ...]
    starts: bool = True
    stops: bool = True
    most_m_s2: float = MOST_M_S2

    @property
    def change_s(self) -> float:
        """How long it speeds up, and how long it slows down."""
        return max(0.5 * self.period_s, self.speed_m_s / self.most_m_s2)

    @property
    def ends(self) -> int:
        """How often it speeds up or slows down."""
        return self.starts + self.stops

    @property
    def top_m_s(self) -> float:
        """Its speed in between, less than the cycle's where the way is short."""
        if not self.ends:
            return self.speed_m_s
        return min(self.speed_m_s, self.length_m / (0.5 * self.ends * self.change_s))

    @property
    def duration_s(self) -> float:
        """From the way's start to its end."""
        return self.length_m / self.top_m_s + 0.5 * self.ends * self.change_s

    @property
    def left_s(self) -> float:
        """When the walk is left for standing."""
        return self.duration_s - (1.0 - LEFT) * self.change_s

    @property
    def done_s(self) -> float:
        """When it stands, or where it does not stop, is at the way's end."""
        return self.duration_s + (DONE * self.period_s if self.stops else 0.0)

    def along_m(self, time_s: ArrayLike) -> FloatArray:
        """How far it has come ``(*)`` at times ``(*)``; below 0 and beyond the end as it walks."""
        clock = np.asarray(time_s, dtype=np.float64)
        change, speed = self.change_s, self.top_m_s
        along = speed * clock
        if self.starts:
            along = np.where(
                clock < change, speed * change * _sped(clock / change), along - 0.5 * speed * change
            )
        if self.stops:
            left = self.duration_s - clock
            slow = self.length_m - speed * change * _sped(left / change)
            along = np.where(left < change, slow, along)
        return along

    @property
    def stride(self) -> float:
        """How long its strides are, as a share of the cycle's."""
        return self.length_m / self.speed_m_s / self._advance_s

    def phase_s(self, time_s: ArrayLike) -> FloatArray:
        """Times ``(*)`` in the cycle."""
        first = 0.0
        if self.starts:
            first = self.passing[0]
        elif self.stops:
            first = self.passing[0] - self._advance_s
        return first + self._advance_s * self.along_m(time_s) / self.length_m

    @property
    def _advance_s(self) -> float:
        """Of the cycle: between two ends from one foot's passing to another's, near the way's."""
        lasts_s = self.length_m / self.speed_m_s
        if self.ends < 2:
            return lasts_s

        def strain(advance_s: float) -> float:
            longer = float(np.log(lasts_s / advance_s))
            return max(LONGER * longer, -longer)

        steps = [
            end - self.passing[0] + turns * self.period_s
            for end in self.passing
            for turns in range(int(lasts_s / self.period_s) + 3)
        ]
        return min((one for one in steps if one > 0.25 * self.period_s), key=strain)


def _sped(x: FloatArray) -> FloatArray:
    """How far speed has led that grows from 0 to 1 by ``3 x² - 2 x³``."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 - 0.5 * x**4


def standing_pose(loop: Clip, skeleton: Skeleton, legs: Sequence[Leg]) -> Clip:
    """How a walker stands: legs and what carries them as at rest, all else as on average.

    Args:
        loop: a rigid cycle on the spot.
        skeleton: resting upright, with J joints.
        legs: of the skeleton.
    """
    clock = loop.time_s[0] + np.linspace(0.0, loop.duration_s, SAMPLES, endpoint=False)
    rotors = loop.at(clock).rotor
    resting = {
        skeleton.index(name) for leg in legs for name in (leg.hip, leg.knee, leg.ankle, leg.ball)
    }
    for joint in list(resting):
        while skeleton.parents[joint] >= 0:
            joint = int(skeleton.parents[joint])
            resting.add(joint)
    turns = [
        skeleton.rest[joint].rotor if joint in resting else mean(rotors[:, joint])
        for joint in range(len(skeleton))
    ]
    pose = Motor.from_rotor_translation(Rotor.stack(turns), skeleton.rest.translation_m)
    flexed = _with_flexed_knees(pose, skeleton, legs)
    return Clip("standing", np.zeros(1), flexed.reshape(1, -1))


def _with_flexed_knees(pose: Motor, skeleton: Skeleton, legs: Sequence[Leg]) -> Motor:
    """A pose lowered over its feet: legs that rest quite straight would snap when they come to."""
    at, flexed = skeleton.rest_world.translation_m, pose
    long_m = np.mean([at[skeleton.index(leg.hip), 2] for leg in legs])
    down = Motor.from_translation(-LOWER * long_m * UP)
    flexed = skeleton.moved(pose, down)
    for leg in legs:
        ankle, ahead = at[skeleton.index(leg.ankle)], at[skeleton.index(leg.knee)] + [9.0, 0, 0]
        flexed = bend_limb(skeleton, flexed, leg.limb, ankle, ahead)
    return flexed


def passing_s(
    loop: Clip, standing: Motor, skeleton: Skeleton, legs: Sequence[Leg], speed_m_s: float
) -> tuple[float, ...]:
    """When in a cycle each foot stands as far ahead of the body as it does in a pose.

    Args:
        loop: a cycle on the spot.
        standing: Motor ``(J,)``.
        skeleton: with J joints.
        legs: whose feet are told by their balls.
        speed_m_s: of the ground under the cycle.
    """
    clock = np.linspace(0.0, loop.duration_s, SAMPLES, endpoint=False)
    at = skeleton.world(loop.at(loop.time_s[0] + clock)).translation_m
    under = skeleton.world(standing).translation_m
    passing = []
    for leg in legs:
        ball = skeleton.index(leg.ball)
        over = np.tile(at[:, ball], (3, 1))  # no stance is cut by the cycle's ends
        times = np.concatenate([clock + turn * loop.duration_s for turn in range(3)])
        over[:, 0] += speed_m_s * times
        standing_still = find_stances(over, times)[SAMPLES : 2 * SAMPLES]
        off = np.abs(at[:, ball, 0] - under[ball, 0])
        passing.append(float(clock[np.argmin(np.where(standing_still, off, off + 1e3))]))
    return tuple(passing)
