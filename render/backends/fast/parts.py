"""The parts of one mesh, each of its own material, in the memory of the renderer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.backends.fast.bare import NUMBERS, PAIRS, QUADS, BareFunctions
from motorcade.render.backends.fast.materials import DrawnPart, Pictures, appearance_of
from motorcade.render.backends.fast.programs import Programs
from motorcade.render.scene import Surface

CORNER_UNIT, VERTEX_UNIT, FIRST_PLACE_UNIT, SECOND_PLACE_UNIT, COLOR_UNIT = 7, 8, 9, 10, 11
"""Texture units of what shaders look up by the number of a triangle or vertex."""
UNITS = {
    "corners": CORNER_UNIT,
    "vertices": VERTEX_UNIT,
    "first_places": FIRST_PLACE_UNIT,
    "second_places": SECOND_PLACE_UNIT,
    "colors": COLOR_UNIT,
}


class MeshParts:
    """The parts of one surface: what covers, and what one sees through.

    Args:
        gl: moderngl's context.
        bare: functions of the same.
        programs: of the same.
        pictures: of the same.
        surface: what is drawn.
        vertices: buffer of its vertices and normals, which may change.
        lit: whether light falls on it.
        lamps: how many lamps there are.
        first_number: number of its first triangle, from 1.
    """

    def __init__(
        self,
        gl: Any,
        bare: BareFunctions,
        programs: Programs,
        pictures: Pictures,
        surface: Surface,
        vertices: Any,
        *,
        lit: bool,
        lamps: int,
        first_number: int,
    ) -> None:
        self._gl, self._bare = gl, bare
        self._held: list[Any] = []
        self._shown: list[int] = []
        look = appearance_of(surface)
        triangles = surface.triangles
        self._vertices, self._corners = vertices, self._buffer(triangles.astype(np.uint32))
        self._colors = None
        if look.colors is not None:
            self._colors = self._buffer(look.colors.astype(np.float32))
        colored = self._colors is not None
        self._sets = [self._buffer(one.astype(np.float32)) for one in look.coordinates]
        self._looked_up = {"vertices": self._look_up(vertices, PAIRS)}
        self._looked_up["corners"] = self._look_up(self._corners, NUMBERS)
        if self._colors is not None:
            self._looked_up["colors"] = self._look_up(self._colors, QUADS)
        self._places = [self._look_up(one, PAIRS) for one in self._sets]
        self.covering: list[DrawnPart] = []
        self.blended: list[DrawnPart] = []
        casting, self._seen_through = [triangles[:0]], []
        for given in look.parts:
            if given.stop == given.first:
                continue
            part = DrawnPart(programs, pictures, given, lit=lit, colored=colored, lamps=lamps)
            part.first_number = first_number + given.first
            self._arrange(part)
            if part.blended:
                self.blended.append(part)
                self._seen_through.append(np.unique(triangles[given.first : given.stop]))
            else:
                self.covering.append(part)
                casting.append(triangles[given.first : given.stop])
        self.casting: IntArray = np.concatenate(casting)
        self.middles_m: list[FloatArray] = []

    @property
    def programs(self) -> set[Any]:
        """Those that draw light."""
        return {part.program for part in (*self.covering, *self.blended)}

    @property
    def both_sides(self) -> bool:
        """Whether any part has no back."""
        return any(part.material.double_sided for part in (*self.covering, *self.blended))

    def move(self, vertices: FloatArray) -> None:
        """Find the middles of the parts through which one sees anew."""
        self.middles_m = [vertices[rows].mean(axis=0) for rows in self._seen_through]

    def use(self, part: DrawnPart) -> None:
        """Bind what the part's shaders look up, and tell them of its material."""
        part.use()
        shown = dict(self._looked_up)
        for name, number in zip(("first_places", "second_places"), part.sets, strict=False):
            shown[name] = self._places[number]
        for name, texture in shown.items():
            self._bare.use(texture, UNITS[name])

    def release(self) -> None:
        """Free everything."""
        for texture in self._shown:
            self._bare.forget(texture)
        for part in reversed(self._held):
            part.release()
        self._held, self._shown = [], []

    def _arrange(self, part: DrawnPart) -> None:
        """The arrays from which a part is drawn."""
        content: list[tuple[Any, ...]] = [
            (self._vertices, "3f4 3f4", "in_position", "in_normal")
            if part.blended
            else (self._vertices, "3f4 12x", "in_position")
        ]
        if self._colors is not None and (part.blended or part.masked):
            content.append((self._colors, "4f4", "in_color"))
        for number, name in zip(part.sets, ("in_first", "in_second"), strict=False):
            if part.blended:
                content.append((self._sets[number], "2f4", name))
        base = part.maps.get("base_map")
        if part.masked and base is not None:
            content.append((self._sets[base.coordinate_set], "2f4", "in_place"))
        program = part.program if part.blended else part.covering
        # What a program does not look at is left out.
        part.array = self._gl.vertex_array(program, content, self._corners, skip_errors=True)
        self._held.append(part.array)
        if not part.blended:
            for name, unit in UNITS.items():
                self._bare.tell_unit(part.program, name, unit)

    def _buffer(self, data: NDArray[Any]) -> Any:
        made = self._gl.buffer(np.ascontiguousarray(data))
        self._held.append(made)
        return made

    def _look_up(self, buffer: Any, form: int) -> int:
        self._shown.append(self._bare.look_up(buffer, form))
        return self._shown[-1]


def draw_triangles(part: DrawnPart) -> None:
    """Draw a part's own triangles of its mesh."""
    given = part.part
    part.array.render(vertices=3 * (given.stop - given.first), first=3 * given.first)
