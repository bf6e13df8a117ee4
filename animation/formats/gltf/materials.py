"""Materials of a glTF document, and the colours that they give to vertices.

A surface keeps its whole material for renderers that sample textures at every pixel. Besides, every
vertex has one colour, for those that do not: vertex colours, base colour textures and base colour
factors multiplied, in linear light, as the format says, with textures sampled at the vertices.

Bones take VRM's names (`hips`, `leftUpperLeg`, …), by which their roles are told; the authors' own
names of such nodes are often those of no language. VRM 0 faces −z, VRM 1 as glTF does +z. What is
particular to it otherwise, such as springs of hair and looks of cartoons, is left out and named.

Source: VRM Consortium, VRM 0.0 and VRMC_vrm-1.0 specifications.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.appearance import MOST_SETS, AlphaMode, Material, TextureMap, Wrap
from motorcade.animation.formats.gltf.document import (
    OF_MATERIALS,
    UNDERSTOOD,
    Accessors,
    Document,
    boolean,
    floats,
    integer,
    listed,
    load,
    load_file,
    number,
    table,
    text,
)
from motorcade.animation.formats.images import Texture, Textures
from motorcade.animation.formats.limits import expected, image_beside, shown
from motorcade.ga.arrays import FloatArray

PLAIN = 0.6
"""Linear grey in the place of a texture that is missing."""
SPECULAR = "KHR_materials_pbrSpecularGlossiness"
TRANSFORM = "KHR_texture_transform"
WEBP = "EXT_texture_webp"
DRAWN = {SPECULAR, "KHR_materials_unlit", "KHR_materials_emissive_strength"}
"""Extensions of materials that are read; all others are named in one notice."""
WRAPS: dict[int, Wrap] = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
NEAREST, LINEAR = 9728, 9729
MAPS = {
    "baseColorTexture": "base_map",
    "metallicRoughnessTexture": "metallic_roughness_map",
    "normalTexture": "normal_map",
    "occlusionTexture": "occlusion_map",
    "emissiveTexture": "emission_map",
}


class GltfMaterials:
    """Reads the materials of one document; each of them, and each texture, once."""

    def __init__(self, document: Document, accessors: Accessors) -> None:
        self._document = document
        self._accessors = accessors
        self._textures = Textures()
        self._made: dict[int, Material] = {}
        self._plainer = {CARTOON} if has_cartoon_looks(document) else set()

    @property
    def notices(self) -> list[str]:
        """Textures that could not be read, and what is not drawn."""
        notices = list(self._textures.notices)
        if self._plainer:
            lost = shown(", ".join(sorted(self._plainer)), 400)
            notices.append(f"materials are drawn without {lost}")
        used = {str(one)[:60] for one in self._document.entries("extensionsUsed")}
        unread = sorted(
            name
            for name in used - UNDERSTOOD - {OLD, NEW, SPRINGS}
            if not name.startswith(OF_MATERIALS)
            if name not in self._plainer  # of materials too, which are named there
        )
        if unread:
            notices.append(f"extensions that are not read: {shown(', '.join(unread), 400)}")
        return notices

    def material(self, part: dict[str, Any], name: str) -> Material:
        """The material of a mesh primitive; glTF's default where it names none."""
        if "material" not in part:
            return Material()
        which = integer(part["material"], f"'{name}'.material", 0, 1 << 30)
        fields = self._document.entry("materials", which, f"'{name}'.material")
        if which not in self._made:
            self._made[which] = self._material(fields)
        return self._made[which]

    def coordinates(
        self, attributes: dict[str, Any], name: str, count: int
    ) -> tuple[NDArray[np.float32], ...]:
        """Sets of texture coordinates, (V, 2) each."""
        sets = []
        for which in range(MOST_SETS):
            key = f"TEXCOORD_{which}"
            if key not in attributes:
                break
            uv = self._accessors.floats(attributes[key], f"'{name}'.{key}", "VEC2")
            if len(uv) != count or np.abs(uv).max(initial=0.0) > 1e6:
                raise expected(f"'{name}'.{key}", f"{count} values up to 1e6", len(uv))
            sets.append(uv.astype(np.float32))
        return tuple(sets)

    def vertex_colors(self, attributes: dict[str, Any], name: str, count: int) -> FloatArray | None:
        """Linear colours with alpha (V, 4), where the primitive has any."""
        if "COLOR_0" not in attributes:
            return None
        field = f"'{name}'.COLOR_0"
        which = integer(attributes["COLOR_0"], field, 0, 1 << 30)
        entry = self._document.entry("accessors", which, field)
        kind = "VEC3" if entry.get("type") == "VEC3" else "VEC4"
        values = self._accessors.floats(which, field, kind)
        if len(values) != count:
            raise expected(field, f"{count} values", len(values))
        colors = np.ones((count, 4))
        colors[:, : values.shape[1]] = np.clip(values, 0.0, 1.0)
        return colors

    def _material(self, fields: dict[str, Any]) -> Material:
        name = str(fields.get("name", ""))[:100]
        extensions = table(fields.get("extensions", {}), "material.extensions")
        self._plainer |= {str(one)[:60] for one in extensions.keys() - DRAWN}
        base = table(fields.get("pbrMetallicRoughness", {}), "pbrMetallicRoughness")
        keys = {"baseColorFactor", "baseColorTexture"}
        if SPECULAR in extensions and not (base.keys() & keys):
            base = _from_specular(table(extensions[SPECULAR], SPECULAR))
        color = floats(base.get("baseColorFactor", [1.0, 1.0, 1.0, 1.0]), "baseColorFactor", 4)
        emission = floats(fields.get("emissiveFactor", [0.0, 0.0, 0.0]), "emissiveFactor", 3)
        stronger = table(extensions.get("KHR_materials_emissive_strength", {}), "emissive_strength")
        emission = emission * number(stronger.get("emissiveStrength", 1.0), "emissiveStrength")
        mode = fields.get("alphaMode", "OPAQUE")
        if mode not in ("OPAQUE", "MASK", "BLEND"):
            raise expected(f"material '{name}'.alphaMode", "OPAQUE, MASK or BLEND", mode)
        alpha_mode: AlphaMode = get_args(AlphaMode)[("OPAQUE", "MASK", "BLEND").index(mode)]
        both = {**fields, **base}
        maps: dict[str, Any] = {}
        for key, into in MAPS.items():
            texture = self._map(both[key], key) if key in both else None
            if texture is not None:
                maps[into] = texture
            elif key == "baseColorTexture" and key in both and self._has_source(both[key]):
                color[:3] *= PLAIN
        normal = table(fields.get("normalTexture", {}), "normalTexture")
        occlusion = table(fields.get("occlusionTexture", {}), "occlusionTexture")
        return replace(
            Material(name, tuple(np.clip(color, 0.0, 1.0).tolist())),
            metallic=_share(base.get("metallicFactor", 1.0), "metallicFactor"),
            roughness=_share(base.get("roughnessFactor", 1.0), "roughnessFactor"),
            emission=tuple(np.clip(emission, 0.0, 1e6).tolist()),
            normal_scale=number(normal.get("scale", 1.0), "normalTexture.scale"),
            occlusion_strength=_share(occlusion.get("strength", 1.0), "occlusion strength"),
            alpha_mode=alpha_mode,
            alpha_cutoff=number(fields.get("alphaCutoff", 0.5), "alphaCutoff"),
            double_sided=boolean(fields.get("doubleSided", False), "doubleSided"),
            unlit="KHR_materials_unlit" in extensions,
            **maps,
        )

    def _has_source(self, link: object) -> bool:
        texture = self._document.entry("textures", table(link, "texture").get("index"), "texture")
        return "source" in texture or bool(texture.get("extensions"))

    def _source(self, texture: dict[str, Any]) -> object:
        """The number of a texture's image; None where it has none that can be read."""
        extensions = table(texture.get("extensions", {}), "texture.extensions")
        if WEBP in extensions:
            return table(extensions[WEBP], WEBP).get("source")
        if "source" not in texture:
            self._plainer |= {f"textures of {str(one)[:60]}" for one in extensions}
        return texture.get("source")

    def _map(self, value: object, field: str) -> TextureMap | None:
        """An image with its sampler and transform; None where it cannot be read."""
        link = table(value, field)
        which = link.get("texCoord", 0)
        extensions = table(link.get("extensions", {}), f"{field}.extensions")
        moved = table(extensions.get(TRANSFORM, {}), TRANSFORM)
        which = integer(moved.get("texCoord", which), f"{field}.texCoord", 0, 15)
        texture = self._document.entry("textures", link.get("index"), f"{field}.index")
        named = self._source(texture)
        if named is None:
            return None
        image = self._texture(integer(named, "texture.source", 0, 1 << 30))
        if image is None:
            return None
        if which >= MOST_SETS:
            self._plainer.add(f"{field}s of more than {MOST_SETS} sets of coordinates")
            return None
        sampler: dict[str, Any] = {}
        if "sampler" in texture:
            sampler = self._document.entry("samplers", texture["sampler"], "texture.sampler")
        magnify = _code(sampler, "magFilter", LINEAR, (NEAREST, LINEAR))
        minify = _code(sampler, "minFilter", 9987, (NEAREST, LINEAR, 9984, 9985, 9986, 9987))
        s, t = (_code(sampler, key, 10497, tuple(WRAPS)) for key in ("wrapS", "wrapT"))
        return TextureMap(
            image.pixels,
            which,
            (WRAPS[s], WRAPS[t]),
            "nearest" if magnify == NEAREST else "linear",
            "nearest" if minify in (NEAREST, 9984, 9986) else "linear",
            None if minify < 9984 else ("nearest" if minify < 9986 else "linear"),
            _transform(moved),
            image.encoded,
        )

    def _texture(self, source: int) -> Texture | None:
        image = self._document.entry("images", source, "texture.source")
        name = str(image.get("uri", image.get("name", source)))[:100]
        return self._textures.read(
            name, lambda: self._bytes(image, f"images[{source}]"), str(source)
        )

    def _bytes(self, image: dict[str, Any], field: str) -> bytes:
        if "uri" in image:
            uri, place = text(image["uri"], f"{field}.uri"), self._document.images
            if place is not None and not uri.startswith("data:"):
                return load_file(image_beside(place, uri, f"{field}.uri"), f"{field}.uri")
            return load(uri, self._document.folder, f"{field}.uri")
        return self._document.view(image.get("bufferView"), f"{field}.bufferView")


