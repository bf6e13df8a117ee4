"""Surfaces in the memory of the renderer, and what carries them there.

A mesh has parts, each of its own material.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation import Character, Placement
from motorcade.animation.skin import SKIN_KERNELS, SkinMethod, checked_method
from motorcade.animation.vectors import box_corners
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.backends.materials import DrawnPart, Images, appearance_of
from motorcade.render.backends.programs import NUMBERS, PAIRS, QUADS, BareFunctions, Programs
from motorcade.render.backends.renderer import check_vertices
from motorcade.render.scene import Surface

_ROWS: dict[SkinMethod, int] = {"linear": 3, "dual_quaternion": 2, "motor": 2, "similarity": 3}


class RenderMesh:
    """One surface: its vertices in a buffer that may change, the rest in buffers that do not.

    Places are counted from `origin_m`: `corners_m` (8, 3) hold it, where it is known how far it
    reaches; `reach_m` (N, 3) are corners that hold it or nearly so.

    Args:
        parts: makes its parts of it and the buffer of its vertices.
        origin_m: (3,) the place from which it is counted: shaders have seven digits.
    """

    def __init__(
        self,
        gl: Any,
        programs: Programs,
        surface: Surface,
        parts: Callable[[Surface, Any], MeshParts],
        origin_m: FloatArray,
        *,
        lit: bool,
    ) -> None:
        self._gl, self.origin_m = gl, origin_m
        self._held: list[Any] = []
        self.shape = surface.vertices.shape
        self.corners_m: FloatArray | None = _corners(surface.vertices, origin_m)
        self.reach_m = _reach(self.corners_m)
        own_m = surface.vertices - origin_m
        self.vertices = self._buffer(_interleaved(own_m, surface.normals), dynamic=True)
        self.parts = parts(surface, self.vertices)
        self.parts.move(own_m)
        self.in_shadow_map: Any = None
        if lit and len(self.parts.casting):
            position = [(self.vertices, "3f4 12x", "in_position")]
            corners = self._buffer(self.parts.casting.astype(np.uint32))
            self.in_shadow_map = self._array(programs.shadow(), position, corners)

    def move(self, vertices: FloatArray, normals: FloatArray) -> None:
        """Write new vertices and normals."""
        check_vertices(self.shape, vertices, normals)
        self.corners_m = _corners(vertices, self.origin_m)
        self.reach_m = _reach(self.corners_m)
        own_m = vertices - self.origin_m
        self.parts.move(own_m)
        self.vertices.write(_interleaved(own_m, normals))

    def read(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Vertices and normals as they are drawn."""
        rows = np.frombuffer(self.vertices.read(), np.float32).reshape(-1, 6)
        places = (rows[:, :3] + self.origin_m).astype(np.float32)
        return places, rows[:, 3:].copy()

    def release(self) -> None:
        """Free everything."""
        self.parts.release()
        for part in reversed(self._held):
            part.release()
        self._held = []

    def _buffer(self, data: NDArray[Any], *, dynamic: bool = False) -> Any:
        buffer = self._gl.buffer(np.ascontiguousarray(data), dynamic=dynamic)
        self._held.append(buffer)
        return buffer

    def _array(self, program: Any, content: Any, corners: Any) -> Any:
        array = self._gl.vertex_array(program, content, corners)
        self._held.append(array)
        return array


_INFLUENCES = (
    ("4u2", "in_joints"),
    ("4f4", "in_weights"),
    ("4u2", "in_more_joints"),
    ("4f4", "in_more_weights"),
)


