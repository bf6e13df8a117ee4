"""Real spherical harmonics, turned by rotors.

Band l holds 2l + 1 functions, order m = -l … l; coefficients of bands 0 to L lie one after another,
`(L + 1)²` in all, as `l² + l + m`. The real basis is orthonormal on the sphere and carries no
Condon-Shortley sign (Green, "Spherical Harmonic Lighting", 2003), so band 1 is
`sqrt(3 / 4π) (y, z, x)`.

A rotor is an element of SU(2): it acts on the polynomials of degree 2l in two complex numbers, and
that action is Wigner's matrix D. Its entries are polynomials of degree 2l in the rotor's four
coefficients (Boyle, "How should spin-weighted spherical functions be defined?", J. Math. Phys. 57,
2016), so nothing degenerates at any angle and no Euler angles appear.
"""

from __future__ import annotations

from functools import cache
from math import comb, factorial, pi, prod, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, checked_floats

MOST_BANDS = 12
"""Highest band: the sums lose about one digit in three bands."""

Complex = NDArray[np.complex128]


def harmonics(directions: ArrayLike, band: int) -> FloatArray:
    """The basis functions at directions.

    Args:
        directions: (*, 3) unit vectors.
        band: highest band L, 0 to `MOST_BANDS`.

    Returns:
        (*, (L + 1)²) values.

    Raises:
        ValueError: a band out of range, or directions whose length is not 1 within 1e-6.

    >>> from motorcade.render.light import harmonics
    >>> harmonics([0.0, 0.0, 1.0], 1).round(3)  # 1, y, z, x
    array([0.282, 0.   , 0.489, 0.   ])
    """
    _check_band(band)
    x, y, z = np.moveaxis(checked_floats(directions, "directions", (3,)), -1, 0)
    if np.any(np.abs(x * x + y * y + z * z - 1.0) > 2e-6):
        raise ValueError("harmonics(directions): expected unit vectors, got other lengths")
    ring: Complex = np.ones(x.shape, dtype=np.complex128)
    values = np.empty((*x.shape, (band + 1) ** 2))
    for m in range(band + 1):
        # sin(θ)^m times the Legendre factor in z alone, upwards in l at fixed m.
        before, now = np.zeros_like(z), np.full_like(z, prod(range(2 * m - 1, 1, -2)))
        for degree in range(m, band + 1):
            if degree > m:
                now, before = (
                    ((2 * degree - 1) * z * now - (degree + m - 1) * before) / (degree - m),
                    now,
                )
            norm = sqrt((2 * degree + 1) / (4 * pi) * factorial(degree - m) / factorial(degree + m))
            middle = degree * degree + degree
            if m == 0:
                values[..., middle] = norm * now
            else:
                values[..., middle + m] = sqrt(2.0) * norm * now * ring.real
                values[..., middle - m] = sqrt(2.0) * norm * now * ring.imag
        ring = ring * (x + 1j * y)
    return values


def rotate_harmonics(coefficients: ArrayLike, rotor: Rotor) -> FloatArray:
    """Coefficients of a function of directions after the function is turned.

    The turned function at `rotor.apply(v)` is the old one at `v`.

    Args:
        coefficients: (*, (L + 1)²), broadcast against the rotor's batch shape.
        rotor: Rotor (*).

    Returns:
        (*, (L + 1)²).

    Raises:
        ValueError: a count of coefficients that is no square, a band above `MOST_BANDS`, or values
            that are not finite.

    >>> import numpy as np
    >>> from motorcade.ga import Rotor
    >>> from motorcade.render.light import rotate_harmonics
    >>> upward = [0.0, 0.0, 1.0, 0.0]
    >>> about_y = Rotor.from_rotation_vector([0.0, np.pi / 2, 0.0])  # takes z to x
    >>> rotate_harmonics(upward, about_y).round(6) + 0.0
    array([0., 0., 0., 1.])
    """
    values = np.asarray(coefficients, dtype=np.float64)
    band = band_of(values)
    if not np.all(np.isfinite(values)):
        raise ValueError("rotate_harmonics(coefficients): expected finite numbers, got others")
    w, x, y, z = np.moveaxis(rotor.as_quaternion(), -1, 0)
    # Functions turn by the reverse of what turns their arguments.
    a, b = w - 1j * z, -y - 1j * x
    parts = []
    for degree in range(band + 1):
        part = values[..., degree * degree : (degree + 1) ** 2]
        parts.append(np.einsum("...ij,...j->...i", _turn(a, b, degree), part))
    return np.concatenate(parts, axis=-1)


