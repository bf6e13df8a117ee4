"""The handheld path of the synthetic room, in closed form: sums of sines, exact at any time.

World: metres, z up, origin on the table top where a character would stand; the camera looks along
+x. The gaze's two angles off +x hold only sines of whole multiples of one frequency about
`FIRST_POLE_S`, so both vanish together every `BETWEEN_POLES_S`: there the optical axis is exactly
+x and the pitch of the intrinsic x-y′-z″ angles is exactly +90°. Nothing moves faster than 2.1 Hz.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray

FIRST_POLE_S = 0.6
BETWEEN_POLES_S = 1.2
BASE_RAD_S = np.pi / BETWEEN_POLES_S
MIDDLE_M = (-0.625, 0.045, 0.172)
# World axes of a level camera that looks along +x: columns x right, y down, z forward.
LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])

# amplitude of the sine of each multiple of the base frequency; degrees
SIDEWAYS_DEG = {1: -10.0, 2: 4.6, 3: 2.8}
UPWARDS_DEG = {1: 2.0, 2: 3.6, 3: -2.3}
# the hand moves against the gaze, so that what is looked at stays in the picture; metres
AGAINST_M = (0.0, 0.085, -0.016)
TREMOR_DEG = 0.35
# deliberate motion: amplitude, frequency (Hz), phase (rad) for every axis, metres
SWEEP = (
    ((0.095, 0.155, 0.4), (0.020, 0.47, 1.0)),
    ((0.050, 0.205, 2.6), (0.016, 0.55, 0.2)),
    ((0.028, 0.260, 1.2), (0.012, 0.62, 2.0)),
)
ROLL_DEG = ((12.0, 0.23, 0.3), (5.0, 0.71, 1.4))
TREMOR_M = 0.0016
TREMOR_HZ = (1.1, 1.5, 1.9, 2.1)


@dataclass(frozen=True)
class HandheldPath:
    """The path of one seed; the deliberate motion is always the same, the tremor is the seed's.

    Attributes:
        gaze_tremor_rad: (2, 2) amplitudes sideways and upwards at 4 and 5 times the base.
        tremor: (4, n, 2) amplitude and phase at `TREMOR_HZ` of x, y, z (m) and roll (rad).
    """

    gaze_tremor_rad: FloatArray
    tremor: FloatArray

    @classmethod
    def of(cls, rng: np.random.Generator) -> "HandheldPath":
        """A path whose tremor is drawn from `rng`."""
        gaze = np.deg2rad(TREMOR_DEG) * rng.uniform(-1.0, 1.0, (2, 2))
        size = np.array([TREMOR_M, TREMOR_M, TREMOR_M, np.deg2rad(TREMOR_DEG)])[:, None]
        amplitude = size * rng.uniform(0.4, 1.0, (4, len(TREMOR_HZ)))
        phase = rng.uniform(0.0, 2.0 * np.pi, (4, len(TREMOR_HZ)))
        return cls(gaze, np.stack([amplitude, phase], axis=-1))

    def at(self, time_s: ArrayLike) -> Motor:
        """Poses `world_T_camera` (*) at times (*) in seconds, OpenCV camera axes."""
        time = np.asarray(time_s, dtype=np.float64)
        gaze = np.zeros((*time.shape, 3))
        gaze[..., 1] = -self._gaze(time, UPWARDS_DEG, 1)
        gaze[..., 2] = self._gaze(time, SIDEWAYS_DEG, 0)
        roll = np.zeros((*time.shape, 3))
        roll[..., 0] = np.deg2rad(_waves(time, ROLL_DEG)) + self._tremor(time, 3)
        rotor = Rotor.from_rotation_vector(gaze) @ Rotor.from_rotation_vector(roll)
        against = np.sin(BASE_RAD_S * (time - FIRST_POLE_S))
        place = [
            MIDDLE_M[k] + AGAINST_M[k] * against + _waves(time, SWEEP[k]) + self._tremor(time, k)
            for k in range(3)
        ]
        return Motor.from_rotor_translation(
            rotor @ Rotor.from_matrix(LEVEL), np.stack(place, axis=-1)
        )

    def trajectory(self, time_ns: IntArray) -> Trajectory:
        """The path at stamps (N,) in ns; stamp 0 is its beginning."""
        return Trajectory(time_ns, self.at(time_ns * 1e-9))

    def _gaze(self, time: FloatArray, amplitudes_deg: dict[int, float], axis: int) -> FloatArray:
        angle = BASE_RAD_S * (time - FIRST_POLE_S)
        total = np.zeros_like(time)
        for multiple, degrees in amplitudes_deg.items():
            total += np.deg2rad(degrees) * np.sin(multiple * angle)
        for k, multiple in enumerate((4, 5)):
            total += self.gaze_tremor_rad[axis, k] * np.sin(multiple * angle)
        return total

    def _tremor(self, time: FloatArray, axis: int) -> FloatArray:
        total = np.zeros_like(time)
        for hertz, (amplitude, phase) in zip(TREMOR_HZ, self.tremor[axis], strict=True):
            total += amplitude * np.sin(2.0 * np.pi * hertz * time + phase)
        return total


def _waves(time: FloatArray, terms: tuple[tuple[float, float, float], ...]) -> FloatArray:
    """Sum of sines given by amplitude, frequency and phase."""
    total = np.zeros_like(time)
    for amplitude, hertz, phase in terms:
        total += amplitude * np.sin(2.0 * np.pi * hertz * time + phase)
    return total
