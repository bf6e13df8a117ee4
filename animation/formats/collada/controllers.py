"""Skins and meshes of a Collada document as surfaces with materials.

A corner names a position, a normal, a texture coordinate and a colour apart; each different
combination becomes a vertex. Polygons are cut into fans.

Colours are sRGB, by habit of the programs that write them. What Phong, Blinn and Lambert say
becomes a dielectric of the diffuse colour whose roughness follows from the exponent of its
highlight; its own specular colour, and images for anything but colour, transparency and emission,
are left out.

Sources: Khronos Group, COLLADA 1.4.1. Roughness is that whose GGX lobe is as high as Blinn's of
exponent n: α² = 2 / (n + 2), α its square (Walter et al., Microfacet models for refraction, 2007).
Phong's exponent is a quarter of Blinn's (Fisher and Woo, R.E versus N.H specular highlights, 1994).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import Filter, Material, TextureMap, Wrap, to_linear
from motorcade.animation.formats.collada.library import (
    Element,
    Library,
    inputs_of,
    matrices_of,
    number,
)
from motorcade.animation.formats.collada.scene import ColladaScene
from motorcade.animation.formats.images import Texture, Textures, colors_at_vertices
from motorcade.animation.formats.limits import (
    MAX_VALUES,
    MAX_VERTICES,
    FormatError,
    check_count,
    expected,
    image_beside,
    read_bounded,
    shown,
)
from motorcade.animation.formats.rig.values import RigSurface, Skin
from motorcade.ga.arrays import FloatArray, IntArray

PLAIN = (0.8, 0.8, 0.8)
SHADERS = ("phong", "blinn", "lambert", "constant")
WRAPS: dict[str, Wrap] = {"WRAP": "repeat", "MIRROR": "mirror"}
BLINN_OF_PHONG = 4.0
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Of the specification, for transparency by colour."""


def roughness_of(exponent: float) -> float:
    """Roughness of the GGX lobe that is as high as Blinn's of an exponent.

    >>> roughness_of(0.0), round(roughness_of(30.0), 3)
    (1.0, 0.5)
    """
    return float((2.0 / (max(exponent, 0.0) + 2.0)) ** 0.25)


