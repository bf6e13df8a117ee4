"""What the fast renderer keeps on the graphics card: shader programs and framebuffers."""

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

    def blended(self, defined: dict[str, str]) -> Any:
        """Draws parts of meshes with one kind of material through which one sees."""
        return self._of_material("blended", defined, _text("reflect.glsl"))

    def covered(self, defined: dict[str, str]) -> Any:
        """Draws which triangle each sample shows."""
        return self._of_material("covered", defined, "")

    def shaded(self, defined: dict[str, str]) -> Any:
        """Draws the light of one kind of material where samples show it."""
        return self._whole("shaded", defined, _text("reflect.glsl"))

    def marked(self) -> Any:
        """Draws where a part of a mesh is seen."""
        return self._whole("marked", {}, "")

    def resolved(self, *, blended: bool) -> Any:
        """Draws the picture as it is read."""
        return self._whole("resolved", {"BLENDED": ""} if blended else {}, "")

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

    def _of_material(self, name: str, defined: dict[str, str], above: str) -> Any:
        head = _head(defined)
        return self._program(
            (name, *sorted(defined.items())),
            vertex_shader=head + _text(f"{name}.vert"),
            fragment_shader=head + above + _text(f"{name}.frag"),
        )

    def _whole(self, name: str, defined: dict[str, str], above: str) -> Any:
        return self._program(
            (name, *sorted(defined.items())),
            vertex_shader=_VERSION + _text("whole.vert"),
            fragment_shader=_head(defined) + above + _text(f"{name}.frag"),
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


Box = tuple[int, int, int, int]
"""Left, bottom, width and height in pixels, rows from the bottom."""

SAMPLES = 4
SRGB8_ALPHA8, FRAMEBUFFER_SRGB = 0x8C43, 0x8DB9


class ShadowMap:
    """Depth as the sun sees it, to compare with.

    Args:
        gl: moderngl's context.
        size: of the square, texels.
    """

    def __init__(self, gl: Any, size: int) -> None:
        self._texture = gl.depth_texture((size, size))
        self._texture.compare_func = "<="
        self._texture.filter = gl.LINEAR, gl.LINEAR
        self._texture.repeat_x = self._texture.repeat_y = False
        self.drawn = gl.framebuffer(depth_attachment=self._texture)

    def use(self, unit: int) -> None:
        """Bind it to a texture unit."""
        self._texture.use(unit)

    def release(self) -> None:
        """Free it."""
        self.drawn.release()
        self._texture.release()
