"""VRM, a glTF file of a humanoid: which node is which bone, and which way it faces.

Bones take VRM's names (`hips`, `leftUpperLeg`, …), by which their roles are told; the authors' own
names of such nodes are often those of no language. VRM 0 faces −z, VRM 1 as glTF does +z. What is
particular to it otherwise, such as springs of hair and looks of cartoons, is left out and named.

Source: VRM Consortium, VRM 0.0 and VRMC_vrm-1.0 specifications.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from motorcade.animation.formats.gltf.container import Document, integer, listed, table, text
from motorcade.animation.formats.limits import expected

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
