"""Allan deviation, and the noise of a sensor that stood still by it.

The overlapping estimator: over averages of m samples, ``σ²(m τ0) = ½ ⟨(ȳ_{k+m} - ȳ_k)²⟩``, all k.
White noise of density N falls as ``N² / τ``, a random walk of the bias rises as ``K² τ / 3``, and
flicker of the bias lies flat at ``(2 ln 2 / π) B²`` (IEEE Std 952, annex C).

Estimates at different τ share data. Their covariance is computed from the spectrum of the fitted
noise, ``Σ_f S² |H_i|² |H_j|²`` over the frequencies that the recording resolves, so the deviations
of N, B and K are those of generalised least squares and not of points taken for independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.imu.noise import ImuNoise
from motorcade.fusion.imu.screening import refuse_movement
from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, checked_positive

_FLICKER = 2.0 * np.log(2.0) / np.pi
# Clusters that a recording holds of its longest average; fewer leave mere chance.
_FEWEST_CLUSTERS = 9
_PER_OCTAVE = 2
_FREQUENCIES = 600
# Deviations above zero from which on flicker is believed in.
_FLICKER_SEEN = 3.0
# Deviations below are those of no sensor, and their squares and covariances soon underflow.
_QUIETEST = 1e-30


@dataclass(frozen=True, eq=False)
class AllanCurve:
    """Overlapping Allan deviation of a signal.

    Fields:
        tau_s: averaging times ``(K,)``.
        deviation: ``(K, *)``, in the unit of the signal.
        samples: how many samples it was made of.
        interval_s: time between them.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.imu.allan import allan_deviation
        >>> curve = allan_deviation(np.random.default_rng(0).normal(size=1000), rate_hz=100.0)
        >>> curve.clusters[:4]
        array([1, 2, 3, 4])
    """

    tau_s: FloatArray
    deviation: FloatArray
    samples: int
    interval_s: float

    @property
    def clusters(self) -> IntArray:
        """Samples in each average, ``(K,)``."""
        return np.round(self.tau_s / self.interval_s).astype(np.int64)


@dataclass(frozen=True, eq=False)
class NoiseEstimate:
    """What an Allan curve says of one axis, each with its standard deviation.

    Fields:
        density, density_deviation: white noise, unit/√Hz.
        walk, walk_deviation: random walk of the bias, unit/s/√Hz.
        flicker, flicker_deviation: flicker of the bias ("bias instability"), unit; 0 where the
            curve shows none.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, (2000, 2, 3))
        >>> time_ns = 10_000_000 * np.arange(2000)
        >>> still = ImuStream(time_ns, 0.01 * white[:, 0], [0.0, 0.0, 9.81] + white[:, 1])

        >>> from motorcade.fusion import estimate_noise
        >>> x = estimate_noise(still).gyro[0]
        >>> f"{x.density:.1e} ± {x.density_deviation:.0e} rad/s/√Hz"
        '1.0e-04 ± 2e-06 rad/s/√Hz'
    """

    density: float
    density_deviation: float
    walk: float
    walk_deviation: float
    flicker: float
    flicker_deviation: float

    def curve(self, tau_s: FloatArray) -> FloatArray:
        """The Allan deviation ``(K,)`` that this noise has."""
        terms = _terms(tau_s) @ np.square([self.density, self.flicker, self.walk])
        return np.asarray(np.sqrt(terms))


@dataclass(frozen=True, eq=False)
class StreamNoise:
    """Noise of an inertial stream.

    Fields:
        gyro_curve, accel_curve: Allan deviations ``(K, 3)`` in rad/s and m/s².
        gyro, accel: the estimates of the three axes.
        noise: the densities and walks over the axes, by mean squares; where no axis shows a walk,
            the deviation of the walk stands for it.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, (2000, 2, 3))
        >>> time_ns = 10_000_000 * np.arange(2000)
        >>> still = ImuStream(time_ns, 0.01 * white[:, 0], [0.0, 0.0, 9.81] + white[:, 1])

        >>> from motorcade.fusion import estimate_noise
        >>> found = estimate_noise(still)
        >>> found.accel_curve.deviation.shape
        (15, 3)
    """

    gyro_curve: AllanCurve
    accel_curve: AllanCurve
    gyro: tuple[NoiseEstimate, NoiseEstimate, NoiseEstimate]
    accel: tuple[NoiseEstimate, NoiseEstimate, NoiseEstimate]
    noise: ImuNoise


def allan_deviation(
    signal: ArrayLike, rate_hz: float, tau_s: ArrayLike | None = None
) -> AllanCurve:
    """Overlapping Allan deviation along the first axis.

    Args:
        signal: ``(N, *)`` samples at even intervals, N at least 3; rates, not angles.
        rate_hz: samples a second.
        tau_s: averaging times ``(K,)``, rounded to whole samples; by default two an octave up to a
            ninth of the recording.

    Raises:
        ValueError: fewer than three samples, NaN or infinity, a rate that is not positive, or times
            of less than one sample or more than half of the recording.

    Source: W. J. Riley, "Handbook of Frequency Stability Analysis", NIST SP 1065, 2008, eq. 11.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.imu.allan import allan_deviation
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, 10_000)
        >>> allan_deviation(white, rate_hz=100.0, tau_s=[0.01, 0.16]).deviation.round(3)
        array([0.1  , 0.025])
    """
    checked_positive(rate_hz, "rate_hz")
    values = np.asarray(signal, dtype=np.float64)
    if values.ndim == 0 or len(values) < 3 or not np.all(np.isfinite(values)):
        raise ValueError(
            f"signal: expected three or more finite samples, got shape {values.shape}"
            f"{'' if values.ndim == 0 or len(values) < 3 else ' with NaN or infinity'}"
        )
    clusters = _clusters(len(values), rate_hz, tau_s)
    # Means are taken off first: sums of a large offset would lose digits.
    total = np.zeros((len(values) + 1, *values.shape[1:]))
    np.cumsum(values - np.mean(values, axis=0), axis=0, out=total[1:])
    variances = [
        np.mean(np.square(total[2 * m :] - 2.0 * total[m:-m] + total[: -2 * m]), axis=0)
        / (2.0 * m**2)
        for m in clusters.tolist()
    ]
    return AllanCurve(clusters / rate_hz, np.sqrt(variances), len(values), 1.0 / rate_hz)


def estimate_noise(imu: ImuStream) -> StreamNoise:
    """Noise densities of a sensor that stood still, by its Allan curves.

    Samples are taken as even at the stream's median interval. Temperature and vibration count as
    noise; where the walk does not rise out of the white noise within a ninth of the recording it
    is uncertain, and its deviation says so.

    Raises:
        ValueError: a recording of fewer than 100 samples, or with gaps, or of a sensor that moved
            (see `refuse_movement`), or noise that is zero.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion import ImuStream
        >>> white = np.random.default_rng(0).normal(0.0, 0.1, (2000, 2, 3))
        >>> time_ns = 10_000_000 * np.arange(2000)
        >>> still = ImuStream(time_ns, 0.01 * white[:, 0], [0.0, 0.0, 9.81] + white[:, 1])

        >>> from motorcade.fusion import estimate_noise
        >>> noise = estimate_noise(still).noise
        >>> f"{noise.gyro_density_rad_s_rthz:.1e}, {noise.accel_density_m_s2_rthz:.1e}"
        '1.0e-04, 1.0e-02'
    """
    _check_even(imu)
    try:
        refuse_movement(imu)
    except ValueError as refusal:
        raise ValueError(
            f"{refusal}; Allan deviation takes all that moves for noise: record hours at rest, or "
            "cut the recording to where it lies still"
        ) from refusal
    curves = [
        allan_deviation(values, imu.rate_hz)
        for values in (imu.angular_rate_rad_s, imu.specific_force_m_s2)
    ]
    gyro, accel = (
        (fitted_noise(curve, 0), fitted_noise(curve, 1), fitted_noise(curve, 2)) for curve in curves
    )
    return StreamNoise(curves[0], curves[1], gyro, accel, ImuNoise(*_pooled(gyro), *_pooled(accel)))


def fitted_noise(curve: AllanCurve, axis: int) -> NoiseEstimate:
    """White noise, flicker and walk of one axis of a curve ``(K, 3)``."""
    variance = np.square(curve.deviation[:, axis])
    if not np.all(curve.deviation[:, axis] > _QUIETEST):
        raise ValueError(
            f"signal: expected noise on axis {axis}, got readings that do not change; "
            "a sensor so quiet is rounded too coarsely to tell"
        )
    with_flicker = _least_squares(curve, variance, [0, 1, 2])
    seen = with_flicker[0][1] > _FLICKER_SEEN * with_flicker[1][1]
    squares, spread = with_flicker if seen else _least_squares(curve, variance, [0, 2])
    # Of a square s ± d the root is √s ± d / 2√s; at zero it is known to be below √d.
    roots = np.sqrt(squares)
    at_zero = np.sqrt(spread)
    least = np.maximum(np.maximum(roots, at_zero), 1e-300)
    deviations = np.where(squares > spread, spread / (2.0 * least), at_zero)
    pairs = np.stack([roots, deviations], axis=-1)[[0, 2, 1]]  # density, walk, flicker
    return NoiseEstimate(*pairs.ravel().tolist())


def _terms(tau_s: FloatArray) -> FloatArray:
    """Allan variance ``(K, 3)`` of white noise, flicker and walk of density one."""
    return np.stack([1.0 / tau_s, np.full_like(tau_s, _FLICKER), tau_s / 3.0], axis=-1)


def _least_squares(
    curve: AllanCurve, variance: FloatArray, used: list[int]
) -> tuple[FloatArray, FloatArray]:
    """Squares of the noise terms, none below zero, and their deviations; zeros where not used."""
    from scipy.optimize import nnls

    terms = _terms(curve.tau_s)[:, used]
    # The first guess weighs every time alike; the covariance then follows from the fit itself.
    scaled = terms / variance[:, None]
    estimate, _ = nnls(scaled, np.ones_like(variance))
    spread = np.zeros_like(estimate)
    for _ in range(3):
        full = np.zeros(3)
        full[used] = estimate
        factor = np.linalg.cholesky(_covariance(curve, full))
        whitened = np.linalg.solve(factor, terms)
        estimate, _ = nnls(whitened, np.linalg.solve(factor, variance))
        spread = np.sqrt(np.diag(np.linalg.inv(whitened.T @ whitened)))
    squares, deviations = np.zeros(3), np.zeros(3)
    squares[used], deviations[used] = estimate, spread
    return squares, deviations


def _covariance(curve: AllanCurve, squares: FloatArray) -> FloatArray:
    """Covariance ``(K, K)`` of the Allan variances of noise of these squared densities."""
    step = curve.interval_s
    span = curve.samples * step
    # Frequencies one resolution apart at the low end, in growing bins above.
    edges = np.unique(np.round(np.geomspace(0.5, 0.5 * span / step, _FREQUENCIES) + 0.5)) - 0.5
    count = np.diff(edges)
    frequency = np.sqrt(edges[:-1] * edges[1:]) / span
    # Two-sided densities N², B²/(2π f), K²/(2π f)²; the walk and flicker as sampled differences.
    chord = np.sin(np.pi * frequency * step) / (np.pi * step)
    spectrum = (
        squares[0] + squares[1] / (2.0 * np.pi * chord) + squares[2] / (2 * np.pi * chord) ** 2
    )
    m = curve.clusters[:, None]
    response = 2.0 * np.sin(np.pi * frequency * step * m) ** 4 / (m * step * np.pi * chord) ** 2
    weights = 2.0 * response * spectrum / span
    covariance: FloatArray = (weights * count) @ weights.T
    return covariance + 1e-12 * np.diag(np.diag(covariance))


def _pooled(axes: tuple[NoiseEstimate, ...]) -> tuple[float, float]:
    """Density and walk over the axes, by mean squares."""
    density = float(np.sqrt(np.mean([axis.density**2 for axis in axes])))
    walk = float(np.sqrt(np.mean([axis.walk**2 for axis in axes])))
    if walk == 0.0:  # none was seen: it is below what would have been
        walk = float(np.mean([axis.walk_deviation for axis in axes]))
    return density, walk


def _clusters(count: int, rate_hz: float, tau_s: ArrayLike | None) -> IntArray:
    if tau_s is None:
        top = max(1.0, count / _FEWEST_CLUSTERS)
        octaves = np.arange(0.0, np.log2(top) + 1e-9, 1.0 / _PER_OCTAVE)
        return np.unique(np.round(2.0**octaves).astype(np.int64))
    wanted = checked_floats(tau_s, "tau_s", ())
    clusters = np.unique(np.round(np.atleast_1d(wanted) * rate_hz).astype(np.int64))
    if clusters[0] < 1 or 2 * clusters[-1] >= count + 1:
        raise ValueError(
            f"tau_s: expected times from {1.0 / rate_hz:g} s to {0.5 * count / rate_hz:g} s, "
            f"got {np.min(wanted):g} to {np.max(wanted):g} s"
        )
    return clusters


def _check_even(imu: ImuStream) -> None:
    if len(imu) < 100:
        raise ValueError(f"imu: expected at least 100 samples, got {len(imu)}")
    steps = np.diff(imu.time_ns)
    longest = int(np.argmax(steps))
    if steps[longest] > 1.5 * np.median(steps):
        raise ValueError(
            "imu: expected samples at even intervals, got a gap of "
            f"{steps[longest] * 1e-9:.4f} s after {int(imu.time_ns[longest])} ns; "
            "cut the recording there"
        )
