"""The figure put together: skin and pieces, weights, image, morph targets and clips."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from docs.making.figure.look.atlas import Chart, charts_of, packed, part_of
from docs.making.figure.look.bake import Texels, openness, texels_of
from docs.making.figure.look.paint import painted
from docs.making.figure.motions.expressions import with_expressions
from docs.making.figure.motions.gait import GAITS, gait_clip
from docs.making.figure.motions.standing import idle, turning, waving
from docs.making.figure.proportions import REFERENCE_HEIGHT_M, figure_skeleton
from docs.making.figure.shape.anatomy import body_field
from docs.making.figure.shape.expressions import expressions
from docs.making.figure.shape.fields import BodyField
from docs.making.figure.shape.pieces import Piece, pieces
from docs.making.figure.shape.surface import SymmetricMesh, meshed
from docs.making.figure.shape.weights import influences, rigid_head
from motorcade.animation.appearance import Appearance, Material, MaterialPart, TextureMap
from motorcade.animation.character import Character
from motorcade.animation.clip import MorphTarget
from motorcade.animation.skeleton import Skeleton
from motorcade.ga.arrays import FloatArray, IntArray

TRIANGLES, SIZE_PX, FACE = 5_900, 1024, ("eye", "brow", "mouth")
BUMP = 1.0
QUALITY = {"base": 85, "surface": 78, "normal": 76}
SHADED = 0.45
"""Share of the light kept off that is painted into the colours, for light without ambient."""


def figure() -> Character:
    """The figure at the reference height."""
    field, skeleton = body_field(), figure_skeleton()
    mesh = _scaled_mesh(meshed(field, TRIANGLES))
    weights = rigid_head(mesh, skeleton, *influences(mesh, skeleton))
    every = pieces(field)
    parts = np.array([part_of(name) for name in skeleton.names])[np.argmax(weights, axis=1)]
    charts = charts_of(mesh, parts, every)
    pixels, scale = packed(charts, SIZE_PX)
    sheet = _Sheet(skeleton)
    surfaces = []
    # the face comes last: it alone has morph targets
    for number in sorted(range(len(charts)), key=lambda k: charts[k].name in FACE):
        sheet.add(charts[number], pixels[number] / SIZE_PX, mesh, weights, every)
    for chart in charts:
        whole = mesh if chart.piece < 0 else every[chart.piece]
        surfaces.append((whole.vertices[chart.rows], whole.normals[chart.rows]))
    texels = texels_of(charts, pixels, surfaces, SIZE_PX)
    material = _material(charts, texels, openness(texels, field, every), scale)
    gaits = [gait_clip(name, skeleton) for name in GAITS]
    clips = (idle(skeleton), *gaits, waving(skeleton), turning(skeleton))
    return sheet.character(material, with_expressions(clips), _targets(field, sheet))


def _scaled_mesh(mesh: SymmetricMesh) -> SymmetricMesh:
    """What a coarse mesh lacks at crown and soles made up for."""
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    vertices = (mesh.vertices - [0.0, 0.0, low]) * (REFERENCE_HEIGHT_M / (high - low))
    return SymmetricMesh(vertices, mesh.normals, mesh.triangles, mesh.twins, mesh.step_m)


def _targets(field: BodyField, sheet: _Sheet) -> tuple[MorphTarget, ...]:
    made = []
    for name, moves in expressions(field).items():
        rows = np.concatenate([sheet.rows_of[piece] for piece in moves])
        steps = np.concatenate([moves[piece] for piece in moves])
        made.append(MorphTarget(name, rows, steps, np.zeros_like(steps)))
    return tuple(made)


class _Sheet:
    """Vertices of both sides, chart by chart.

    Args:
        skeleton: that carries them.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.skeleton = skeleton
        self.rows_of: dict[str, IntArray] = {}
        self._columns: list[list[NDArray[np.float64]]] = [[], [], [], []]
        self._triangles: list[IntArray] = []
        self._count = self._plain = 0
        names = [name.replace("left_", "+").replace("right_", "left_") for name in skeleton.names]
        swapped = [name.replace("+", "right_") for name in names]
        self._other = np.array([skeleton.index(name) for name in swapped])

    def add(
        self,
        chart: Chart,
        uv: FloatArray,
        mesh: SymmetricMesh,
        weights: FloatArray,
        every: list[Piece],
    ) -> None:
        """Add a chart and, where there is one, its mirror image on the right."""
        body = chart.piece < 0
        if body:
            whole: SymmetricMesh | Piece = mesh
            own = weights[chart.rows]
        else:
            whole = every[chart.piece]
            own = self._carried(every[chart.piece], mesh, weights)
        vertices, normals = whole.vertices[chart.rows], whole.normals[chart.rows]
        first = self._count
        self._put(vertices, normals, own, uv, chart.triangles, chart.name)
        if body or every[chart.piece].mirrored:
            flip = np.array([1.0, -1.0, 1.0])
            other = own[:, self._other]
            self._put(
                vertices * flip, normals * flip, other, uv, chart.triangles[:, ::-1], chart.name
            )
        rows = np.arange(first, self._count)
        known = self.rows_of.get(chart.name, np.zeros(0, dtype=np.int64))
        self.rows_of[chart.name] = np.concatenate([known, rows])

    def _put(
        self,
        vertices: FloatArray,
        normals: FloatArray,
        weights: FloatArray,
        uv: FloatArray,
        triangles: IntArray,
        name: str,
    ) -> None:
        for column, values in zip(self._columns, (vertices, normals, weights, uv), strict=True):
            column.append(values)
        self._triangles.append(triangles + self._count)
        self._count += len(vertices)
        if name not in FACE:
            self._plain += len(triangles)

    def _carried(self, piece: Piece, mesh: SymmetricMesh, weights: FloatArray) -> FloatArray:
        """Weights (V, J) of a piece: its joint's, or those of the skin below it."""
        if piece.joint:
            made = np.zeros((len(piece.vertices), len(self.skeleton)))
            made[:, self.skeleton.index(piece.joint)] = 1.0
            return made
        from scipy.spatial import cKDTree

        apart, near = cKDTree(mesh.vertices).query(piece.vertices, k=5)
        share = 1.0 / (apart + 0.004) ** 2
        share /= share.sum(axis=1, keepdims=True)
        return np.asarray(np.einsum("vk,vkj->vj", share, weights[near]))

    def character(
        self, material: Material, clips: tuple, targets: tuple[MorphTarget, ...]
    ) -> Character:
        """All of it, standing on the ground."""
        vertices, normals, weights, uv = (np.concatenate(column) for column in self._columns)
        vertices = vertices - [0.0, 0.0, vertices[:, 2].min()]
        joints = np.argsort(-weights, axis=1, kind="stable")[:, :4]
        kept = np.take_along_axis(weights, joints, axis=1)
        kept[kept < 2e-3] = 0.0
        kept = (kept / kept.sum(axis=1, keepdims=True)).astype(np.float32).astype(np.float64)
        kept[:, 0] += 1.0 - kept.sum(axis=1)
        triangles = np.concatenate(self._triangles)
        look = Appearance(
            (
                MaterialPart(material, 0, self._plain),
                MaterialPart(material, self._plain, len(triangles)),
            ),
            uv[None].astype(np.float32),
        )
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return Character(
            self.skeleton,
            vertices,
            normals / length,
            triangles,
            np.ones_like(vertices),
            np.where(kept > 0.0, joints, joints[:, :1]),
            kept,
            clips,
            appearance=look,
            morphs=targets,
        )


