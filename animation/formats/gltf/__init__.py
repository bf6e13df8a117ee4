"""glTF 2.0: read `.glb`, `.gltf` and `.vrm` as a rig, write `.glb`.

Source: Khronos Group, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.animation.formats.gltf.animations import read_animations, read_nodes
from motorcade.animation.formats.gltf.binary import GENERATOR
from motorcade.animation.formats.gltf.compression import unpack_draco, unpack_meshopt
from motorcade.animation.formats.gltf.document import Accessors, open_gltf
from motorcade.animation.formats.gltf.materials import read_humanoid
from motorcade.animation.formats.gltf.meshes import Meshes
from motorcade.animation.formats.gltf.write import (
    CameraPath,
    CharacterOnPath,
    write_cast_gltf,
    write_gltf,
)
from motorcade.animation.formats.rig.values import Rig

__all__ = ["CameraPath", "CharacterOnPath", "read_gltf", "write_cast_gltf", "write_gltf"]


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