class ColladaMaterials:
    """Reads the materials of one document, each once; textures are looked for in `folder`."""

    def __init__(self, library: Library, folder: Path) -> None:
        self._library = library
        self._folder = folder
        self._textures = Textures()
        self._made: dict[str, Material] = {}
        self._lost: set[str] = set()

    @property
    def notices(self) -> list[str]:
        """Textures that could not be read, and what is not drawn."""
        notes = list(self._textures.notices)
        if self._lost:
            notes.append(f"materials are drawn without {shown(', '.join(sorted(self._lost)), 400)}")
        return notes

    def material(self, symbol: str, instance: Element) -> Material:
        """What an instance of a mesh binds to a symbol; plain grey where that is nothing."""
        bound = next(
            (one for one in instance.every("instance_material") if one.get("symbol") == symbol),
            None,
        )
        target = "" if bound is None else bound.get("target")
        if target not in self._made:
            self._made[target] = self._material(target)
        return self._made[target]

    def _material(self, target: str) -> Material:
        entry = self._library.find(target)
        link = None if entry is None else entry.first("instance_effect")
        effect = None if link is None else self._library.find(link.get("url"))
        name = "" if entry is None else (entry.get("name") or entry.get("id"))[:100]
        plain = Material(name, (*to_linear(np.array(PLAIN)).tolist(), 1.0), 0.0)
        technique = None if effect is None else effect.first("profile_COMMON", "technique")
        if effect is None or technique is None:
            return plain
        for kind in SHADERS:
            shader = technique.first(kind)
            if shader is not None:
                return self._shaded(plain, effect, kind, shader)
        return plain

    def _shaded(self, plain: Material, effect: Element, kind: str, shader: Element) -> Material:
        color, image = self._value(effect, shader.first("diffuse"))
        glow, lamp = self._value(effect, shader.first("emission"))
        if kind == "constant" and shader.first("diffuse") is None:
            color, image, glow, lamp = glow, lamp, None, None
        base = np.array(plain.base_color[:3])
        if image is not None:
            base = np.ones(3)
        elif color is not None:
            base = to_linear(np.clip(color[:3], 0.0, 1.0))
        alpha, see_through = self._alpha(effect, shader, image, plain.name)
        emission = (0.0, 0.0, 0.0) if glow is None else to_linear(np.clip(glow[:3], 0, 1)).tolist()
        self._note_left_out(effect, shader)
        return replace(
            plain,
            base_color=(*base.tolist(), alpha),
            base_map=image,
            roughness=_roughness(kind, shader),
            emission=(1.0, 1.0, 1.0) if lamp is not None else tuple(emission),
            emission_map=lamp,
            alpha_mode="blend" if alpha < 1.0 or see_through else "opaque",
            # The extension of Google Earth, which most programs write.
            double_sided=any(
                side.text.strip() in ("1", "true") for side in effect.every("double_sided")
            ),
            unlit=kind == "constant",
        )

    def _alpha(
        self, effect: Element, shader: Element, image: TextureMap | None, name: str
    ) -> tuple[float, bool]:
        """Opacity, and whether the image's own alpha is meant."""
        transparent = shader.first("transparent")
        share = _number(shader.first("transparency"), 1.0)
        if transparent is None:
            return 1.0, False
        color, veil = self._value(effect, transparent)
        if veil is not None:
            own = image is not None and veil.pixels is image.pixels
            if not own:
                self._lost.add("images of transparency")
            return 1.0, own and bool((veil.pixels[..., 3] < 255).any())
        tint = np.ones(4) if color is None or len(color) < 4 else color[:4]
        alpha = float(tint[3]) * share
        if transparent.get("opaque") == "RGB_ZERO":
            alpha = 1.0 - float(LUMINANCE @ tint[:3]) * share
        if not alpha > 0.0:  # programs differ on which end is clear; nobody draws what is not seen
            self._lost.add(f"the transparency of '{shown(name, 40)}', which would hide it")
            return 1.0, False
        return min(alpha, 1.0), False

    def _note_left_out(self, effect: Element, shader: Element) -> None:
        """Note what is left out."""
        for name in ("specular", "ambient", "reflective", "shininess"):
            if shader.first(name, "texture") is not None:
                self._lost.add(f"images of {name} light" if name != "shininess" else name)
        if next(effect.every("bump"), None) is not None:
            self._lost.add("bump maps")

    def _value(
        self, effect: Element, element: Element | None
    ) -> tuple[FloatArray | None, TextureMap | None]:
        """A colour of three numbers or more, or an image."""
        if element is None:
            return None, None
        color, texture = element.first("color"), element.first("texture")
        if color is not None:
            values = color.floats()
            return (values if len(values) >= 3 else None), None
        return None, None if texture is None else self._map(effect, texture.get("texture"))

    def _map(self, effect: Element, name: str) -> TextureMap | None:
        """The image that a sampler of the effect leads to, as it says."""
        profile = effect.needed("profile_COMMON")
        sampler: Element | None = None
        for _ in range(2):  # sampler, then surface
            parameter = next(
                (one for one in profile.all("newparam") if one.get("sid") == name), None
            )
            if parameter is None:
                break
            sampler = parameter.first("sampler2D") or sampler
            source = next(parameter.every("source"), None) or next(
                parameter.every("init_from"), None
            )
            if source is None:
                break
            name = source.text.strip()
        stored = self._library.find(f"#{name}")
        start = None if stored is None else next(stored.every("init_from"), None)
        image = None if start is None else self._image(start.text.strip())
        if image is None:
            return None
        return TextureMap(image.pixels, encoded=image.encoded, **_sampling(sampler))

    def _image(self, uri: str) -> Texture | None:
        return self._textures.read(
            uri, lambda: read_bounded(image_beside(self._folder, uri, "texture"))
        )


