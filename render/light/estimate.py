"""Light estimated from images whose geometry is known: ambient, and where most light comes from.

A Lambertian surface of albedo ρ that faces n shows ρ E(n). E is fitted with spherical harmonics to
band 2, which hold 99 % of the irradiance of distant light (Ramamoorthi and Hanrahan, "On the
relationship between radiance and irradiance", 2001); ρ is one number for every hue that occurs,
found in turns with E, so a painting on the wall does not pass for light. Cauchy weights let cast
shadows and highlights go. Where all surfaces face one way, or every hue faces its own, light and
paint cannot be told apart: the fit then falls back on light from all sides, and says so by a small
`contrast`.

Spherical harmonics are real: band l holds 2l + 1 functions, m = -l … l, as `l² + l + m`,
orthonormal on the sphere without the Condon-Shortley sign (Green, "Spherical Harmonic Lighting",
2003). A rotor, an element of SU(2), turns them by Wigner's matrix D, polynomials of degree 2l in
its coefficients (Boyle, "How should spin-weighted spherical functions be defined?", J. Math. Phys.
57, 2016): nothing degenerates at any angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb, factorial, pi, prod, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, checked_floats
from motorcade.render.scene import BRIGHTEST, DepthArray, ImageArray
from motorcade.tracking.cameras.camera import Camera

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

    >>> from motorcade.render.light.estimate import harmonics
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
    >>> from motorcade.render.light.estimate import rotate_harmonics
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


HUE_STEP = 0.05
"""Width of a cell of log red and log blue over brightness that counts as one paint."""
BRIGHT_ALBEDO = 0.8
"""Of the brightest twentieth of what is seen: paper, walls."""
RIDGE = np.array([0.0] + [0.03] * 3 + [0.5] * 5)
ROUNDS = 15
REACH_PX, STEP_PX, FLATNESS = 3, 5, 0.004
DARKEST = 4


@dataclass(frozen=True, eq=False)
class ShadedPoints:
    """What images show of surfaces: (N, 3) each.

    Attributes:
        points_m: world.
        normals: unit, world, towards the camera.
        colors: linear RGB, 0 to 1.

    Raises:
        ValueError: shapes that differ.

    >>> import numpy as np
    >>> from motorcade.render.light.estimate import ShadedPoints
    >>> wall = ShadedPoints(np.zeros((2, 3)), np.tile([0, 0, 1.0], (2, 1)), np.full((2, 3), 0.5))
    >>> len(ShadedPoints.joined([wall, wall]).points_m)
    4
    """

    points_m: FloatArray
    normals: FloatArray
    colors: FloatArray

    def __post_init__(self) -> None:
        for name in ("points_m", "normals", "colors"):
            values = getattr(self, name)
            if values.ndim != 2 or values.shape != (len(self.points_m), 3):
                raise ValueError(
                    f"ShadedPoints.{name}: expected shape (N, 3) for all, got {values.shape}"
                )

    @classmethod
    def joined(cls, parts: Sequence[ShadedPoints]) -> ShadedPoints:
        """All points of several images."""
        names = ("points_m", "normals", "colors")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True, eq=False)
class LightEstimate:
    """Distant light, as it falls on a place.

    Attributes:
        irradiance: (9,) spherical harmonics of E in the world, mean of the channels; 1 lights white
            paper to white.
        color: (3,) linear RGB of the light, mean 1.

    >>> import numpy as np
    >>> from motorcade.render.light.estimate import LightEstimate
    >>> from_above = LightEstimate(np.array([1.0, 0, 0.4, 0, 0, 0, 0, 0, 0]), np.ones(3))
    >>> from_above.towards_light, round(from_above.contrast, 3)
    (array([0., 0., 1.]), 0.693)
    """

    irradiance: FloatArray
    color: FloatArray

    @property
    def towards_light(self) -> FloatArray:
        """(3,) unit vector to where most light comes from (the vector of band 1)."""
        vector = self.irradiance[[3, 1, 2]]
        length = np.linalg.norm(vector)
        return np.asarray(vector / length) if length > 0.0 else np.array([0.0, 0.0, 1.0])

    @property
    def contrast(self) -> float:
        """Amplitude of E's change with direction over its mean; 0 for light from all sides."""
        return float(np.sqrt(3.0) * np.linalg.norm(self.irradiance[1:4]) / self.irradiance[0])

    def sun_and_ambient(self, contrast: float | None = None) -> tuple[float, float]:
        """Irradiance of a sun along `towards_light`, and from all sides, with the same bands 0, 1.

        A sun S gives a mean of S / 4 and a first band of amplitude S / 2. Another `contrast` than
        the estimate's own may be asked for; above 1.9 no light from all sides would be left.
        """
        mean = float(self.irradiance[0] / np.sqrt(4.0 * np.pi))
        change = min(self.contrast if contrast is None else contrast, 1.9) * mean
        return 2.0 * change, mean - 0.5 * change


