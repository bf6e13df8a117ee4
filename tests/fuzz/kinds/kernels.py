"""Kernels on arrays of any layout: what came out of tidy copies, or a refusal.

Operands are reversed, strided, transposed, cut out of larger ones, spread, misaligned, of another
byte order or type, empty; outputs also overlap inputs. Numbers are of any size.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import kernels
from motorcade.ga.kernels.generated.python import KERNELS
from tests.fuzz.mutations import one_of
from tests.fuzz.runner import Feed

__all__ = ["prepare"]

Array = NDArray[Any]
COUNTS = (0, 1, 2, 5, 15, 16, 17, 54, 333)
NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, 1e-40, 1e38, np.nan, np.inf, -np.inf, 5e-324)


def prepare(folder: Path) -> Feed:
    """Kernels called on operands of any layout."""

    def feed(rng: np.random.Generator) -> str:
        name = one_of(list(KERNELS), rng)
        _, widths, width = KERNELS[name]
        dtype, count = one_of([np.float32, np.float64], rng), int(one_of(COUNTS, rng))
        given = [_numbers((count, size), dtype, rng) for size in widths]
        kernel = kernels.function(name)
        expected = np.zeros((count, width), dtype)
        with np.errstate(all="ignore"):
            kernel(*(np.ascontiguousarray(one) for one in given), expected)
        operands = [one_of(LAYOUTS, rng)(one, rng) for one in given]
        out = one_of(OUTPUTS, rng)(operands, width, count, dtype, rng)
        tidy = [np.array(one) for one in operands]
        try:
            with np.errstate(all="ignore"):
                kernel(*operands, out)
        except (TypeError, ValueError, BufferError):
            return "refused"
        alike = [np.array_equal(a, b, equal_nan=True) for a, b in zip(tidy, given, strict=True)]
        alike.append(out.shape == expected.shape)  # one row of input may fill more rows of output
        if all(alike) and not np.array_equal(out, expected, equal_nan=True):
            raise AssertionError(f"{name}: another result by another layout")
        return "valid"

    return feed


def _numbers(shape: tuple[int, ...], dtype: Any, rng: np.random.Generator) -> Array:
    made = rng.uniform(-1.0, 1.0, shape)
    if made.size and rng.random() < 0.3:
        made.reshape(-1)[int(rng.integers(made.size))] = one_of(NUMBERS, rng)
    with np.errstate(all="ignore"):
        return made.astype(dtype)


def _holder(shape: tuple[int, ...], dtype: Any, rng: np.random.Generator) -> Array:
    """An array of this shape cut out of memory, in a layout that may be written."""
    rows, width = shape
    kind = int(rng.integers(9))
    if kind == 0:
        return np.zeros((rows, width), dtype)
    if kind == 1:
        return np.zeros((width, rows), dtype).T
    if kind == 2:
        return np.zeros((rows, width), dtype)[::-1]
    if kind == 3:
        return np.zeros((rows, width), dtype)[:, ::-1]
    if kind == 4:
        return np.zeros((3 * rows + 1, 2 * width), dtype)[1::3, ::2][:rows]
    if kind == 5:
        return np.zeros((width + 2, rows + 3), dtype)[1:-1, 2 : 2 + rows].T
    if kind == 6:
        return np.zeros((2 * width, 2 * rows), dtype)[::-2, ::-2].T
    if kind == 7:  # misaligned
        size = rows * width * np.dtype(dtype).itemsize
        return np.zeros(size + 1, np.uint8)[1:].view(dtype).reshape(rows, width)
    return np.zeros((rows, 1, width), dtype)[:, 0]


def _laid(given: Array, rng: np.random.Generator) -> Array:
    made = _holder(given.shape, given.dtype, rng)
    made[...] = given
    if rng.random() < 0.2:
        made.setflags(write=False)
    return made


def _other(given: Array, rng: np.random.Generator) -> Array:
    """Another type, byte order, shape or count."""
    with np.errstate(all="ignore"):
        kinds: list[Callable[[], Array]] = [
            lambda: given.astype(given.dtype.newbyteorder()),
            lambda: given.astype(np.float16),
            lambda: np.nan_to_num(given).astype(np.int64),
            lambda: given.astype(object),
            lambda: given[:, :-1],
            lambda: given[:-1],
            lambda: given[None],
            lambda: given.reshape(-1),
            lambda: np.concatenate([given, given], axis=0)[: 2 * len(given)],
        ]
        return one_of(kinds, rng)()


def _spread(given: Array, rng: np.random.Generator) -> Array:
    """One row for all, with no stride."""
    if not len(given):
        return given
    return np.broadcast_to(given[:1], given.shape) if rng.random() < 0.5 else given[:1]


def _deep(given: Array, rng: np.random.Generator) -> Array:
    """Rows in two dimensions, which follow each other or not."""
    rows = len(given)
    if rows % 3:
        return given
    made = _laid(given, rng).reshape(rows // 3, 3, given.shape[1])
    return made[::-1] if rng.random() < 0.2 else made


LAYOUTS: list[Callable[[Array, np.random.Generator], Array]] = [_laid, _laid, _laid, _laid]
LAYOUTS += [_deep, _spread, _other]


def _apart(
    operands: list[Array], width: int, count: int, dtype: Any, rng: np.random.Generator
) -> Array:
    return _holder((count, width), dtype, rng)


def _in_the_way(
    operands: list[Array], width: int, count: int, dtype: Any, rng: np.random.Generator
) -> Array:
    """An output in the memory of an input, which then lies there too."""
    at = int(rng.integers(len(operands)))
    given = operands[at]
    if given.dtype != dtype or given.ndim != 2 or len(given) != count:
        return _holder((count, width), dtype, rng)
    most = max(width, given.shape[1])
    memory = np.zeros((count + 4, 2 * most + 2), dtype)
    row, column = int(rng.integers(4)), int(rng.integers(most + 2))
    operands[at] = memory[:count, : given.shape[1]]
    operands[at][...] = given
    out = memory[row : row + count, column : column + width]
    return out[::-1] if rng.random() < 0.3 else out


def _odd(
    operands: list[Array], width: int, count: int, dtype: Any, rng: np.random.Generator
) -> Array:
    kinds: list[Callable[[], Array]] = [
        lambda: np.broadcast_to(np.zeros(width, dtype), (count, width)),
        lambda: np.zeros((count, width + 1), dtype),
        lambda: np.zeros((count + 1, width), dtype),
        lambda: np.zeros((count, width), np.float32 if dtype is np.float64 else np.float64),
        lambda: np.zeros((count, width), np.int64),
        lambda: np.zeros((), dtype),
    ]
    return one_of(kinds, rng)()


OUTPUTS: list[Callable[..., Array]] = [_apart, _apart, _apart, _in_the_way, _odd]
