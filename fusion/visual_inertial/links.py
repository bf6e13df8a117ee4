"""What inertial samples add up to between keyframes, where no gap parts them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import LONGEST_BRIDGE_S

_NO_LINKS = Preintegrated(
    np.zeros(0),
    Motor.identity((0, 2)),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 15, 15)),
    np.zeros((0, 15, 15)),
)


def bridged(samples_ns: IntArray, keys_ns: IntArray) -> list[slice]:
    """Runs of keyframes between which samples are nowhere too far apart to be summed up."""
    wide = np.flatnonzero(np.diff(samples_ns) > LONGEST_BRIDGE_S * 1e9)
    spans = np.stack([samples_ns[wide], samples_ns[wide + 1]], axis=-1)
    # A link is broken by a gap that begins before its end and ends after its start.
    broken = (spans[:, :1] < keys_ns[1:]) & (spans[:, 1:] > keys_ns[:-1])
    edges = [0, *(np.flatnonzero(broken.any(axis=0)) + 1).tolist(), len(keys_ns)]
    return [slice(*edge) for edge in pairwise(edges)]


def summed_links(
    imu: ImuStream, noise: ImuNoise, stamps_ns: list[IntArray], biases: list[FloatArray]
) -> Preintegrated:
    """All links, about the mean of the biases at both ends."""
    parts = [_NO_LINKS]
    for keys_ns, bias in zip(stamps_ns, biases, strict=True):
        if len(keys_ns) > 1:
            mean = 0.5 * (bias[1:] + bias[:-1])
            parts.append(preintegrate(imu, keys_ns, noise, mean[:, :3], mean[:, 3:]))
    motion = np.concatenate([part.motion.coefficients for part in parts])
    rest = ("gyro_bias_rad_s", "accel_bias_m_s2", "transition", "covariance")
    return Preintegrated(
        np.concatenate([part.duration_s for part in parts]),
        Motor(motion),
        *(np.concatenate([getattr(part, name) for part in parts]) for name in rest),
    )
