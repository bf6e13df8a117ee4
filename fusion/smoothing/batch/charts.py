"""Differences of poses with their derivatives, for estimators that linearise.

`Chart.between` gives the vector from one pose to another, as the representation defines it, and how
it changes when either pose moves by a small vector of its own. Where poses are written down as
plain components that is the identity; for rotors, motors and similarities the difference is written
once for CasADi, which derives it.

With ``Z = Ω + λ`` (rotation vector as a cross product matrix, logarithm of the scale) a relative
pose (q, t, λ) has the twist ``(θ, Z (e^Z - 1)⁻¹ t, λ)``; the function of Z is summed as
``Σ B_n Z^n / n!``, which converges for all turns up to π and gives 1e-9 there.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache, lru_cache
from math import comb, factorial
from typing import Any, NamedTuple

import numpy as np

from motorcade.fusion.smoothing.representations import Representation
from motorcade.ga import FloatArray, Motor, Rotor, Similarity

__all__ = ["Between", "Chart", "component_sizes"]

_TERMS = 30
# Poses at once, for the sake of memory.
_CHUNK = 4096
# Numbers of poses whose functions are kept.
_LENGTHS = 32


class Between(NamedTuple):
    """Vectors ``(N, d)`` from bases to targets, derivatives ``(N, d, d)`` by small moves of each.

    The derivatives of plain components are ``(1, d, d)``, the same for all.
    """

    vector: FloatArray
    by_base: FloatArray
    by_target: FloatArray


class Chart:
    """The vectors of one representation, with derivatives.

    Raises:
        ModuleNotFoundError: CasADi is missing and the representation needs it.
    """

    def __init__(self, representation: Representation) -> None:
        self._representation = representation
        if representation.coupled:
            _derived(representation.coupled)  # tells at once where CasADi is missing

    def between(self, base: FloatArray, target: FloatArray) -> Between:
        """Vectors from bases ``(N, D)`` to targets ``(N, D)``."""
        if not self._representation.coupled:
            vector = self._representation.local(target, base)
            unit = np.eye(vector.shape[-1])[None]
            return Between(vector, -unit, unit)
        relative, beside = self._relative(base, target)
        derived = _derived(self._representation.coupled)
        parts = [derived(relative[i : i + _CHUNK]) for i in range(0, len(relative), _CHUNK)]
        curved = Between(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        return _with_scale_beside(curved, beside) if beside is not None else curved

    def _relative(
        self, base: FloatArray, target: FloatArray
    ) -> tuple[FloatArray, FloatArray | None]:
        """Numbers ``(N, 8)`` of target seen from base: wxyz with w not negative, shift, log scale.

        With rotors the shift is the world's. A scale carried beside comes apart, ``(N, 1)``.
        """
        here, there = self._representation.poses(base), self._representation.poses(target)
        if not self._representation.scale_beside:
            assert isinstance(here, Similarity)
            assert isinstance(there, Similarity)
            step = here.inverse() @ there
            rotor, shift, scale = step.as_rotor_translation_scale()
            return _numbers(rotor, shift, np.log(scale)), None
        beside = None
        if isinstance(here, Similarity) and isinstance(there, Similarity):
            beside = (there.scale - here.scale)[:, None]
            here, there = here.as_motor_scale()[0], there.as_motor_scale()[0]
        assert isinstance(here, Motor)
        assert isinstance(there, Motor)
        motor = here.inverse() @ there
        shift = motor.translation_m
        if self._representation.coupled == 3:
            shift = there.translation_m - here.translation_m
        return _numbers(motor.rotor, shift, np.zeros(len(base))), beside


def component_sizes(
    representation: Representation, count: int, rotation: float, translation: float, scale: float
) -> FloatArray:
    """Sizes ``(d,)`` of the components of a difference for sizes in rad, m and log scale.

    A small turn changes quaternion components by half of it, and so does a small shift the dual
    part of a dual quaternion near the origin (further off, components are larger than that).
    """
    (turning, shifting), (a_radian, a_metre) = representation.ends, representation.units
    sizes = np.full(count, scale)
    sizes[:turning], sizes[turning:shifting] = a_radian * rotation, a_metre * translation
    return sizes


def _numbers(rotor: Rotor, shift: FloatArray, log_scale: FloatArray) -> FloatArray:
    wxyz = rotor.as_quaternion()
    short = np.where(wxyz[:, :1] < 0.0, -wxyz, wxyz)
    return np.concatenate([short, shift, log_scale[:, None]], axis=-1)


def _with_scale_beside(curved: Between, beside: FloatArray) -> Between:
    d = curved.vector.shape[1]
    by_base, by_target = (np.zeros((len(beside), d + 1, d + 1)) for _ in range(2))
    by_base[:, :d, :d], by_target[:, :d, :d] = curved.by_base, curved.by_target
    by_base[:, d, d], by_target[:, d, d] = -1.0, 1.0
    return Between(np.concatenate([curved.vector, beside], axis=1), by_base, by_target)


@cache
def _derived(coupled: int) -> Callable[[FloatArray], Between]:
    """From the numbers of relative poses ``(N, 8)`` to vectors and derivatives, by CasADi.

    Args:
        coupled: 3 of rotors, 6 of motors, 7 of similarities.
    """
    try:
        import casadi as ca
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(
            'robust_map needs CasADi: pip install "motorcade[pipeline]" brings it', name="casadi"
        ) from missing
    similar, size = coupled == 7, max(6, coupled)
    numbers, first, second = ca.SX.sym("x", 8), ca.SX.sym("a", size), ca.SX.sym("b", size)
    q, shift, log_scale = numbers[:4], numbers[4:7], numbers[7]
    # Moves are taken to first order: only derivatives at zero are asked for.
    q = _product(_product(ca.vertcat(1, -0.5 * first[:3]), q), ca.vertcat(1, 0.5 * second[:3]))
    if coupled == 3:
        vector = ca.vertcat(_rotation_vector(q), shift - first[3:] + second[3:])
    else:
        grown = log_scale
        scale = ca.exp(log_scale)
        moved = shift + scale * _turned(numbers[:4], second[3:6]) - first[3:6]
        moved = moved - ca.cross(first[:3], shift)
        if similar:
            moved = moved - first[6] * shift
            grown = log_scale - first[6] + second[6]
        rotation = _rotation_vector(q)
        grow = _scaled_shift if similar else _rigid_shift
        vector = ca.vertcat(rotation, grow(rotation, moved, grown), grown)[:size]
    derivatives = [ca.jacobian(vector, by) for by in (first, second)]
    zero = [ca.DM.zeros(size)] * 2
    values = ca.substitute([vector, *derivatives], [first, second], zero)
    dense = [ca.densify(value) for value in values]
    function = ca.Function(f"between_{coupled}", [numbers], dense)

    mapped = lru_cache(_LENGTHS)(function.map)

    def derived(relative: FloatArray) -> Between:
        given = np.ascontiguousarray(relative, dtype=np.float64)
        made = [np.empty((len(given), *shape)) for shape in ((size,), (size, size), (size, size))]
        # CasADi reads and writes these arrays as they are, column by column.
        function_of_all: Any = mapped(len(given))
        buffer, evaluate = function_of_all.buffer()
        buffer.set_arg(0, given.data)
        for k, part in enumerate(made):
            buffer.set_res(k, part.data)
        evaluate()
        return Between(made[0], made[1].swapaxes(1, 2), made[2].swapaxes(1, 2))

    return derived


def _product(p: Any, q: Any) -> Any:
    import casadi as ca

    vector = p[0] * q[1:] + q[0] * p[1:] + ca.cross(p[1:], q[1:])
    return ca.vertcat(p[0] * q[0] - ca.dot(p[1:], q[1:]), vector)


def _turned(q: Any, vector: Any) -> Any:
    import casadi as ca

    twice = 2 * ca.cross(q[1:], vector)
    return vector + q[0] * twice + ca.cross(q[1:], twice)


def _rotation_vector(q: Any) -> Any:
    """Twice the half angle over its sine, times the vector part; smooth at zero to rounding."""
    import casadi as ca

    sine = ca.sqrt(ca.dot(q[1:], q[1:]) + 1e-40)
    return 2 * ca.atan2(sine, q[0]) / sine * q[1:]


def _scaled_shift(rotation: Any, shift: Any, log_scale: Any) -> Any:
    """``Σ B_n Z^n / n! t``."""
    import casadi as ca

    series = _series()
    total = series[-1] * shift
    for factor in series[-2::-1]:
        total = ca.cross(rotation, total) + log_scale * total + factor * shift
    return total


def _rigid_shift(rotation: Any, shift: Any, log_scale: Any) -> Any:
    """The same where λ = 0: even powers of Ω are ``(-θ²)^(k-1) Ω²``, and of the odd one is left."""
    import casadi as ca

    series = _series()
    square = ca.dot(rotation, rotation)
    total = 0.0
    for factor in series[:1:-2]:
        total = factor - square * total
    crossed = ca.cross(rotation, shift)
    return shift + series[1] * crossed + total * ca.cross(rotation, crossed)


def _series() -> list[float]:
    """Bernoulli numbers over factorials: the powers of ``z / (e^z - 1)``."""
    numbers = [Fraction(1)]
    for n in range(1, _TERMS + 1):
        rest = sum((comb(n + 1, k) * numbers[k] for k in range(n)), Fraction(0))
        numbers.append(-rest / (n + 1))
    return [float(b / factorial(n)) for n, b in enumerate(numbers)]