def shaded_points(
    frame: ImageArray, depth_m: DepthArray, camera: Camera, world_T_camera: Motor
) -> ShadedPoints:
    """Points on smooth surfaces, with normals from depth; what is too dark or too bright is left.

    Args:
        frame: (h, w, 3) uint8 sRGB.
        depth_m: (h, w) along the optical axis, metres; 0 and NaN are unknown.
        camera: pinhole, of that size.
        world_T_camera: its pose.

    Raises:
        ValueError: sizes that differ, or a camera with distortion.
    """
    if camera.model != "pinhole":
        raise ValueError(f"shaded_points(camera): expected a pinhole camera, got {camera.model}")
    size = (camera.height, camera.width)
    if depth_m.shape != size or frame.shape != (*size, 3):
        raise ValueError(
            f"shaded_points: expected a frame and depth of {size}, got {frame.shape} and "
            f"{depth_m.shape}"
        )
    r, c = (
        part.ravel()
        for part in np.mgrid[
            REACH_PX : size[0] - REACH_PX : STEP_PX, REACH_PX : size[1] - REACH_PX : STEP_PX
        ]
    )
    shown = frame[r, c]
    fit = (shown.max(axis=1) < BRIGHTEST) & (shown.min(axis=1) > DARKEST)
    known = np.where(np.isfinite(depth_m) & (depth_m > 0.0), depth_m, np.nan).astype(np.float64)
    for rows, columns in ((REACH_PX, 0), (0, REACH_PX)):
        # Inverse depth is linear in the pixels of a plane.
        before, two = known[r - rows, c - columns], known[r + rows, c + columns]
        with np.errstate(invalid="ignore"):
            fit &= np.abs(1.0 / before + 1.0 / two - 2.0 / known[r, c]) * known[r, c] < FLATNESS
    r, c = r[fit], c[fit]
    across = _at(known, camera, r, c + REACH_PX) - _at(known, camera, r, c - REACH_PX)
    down = _at(known, camera, r + REACH_PX, c) - _at(known, camera, r - REACH_PX, c)
    normals = np.cross(down, across)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return ShadedPoints(
        world_T_camera.apply(_at(known, camera, r, c)),
        world_T_camera.rotor.apply(normals),
        to_linear(shown[fit] / 255.0),
    )


