"""The kernels on arrays ``(*, n)`` whose batches broadcast; results are new arrays.

Inputs are float32 or float64, all of one kind, and are read where they lie. Results of sixteen
rows and more are views ``(*, n)`` onto storage that holds one component after the other, so that
the next kernel reads them without copying; smaller ones are in C order.

Rotors ``(*, 4)`` stand on ``1, e23, e31, e12``, motors ``(*, 8)`` on ``1, e23, e31, e12, e1∞, e2∞,
e3∞, e123∞``, similarities ``(*, 12)`` on ``1, e23, e31, e12, E, e23E, e31E, e12E, e1∞, e2∞, e3∞,
e123∞`` with ``E = e0∧e∞``; logarithms on ``e23, e31, e12``, then ``E``, then ``e1∞, e2∞, e3∞``, as
many as there are. A scale ``ρ`` leaves the difference of the first two quadruples with a relative
error of ``max(ρ, 1/ρ)`` roundings, so scales are meant to lie in 1e-12 … 1e12 (float64) or
1e-5 … 1e5 (float32). A twist is ``-2 log``: rotation vector (rad), then translational part (m),
then, of similarities, logarithm of the scale.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.kernels.backend import checked_function, function

# Points that one versor moves faster by its matrix.
_BY_MATRIX = 1024

_blend, _blend_matrix = function("blend"), function("blend_matrix")
_screw_blend, _screw_blend_matrix = function("screw_blend"), function("screw_blend_matrix")
_accumulate = function("accumulate")
_normalize, _normalize_matrix = function("normalize"), function("normalize_matrix")
_dual_quaternion = function("dual_quaternion")
_transform, _checked_transform = function("transform"), checked_function("transform")
_rotor_matrix33 = function("rotor_matrix33")
_similarity_normalize = function("similarity_normalize")
_similarity_blend = function("similarity_blend")
_similarity_parts = function("rotor_translation_scale")
_similarity_of_motor = function("similarity_of_motor")


def _of_fraction(
    kernel: Callable[..., None], a: Array, b: Array, fraction: Array | float, width: int
) -> Array:
    """Apply a kernel of two inputs ``(*, n)`` and a fraction ``(*)``."""
    shape = batch_of(a, b)
    if not isinstance(fraction, float | int):
        expect_arrays(fraction)
        if fraction.shape == ():
            fraction = float(fraction)
        elif fraction.shape != shape:
            shape = np.broadcast_shapes(shape, fraction.shape)
    rows = empty(shape, width, a.dtype)
    part = float(fraction) if isinstance(fraction, float | int) else spread(fraction, shape, 0)
    kernel(spread(a, shape, 1), spread(b, shape, 1), part, rows)
    return rows


def blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """Linear blend of motors the short way round, projected to motors ``(*, 8)``."""
    return _of_fraction(_blend, a, b, fraction, 8)


def blend_matrix(a: Array, b: Array, fraction: Array | float) -> Array:
    """`blend` as matrices ``(*, 3, 4)``."""
    return _matrices(_of_fraction(_blend_matrix, a, b, fraction, 12), 3)


def screw_blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """`MOTORS.interpolate` for fractions in [0, 1], faster; outside it loses accuracy."""
    return _of_fraction(_screw_blend, a, b, fraction, 8)


def screw_blend_matrix(a: Array, b: Array, fraction: Array | float) -> Array:
    """`screw_blend` as matrices ``(*, 3, 4)``."""
    return _matrices(_of_fraction(_screw_blend_matrix, a, b, fraction, 12), 3)


def blend_many(motors: Array, weights: Array) -> Array:
    """Linear blend of ``K`` motors ``(K, *, 8)`` with weights ``(K)`` or ``(K, *)``: ``(*, 8)``.

    Signs follow the first motor, the pivot. Weights need not add up to 1; where everything
    cancels there is no blend and the result is not finite.
    """
    return of_one(_normalize, _accumulated(motors, weights), 8)


def blend_many_matrix(motors: Array, weights: Array) -> Array:
    """`blend_many` as matrices ``(*, 3, 4)``."""
    return _matrices(of_one(_normalize_matrix, _accumulated(motors, weights), 12), 3)


def _accumulated(motors: Array, weights: Array) -> Array:
    expect_arrays(motors, weights)
    shape = motors.shape[1:-1]
    total = np.zeros(8, motors.dtype)
    other = empty(shape, 8, motors.dtype)
    spare = empty(shape, 8, motors.dtype)
    pivot = spread(motors[0], shape, 1)
    for motor, weight in zip(motors, weights, strict=True):
        part = float(weight) if weight.shape == () else spread(weight, shape, 0)
        _accumulate(total, pivot, spread(motor, shape, 1), part, other)
        total, other, spare = other, spare, other
    return total


def normalize(m: Array) -> Array:
    """The motors nearest to even elements ``(*, 8)``, which must not have a zero rotor part."""
    return of_one(_normalize, m, 8)


def _matrices(rows: Array, height: int) -> Array:
    return rows.reshape(*rows.shape[:-1], height, 4)


def dual_quaternion(m: Array) -> Array:
    """Hamilton dual quaternions ``(*, 8)``, real wxyz then dual wxyz."""
    return of_one(_dual_quaternion, m, 8)


def similarity_blend(a: Array, b: Array, fraction: Array | float) -> Array:
    """Linear blend of similarities the short way round, projected to similarities ``(*, 12)``.

    Where both cancel there is no blend and the result is no similarity.
    """
    return _of_fraction(_similarity_blend, a, b, fraction, 12)


def similarity_normalize(m: Array) -> tuple[Array, Array]:
    """The similarities nearest to even elements ``(*, 12)``, and how well defined they are ``(*)``.

    The second is 1 for a versor and 0 for an element that has no scale or is turned inside out;
    there the first means nothing.
    """
    results = of_one(_similarity_normalize, m, 13)
    return results[..., :12], results[..., 12]


def rotor_translation_scale(m: Array) -> tuple[Array, Array, Array]:
    """Rotors ``(*, 4)``, translations ``(*, 3)`` and scales ``(*)`` of similarities."""
    parts: Any = of_one(_similarity_parts, m, 8)
    return parts[..., :4], parts[..., 4:7], parts[..., 7]


def similarity_of_motor(m: Array, scale: Array) -> Array:
    """Similarities ``(*, 12)`` that grow by ``scale (*)`` and then move by motors ``(*, 8)``."""
    expect_arrays(scale)
    return of_two(_similarity_of_motor, m, scale[..., None], 12)


class VersorKernels:
    """The verbs of one kind of versor, whose kernels are called `prefix` and the verb.

    Versors are ``(*, size)``, bivectors and twists ``(*, d)``.

    >>> import numpy as np
    >>> from motorcade.ga import Rotor
    >>> from motorcade.ga.kernels import ROTORS
    >>> quarter = Rotor.from_rotation_vector([0.0, 0.0, np.pi / 2]).coefficients
    >>> (-2 * ROTORS.log(ROTORS.compose(quarter, quarter))).round(6)
    array([-0.      , -0.      ,  3.141593])
    """

    def __init__(self, prefix: str, size: int, twist_size: int) -> None:
        self._size = size
        self._twist_size = twist_size
        self._compose, self._inverse = function(f"{prefix}compose"), function(f"{prefix}inverse")
        self._exp, self._log = function(f"{prefix}exp"), function(f"{prefix}log")
        self._log_long = function(f"{prefix}log_long")
        self._interpolate = function(f"{prefix}interpolate")
        self._interpolate_long = function(f"{prefix}interpolate_long")
        self._adjoint = function(f"{prefix}adjoint")
        self._transform_twist = function(f"{prefix}transform_twist")
        self._left_jacobian = function(f"{prefix}left_jacobian")
        self._left_jacobian_inverse = function(f"{prefix}left_jacobian_inverse")
        self._retract, self._local = function(f"{prefix}retract"), function(f"{prefix}local")
        self._apply, self._as_twist = function(f"{prefix}apply"), function(f"{prefix}as_twist")
        self._checked_apply = checked_function(f"{prefix}apply")
        self._checked_of_twist = checked_function(f"{prefix}of_twist")
        self._of_coefficients = function(f"{prefix}of_coefficients")
        self._add_weighted = function(f"{prefix}add_weighted")
        self._add_local = function(f"{prefix}add_local")

    def compose(self, a: Array, b: Array) -> Array:
        """Geometric product ``a b``."""
        return of_two(self._compose, a, b, self._size)

    def inverse(self, m: Array) -> Array:
        """The reverse: the inverse where versors are unit."""
        return of_one(self._inverse, m, self._size)

    def apply(self, m: Array, points: Array) -> Array:
        """Points ``(*, 3)`` moved."""
        if m.size == self._size and points.size >= 3 * _BY_MATRIX:
            return of_two(_transform, self._matrix(m), points, 3)
        return of_two(self._apply, m, points, 3)

    def checked_apply(self, m: Array, points: Array) -> tuple[Array, bool]:
        """The same, and whether all numbers given are finite."""
        if m.size == self._size and points.size >= 3 * _BY_MATRIX:
            return checked_call(_checked_transform, 3, self._matrix(m), points)
        return checked_call(self._checked_apply, 3, m, points)

    def _matrix(self, m: Array) -> Array:
        """The matrices ``(*, 12)``, by rows, of rotors."""
        matrices = np.zeros((*m.shape[:-1], 3, 4), m.dtype)
        matrices[..., :3] = of_one(_rotor_matrix33, m, 9).reshape(*m.shape[:-1], 3, 3)
        return matrices.reshape(*m.shape[:-1], 12)

    def checked_of_twist(self, twist: Array) -> tuple[Array, bool]:
        """Versors of twists ``(*, d)``, and whether these are finite; see `exp`."""
        return checked_call(self._checked_of_twist, self._size, twist)

    def off(self, m: Array) -> float:
        """How far coefficients are from a versor's, the most of a batch."""
        with np.errstate(over="ignore", invalid="ignore"):
            measured = of_one(self._of_coefficients, m, self._size + 1)[..., self._size]
        return float(np.max(measured, initial=0.0))

    def as_twist(self, m: Array) -> Array:
        """Twists ``(*, d)`` of versors, which turn by at most π."""
        return of_one(self._as_twist, m, self._twist_size)

    def exp(self, log: Array) -> Array:
        """Versors of bivectors.

        Of half angles up to 2e8 (float64) or 6e3 (float32) nothing is lost beyond their own
        rounding. Where ``e^|E|`` is too large, similarities are not finite.
        """
        return of_one(self._exp, log, self._size)

    def log(self, m: Array, short_way: bool = True) -> Array:
        """Bivectors of unit versors.

        With ``short_way`` the sign is flipped first where ``m0 < 0``, so half the rotation angle
        is at most π/2; without, it runs up to π, where the axis is lost.
        """
        return of_one(self._log if short_way else self._log_long, m, self._twist_size)

    def interpolate(
        self, a: Array, b: Array, fraction: Array | float, short_way: bool = True
    ) -> Array:
        """Great circles, screws and spirals ``a exp(fraction log(~a b))`` for any fraction."""
        kernel = self._interpolate if short_way else self._interpolate_long
        return _of_fraction(kernel, a, b, fraction, self._size)

    def adjoint(self, m: Array) -> Array:
        """Matrices ``(*, d, d)`` with ``m exp(x) ~m = exp(Ad x)``."""
        return self._square(of_one(self._adjoint, m, self._twist_size**2))

    def transform_twist(self, m: Array, twist: Array) -> Array:
        """Twists ``Ad x``, without the matrix."""
        return of_two(self._transform_twist, m, twist, self._twist_size)

    def left_jacobian(self, twist: Array) -> Array:
        """Matrices with ``exp(x + y) ≈ exp(J y) exp(x)``; the right one is that of ``-x``."""
        return self._square(of_one(self._left_jacobian, twist, self._twist_size**2))

    def left_jacobian_inverse(self, twist: Array) -> Array:
        """The inverse of `left_jacobian`; not finite or huge at full turns."""
        return self._square(of_one(self._left_jacobian_inverse, twist, self._twist_size**2))

    def retract(self, m: Array, twist: Array) -> Array:
        """Versors ``m exp(x)``."""
        return of_two(self._retract, m, twist, self._size)

    def local(self, a: Array, b: Array) -> Array:
        """Twists from ``a`` to ``b``, seen from ``a``, which turn by at most π."""
        return of_two(self._local, a, b, self._twist_size)

    def weighted_sum(self, m: Array, weights: Array) -> Array:
        """Sums ``(*, n + 1)`` of versors ``(*, K, n)`` times weights ``(*, K)``.

        Each is signed as it is beside the first. The last number is how long the terms are
        together, by their largest rotor coefficient.
        """
        return self._summed(self._add_weighted, m[..., 0, :], m, weights, self._size + 1)

    def weighted_local(self, middle: Array, m: Array, weights: Array) -> Array:
        """Sums of `local` from ``(*, n)`` to versors ``(*, K, n)``, times weights ``(*, K)``."""
        return self._summed(self._add_local, middle, m, weights, self._twist_size)

    def _summed(
        self, kernel: Callable[..., None], first: Array, m: Array, weights: Array, width: int
    ) -> Array:
        """What a kernel adds up, one of K after the other; weights have the batch of the result."""
        shape = weights.shape[:-1]
        beside = spread(first, shape, 1)
        total = np.zeros(width, m.dtype)
        summed, spare = empty(shape, width, m.dtype), empty(shape, width, m.dtype)
        for k in range(weights.shape[-1]):
            versor = spread(m[..., k, :], shape, 1)
            weight = spread(weights[..., k], shape, 0)
            kernel(spread(total, shape, 1), beside, versor, weight, summed)
            total, summed, spare = summed, spare, summed
        return total

    def _square(self, rows: Array) -> Array:
        return rows.reshape(*rows.shape[:-1], self._twist_size, self._twist_size)


