"""What the covariances of a fused path do not cover, in words that go with the result."""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray

_KNOWN_TURN_RAD = 0.6
"""A turn to the second order, as the filter has it, is off by a third of its cube: a fourteenth of
a radian here. From there on a Gaussian of an attitude is no longer one of the place that it turns:
with only an altitude after one pose, squared errors of the smoothed path are 0.1 of what is stated
where the attitude is known to 33°, 2 to 5 times it at 50°, 24 times at 75°."""
_EXTRINSICS_AND_OFFSET = slice(17, 24)


def path_doubts(
    time_ns: IntArray, covariance: FloatArray, state_covariance: FloatArray
) -> tuple[str, ...]:
    """What does not hold of a path's covariances, a line each.

    Args:
        time_ns: ``(N,)``.
        covariance: ``(N, 6, 6)`` of the poses.
        state_covariance: ``(N, M, M)`` of the states, or no rows.
    """
    made = []
    variances = np.einsum("nii->ni", covariance[:, :3, :3])
    turn_rad = np.sqrt(variances.max(axis=1, initial=0.0))
    lost = np.flatnonzero(turn_rad > _KNOWN_TURN_RAD)
    if lost.size:
        first_s, last_s = (time_ns[lost[[0, -1]]] - time_ns[0]) * 1e-9
        made.append(
            f"from {first_s:.1f} to {last_s:.1f} s the attitude is known to "
            f"{np.rad2deg(turn_rad.max()):.0f}° only: poses and covariances cannot be relied on "
            "there, nor before where they look ahead; measure poses or directions too"
        )
    estimated = np.einsum("nii->ni", state_covariance)[:, _EXTRINSICS_AND_OFFSET]
    if np.any(estimated > 0.0):
        made.append(
            "deviations of extrinsics and offset hold for a sensor that errs by noise and biases "
            "alone: on recorded flights squared errors were 4 to 79 times theirs; those of "
            "synchronise cover axes and clocks that differ"
        )
    return tuple(made)