def _sampling(element: Element | None) -> dict[str, Any]:
    """How a sampler reads its image; smoothly and repeating where it does not say."""
    if element is None:
        return {}
    wrap = []
    for axis in ("wrap_s", "wrap_t"):
        said = element.first(axis)
        wrap.append("repeat" if said is None else WRAPS.get(said.text.strip(), "clamp"))
    nearest: dict[str, Filter] = {}
    for ours, theirs in (("magnify", "magfilter"), ("minify", "minfilter")):
        said = element.first(theirs)
        if said is not None and said.text.strip().startswith("NEAREST"):
            nearest[ours] = "nearest"
    return {"wrap": tuple(wrap), **nearest}


def _roughness(kind: str, shader: Element) -> float:
    """1 without a highlight."""
    specular = shader.first("specular", "color")
    dark = specular is not None and not specular.floats()[:3].any()
    if kind not in ("phong", "blinn") or shader.first("specular") is None or dark:
        return 1.0
    exponent = _number(shader.first("shininess"), 0.0)
    return roughness_of(exponent * (BLINN_OF_PHONG if kind == "phong" else 1.0))


def _number(element: Element | None, default: float) -> float:
    """The number of `<float>` within an element."""
    inside = None if element is None else element.first("float")
    if inside is None:
        return default
    values = inside.floats()
    return float(values[0]) if len(values) else default


MOST_INFLUENCES = 64


