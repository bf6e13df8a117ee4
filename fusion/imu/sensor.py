"""The sensor that `simulate_imu` moves: its readings in blocks, one after another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from motorcade.fusion.imu.continuous_path import ContinuousPath
from motorcade.fusion.imu.faults import ImuFaults
from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.noise_terms import (
    BiasWalk,
    Flicker,
    LowPass,
    WhiteNoise,
    own_generator,
    reserve_losses,
)
from motorcade.fusion.imu.vibration import VibrationNoise, VibrationSpectrum
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.motion import SplineSample, sampled_motion

BLOCK = 1 << 13
"""Samples that are made at a time: as many as stay in a processor's cache."""
_JITTER_CUT = 0.4


@dataclass(frozen=True, eq=False)
class Readings:
    """Samples with all that is known of them, ``(n,)`` or ``(n, *)``."""

    time_ns: IntArray
    angular_rate_rad_s: FloatArray
    specific_force_m_s2: FloatArray
    gyro_bias_rad_s: FloatArray
    accel_bias_m_s2: FloatArray
    true_ns: IntArray
    pose: FloatArray
    velocity_m_s: FloatArray

    def __len__(self) -> int:
        return len(self.time_ns)

    def __getitem__(self, part: slice | IntArray) -> Readings:
        return Readings(*(getattr(self, field.name)[part] for field in fields(self)))

    @staticmethod
    def joined(parts: list[Readings]) -> Readings:
        """One after another; the list is emptied on the way, so that no two copies stay."""
        if len(parts) == 1:
            return parts[0]
        columns = [
            np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(Readings)
        ]
        return Readings(*columns)


