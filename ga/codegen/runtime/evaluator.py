"""Runs a program's tape: as NumPy source at once, and as compiled C once that is there.

The first call in a precision looks whether the C was compiled before (`cache`); otherwise a thread
compiles it while calls go on with NumPy. MOTORCADE_PROGRAMS set to "numpy" has no C compiled, set
to "wait" has the first call wait for it. Which way a call goes changes results by rounding alone.
"""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from motorcade.ga import kernels
from motorcade.ga.codegen.precision import DOUBLE, SINGLE, Precision
from motorcade.ga.codegen.runtime.by_numpy import SYMBOL, NumpyProgram, c_source, plain_tape
from motorcade.ga.codegen.runtime.compiler import (
    CompileError,
    cache_folder,
    cache_key,
    cached_library,
    find_compiler,
    keep_library,
)
from motorcade.ga.codegen.tape import Tape

LONGEST_COMPILED = 20_000
"""Operations; longer programs stay with NumPy, as C compilers take minutes for them."""

_WAYS = ("", "numpy", "wait")
_log = logging.getLogger(__name__)


def way_wanted() -> str:
    """What MOTORCADE_PROGRAMS says: nothing, numpy or wait. Raises ValueError: anything else."""
    wanted = os.environ.get("MOTORCADE_PROGRAMS", "")
    if wanted not in _WAYS:
        raise ValueError(f"MOTORCADE_PROGRAMS: expected 'numpy', 'wait' or nothing, got {wanted!r}")
    return wanted


class Evaluator:
    """A program that runs on arrays, `arrays`, and on coefficients, `components`.

    Attributes:
        arrays: takes an array ``(*, n)`` for each input, or ``(*)`` or a number where that is a
            scalar, and gives one for each output.
        components: takes one number or array for each component of each input, those that are
            `negative` with the other sign, and gives a tuple of those of the outputs, which must
            be finite.
    """

    arrays: Callable[..., Any]
    components: Callable[..., tuple[Any, ...]]

    def __init__(self, name: str, tape: Tape, bare: bool, negative: Sequence[bool]) -> None:
        self._name = name
        self._plain = plain_tape(tape)
        self._inputs = [(o.name, -1 if o.components == ("1",) else o.width) for o in tape.inputs]
        self._outputs = [(o.name, -1 if o.components == ("1",) else o.width) for o in tape.outputs]
        self._bare = bare
        self._negative = list(negative)
        self._numpy = NumpyProgram(name, self._plain, self._inputs, self._outputs, self._negative)
        self._lock = threading.Lock()
        self._threads: dict[str, threading.Thread] = {}
        self._libraries: dict[str, str] = {}
        self._state: dict[str, str] = {}
        self._bind()

    def backend(self, precision: str = "float64") -> str:
        """How calls in a precision run now: "c", or "numpy" and why, in one line."""
        if precision in self._libraries:
            return "c"
        return f"numpy: {self._state.get(precision, 'not called yet')}"

    def wait(self, precision: str = "float64") -> bool:
        """Have the C of a precision compiled; whether it is there."""
        chosen = {p.numpy: p for p in (SINGLE, DOUBLE)}.get(precision)
        if chosen is None:
            raise ValueError(f"precision: expected float32 or float64, got {precision!a}")
        self._start(chosen)
        thread = self._threads.get(precision)
        if thread is not None:
            thread.join()
        return precision in self._libraries

    def _bind(self) -> None:
        """Calls go to the libraries that are there, and what they do not do to `_slowly`."""
        trampoline = _trampoline()
        if trampoline is None or not self._libraries:
            self.arrays = lambda *values: self._slowly("arrays", values)
            self.components = lambda *values: self._slowly("components", values)
            return
        arrays, components = trampoline.bind(
            self._name,
            self._inputs,
            self._outputs,
            self._negative,
            self._bare,
            self._libraries.get(SINGLE.numpy),
            self._libraries.get(DOUBLE.numpy),
            SYMBOL,
            kernels.threads,
        )
        if len(self._libraries) == 2:
            self.arrays, self.components = arrays, components
            return

        def either(of: Callable[..., Any], verb: str) -> Callable[..., Any]:
            def call(*values: Any) -> Any:
                result = of(*values)
                return self._slowly(verb, values) if result is NotImplemented else result

            return call

        self.arrays, self.components = either(arrays, "arrays"), either(components, "components")

    def _slowly(self, verb: str, values: Sequence[Any]) -> Any:
        """A call whose precision is not compiled: begin that, and do without."""
        precision = precision_of(values)
        if precision.numpy not in self._state:
            self._start(precision)
            if way_wanted() == "wait":
                self.wait(precision.numpy)
            if precision.numpy in self._libraries:
                return getattr(self, verb)(*values)
        if verb == "components":
            return self._numpy.components(precision, values)
        arrays = self._numpy.arrays(precision, values)
        return arrays[0] if self._bare else arrays

    def _start(self, precision: Precision) -> None:
        """Find the library of a precision, or have a thread compile it; does so once."""
        with self._lock:
            if precision.numpy in self._state:
                return
            self._state[precision.numpy] = "being compiled"
            trampoline = _trampoline()
            reason = ""
            if way_wanted() == "numpy":
                reason = "MOTORCADE_PROGRAMS says so"
            elif trampoline is None:
                reason = "the library was installed without compiled code"
            elif len(self._plain.nodes) > LONGEST_COMPILED:
                reason = f"more than {LONGEST_COMPILED} operations"
            if reason or trampoline is None:
                self._refused(precision, reason)
                return
            try:
                compiler = find_compiler(trampoline.processor_level())
                source = c_source(self._plain, precision)
                folder = cache_folder()
                key = cache_key(source, compiler.identity)
                path = cached_library(folder, key)
                if path is not None and self._load(precision, str(path)):
                    return
            except (CompileError, ValueError, OSError) as failed:
                self._refused(precision, str(failed))
                return

            def compile_it() -> None:
                try:
                    path = keep_library(folder, key, compiler.library(source, folder))
                except (CompileError, OSError) as failed:
                    self._refused(precision, str(failed))
                    return
                with self._lock:
                    self._load(precision, str(path))

            thread = threading.Thread(target=compile_it, name=f"compile {self._name}")
            self._threads[precision.numpy] = thread
            thread.start()

    def _load(self, precision: Precision, path: str) -> bool:
        """Call a library from now on; whether it could be loaded."""
        self._libraries[precision.numpy] = path
        try:
            self._bind()
        except RuntimeError as failed:
            del self._libraries[precision.numpy]
            self._refused(precision, str(failed))
            return False
        self._state[precision.numpy] = "compiled"
        _log.debug("%s: %s runs as compiled C, %s", self._name, precision.numpy, path)
        return True

    def _refused(self, precision: Precision, reason: str) -> None:
        self._state[precision.numpy] = reason
        _log.info("%s: %s runs as NumPy: %s", self._name, precision.numpy, reason)


def precision_of(values: Sequence[Any]) -> Precision:
    """The precision that arguments are computed in: float32 where all typed ones are."""
    kinds = {one.dtype for one in values if isinstance(one, np.ndarray | np.generic)}
    return SINGLE if kinds == {np.dtype(np.float32)} else DOUBLE


def _trampoline() -> Any:
    """The module that calls compiled programs; None where the library has no compiled code."""
    try:
        from motorcade.ga.codegen.runtime import _trampoline as found
    except ImportError:
        return None
    return found