class Controllers:
    """Reads the surfaces of one document; `notices` gathers what was left out."""

    def __init__(self, library: Library, scene: ColladaScene, materials: ColladaMaterials) -> None:
        self._library = library
        self._scene = scene
        self._materials = materials
        self.notices: list[str] = []
        self._geometries: dict[str, tuple[list[PolygonGroup], list[str]]] = {}
        self._total = 0

    def surfaces(self) -> tuple[tuple[RigSurface, ...], tuple[int, ...]]:
        """Surfaces of every node, and the nodes that skins call joints.

        Raises:
            FormatError: sources that are missing or do not fit, or joints that are no nodes.
        """
        rig_surfaces: list[RigSurface] = []
        joints: set[int] = set()
        for node, element in enumerate(self._scene.elements):
            for instance in element.all("instance_controller"):
                skin = self._skin_of(instance.get("url"))
                if skin is not None:
                    surfaces, held = self._skinned(skin, instance, node)
                    rig_surfaces += surfaces
                    joints.update(held)
            for instance in element.all("instance_geometry"):
                rig_surfaces += self._hanging(instance, node)
        return tuple(rig_surfaces), tuple(sorted(joints))

    def _skin_of(self, url: str) -> Element | None:
        controller = self._library.named(url, "controller", "instance_controller")
        skin = controller.first("skin")
        if skin is None:
            self.notices.append(f"'{controller.get('id')[:60]}' morphs a mesh: left out")
        return skin

    def _parts(self, geometry: Element) -> tuple[list[PolygonGroup], list[str]]:
        """Parts of a geometry, which several nodes may share; read once."""
        key = geometry.get("id")
        if key not in self._geometries:
            self._geometries[key] = read_geometry(self._library, geometry)
        parts, notices = self._geometries[key]
        self._total += sum(max(len(part.vertices), len(part.triangles)) for part in parts)
        check_count("vertices and triangles", self._total, MAX_VERTICES)
        return parts, notices

    def _hanging(self, instance: Element, node: int) -> list[RigSurface]:
        geometry = self._library.named(instance.get("url"), "geometry", "instance_geometry")
        if geometry.first("mesh") is None:
            self.notices.append(f"'{geometry.get('id')[:60]}' is no mesh: left out")
            return []
        parts, notices = self._parts(geometry)
        self.notices += notices
        name = (geometry.get("name") or geometry.get("id"))[:60]
        return [self._surface(part, instance, node, name) for part in parts]

    def _surface(self, part: PolygonGroup, instance: Element, node: int, name: str) -> RigSurface:
        """A part of a mesh with its looks; coordinates go down from the upper left corner."""
        count = len(part.vertices)
        material = self._materials.material(part.material, instance)
        coordinates: tuple[NDArray[np.float32], ...] = ()
        if part.uv is not None and np.abs(part.uv).max(initial=0.0) <= 1e6:
            coordinates = ((part.uv * (1.0, -1.0) + (0.0, 1.0)).astype(np.float32),)
        tints = None
        if part.colors is not None:
            tints = np.column_stack([to_linear(np.clip(part.colors, 0.0, 1.0)), np.ones(count)])
            material = replace(material, base_color=(1.0, 1.0, 1.0, material.base_color[3]))
        if material.maps and not coordinates:
            material = replace(material, base_map=None, emission_map=None)
        return RigSurface(
            name,
            node,
            part.vertices,
            part.normals,
            part.triangles,
            colors_at_vertices(material, coordinates, tints, count),
            material=material,
            coordinates=coordinates,
            vertex_colors=tints,
        )

    def _skinned(
        self, element: Element, instance: Element, node: int
    ) -> tuple[list[RigSurface], list[int]]:
        geometry = self._library.named(element.get("source"), "geometry", "skin source")
        name = (geometry.get("name") or geometry.get("id"))[:60]
        parts, notices = self._parts(geometry)
        self.notices += notices
        skin = self._skin(element, name)
        numbers, weights = self._influences(element, name, len(skin.nodes))
        bound = []
        for part in parts:
            if part.positions.max(initial=0) >= len(numbers):
                raise expected(f"skin of '{name}'", "weights of every vertex", len(numbers))
            bound.append(self._bound(part, instance, node, name, skin, numbers, weights))
        return bound, skin.nodes.tolist()

    def _bound(
        self,
        part: PolygonGroup,
        instance: Element,
        node: int,
        name: str,
        skin: Skin,
        numbers: IntArray,
        weights: FloatArray,
    ) -> RigSurface:
        bare = self._surface(part, instance, node, name)
        held = part.positions
        return replace(bare, skin=skin, influences=numbers[held], weights=weights[held])

    def _skin(self, element: Element, name: str) -> Skin:
        """Joints and inverse bind matrices, with the bind shape of the mesh folded in."""
        inputs = inputs_of(element.needed("joints"))
        if "JOINT" not in inputs or "INV_BIND_MATRIX" not in inputs:
            raise expected(f"skin of '{name}'", "JOINT and INV_BIND_MATRIX", sorted(inputs))
        called = self._library.names(inputs["JOINT"].get("source"), "JOINT")
        values = self._library.source(
            inputs["INV_BIND_MATRIX"].get("source"), "INV_BIND_MATRIX", 16
        )
        if not called or len(values) < len(called):
            raise expected(f"skin of '{name}'", f"{len(called)} bind matrices", len(values))
        nodes = []
        for joint_name in called:
            node = self._scene.joint(joint_name)
            if node is None:
                raise expected(
                    f"skin of '{name}'", "joints that are nodes of the scene", joint_name
                )
            nodes.append(node)
        matrices = matrices_of(values[: len(called)])
        shape = element.first("bind_shape_matrix")
        if shape is not None:
            matrices = matrices @ shape.floats(16).reshape(4, 4)
        if len(set(nodes)) < len(nodes):
            raise expected(f"skin of '{name}'", "different joints", "one twice")
        return Skin(np.array(nodes), matrices)

    def _influences(self, element: Element, name: str, joints: int) -> tuple[IntArray, FloatArray]:
        """Joint numbers (P, K) and weights (P, K) of the mesh's positions."""
        vertex_weights = element.needed("vertex_weights")
        inputs = inputs_of(vertex_weights)
        if "JOINT" not in inputs or "WEIGHT" not in inputs:
            raise expected(f"weights of '{name}'", "JOINT and WEIGHT", sorted(inputs))
        shares = self._library.source(inputs["WEIGHT"].get("source"), "WEIGHT", 1)[:, 0]
        at = {
            semantic: number(source.get("offset") or "0", f"weights of '{name}'", 0, 63)
            for semantic, source in inputs.items()
        }
        stride = 1 + max(at.values())
        counts = vertex_weights.needed("vcount").integers()
        pairs = vertex_weights.needed("v").integers()
        if counts.min(initial=0) < 0 or counts.sum() * stride != len(pairs):
            raise expected(f"weights of '{name}'", f"{counts.sum()} pairs", len(pairs))
        if counts.max(initial=0) > MOST_INFLUENCES:
            raise expected(
                f"weights of '{name}'", f"at most {MOST_INFLUENCES} a vertex", counts.max()
            )
        pairs = pairs.reshape(-1, stride)
        which, share = pairs[:, at["JOINT"]], pairs[:, at["WEIGHT"]]
        if np.any(which < -1) or np.any(which >= joints):
            raise expected(f"weights of '{name}'", f"joints below {joints}", which.max())
        if len(share) and (share.min() < 0 or share.max() >= len(shares)):
            raise expected(f"weights of '{name}'", f"weights below {len(shares)}", share.max())
        width = max(int(counts.max(initial=0)), 1)
        rows = np.repeat(np.arange(len(counts)), counts)
        columns = np.arange(len(pairs)) - np.repeat(np.cumsum(counts) - counts, counts)
        numbers = np.zeros((len(counts), width), dtype=np.int64)
        weights = np.zeros((len(counts), width))
        # Joint −1 means the bind shape itself: that share stays without a joint.
        numbers[rows, columns] = np.maximum(which, 0)
        weights[rows, columns] = np.where(which >= 0, shares[share], 0.0)
        return numbers, weights