def _code(sampler: dict[str, Any], key: str, default: int, known: tuple[int, ...]) -> int:
    """A sampler's filter or wrapping: one of the whole numbers that glTF knows."""
    field = f"sampler.{key}"
    code = integer(sampler.get(key, default), field, 0, 1 << 30)
    if code not in known:
        raise expected(field, f"one of {', '.join(map(str, known))}", code)
    return code


def _share(value: object, field: str) -> float:
    return min(max(number(value, field), 0.0), 1.0)


def _from_specular(fields: dict[str, Any]) -> dict[str, Any]:
    """A material of diffuse and specular colours as a dielectric of the same base and gloss."""
    metallic: dict[str, Any] = {"metallicFactor": 0.0}
    for old, new in (("diffuseFactor", "baseColorFactor"), ("diffuseTexture", "baseColorTexture")):
        if old in fields:
            metallic[new] = fields[old]
    gloss = number(fields.get("glossinessFactor", 1.0), "glossinessFactor")
    return metallic | {"roughnessFactor": 1.0 - gloss}


def _transform(fields: dict[str, Any]) -> tuple[tuple[float, ...], ...]:
    """The (2, 3) matrix of KHR_texture_transform: scaled, turned, then moved."""
    u, v = floats(fields.get("offset", [0.0, 0.0]), "offset", 2).tolist()
    wide, high = floats(fields.get("scale", [1.0, 1.0]), "scale", 2).tolist()
    turn = number(fields.get("rotation", 0.0), "rotation")
    c, s = cos(turn), sin(turn)
    return (c * wide, s * high, u), (-s * wide, c * high, v)