class PoseKernels(VersorKernels):
    """What versors do that have a matrix with a translation: motors and similarities.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor
        >>> from motorcade.ga.kernels import MOTORS
        >>> world_T_camera = Motor.from_translation([0.0, 0.0, 1.5]).coefficients
        >>> MOTORS.apply(world_T_camera, np.array([[0.0, 0.0, 2.0]]))
        array([[0. , 0. , 3.5]])
    """

    def __init__(self, prefix: str, size: int, twist_size: int) -> None:
        super().__init__(prefix, size, twist_size)
        self._matrix34, self._matrix44 = (
            function(f"{prefix}matrix34"),
            function(f"{prefix}matrix44"),
        )

    def matrix34(self, m: Array) -> Array:
        """Matrices ``(*, 3, 4)``."""
        return _matrices(self._matrix(m), 3)

    def _matrix(self, m: Array) -> Array:
        return of_one(self._matrix34, m, 12)

    def matrix44(self, m: Array) -> Array:
        """Homogeneous matrices ``(*, 4, 4)``."""
        return _matrices(of_one(self._matrix44, m, 16), 4)


ROTORS = VersorKernels("rotor_", 4, 3)
MOTORS = PoseKernels("", 8, 6)
SIMILARITIES = PoseKernels("similarity_", 12, 7)