def estimate_light(seen: ShadedPoints, near_m: ArrayLike, reach_m: float) -> LightEstimate:
    """Fit the light that falls on a place.

    Args:
        seen: from one or several images.
        near_m: (3,) the place, world; points count less the further they are from it.
        reach_m: distance at which they count half.

    Raises:
        ValueError: fewer than 50 points, or a reach that is not positive.
    """
    if len(seen.points_m) < 50:
        raise ValueError(
            f"estimate_light(seen): expected 50 points or more, got {len(seen.points_m)}"
        )
    if not (np.isfinite(reach_m) and reach_m > 0.0):
        raise ValueError(f"estimate_light(reach_m): expected metres above 0, got {reach_m}")
    place = checked_floats(near_m, "near_m", (3,))
    distance = np.linalg.norm(seen.points_m - place, axis=1)
    brightness = seen.colors.mean(axis=1)
    paint = _paints(seen.colors / brightness[:, None])
    weight = _balanced(1.0 / (1.0 + (distance / reach_m) ** 2), seen.normals)
    irradiance, albedo = _fit(brightness, harmonics(seen.normals, 2), paint, weight)
    share = np.bincount(paint, weight)
    hue = np.log(seen.colors / brightness[:, None])
    each = np.stack([np.bincount(paint, weight * hue[:, k]) for k in range(3)], 1) / share[:, None]
    # The brighter a paint, the nearer to white; half way, since that is no law.
    near_white = np.sqrt(share) * (np.bincount(paint, weight * albedo) / share) ** 3
    color = np.exp(0.5 * np.average(each, axis=0, weights=near_white))
    return LightEstimate(irradiance, np.asarray(color / color.mean()))


def _fit(
    brightness: FloatArray, basis: FloatArray, paint: NDArray[np.int64], weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Irradiance and each point's albedo in turns, weighted anew in every round."""
    irradiance = np.zeros(basis.shape[1])
    irradiance[0] = np.median(brightness) * np.sqrt(4.0 * np.pi)
    robust, albedo = np.ones(len(brightness)), np.ones(len(brightness))
    for _ in range(ROUNDS):
        floor = 0.05 * irradiance[0] / np.sqrt(4.0 * np.pi)
        falling = np.maximum(basis @ irradiance, floor)
        ratio, counts = np.log(brightness / falling), weight * robust
        log_albedo = np.bincount(paint, counts * ratio) / np.bincount(paint, counts)
        log_albedo -= np.average(log_albedo[paint], weights=counts)
        apart = ratio - log_albedo[paint]
        apart -= np.median(apart)
        robust = 1.0 / (1.0 + (apart / (1.4826 * np.median(np.abs(apart)) + 1e-3)) ** 2)
        albedo = np.exp(log_albedo[paint])
        # Errors are shares of what is seen, so each point is weighed by its brightness.
        counts = weight * robust / (falling * albedo) ** 2
        normal = (basis * (counts * albedo**2)[:, None]).T @ basis
        right = basis.T @ (counts * albedo * brightness)
        irradiance = np.linalg.solve(normal + np.diag(RIDGE) * normal[0, 0], right)
    order = np.argsort(albedo)
    reached = np.cumsum(weight[order]) >= 0.95 * weight.sum()
    scale = BRIGHT_ALBEDO / albedo[order][np.argmax(reached)]
    return np.asarray(irradiance / scale), np.asarray(albedo * scale)


def _balanced(weight: FloatArray, normals: FloatArray) -> FloatArray:
    """Weights that grow with the root of how often a direction is seen, not with its area."""
    _, cell = np.unique(np.round(3.0 * normals), axis=0, return_inverse=True)
    return np.asarray(weight / np.sqrt(np.bincount(cell.ravel(), weight)[cell.ravel()]))


def _paints(hue: FloatArray) -> NDArray[np.int64]:
    """Number of the cell of hue that each point belongs to."""
    cells = np.round(np.log(hue[:, [0, 2]]) / HUE_STEP)
    _, number = np.unique(cells, axis=0, return_inverse=True)
    return np.asarray(number.ravel(), dtype=np.int64)


def _at(
    depth_m: FloatArray, camera: Camera, r: NDArray[np.int64], c: NDArray[np.int64]
) -> FloatArray:
    """Points (N, 3) in the camera's frame at rows and columns."""
    depth = depth_m[r, c]
    x, y = (c - camera.cx) / camera.fx, (r - camera.cy) / camera.fy
    return np.stack([x * depth, y * depth, depth], axis=1)