KINDS = ("triangles", "polylist", "polygons", "trifans", "tristrips")
OTHERS = ("lines", "linestrips")


@dataclass(frozen=True, eq=False)
class PolygonGroup:
    """Polygons of one material.

    Args:
        material: its symbol.
        positions: (V,) number of each vertex's position in the mesh.
        vertices: (V, 3).
        normals: (V, 3) or None.
        uv: (V, 2) or None.
        colors: (V, 3) or None.
        triangles: (T, 3).
    """

    material: str
    positions: IntArray
    vertices: FloatArray
    normals: FloatArray | None
    uv: FloatArray | None
    colors: FloatArray | None
    triangles: IntArray


def read_geometry(library: Library, geometry: Element) -> tuple[list[PolygonGroup], list[str]]:
    """Parts of a geometry, and what was left out.

    Raises FormatError: no mesh, or numbers that do not fit its sources.
    """
    name = geometry.get("name") or geometry.get("id")
    mesh = geometry.first("mesh")
    if mesh is None:
        raise expected(f"geometry '{name}'", "a <mesh>", "another kind")
    vertices = inputs_of(mesh.needed("vertices"))
    if "POSITION" not in vertices:
        raise expected(f"geometry '{name}'", "positions", sorted(vertices))
    positions = library.source(vertices["POSITION"].get("source"), f"'{name}' POSITION", 3)
    if not len(positions):
        raise expected(f"geometry '{name}'", "positions", "none")
    parts, notices = [], []
    for child in mesh.children:
        if child.name in KINDS:
            part = _part(library, child, positions, vertices, name)
            if part is not None:
                parts.append(part)
        elif child.name in OTHERS:
            notices.append(f"<{child.name}> of '{name}' is left out")
    return parts, notices


