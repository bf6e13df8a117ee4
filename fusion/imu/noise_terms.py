"""Terms of a simulated sensor's noise and filters, block by block.

A term keeps between blocks what it needs, so that blocks one after another are what one long block
would be. Each draws from a generator of its own, so that no term's numbers depend on another's.
"""

from __future__ import annotations

from copy import deepcopy
from itertools import pairwise

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

_DRAWN = 1 << 16
# Flicker: a pole every two octaves, a zero between two poles, from half the rate down to where the
# recording is a tenth of a period. The spectrum is then 1/f to 2 % up to a tenth of the rate, 17 %
# above it at a third, where white noise covers it.
_POLE_RATIO = 4.0
_HIGHEST_POLE, _LOWEST_PERIODS = 0.5, 0.1


def reserve_normals(rng: np.random.Generator, count: int) -> np.random.Generator:
    """A generator that gives the next `count` normal numbers of `rng`, which is moved past them."""
    here = deepcopy(rng)
    place = np.empty(min(count, _DRAWN))
    for first in range(0, count, _DRAWN):
        rng.standard_normal(out=place[: min(_DRAWN, count - first)])
    return here


def reserve_losses(
    rng: np.random.Generator, count: int, dropped_share: float
) -> tuple[np.random.Generator, int]:
    """As `reserve_normals` for a number in [0, 1) a sample; and how many samples are not lost."""
    here, kept = deepcopy(rng), 0
    for first in range(0, count, _DRAWN):
        drawn = rng.random(min(_DRAWN, count - first))
        kept += int(np.count_nonzero(drawn >= dropped_share))
    return here, kept


def own_generator(rng: np.random.Generator) -> np.random.Generator:
    """A new generator, seeded by `rng`."""
    return np.random.default_rng(rng.integers(0, 2**63, 4))


class BiasWalk:
    """A random walk from zero; through a gap it goes on for as long as it lasts."""

    def __init__(self, density: FloatArray, step_s: float, count: int, rng: np.random.Generator):
        self._density, self._step_s = density, step_s
        self._rng = reserve_normals(rng, 3 * (count - 1))
        self._last: FloatArray | None = None
        self._last_ns = 0

    def block(self, time_ns: IntArray) -> FloatArray:
        """Its values ``(n, 3)`` at the next stamps."""
        begins = self._last is None
        last = np.zeros(3) if self._last is None else self._last
        steps = self._density * np.sqrt(self._step_s)
        steps = steps * self._rng.standard_normal((len(time_ns) - begins, 3))
        earlier = time_ns[:1] if begins else np.array([self._last_ns])
        longer = np.diff(np.concatenate([earlier, time_ns[begins:]])) * (1e-9 / self._step_s)
        gaps = longer > 1.5
        steps[gaps] *= np.sqrt(longer[gaps])[:, None]
        values = np.cumsum(np.concatenate([last[None], steps]), axis=0)
        self._last, self._last_ns = values[-1].copy(), int(time_ns[-1])
        return values if begins else values[1:]


class WhiteNoise:
    """Independent normal numbers."""

    def __init__(self, density: FloatArray, step_s: float, count: int, rng: np.random.Generator):
        self._density, self._step_s = density, step_s
        self._rng = reserve_normals(rng, 3 * count)

    def block(self, count: int) -> FloatArray:
        """The next values ``(count, 3)``."""
        white: FloatArray = self._rng.standard_normal((count, 3)) / np.sqrt(self._step_s)
        white *= self._density
        return white


class Flicker:
    """Noise whose spectrum is 1/f, from zero: white noise through poles and zeros by turns.

    Source: M. Keshner, "1/f noise", Proceedings of the IEEE 70, 1982; a chain of first-order
    sections whose mean slope is half that of an integrator.
    """

    def __init__(
        self, instability: FloatArray, rate_hz: float, duration_s: float, rng: np.random.Generator
    ):
        lowest_hz = _LOWEST_PERIODS / duration_s
        octaves = np.log(_HIGHEST_POLE * rate_hz / lowest_hz) / np.log(_POLE_RATIO)
        poles_hz = _HIGHEST_POLE * rate_hz * _POLE_RATIO ** -np.arange(np.ceil(octaves) + 1)
        zero, pole = (
            np.exp(-2.0 * np.pi * hz / rate_hz)
            for hz in (poles_hz * np.sqrt(_POLE_RATIO), poles_hz)
        )
        unit, none = np.ones_like(pole), np.zeros_like(pole)
        self._sections = np.stack([unit, -zero, none, unit, -pole, none], axis=-1)
        self._gain = np.asarray(instability) * self._unit_gain(
            rate_hz, float(np.sqrt(np.prod(poles_hz[[0, -1]])))
        )
        self._state = np.zeros((len(poles_hz), 2, 3))
        self._rng = own_generator(rng)

    def _unit_gain(self, rate_hz: float, hz: float) -> float:
        """What white noise of deviation one wants for a spectrum B² / (π f) of B = 1, one-sided."""
        from scipy.signal import sosfreqz

        _, response = sosfreqz(self._sections, [hz], fs=rate_hz)
        return float(np.sqrt(rate_hz / (2.0 * np.pi * hz)) / np.abs(response[0]))

    def block(self, count: int) -> FloatArray:
        """The next values ``(count, 3)``."""
        from scipy.signal import sosfilt

        white = self._gain * self._rng.standard_normal((count, 3))
        filtered, self._state = sosfilt(self._sections, white, axis=0, zi=self._state)
        return np.asarray(filtered)


class LowPass:
    """A Butterworth filter of second order, settled on the first reading of each stretch."""

    def __init__(self, cutoff_hz: float, rate_hz: float):
        from scipy.signal import butter, sosfilt_zi

        self._sections = butter(2, cutoff_hz, fs=rate_hz, output="sos")
        self._settled = sosfilt_zi(self._sections)[..., None]
        self._state: FloatArray = np.zeros((1, 2, 3))

    def block(self, readings: FloatArray, begins: IntArray) -> FloatArray:
        """The next readings ``(n, 3)`` filtered; `begins` are those that open a stretch."""
        from scipy.signal import sosfilt

        opening = begins.tolist()
        edges = [0, *(at for at in opening if at > 0), len(readings)]
        parts = []
        for first, last in pairwise(edges):
            if first in opening:
                self._state = self._settled * readings[first]
            part, self._state = sosfilt(
                self._sections, readings[first:last], axis=0, zi=self._state
            )
            parts.append(part)
        return np.concatenate(parts)