class SimulatedSensor:
    """An IMU on a path, with noise and faults as of `simulate_imu`; to be read once.

    Raises:
        ValueError: fewer than two samples, by the rate or by losses; filters or jitter that the
            rate is too low for.
    """

    def __init__(
        self,
        path: ContinuousPath,
        rate_hz: float,
        noise: ImuNoise | tuple[ImuNoise, ...] | None,
        rng: np.random.Generator,
        gravity_m_s2: float,
        faults: ImuFaults,
        vibration: VibrationSpectrum | None,
    ) -> None:
        _check_rate(faults, rate_hz)
        self._path, self._faults, self._gravity = path, faults, gravity_m_s2
        self._stamps = _EvenStamps(path, rate_hz)
        self._step_ns = 1e9 / rate_hz
        count = self._stamps.count
        walks, white = _noise_terms(noise, 1.0 / rate_hz, count, rng)
        self._losses: np.random.Generator | None = None
        if faults.dropped_share > 0.0:
            self._losses, kept = reserve_losses(rng, count, faults.dropped_share)
            if kept < 2:
                raise ValueError(
                    "ImuFaults.dropped_share: expected two samples or more to be left of "
                    f"{count}, got a share of {faults.dropped_share}"
                )
        flicker = [
            Flicker(np.asarray(b), rate_hz, path.duration_s, rng) if np.any(b) else None
            for b in (faults.gyro_flicker_rad_s, faults.accel_flicker_m_s2)
        ]
        gyro, accel = (
            [np.asarray(one) for one in drift]
            for drift in (
                (faults.gyro_bias_rad_s, faults.gyro_bias_rad_s_k, faults.gyro_scale_k),
                (faults.accel_bias_m_s2, faults.accel_bias_m_s2_k, faults.accel_scale_k),
            )
        )
        self._errors = (
            _Errors(gyro[0], gyro[1], gyro[2], walks[0], flicker[0], white[0]),
            _Errors(accel[0], accel[1], accel[2], walks[1], flicker[1], white[1]),
        )
        self._jitter = own_generator(rng) if faults.stamp_jitter_s > 0.0 else None
        cutoffs = faults.gyro_lowpass_hz, faults.accel_lowpass_hz
        self._vibration = None
        if vibration is not None:
            self._vibration = VibrationNoise(vibration, rate_hz, cutoffs, BLOCK, rng)
        self._lowpass = [LowPass(hz, rate_hz) if np.isfinite(hz) else None for hz in cutoffs]

    def blocks(self) -> Iterator[Readings]:
        """All readings, in blocks that may be empty where samples were lost."""
        for first in range(0, self._stamps.count, BLOCK):
            yield self._block(first, min(self._stamps.count, first + BLOCK))

    def _block(self, first: int, last: int) -> Readings:
        faults = self._faults
        true_ns, opened_ns, begins = self._stamps.between(first, last)
        exact = self._at(true_ns, opened_ns, 0.0)
        felt = self._felt(exact, true_ns, opened_ns, begins)
        since_ns = (true_ns - self._path.start_ns).astype(np.float64)
        warmed_k = faults.warmed_k(1e-9 * since_ns)
        (rate, gyro_bias), (force, accel_bias) = (
            errors.added(signal, true_ns, warmed_k)
            for errors, signal in zip(self._errors, felt, strict=True)
        )
        readings = Readings(
            self._stamped(true_ns), faults.converted_rate(rate), faults.converted_force(force),
            gyro_bias, accel_bias, true_ns, exact.pose.coefficients, exact.world_velocity_m_s,
        )  # fmt: skip
        if self._losses is None:
            return readings
        return readings[np.flatnonzero(self._losses.random(len(true_ns)) >= faults.dropped_share)]

    def _at(self, true_ns: IntArray, opened_ns: IntArray, delay_s: float) -> SplineSample:
        """The motion so long before stamps ``(n,)``, but not before their stretches' starts."""
        late_ns = np.maximum(true_ns - round(delay_s * 1e9), opened_ns)
        seconds = np.minimum((late_ns - self._path.start_ns) * 1e-9, self._path.duration_s)
        return sampled_motion(self._path.twists(seconds))

    def _felt(
        self, exact: SplineSample, true_ns: IntArray, opened_ns: IntArray, begins: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """Angular rate and specific force ``(n, 3)`` in the sensor's axes, through its filters."""
        faults = self._faults
        delays = faults.gyro_delay_s, faults.accel_delay_s
        moved = [self._at(true_ns, opened_ns, late) if late > 0.0 else exact for late in delays]
        rate = moved[0].body_angular_rate_rad_s @ faults.gyro_matrix.T
        force = specific_force_m_s2(moved[1], self._gravity)
        sensitivity = np.asarray(faults.gyro_g_sensitivity_rad_s_m)
        if np.any(sensitivity):
            rate += specific_force_m_s2(moved[0], self._gravity) @ sensitivity.T
        if self._lowpass[0] is not None:
            rate = self._lowpass[0].block(rate, begins)
        if self._lowpass[1] is not None:
            force = self._lowpass[1].block(force, begins)
        if self._vibration is not None:
            vibrating = self._vibration.block()[: len(true_ns)]
            rate += vibrating[:, :3] @ faults.gyro_matrix.T + vibrating[:, 3:] @ sensitivity.T
            force = force + vibrating[:, 3:]
        return rate, force @ faults.accel_matrix.T

    def _stamped(self, true_ns: IntArray) -> IntArray:
        """What the stamps show of when samples were taken."""
        if self._jitter is None:
            return true_ns
        drawn = self._faults.stamp_jitter_s * 1e9 * self._jitter.standard_normal(len(true_ns))
        cut = _JITTER_CUT * self._step_ns
        stamps: IntArray = true_ns + np.trunc(np.clip(drawn, -cut, cut)).astype(np.int64)
        return stamps


def specific_force_m_s2(motion: SplineSample, gravity_m_s2: float) -> FloatArray:
    """What a perfect accelerometer reads ``(*, 3)``: acceleration minus gravity, in its axes."""
    up = np.array([0.0, 0.0, gravity_m_s2])
    force: FloatArray = motion.pose.rotor.inverse().apply(motion.world_acceleration_m_s2 + up)
    return force


@dataclass(frozen=True, eq=False)
class _Errors:
    """What the gyroscope or the accelerometer makes of what it feels."""

    bias: FloatArray
    bias_k: FloatArray
    scale_k: FloatArray
    walk: BiasWalk | None
    flicker: Flicker | None
    white: WhiteNoise | None

    def added(
        self, felt: FloatArray, true_ns: IntArray, warmed_k: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Readings and true biases ``(n, 3)`` at the next stamps."""
        bias = np.tile(self.bias, (len(true_ns), 1))
        if self.walk is not None:
            bias += self.walk.block(true_ns)
        if self.flicker is not None:
            bias += self.flicker.block(len(true_ns))
        if np.any(warmed_k):
            bias += warmed_k[:, None] * self.bias_k
            felt = felt * (1.0 + warmed_k[:, None] * self.scale_k)
        reading = felt + bias
        if self.white is not None:
            reading += self.white.block(len(true_ns))
        return reading, bias


def _noise_terms(
    noise: ImuNoise | tuple[ImuNoise, ...] | None,
    step_s: float,
    count: int,
    rng: np.random.Generator,
) -> tuple[list[BiasWalk | None], list[WhiteNoise | None]]:
    """Walks and white noise of the gyroscope and of the accelerometer."""
    if noise is None:
        return [None, None], [None, None]
    axes = (noise,) * 3 if isinstance(noise, ImuNoise) else noise
    if len(axes) != 3:
        raise ValueError(f"noise: expected that of all axes, or of three, got {len(axes)}")
    gyro, gyro_walk, accel, accel_walk = (
        np.array([getattr(axis, field.name) for axis in axes]) for field in fields(ImuNoise)
    )
    return (
        [BiasWalk(one, step_s, count, rng) for one in (gyro_walk, accel_walk)],
        [WhiteNoise(one, step_s, count, rng) for one in (gyro, accel)],
    )


def _check_rate(faults: ImuFaults, rate_hz: float) -> None:
    for name in ("gyro_lowpass_hz", "accel_lowpass_hz"):
        cutoff_hz = getattr(faults, name)
        if np.isfinite(cutoff_hz) and not cutoff_hz < 0.5 * rate_hz:
            raise ValueError(
                f"ImuFaults.{name}: expected less than half the rate of {rate_hz:g} Hz, or "
                f"infinity, got {cutoff_hz:g}"
            )
    if not faults.stamp_jitter_s <= 0.25 / rate_hz:
        raise ValueError(
            f"ImuFaults.stamp_jitter_s: expected at most a quarter of the interval of "
            f"{1.0 / rate_hz:g} s, got {faults.stamp_jitter_s:g}"
        )


class _EvenStamps:
    """Even stamps in every stretch of a path, from its start on, without a list of them."""

    def __init__(self, path: ContinuousPath, rate_hz: float) -> None:
        spans = np.array(path.stretches_s)
        self._step_ns = 1e9 / rate_hz
        self._opened_ns = path.start_ns + np.round(spans[:, 0] * 1e9).astype(np.int64)
        self._length_ns = np.round((spans[:, 1] - spans[:, 0]) * 1e9).astype(np.int64)
        counts = np.floor((spans[:, 1] - spans[:, 0]) * rate_hz + 1e-6).astype(np.int64) + 1
        self._first = np.concatenate([[0], np.cumsum(counts)])
        self.count = int(self._first[-1])
        if self.count < 2:
            raise ValueError(
                f"rate_hz: expected two samples or more within {path.duration_s} s, got "
                f"{rate_hz} Hz"
            )

    def between(self, first: int, last: int) -> tuple[IntArray, IntArray, IntArray]:
        """Stamps ``(n,)`` from one number to before another, and the starts of their stretches.

        The third are the indices of those that open a stretch.
        """
        number = np.arange(first, last)
        stretch = np.searchsorted(self._first, number, side="right") - 1
        within = number - self._first[stretch]
        offsets = np.round(within * self._step_ns).astype(np.int64)
        opened_ns: IntArray = self._opened_ns[stretch]
        stamps = opened_ns + np.minimum(offsets, self._length_ns[stretch])
        return stamps, opened_ns, np.flatnonzero(within == 0)