def irradiance_factors(band: int) -> FloatArray:
    """What the clamped cosine makes of each coefficient of light: ((L + 1)²,).

    Light `L` on a surface that faces `n` gives the irradiance `Σ A_l L_lm Y_lm(n)`, with
    A = π, 2π/3, π/4, 0, -π/24, … (Ramamoorthi and Hanrahan, "An Efficient Representation for
    Irradiance Environment Maps", 2001).

    Raises:
        ValueError: a band out of range.
    """
    _check_band(band)
    factors = []
    for degree in range(band + 1):
        if degree == 1:
            value = 2.0 * pi / 3.0
        elif degree % 2:
            value = 0.0
        else:
            half = degree // 2
            sign = -1.0 if half % 2 == 0 else 1.0
            value = 2.0 * pi * sign / ((degree + 2) * (degree - 1))
            value *= factorial(degree) / (2.0**degree * factorial(half) ** 2)
        factors += [value] * (2 * degree + 1)
    return np.array(factors)


def band_of(coefficients: FloatArray) -> int:
    """The highest band L of an array (*, (L + 1)²).

    Raises ValueError: another count, or a band above `MOST_BANDS`.
    """
    count = coefficients.shape[-1] if coefficients.ndim else 0
    band = round(sqrt(count)) - 1
    if band < 0 or (band + 1) ** 2 != count:
        raise ValueError(f"coefficients: expected 1, 4, 9, 16, 25, … numbers, got {count}")
    _check_band(band)
    return band


def _turn(a: Complex, b: Complex, degree: int) -> FloatArray:
    """The real (*, 2l + 1, 2l + 1) matrix of one band, from the two complex halves of a rotor."""
    size = 2 * degree + 1
    powers_a, powers_b = _powers(a, size), _powers(b, size)
    wigner: Complex = np.zeros((*a.shape, size, size), dtype=np.complex128)
    for row, column, factor, p, q, r, s in _terms(degree):
        wigner[..., row, column] += (
            factor * powers_a[p] * powers_b[q] * powers_b[r].conj() * powers_a[s].conj()
        )
    into = _real_from_complex(degree)
    return np.asarray((into @ wigner @ into.conj().T).real)


@cache
def _terms(degree: int) -> tuple[tuple[int, int, float, int, int, int, int], ...]:
    """Each term of D: row, column, factor, and powers of a, b, conj(b), conj(a).

    The monomial u^(l+m) v^(l-m) becomes (a u - b̄ v)^(l+m) (b u + ā v)^(l-m), multiplied out.
    """
    terms = []
    for column in range(2 * degree + 1):
        up, down = column, 2 * degree - column
        for i in range(up + 1):
            for j in range(down + 1):
                row = i + j
                scale = sqrt(
                    factorial(row) * factorial(2 * degree - row) / (factorial(up) * factorial(down))
                )
                factor = scale * comb(up, i) * comb(down, j) * (-1.0) ** (up - i)
                terms.append((row, column, factor, i, j, up - i, down - j))
    return tuple(terms)


@cache
def _real_from_complex(degree: int) -> Complex:
    """The unitary matrix from complex to real coefficients of one band."""
    size = 2 * degree + 1
    matrix: Complex = np.zeros((size, size), dtype=np.complex128)
    matrix[degree, degree] = 1.0
    half = sqrt(0.5)
    for m in range(1, degree + 1):
        sign = (-1.0) ** m
        matrix[degree + m, degree + m] = sign * half
        matrix[degree + m, degree - m] = half
        matrix[degree - m, degree + m] = sign * 1j * half
        matrix[degree - m, degree - m] = -1j * half
    return matrix


def _powers(base: Complex, count: int) -> list[Complex]:
    powers: list[Complex] = [np.ones_like(base)]
    for _ in range(count):
        powers.append(powers[-1] * base)
    return powers


def _check_band(band: int) -> None:
    if not 0 <= band <= MOST_BANDS:
        raise ValueError(f"band: expected 0 to {MOST_BANDS}, got {band}")