OLD, NEW, SPRINGS = "VRM", "VRMC_vrm", "VRMC_springBone"
CARTOON = "VRM/MToon"


@dataclass(frozen=True, eq=False)
class Humanoid:
    """What a VRM file says beyond glTF.

    Args:
        bones: names of bones by numbers of nodes.
        forward: unit vector (3,) of the file's frame that the figure faces.
        notices: what is left out.
    """

    bones: dict[int, str]
    forward: tuple[float, float, float]
    notices: tuple[str, ...]


def read_humanoid(document: Document) -> Humanoid | None:
    """The humanoid of a document; None where it is no VRM.

    Raises:
        FormatError: bones that are no nodes, or two of one node.
    """
    extensions = table(document.root.get("extensions", {}), "extensions")
    if OLD in extensions:
        extension = table(extensions[OLD], OLD)
        springs = table(extension.get("secondaryAnimation", {}), "secondaryAnimation")
        bones = _old_bones(document, extension)
        return Humanoid(bones, (0.0, 0.0, -1.0), _notices(bool(springs.get("boneGroups"))))
    if NEW in extensions:
        bones = _new_bones(document, table(extensions[NEW], NEW))
        return Humanoid(bones, (0.0, 0.0, 1.0), _notices(SPRINGS in extensions))
    return None


def has_cartoon_looks(document: Document) -> bool:
    """Whether a VRM 0 file wants MToon's shading somewhere; VRM 1 says so in its materials."""
    extensions = table(document.root.get("extensions", {}), "extensions")
    extension = table(extensions.get(OLD, {}), OLD)
    looks = listed(extension.get("materialProperties", []), "materialProperties")
    return any(isinstance(one, dict) and one.get("shader") == CARTOON for one in looks)


def _notices(springs: bool) -> tuple[str, ...]:
    return ("springs of hair and clothes stand still",) if springs else ()


def _old_bones(document: Document, fields: dict[str, Any]) -> dict[int, str]:
    humanoid = table(fields.get("humanoid", {}), "VRM.humanoid")
    bones: dict[int, str] = {}
    for entry in listed(humanoid.get("humanBones", []), "VRM.humanBones"):
        bone = table(entry, "VRM.humanBones")
        _add(bones, document, text(bone.get("bone"), "VRM bone"), bone.get("node"))
    return bones


def _new_bones(document: Document, fields: dict[str, Any]) -> dict[int, str]:
    humanoid = table(fields.get("humanoid", {}), "VRMC_vrm.humanoid")
    bones: dict[int, str] = {}
    for name, entry in table(humanoid.get("humanBones", {}), "VRMC_vrm.humanBones").items():
        _add(bones, document, name, table(entry, "VRMC_vrm.humanBones").get("node"))
    return bones


def _add(bones: dict[int, str], document: Document, name: str, value: object) -> None:
    node = integer(value, f"VRM bone '{name[:40]}'", 0, len(document.entries("nodes")) - 1)
    if node in bones:
        raise expected(f"VRM bone '{name[:40]}'", "a node of its own", f"that of {bones[node]}")
    bones[node] = name[:60]