# float32 or float64, one kind throughout a call.
Array = NDArray[Any]

_BLOCK = 16
# Rows that are worth a place of their own in memory; bytes of a line of the cache.
_LONG, _LINE = 1024, 64


def empty(shape: tuple[int, ...], width: int, dtype: np.dtype[Any]) -> Array:
    """An array ``(*shape, width)`` for a kernel to write into, see `batches`."""
    count = prod(shape)
    if count < _BLOCK:
        return np.empty((*shape, width), dtype)
    rows = _columns(width, -(-count // _BLOCK) * _BLOCK, dtype)[:, :count]
    if len(shape) == 1:
        return rows.T
    return np.moveaxis(rows.reshape(width, *shape), 0, -1)


def _columns(width: int, count: int, dtype: np.dtype[Any]) -> Array:
    """An array ``(width, count)``; long ones begin on a cache line, as do their rows.

    Where each vector that is stored lies across two lines, kernels take up to 1.7 times as long.
    Rows of an odd number of lines keep apart in the cache.
    """
    if count < _LONG:
        return np.empty((width, count), dtype)
    step = (count * dtype.itemsize // _LINE | 1) * _LINE
    memory = np.empty(width * step + _LINE, np.uint8)
    first = -memory.__array_interface__["data"][0] % _LINE
    return memory[first : first + width * step].view(dtype).reshape(width, -1)[:, :count]


def spread(array: Array, shape: tuple[int, ...], trailing: int) -> Array:
    """The batch `shape` of an array whose rows a kernel can step through, or one row for all."""
    batch = array.shape[: array.ndim - trailing]
    if batch == shape and (len(shape) < 2 or array.flags.c_contiguous):
        return array
    rest = array.shape[array.ndim - trailing :]
    if prod(batch) == 1:
        return array.reshape(rest)
    whole = np.broadcast_to(array, (*shape, *rest))
    return whole if len(shape) < 2 else whole.reshape(prod(shape), *rest)  # copied if need be


def expect_arrays(*inputs: object) -> None:
    """Refuse what is no array with TypeError."""
    kinds = [type(one).__name__ for one in inputs if not isinstance(one, np.ndarray | np.generic)]
    if kinds:
        raise TypeError(f"expected NumPy arrays of float32 or float64, got {', '.join(kinds)}")


def batch_of(*inputs: Array) -> tuple[int, ...]:
    """The batch that inputs ``(*, n)`` broadcast to."""
    try:
        shape = inputs[0].shape[:-1]
        for other in inputs[1:]:
            if other.shape[:-1] != shape:
                shape = np.broadcast_shapes(shape, other.shape[:-1])
    except AttributeError:
        expect_arrays(*inputs)
        raise
    return shape


def checked_call(kernel: Callable[..., Any], width: int, *inputs: Array) -> tuple[Array, Any]:
    """Apply a kernel to inputs ``(*, n)`` of one precision; checked ones say if all are finite."""
    shape = batch_of(*inputs)
    out = empty(shape, width, inputs[0].dtype)
    return out, kernel(*[spread(one, shape, 1) for one in inputs], out)


def of_one(kernel: Callable[..., None], array: Array, width: int) -> Array:
    """Apply a kernel of one input ``(*, n)``."""
    return checked_call(kernel, width, array)[0]


def of_two(kernel: Callable[..., None], a: Array, b: Array, width: int) -> Array:
    """Apply a kernel of two inputs ``(*, n)`` whose batches broadcast."""
    return checked_call(kernel, width, a, b)[0]