def _part(
    library: Library,
    element: Element,
    positions: FloatArray,
    shared: dict[str, Element],
    name: str,
) -> PolygonGroup | None:
    inputs = inputs_of(element)
    if "VERTEX" not in inputs:
        raise expected(f"'{name}' <{element.name}>", "an input VERTEX", sorted(inputs))
    stride = 1 + max(_offset(one, name) for one in element.all("input"))
    corners, counts = _corners(element, stride, name)
    if not len(corners):
        return None
    column = corners[:, _offset(inputs["VERTEX"], name)]
    used = {"VERTEX": (_checked(column, positions, f"'{name}' VERTEX"), positions)}
    for semantic, width in (("NORMAL", 3), ("TEXCOORD", 2), ("COLOR", 3)):
        # What the vertices themselves bring goes by the number of the position.
        source = inputs.get(semantic) or shared.get(semantic)
        if source is None:
            continue
        values = library.source(source.get("source"), semantic, width)
        own = corners[:, _offset(source, name)] if semantic in inputs else column
        used[semantic] = _checked(own, values, f"'{name}' {semantic}"), values
    columns = np.stack([numbers for numbers, _ in used.values()], axis=1)
    unique, inverse = np.unique(columns, axis=0, return_inverse=True)
    taken = {
        semantic: values[unique[:, column_number]]
        for column_number, (semantic, (_, values)) in enumerate(used.items())
    }
    return PolygonGroup(
        element.get("material"),
        unique[:, 0],
        taken["VERTEX"],
        taken.get("NORMAL"),
        taken.get("TEXCOORD"),
        taken.get("COLOR"),
        inverse.reshape(-1)[_fans(counts)],
    )


def _offset(element: Element, name: str) -> int:
    return number(element.get("offset") or "0", f"'{name}' offset", 0, 63)


def _checked(numbers: IntArray, values: FloatArray, field: str) -> IntArray:
    if numbers.min() < 0 or numbers.max() >= len(values):
        raise expected(field, f"numbers below {len(values)}", numbers.max())
    return numbers


def _corners(element: Element, stride: int, name: str) -> tuple[IntArray, IntArray]:
    """Numbers (C, stride) of the corners, and how many corners (P,) each polygon has."""
    if element.name in ("polygons", "trifans", "tristrips"):
        if element.first("ph") is not None:
            raise expected(f"'{name}' <polygons>", "polygons without holes", "some with holes")
        runs = [one.integers() for one in element.all("p")]
        if any(len(run) % stride for run in runs):
            raise expected(f"'{name}' <p>", f"a multiple of {stride} numbers", "others")
        if element.name == "tristrips":
            runs = [run.reshape(-1, stride)[_strip(len(run) // stride)].reshape(-1) for run in runs]
        counts = np.array([len(run) // stride for run in runs], dtype=np.int64)
        flat = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
        if element.name == "tristrips":
            counts = np.full(len(flat) // stride // 3, 3)
        return flat.reshape(-1, stride), counts
    runs = [one.integers() for one in element.all("p")]
    flat = np.concatenate(runs) if runs else np.zeros(0, dtype=np.int64)
    if len(flat) % stride:
        raise expected(f"'{name}' <p>", f"a multiple of {stride} numbers", len(flat))
    corners = flat.reshape(-1, stride)
    if element.name == "triangles":
        if len(corners) % 3:
            raise expected(f"'{name}' <p>", "three corners a triangle", len(corners))
        return corners, np.full(len(corners) // 3, 3)
    counts = element.needed("vcount").integers()
    if counts.min(initial=0) < 0 or counts.sum() != len(corners):
        raise expected(f"'{name}' <vcount>", f"counts that sum to {len(corners)}", counts.sum())
    return corners, counts


def _strip(count: int) -> IntArray:
    """Corner numbers of a strip's triangles, every other one turned about."""
    first = np.arange(max(count - 2, 0))
    odd = first % 2
    return np.stack([first, first + 1 + odd, first + 2 - odd], axis=1).reshape(-1)


def _fans(counts: IntArray) -> IntArray:
    """Corner numbers (T, 3) of polygons cut into fans from their first corners."""
    pieces = np.maximum(counts - 2, 0)
    total = int(pieces.sum())
    if total > MAX_VALUES // 3:
        raise FormatError(f"polygons: expected at most {MAX_VALUES // 3} triangles, got {total}")
    first = np.repeat(np.cumsum(counts) - counts, pieces)
    step = np.arange(total) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)