class SkinnedMesh:
    """A mesh whose vertices a shader carries by the joints of a character.

    Args:
        method: how the palette is written; one of `SKIN_METHODS`.

    Raises:
        ValueError: an unknown method, another number of vertices, more joints than a texture has
            rows.
    """

    def __init__(
        self, gl: Any, programs: Programs, mesh: RenderMesh, character: Character, method: str
    ) -> None:
        self._gl, self._mesh = gl, mesh
        known = checked_method(method)
        if character.vertices.shape != mesh.shape:
            raise ValueError(
                f"bind(character): expected {mesh.shape[0]} vertices as the surface has, got "
                f"{len(character.vertices)}"
            )
        self._shape = (len(character.skeleton), 4 * _ROWS[known])
        most = gl.info["GL_MAX_TEXTURE_SIZE"]
        if self._shape[0] > most:
            raise ValueError(f"bind(character): expected at most {most} joints")
        joints, weights = character.influences
        self._program = programs.carry(
            SKIN_KERNELS[known], _ROWS[known], signed=known != "linear", more=joints.shape[1] > 4
        )
        self._method, self._corners_m = known, box_corners(character.vertices)
        self._rest = gl.buffer(_interleaved(character.vertices, character.normals))
        self._held = [
            gl.buffer(np.ascontiguousarray(values[:, start : start + 4], kind))
            for start in range(0, joints.shape[1], 4)
            for values, kind in ((joints, np.uint16), (weights, np.float32))
        ]
        self._palette = gl.texture((_ROWS[known], self._shape[0]), 4, dtype="f4")
        self._palette.filter = gl.NEAREST, gl.NEAREST
        content = [
            (self._rest, "3f4 3f4", "in_position", "in_normal"),
            *(
                (buffer, *name)
                for buffer, name in zip(self._held, _INFLUENCES[: len(self._held)], strict=True)
            ),
        ]
        self._array = gl.vertex_array(self._program, content)

    def pose(self, entries: FloatArray, placement: Placement | None) -> None:
        """Carry the mesh, in the buffer from which it is drawn."""
        if entries.shape != self._shape:
            raise ValueError(
                f"pose(entries): expected a palette of shape {self._shape}, got {entries.shape}"
            )
        matrix = np.eye(4) if placement is None else placement.as_matrix()
        matrix[:3, 3] -= self._mesh.origin_m
        self._mesh.corners_m = None
        self._mesh.reach_m = _homogeneous(self._reach(entries)) @ matrix[:3].T
        self._palette.write(np.ascontiguousarray(entries, np.float32))
        self._palette.use(0)
        self._program["palette"] = 0
        self._program["world_from_character"].write(column_major(matrix))
        self._array.transform(self._mesh.vertices, self._gl.POINTS, vertices=self._mesh.shape[0])

    def _reach(self, entries: FloatArray) -> FloatArray:
        """Where the joints take the rest pose's box, made larger by half: what they carry is there.

        A blend of rigid motions may bulge a little out of the hull of its parts.
        """
        middle = self._corners_m.mean(axis=0)
        corners = middle + 1.5 * (self._corners_m - middle)
        values = np.asarray(entries, np.float64)[:, None]
        if self._method == "linear":
            rows = values.reshape(-1, 3, 4)
            return np.concatenate(np.einsum("jrk,ck->jcr", rows, _homogeneous(corners)))
        if self._method == "similarity":
            moved = Similarity.normalize(values).apply(corners)
        elif self._method == "dual_quaternion":
            moved = Motor.from_dual_quaternion(values).apply(corners)
        else:
            moved = Motor.normalize(values).apply(corners)
        return moved.reshape(-1, 3)

    def release(self) -> None:
        """Free everything."""
        for part in (self._array, self._palette, *self._held, self._rest):
            part.release()


def column_major(matrix: FloatArray) -> bytes:
    """A matrix (4, 4) as OpenGL reads it."""
    return np.ascontiguousarray(matrix.T, np.float32).tobytes()


def _corners(vertices: FloatArray, origin_m: FloatArray) -> FloatArray | None:
    """Corners of the box around vertices, from the origin; None without any."""
    return box_corners(vertices) - origin_m if len(vertices) else None


def _reach(corners_m: FloatArray | None) -> FloatArray:
    return np.zeros((0, 3)) if corners_m is None else corners_m


def _homogeneous(points: FloatArray) -> FloatArray:
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)


def _interleaved(vertices: FloatArray, normals: FloatArray) -> NDArray[np.float32]:
    rows = np.empty((len(vertices), 6), np.float32)
    rows[:, :3], rows[:, 3:] = vertices, normals
    return rows


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
        vertices: buffer of its vertices and normals, which may change.
        first_number: number of its first triangle, from 1.
    """

    def __init__(
        self,
        gl: Any,
        bare: BareFunctions,
        programs: Programs,
        images: Images,
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
        for look_part in look.parts:
            if look_part.stop == look_part.first:
                continue
            part = DrawnPart(programs, images, look_part, lit=lit, colored=colored, lamps=lamps)
            part.first_number = first_number + look_part.first
            self._arrange(part)
            if part.blended:
                self.blended.append(part)
                self._seen_through.append(np.unique(triangles[look_part.first : look_part.stop]))
            else:
                self.covering.append(part)
                casting.append(triangles[look_part.first : look_part.stop])
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
        buffer = self._gl.buffer(np.ascontiguousarray(data))
        self._held.append(buffer)
        return buffer

    def _look_up(self, buffer: Any, form: int) -> int:
        self._shown.append(self._bare.look_up(buffer, form))
        return self._shown[-1]


def draw_triangles(part: DrawnPart) -> None:
    """Draw a part's own triangles of its mesh."""
    numbers = part.part
    part.array.render(vertices=3 * (numbers.stop - numbers.first), first=3 * numbers.first)
