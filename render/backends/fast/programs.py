"""Shader programs: put together from the files beside this one, compiled once for each need."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from motorcade.ga import kernels

_SHADERS = Path(__file__).parent / "shaders"
_CARRYING = Path(kernels.__file__).parent / "generated" / "glsl" / "skinning.glsl"
_VERSION = "#version 330 core\n"


class Programs:
    """The programs of one context, by what they are for.

    Args:
        gl: moderngl's context.
    """

    def __init__(self, gl: Any) -> None:
        self._gl = gl
        self._made: dict[tuple[object, ...], Any] = {}

    def surface(self, *, lit: bool, colored: bool, textured: bool, lamps: int) -> Any:
        """Draws surfaces into the picture."""
        names = ("LIT", lit), ("COLORED", colored), ("TEXTURED", textured)
        defined = {name: "" for name, wanted in names if wanted} | {"LAMPS": str(lamps)}
        head = _head(defined)
        return self._program(
            ("surface", lit, colored, textured, lamps),
            vertex_shader=head + _text("surface.vert"),
            fragment_shader=head + _text("surface.frag"),
        )

    def shadow(self) -> Any:
        """Draws surfaces into the shadow map."""
        return self._program(
            ("shadow",),
            vertex_shader=_VERSION + _text("shadow.vert"),
            fragment_shader=_VERSION + _text("shadow.frag"),
        )

    def carry(self, function: str, rows: int, *, signed: bool) -> Any:
        """Carries vertices by a palette with one of the generated functions."""
        defined = {"CARRY": function, "ROWS": str(rows)} | ({"SIGNED": ""} if signed else {})
        return self._program(
            ("carry", function),
            vertex_shader=_head(defined) + _generated() + _text("carry.vert"),
            varyings=("position", "normal"),
        )

    def release(self) -> None:
        """Free them."""
        for program in self._made.values():
            program.release()
        self._made = {}

    def _program(self, key: tuple[object, ...], **sources: Any) -> Any:
        if key not in self._made:
            self._made[key] = self._gl.program(**sources)
        return self._made[key]


def _head(defined: dict[str, str]) -> str:
    return _VERSION + "".join(f"#define {name} {value}\n" for name, value in defined.items())


@cache
def _text(name: str) -> str:
    return (_SHADERS / name).read_text(encoding="ascii")


@cache
def _generated() -> str:
    return _CARRYING.read_text(encoding="ascii")