@dataclass(frozen=True)
class _Images:
    """Channels (H, W, C) from 0 to 1."""

    base: FloatArray
    surface: FloatArray
    relief_m: FloatArray


def _material(charts: list[Chart], texels: Texels, free: FloatArray, scale: float) -> Material:
    """Base colour; occlusion, roughness and metal in one image; normals of the relief."""
    drawn = _painted(charts, texels)
    shade = 1.0 - SHADED * (1.0 - free)
    base = drawn.base * shade[..., None] ** np.array([0.9, 1.0, 1.0])
    surface = drawn.surface.copy()
    surface[..., 0] = free
    finer = np.array([chart.finer for chart in charts])[texels.chart]
    normal = _bent(drawn.relief_m, scale * finer, texels.chart)
    half = surface.reshape(SIZE_PX // 2, 2, SIZE_PX // 2, 2, 3).mean(axis=(1, 3))
    shared = _map(half, QUALITY["surface"])
    return Material(
        "explorer",
        metallic=1.0,
        roughness=1.0,
        base_map=_map(base, QUALITY["base"]),
        metallic_roughness_map=shared,
        occlusion_map=shared,
        normal_map=_map(0.5 + 0.5 * normal, QUALITY["normal"]),
    )


def _painted(charts: list[Chart], texels: Texels) -> _Images:
    shape = texels.chart.shape
    base, surface, relief = np.zeros((*shape, 3)), np.zeros((*shape, 3)), np.zeros(shape)
    for number, chart in enumerate(charts):
        here = texels.chart == number
        paint = painted(chart.name, texels.points[here], texels.flat_m[here])
        base[here], relief[here] = paint.color, paint.relief_m
        surface[here, 1], surface[here, 2] = paint.rough, paint.metal
    return _Images(np.clip(base, 0.0, 1.0), surface, relief)


def _bent(relief_m: FloatArray, per_m: FloatArray, chart: IntArray) -> FloatArray:
    """Unit normals (H, W, 3) of a relief, x to the right and y up as glTF has it."""
    right = np.roll(relief_m, -1, axis=1) - np.roll(relief_m, 1, axis=1)
    down = np.roll(relief_m, -1, axis=0) - np.roll(relief_m, 1, axis=0)
    right = np.where(np.roll(chart, -1, axis=1) == np.roll(chart, 1, axis=1), right, 0.0)
    down = np.where(np.roll(chart, -1, axis=0) == np.roll(chart, 1, axis=0), down, 0.0)
    slope = 0.5 * BUMP * per_m
    made = np.stack([-slope * right, slope * down, np.ones_like(relief_m)], axis=-1)
    made[..., :2] = np.clip(made[..., :2], -0.9, 0.9)
    return np.asarray(made / np.linalg.norm(made, axis=-1, keepdims=True))


def _map(values: FloatArray, quality: int) -> TextureMap:
    """An image (H, W, 3) from 0 to 1 as JPEG, with the pixels that it decodes to."""
    from PIL import Image

    held = io.BytesIO()
    image = Image.fromarray(np.round(255.0 * values).astype(np.uint8))
    image.save(held, "JPEG", quality=quality, optimize=True, subsampling=2)
    pixels = np.asarray(Image.open(io.BytesIO(held.getvalue())).convert("RGBA"))
    return TextureMap(pixels, encoded=held.getvalue())
