"""glTF 2.0: read `.glb`, `.gltf` and `.vrm` as a rig, write `.glb`.

Source: Khronos Group, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation.appearance import Material
from motorcade.animation.formats.gltf.animations import (
    Nodes,
    nodes_of_scene,
    read_animations,
    read_nodes,
)
from motorcade.animation.formats.gltf.binary import GENERATOR
from motorcade.animation.formats.gltf.compression import unpack_draco, unpack_meshopt
from motorcade.animation.formats.gltf.document import (
    Accessors,
    Document,
    floats,
    integer,
    listed,
    open_gltf,
    table,
)
from motorcade.animation.formats.gltf.materials import GltfMaterials, read_humanoid
from motorcade.animation.formats.images import colors_at_vertices
from motorcade.animation.formats.limits import (
    MAX_MORPHS,
    MAX_PARTS,
    MAX_VALUES,
    MAX_VERTICES,
    FormatError,
    check_count,
    expected,
)
from motorcade.animation.formats.rig.values import Rig, RigMorph, RigSurface, Skin
from motorcade.ga.arrays import FloatArray, IntArray

STRIP, FAN, TRIANGLES = 5, 6, 4
"""Primitive modes of glTF."""


class Meshes:
    """Reads the surfaces of one document; `notices` gathers what was left out."""

    def __init__(self, document: Document, accessors: Accessors, nodes: Nodes) -> None:
        self._document = document
        self._accessors = accessors
        self._nodes = nodes
        self._materials = GltfMaterials(document, accessors)
        self._targets_read = 0
        self._looked_at = self._morphs = 0  # numbers of targets, and those of moved vertices
        self._lines = 0
        self._read: dict[tuple[int, int], RigSurface] = {}
        self._elsewhere = ""
        self._total = 0
        self._unplaced: set[str] = set()

    @property
    def notices(self) -> list[str]:
        """What was left out or assumed."""
        notices = [*self._materials.notices]
        if self._unplaced:
            lost = ", ".join(sorted(self._unplaced))
            notices.append(f"meshes without coordinates for their {lost} are drawn without")
        if self._elsewhere:
            notices.append(self._elsewhere)
        if self._lines:
            notices.append(f"{self._lines} meshes of points or lines are left out")
        return notices

    def surfaces(self) -> tuple[tuple[RigSurface, ...], tuple[int, ...]]:
        """Surfaces of every node with a mesh, and the nodes that skins call joints.

        Raises:
            FormatError: attributes that are missing, of the wrong type or length, or out of range.
        """
        skins: dict[int, Skin] = {}
        joints: set[int] = set()
        for number in range(len(self._document.entries("skins"))):
            skins[number] = self._skin(number)
            joints.update(skins[number].nodes.tolist())
        read, shown = [], self._shown()
        self._check_parts(shown)
        for node in shown:
            fields = self._nodes.fields[node]
            mesh = self._document.entry("meshes", fields["mesh"], f"node {node} mesh")
            skin = None
            if "skin" in fields:
                skin = skins[integer(fields["skin"], f"node {node} skin", 0, len(skins) - 1)]
            name = str(fields.get("name") or mesh.get("name") or f"mesh {fields['mesh']}")[:100]
            for part in listed(mesh.get("primitives"), f"mesh '{name}'.primitives"):
                primitive = table(part, f"mesh '{name}'")
                read += self._shared(primitive, mesh, name, node, skin)
        return tuple(read), tuple(sorted(joints))

    def _check_parts(self, shown: list[int]) -> None:
        """Refuse more parts than are drawn before any is read: a few bytes may ask for millions."""
        parts = [
            len(listed(mesh.get("primitives", []), "mesh.primitives"))
            for mesh in (table(entry, "mesh") for entry in self._document.entries("meshes"))
        ]
        numbers = (self._nodes.fields[node]["mesh"] for node in shown)
        total = sum(parts[n] for n in numbers if isinstance(n, int) and 0 <= n < len(parts))
        check_count("parts of meshes at all nodes", total, MAX_PARTS)

    def _shared(
        self, part: dict[str, Any], mesh: dict[str, Any], name: str, node: int, skin: Skin | None
    ) -> list[RigSurface]:
        """The surface of a primitive at a node, if any; read once, however many nodes show it."""
        fields = self._nodes.fields[node]
        key = id(part), id(skin)
        if key in self._read and "weights" not in fields:
            known = self._read[key]
            self._total += max(len(known.vertices), len(known.triangles))
            check_count("vertices and triangles", self._total, MAX_VERTICES)
            self._targets_read += len(known.morphs)
            check_count("morph targets", self._targets_read, MAX_MORPHS)
            self._morphs += 6 * sum(len(one.rows) for one in known.morphs)
            check_count("numbers of morph targets", self._morphs, MAX_VALUES // 2)
            return [replace(known, name=name, node=node)]
        surface = self._surface(part, name, node, skin)
        if surface is None:
            return []
        morphs = self._targets(part, mesh, fields, name, len(surface.vertices))
        morphed = replace(surface, morphs=morphs)
        if "weights" not in fields:
            self._read[key] = morphed
        return [morphed]

    def _shown(self) -> list[int]:
        """Nodes with a mesh: those of the scene that is shown, or all where it has none."""
        bearing = [node for node, given in enumerate(self._nodes.fields) if "mesh" in given]
        in_scene = nodes_of_scene(self._document, self._nodes)
        shown = [node for node in bearing if in_scene[node]]
        if bearing and not shown:
            self._elsewhere = "no mesh stands in the scene that is shown: all are read"
            return bearing
        if len(shown) < len(bearing):
            count = len(bearing) - len(shown)
            self._elsewhere = f"{count} meshes outside of the scene that is shown are left out"
        return shown

    def _skin(self, number: int) -> Skin:
        fields = table(self._document.entries("skins")[number], f"skins[{number}]")
        field = f"skins[{number}].joints"
        count = len(self._nodes.number)
        listed_joints = [
            integer(joint, field, 0, count - 1) for joint in listed(fields.get("joints"), field)
        ]
        if not listed_joints or len(set(listed_joints)) < len(listed_joints):
            raise expected(field, "one or more different nodes", fields.get("joints"))
        nodes = self._nodes.number[listed_joints]
        matrices = np.repeat(np.eye(4)[None], len(nodes), axis=0)
        if "inverseBindMatrices" in fields:
            field = f"skins[{number}].inverseBindMatrices"
            read = self._accessors.floats(fields["inverseBindMatrices"], field, "MAT4")
            if len(read) < len(nodes) or np.abs(read).max() > 1e9:
                raise expected(field, f"{len(nodes)} matrices of numbers up to 1e9", len(read))
            matrices = read[: len(nodes)].reshape(-1, 4, 4).swapaxes(1, 2)
        return Skin(nodes, matrices)

    def _surface(
        self, part: dict[str, Any], name: str, node: int, skin: Skin | None
    ) -> RigSurface | None:
        mode = integer(part.get("mode", TRIANGLES), f"mesh '{name}'.mode", 0, 6)
        if mode not in (TRIANGLES, STRIP, FAN):
            self._lines += 1
            return None
        attributes = table(part.get("attributes"), f"mesh '{name}'.attributes")
        if "POSITION" not in attributes:
            raise expected(f"mesh '{name}'.attributes", "POSITION", sorted(attributes))
        vertices = self._accessors.floats(attributes["POSITION"], f"'{name}'.POSITION", "VEC3")
        count = len(vertices)
        if np.abs(vertices).max() > 1e9:
            raise expected(f"'{name}'.POSITION", "numbers up to 1e9", np.abs(vertices).max())
        normals = None
        if "NORMAL" in attributes:
            normals = self._same(attributes["NORMAL"], f"'{name}'.NORMAL", "VEC3", count)
        triangles = self._triangles(part, name, count, mode)
        self._total += max(count, len(triangles))
        check_count("vertices and triangles", self._total, MAX_VERTICES)
        tangents = None
        if "TANGENT" in attributes:
            tangents = self._same(attributes["TANGENT"], f"'{name}'.TANGENT", "VEC4", count)
        material = self._materials.material(part, name)
        coordinates = self._materials.coordinates(attributes, name, count)
        tints = self._materials.vertex_colors(attributes, name, count)
        surface = RigSurface(
            name,
            node,
            vertices,
            normals,
            triangles,
            colors_at_vertices(material, coordinates, tints, count),
            material=self._placed(material, len(coordinates)),
            coordinates=coordinates,
            vertex_colors=tints,
            flat=normals is None,
            tangents=tangents,
        )
        if skin is None:
            return surface
        numbers, weights = self._influences(attributes, name, count, len(skin.nodes))
        return replace(surface, skin=skin, influences=numbers, weights=weights)

    def _targets(
        self,
        part: dict[str, Any],
        mesh: dict[str, Any],
        node: dict[str, Any],
        name: str,
        count: int,
    ) -> tuple[RigMorph, ...]:
        """Morph targets of a primitive, with the weights that its node or mesh gives at rest."""
        entries = listed(part.get("targets", []), f"'{name}'.targets")
        self._targets_read += len(entries)
        check_count("morph targets", self._targets_read, MAX_MORPHS)
        self._looked_at += 6 * count * len(entries)
        check_count("numbers of morph targets", self._looked_at, 4 * MAX_VALUES)
        value = node.get("weights", mesh.get("weights", [0.0] * len(entries)))
        weights = floats(value, f"'{name}'.weights", len(entries))
        extras = mesh.get("extras")
        names = extras.get("targetNames") if isinstance(extras, dict) else None
        morphs = []
        for number, entry in enumerate(entries):
            field = f"'{name}'.targets[{number}]"
            target = table(entry, field)
            positions, normals = np.zeros((count, 3)), None
            if "POSITION" in target:
                positions = self._same(target["POSITION"], f"{field}.POSITION", "VEC3", count)
            if "NORMAL" in target:
                normals = self._same(target["NORMAL"], f"{field}.NORMAL", "VEC3", count)
            far = max(np.abs(one).max() for one in (positions, normals) if one is not None)
            if far > 1e9:
                raise expected(field, "numbers up to 1e9", far)
            named = isinstance(names, list) and number < len(names)
            label = str(names[number])[:100] if named and names else ""
            rows = np.flatnonzero(positions.any(axis=1))
            if normals is not None:
                rows = np.flatnonzero(positions.any(axis=1) | normals.any(axis=1))
                normals = normals[rows]
            self._morphs += 6 * len(rows)
            check_count("numbers of morph targets", self._morphs, MAX_VALUES // 2)
            morphs.append(RigMorph(label, float(weights[number]), rows, positions[rows], normals))
        return tuple(morphs)

    def _placed(self, material: Material, sets: int) -> Material:
        """A material without the maps for which a mesh has no coordinates."""
        lost = [key for key, one in material.maps.items() if one.coordinate_set >= sets]
        if not lost:
            return material
        self._unplaced.update(lost)
        bare: dict[str, Any] = dict.fromkeys(lost)
        return replace(material, **bare)

    def _same(self, index: object, field: str, kind: str, count: int) -> FloatArray:
        values = self._accessors.floats(index, field, kind)
        if len(values) != count:
            raise expected(field, f"{count} values", len(values))
        return values

    def _triangles(self, part: dict[str, Any], name: str, count: int, mode: int) -> IntArray:
        if "indices" in part:
            field = f"'{name}'.indices"
            run = self._accessors.integers(part["indices"], field, "SCALAR")
            if run.min() < 0 or run.max() >= count:
                raise expected(field, f"numbers below {count}", run.max())
        else:
            run = np.arange(count)
        if mode == TRIANGLES:
            return run[: len(run) - len(run) % 3].reshape(-1, 3)
        if len(run) < 3:
            return np.zeros((0, 3), dtype=np.int64)
        if mode == FAN:
            first = np.full(len(run) - 2, run[0])
            return np.stack([first, run[1:-1], run[2:]], axis=1)
        triangles = np.stack([run[:-2], run[1:-1], run[2:]], axis=1)
        triangles[1::2] = triangles[1::2, ::-1]
        return triangles

    def _influences(
        self, fields: dict[str, Any], name: str, count: int, joints: int
    ) -> tuple[IntArray, FloatArray]:
        numbers, weights = [], []
        for group in range(16):
            if f"JOINTS_{group}" not in fields:
                break
            field = f"'{name}'.JOINTS_{group}"
            these = self._accessors.integers(fields[f"JOINTS_{group}"], field, "VEC4")
            field = f"'{name}'.WEIGHTS_{group}"
            shares = self._same(fields.get(f"WEIGHTS_{group}"), field, "VEC4", count)
            if len(these) != count:
                raise expected(field, f"{count} values", len(these))
            numbers.append(these)
            weights.append(shares)
        if not numbers:
            raise FormatError(f"'{name}': expected JOINTS_0 on a mesh with a skin, got none")
        all_numbers, all_weights = np.concatenate(numbers, 1), np.concatenate(weights, 1)
        used = all_weights != 0.0
        if np.any((all_numbers >= joints) & used) or np.any(all_numbers < 0):
            raise expected(f"'{name}'.JOINTS", f"numbers below {joints}", all_numbers.max())
        return np.where(used, all_numbers, 0), all_weights


KEEPS_UNITS = "Open Asset Import Library"
"""A generator that copies numbers from files in other units without converting them."""


def read_gltf(path: Path, *, images: Path | None = None) -> Rig:
    """Read a `.glb`, `.gltf` or `.vrm`; its images may lie in another folder, below any name.

    Raises:
        FormatError: see `open_gltf`, `read_humanoid`, `read_nodes`, `unpack_meshopt`,
            `unpack_draco`, `Meshes.surfaces`, `read_animations`.
        ModuleNotFoundError: a package of the extra `pipeline` is needed and not installed.
    """
    document = open_gltf(path, images)
    unpack_meshopt(document)
    accessors = Accessors(document)
    unpack_draco(document, accessors)
    humanoid = read_humanoid(document)
    nodes = read_nodes(document, {} if humanoid is None else humanoid.bones)
    meshes = Meshes(document, accessors, nodes)
    surfaces, joints = meshes.surfaces()
    own = np.argsort(nodes.number)
    targets = {
        int(own[surface.node]): len(surface.morphs) for surface in surfaces if surface.morphs
    }
    clips, notices_of_clips = read_animations(document, accessors, nodes, targets)
    generator = document.root["asset"].get("generator")
    return Rig(
        nodes.tree,
        joints,
        surfaces,
        clips,
        up=(0.0, 1.0, 0.0),
        forward=(0.0, 0.0, 1.0) if humanoid is None else humanoid.forward,
        unit_m=1.0,
        unit_checked=isinstance(generator, str) and KEEPS_UNITS in generator,
        notices=(
            *meshes.notices,
            *notices_of_clips,
            *(() if humanoid is None else humanoid.notices),
        ),
        settled=generator == GENERATOR,
    )
