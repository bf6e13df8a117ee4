"""The filters for those without Python: ``include/motorcade/smooth.h``, one header of C99.

What a motor does is written from the definitions of `motorcade.ga`, as the compiled kernels are;
the filters around it are the files of `native`. `python -m motorcade.fusion.smoothing.header`
writes it anew.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["get_include", "header_text"]

_PARTS = ("poses", "covariance", "kalman", "smoother", "one_euro")
_MOTORS = {
    "normalize": "normalize",
    "exp": "exp",
    "local": "local",
    "retract": "retract",
    "adjoint": "adjoint",
    "translation": "translation",
    "motor_of": "motor_of",
}
"""Functions of the header, and the kernels that they are."""
_ASCII = {"∞": "inf", "π": "pi", "²": "^2"}
"""A compiler may take comments for text of any encoding."""


def get_include() -> str:
    """The folder for a compiler's ``-I``: ``#include "motorcade/smooth.h"`` is found there.

    >>> from pathlib import Path
    >>> from motorcade.fusion.smoothing.header import get_include
    >>> (Path(get_include()) / "motorcade" / "smooth.h").is_file()
    True
    """
    return str(Path(__file__).resolve().parents[3] / "include")


def header_text() -> str:
    """The header, from the definitions and the files of `native`.

    Raises:
        ModuleNotFoundError: without CasADi or mpmath, which only this needs.
    """
    from motorcade.ga.codegen.targets.c import c_function
    from motorcade.ga.kernels.definitions.library import FUNCTIONS

    kernels = {kernel.name: kernel for _, kernel in FUNCTIONS}
    motors = [
        c_function(f"motorcade_inner_{name}", kernels[kernel], "static inline")
        for name, kernel in _MOTORS.items()
    ]
    text = "\n".join([_part("opening"), *(f"{one}\n" for one in motors), *map(_part, _PARTS)])
    text += "\n" + _part("closing")
    for written, plain in _ASCII.items():
        text = text.replace(written, plain)
    return text


def _part(name: str) -> str:
    part = Path(__file__).parent / "native" / f"{name}.h"
    return part.read_text(encoding="utf-8")
