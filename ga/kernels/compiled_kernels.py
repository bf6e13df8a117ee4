"""Motor kernels in compiled SIMD code; the functions and results of `numpy_kernels`.

Here batches are broadcast and outputs allocated; the compiled module sees rows. Inputs are float64,
``(*, 8)`` or ``(*, 6)``, and are read in place where they are in C order.
"""

from __future__ import annotations

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.ga.kernels import _compiled

__all__ = ["compose", "exp", "interpolate", "inverse", "log"]


def _batch(*arrays: FloatArray) -> tuple[int, ...]:
    """The common batch shape; most often all are alike, which NumPy takes longer to find out."""
    shapes = {array.shape[:-1] for array in arrays}
    return shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)


def _rows(array: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """The batch `shape` of an array as contiguous rows, or one row that stands for them all."""
    width = array.shape[-1]
    if array.shape[:-1] != shape:
        if array.size == width:
            return np.ascontiguousarray(array).reshape(1, width)
        array = np.broadcast_to(array, (*shape, width))
    if array.ndim == 2 and array.flags.c_contiguous:
        return array
    return np.ascontiguousarray(array).reshape(-1, width)


def _result(shape: tuple[int, ...], width: int) -> tuple[FloatArray, FloatArray]:
    """A new array ``(*shape, width)`` and its rows."""
    made = np.empty((*shape, width))
    return made, made if len(shape) == 1 else made.reshape(-1, width)


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geometric product ``a b`` of motors, ``(*, 8)``."""
    shape = _batch(a, b)
    made, rows = _result(shape, 8)
    _compiled.compose(_rows(a, shape), _rows(b, shape), rows)
    return made


def inverse(m: FloatArray) -> FloatArray:
    """Reverse of motors, ``(*, 8)``: the inverse where they are unit."""
    made, rows = _result(m.shape[:-1], 8)
    _compiled.inverse(_rows(m, m.shape[:-1]), rows)
    return made


def exp(log: FloatArray) -> FloatArray:
    """Motors ``(*, 8)`` from bivectors ``(*, 6)`` on ``e23, e31, e12, e1∞, e2∞, e3∞``."""
    made, rows = _result(log.shape[:-1], 8)
    _compiled.exp(_rows(log, log.shape[:-1]), rows)
    return made


def log(m: FloatArray, short_way: bool = True) -> FloatArray:
    """Bivectors ``(*, 6)`` of unit motors ``(*, 8)``; the sign rule of `numpy_kernels.log`."""
    made, rows = _result(m.shape[:-1], 6)
    _compiled.log(_rows(m, m.shape[:-1]), rows, short_way)
    return made


def interpolate(
    a: FloatArray, b: FloatArray, fraction: FloatArray, short_way: bool = True
) -> FloatArray:
    """Screw interpolation ``a exp(fraction log(~a b))``; ``fraction`` broadcasts on the batch."""
    steps = fraction[..., None]
    shape = _batch(a, b, steps)
    made, rows = _result(shape, 8)
    _compiled.interpolate(_rows(a, shape), _rows(b, shape), _rows(steps, shape), rows, short_way)
    return made
