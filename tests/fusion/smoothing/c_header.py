"""The C header as a library, so that tests may call it beside Python; its functions exported."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.smoothing.header import get_include
from motorcade.ga.arrays import FloatArray, IntArray

STRICT = ("-Wall", "-Wextra", "-pedantic", "-Wshadow", "-Wconversion", "-Werror")
_EXPORT = '-DMOTORCADE_API=__attribute__((visibility("default")))'


class Model(ctypes.Structure):
    """``motorcade_model``."""

    _fields_ = (
        ("order", ctypes.c_int),
        *((name, ctypes.c_double) for name in ("density_rad", "density_m", "noise_rad", "noise_m")),
    )


def compiled(source: Path, into: Path, *options: str, compiler: Sequence[str] = ("gcc",)) -> Path:
    """A C or C++ source with the header in its way; every warning is an error."""
    command = [*compiler, *STRICT, f"-I{get_include()}", *options, str(source), "-o", str(into)]
    done = subprocess.run([*command, "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return into


class Header:
    """The functions of the header, on arrays."""

    def __init__(self, folder: Path) -> None:
        source = folder / "exported.c"
        source.write_text('#include "motorcade/smooth.h"\n')
        options = "-std=c99", "-O2", "-fPIC", "-shared", _EXPORT
        self.c = ctypes.CDLL(str(compiled(source, folder / "exported.so", *options)))
        for name in ("kalman_size", "one_euro_size", "rts_work"):
            getattr(self.c, f"motorcade_{name}").restype = ctypes.c_size_t
        self.c.motorcade_message.restype = ctypes.c_char_p
        for order in ("velocity", "acceleration"):
            getattr(self.c, f"motorcade_constant_{order}").restype = Model

    def kalman(self, model: Model) -> Stream:
        """A filter of motion that has seen nothing."""
        return Stream(self, "kalman", ctypes.byref(model))

    def one_euro(self, *cutoffs: float) -> Stream:
        """A 1€ filter that has seen nothing."""
        return Stream(self, "one_euro", *map(ctypes.c_double, cutoffs))

    def rts(
        self, model: Model, motors: FloatArray, time_ns: IntArray, noise: FloatArray | None = None
    ) -> tuple[FloatArray, float]:
        """Smoothed motors, and the logarithm of the likelihood."""
        count = len(motors)
        size = self.c.motorcade_kalman_size()
        work = ctypes.create_string_buffer(
            size * self.c.motorcade_rts_work(ctypes.c_size_t(count)) or 1
        )
        out, told = np.empty((count, 8)), ctypes.c_double()
        given = None if noise is None else _at(noise)
        status = self.c.motorcade_rts(
            ctypes.byref(model),
            _at(motors),
            _at(time_ns),
            ctypes.c_size_t(count),
            given,
            _at(out),
            ctypes.byref(told),
            work,
        )
        refuse(self, status)
        return out, told.value


class Stream:
    """A filter of the header and its memory."""

    def __init__(self, header: Header, name: str, *start: Any) -> None:
        self.header, self.name = header, name
        size = getattr(header.c, f"motorcade_{name}_size")()
        self.memory = ctypes.create_string_buffer(size)
        refuse(header, getattr(header.c, f"motorcade_{name}_start")(self.memory, *start))

    def update(self, motor: FloatArray, time_ns: int) -> FloatArray:
        """One pose filtered."""
        return self._called("update", motor, time_ns)

    def predict(self, time_ns: int) -> FloatArray:
        """The pose expected at a stamp."""
        out = np.empty(8)
        status = self.header.c.motorcade_kalman_predict(
            self.memory, ctypes.c_int64(time_ns), _at(out)
        )
        refuse(self.header, status)
        return out

    def _called(self, verb: str, motor: FloatArray, time_ns: int) -> FloatArray:
        out = np.empty(8)
        call = getattr(self.header.c, f"motorcade_{self.name}_{verb}")
        refuse(self.header, call(self.memory, _at(motor), ctypes.c_int64(time_ns), _at(out)))
        return out


def refuse(header: Header, status: int) -> None:
    """Raise ValueError with the header's own words."""
    if status != 0:
        raise ValueError(header.c.motorcade_message(status).decode())


def _at(array: np.ndarray) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)
