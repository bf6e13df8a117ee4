"""Smoothing by a spline: the least-squares quintic B-spline with knots so many seconds apart.

The knots are too few to follow the noise. On motors it is the cumulative spline, a product of
screws (see `motorcade.ga.splines`); on plain components an ordinary B-spline over the same knots,
of each component for itself; on rotors the one for the rotation and the other for the translation.
A scale is fitted beside: its logarithm under `similarity`, itself under the others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.fusion.smoothing.checks import checked_length, in_double
from motorcade.fusion.smoothing.representations import Representation, restored
from motorcade.ga import CumulativeBSpline, Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, checked_positive
from motorcade.ga.splines import ORDER, bridged_gaps, cumulative_weights, located, segments_of
from motorcade.ga.stamps import segments

# As the fit of motors: decides what the poses leave open, and nothing else.
_SMOOTHNESS = 1e-6
# Poses that are taken from a spline at once, for the sake of memory.
_CHUNK = 4096


def spline(
    trajectory: Trajectory, representation: Representation, *, knot_spacing_s: float = 0.2
) -> Trajectory:
    """The least-squares spline's poses at the trajectory's stamps.

    Args:
        trajectory: two poses or more, at any sampling. A gap longer than four knots and three
            median intervals is bridged by the screw between its ends; one of more than ten seconds
            splits the path, and each segment has a spline of its own.
        representation: what is fitted; see the module. Turns must stay below π from knot to knot.
        knot_spacing_s: seconds from knot to knot. Motion faster than about 1 / (3 spacing) Hz is
            smoothed away; as dense as the poses, the spline follows their noise.

    Raises:
        ValueError: a spacing that is not positive or makes more than 2,000 knots and 20 more a
            pose, a single pose, or motion too fast for it.
        ModuleNotFoundError: scipy is missing.
    """
    spacing_s = checked_positive(knot_spacing_s, "knot_spacing_s", "seconds")
    checked_length(trajectory, 2, "spline")
    trajectory = in_double(trajectory)
    parts = [trajectory[part] for part in segments(trajectory.time_ns)]
    smoothed = [
        _smoothed(part, representation, spacing_s).poses.coefficients
        if len(part) > 1
        else part.poses.coefficients
        for part in parts
    ]
    return replace(trajectory, poses=type(trajectory.poses)(np.concatenate(smoothed)))


def _smoothed(
    trajectory: Trajectory, representation: Representation, spacing_s: float
) -> Trajectory:
    """One spline over all poses."""
    poses = trajectory.poses
    if representation.coupled > 3:
        if not isinstance(poses, Similarity):
            return replace(trajectory, poses=_motors(trajectory, spacing_s))
        rigid, scale = poses.as_motor_scale()
        fitted = _motors(replace(trajectory, poses=rigid), spacing_s)
        component = scale if representation.scale_beside else np.log(scale)
        fitted_component = _components(trajectory, component[:, None], spacing_s)[:, 0]
        grown = fitted_component if representation.scale_beside else np.exp(fitted_component)
        return replace(trajectory, poses=Similarity.from_motor_scale(fitted, grown))
    coordinates = representation.coordinates(poses)
    fitted_all = _components(trajectory, coordinates, spacing_s)
    if representation.coupled == 3:
        turning = Motor.from_rotor_translation(poses.rotor, np.zeros(3))
        turned = _motors(replace(trajectory, poses=turning), spacing_s)
        fitted_all[:, :4] = turned.coefficients[:, :4]
        return restored(representation, fitted_all, trajectory)
    vector = representation.local(fitted_all, coordinates)
    return restored(representation, representation.retract(coordinates, vector), trajectory)


def _motors(trajectory: Trajectory, spacing_s: float) -> Motor:
    fitted = CumulativeBSpline.fit(trajectory, spacing_s)
    coefficients = np.empty((len(trajectory), 8))
    for start in range(0, len(trajectory), _CHUNK):
        part = slice(start, start + _CHUNK)
        coefficients[part] = fitted.at(trajectory.time_ns[part]).coefficients
    return Motor(coefficients)


def _components(trajectory: Trajectory, values: FloatArray, spacing_s: float) -> FloatArray:
    """Least-squares B-splines of values ``(N, D)`` at the stamps, each column for itself."""
    from scipy.linalg import solveh_banded

    segments, spacing = segments_of(trajectory, spacing_s)
    bridged = bridged_gaps(trajectory, spacing)
    time_s = bridged.time_s
    between = np.stack(
        [np.interp(time_s, trajectory.time_s, column) for column in values.T], axis=-1
    )
    band = np.zeros((ORDER, segments + ORDER - 1))
    right = np.zeros((segments + ORDER - 1, values.shape[1]))
    segment, fraction = located(time_s, spacing, segments)
    basis = -np.diff(cumulative_weights(fraction, 0), axis=0, append=0.0)
    for j in range(ORDER):
        np.add.at(right, segment + j, basis[j][:, None] * between)
        for k in range(j, ORDER):
            np.add.at(band[k - j], segment + j, basis[j] * basis[k])
    fifth = np.array([1.0, -5.0, 10.0, -10.0, 5.0, -1.0])
    strength = _SMOOTHNESS * len(time_s) / segments
    for j in range(ORDER):
        for k in range(j, ORDER):
            band[k - j, j : j + segments] += strength * fifth[j] * fifth[k]
    band[0] += 1e-14 * np.max(band[0])
    controls = np.asarray(solveh_banded(band, right, lower=True), dtype=np.float64)
    segment, fraction = located(trajectory.time_s, spacing, segments)
    basis = -np.diff(cumulative_weights(fraction, 0), axis=0, append=0.0)
    return np.asarray(
        sum(basis[j][:, None] * controls[segment + j] for j in range(ORDER)), dtype=np.float64
    )
