"""Collada 1.4 and 1.5 (`.dae`): skinned meshes, scenes and animations, as a rig.

Source: Khronos Group, COLLADA Digital Asset Schema Release 1.4.1 and 1.5.0.

Figures with z up face −y and those with y up face +z by habit of the programs that write them.
"""

from __future__ import annotations

from pathlib import Path

from motorcade.animation.formats.collada.controllers import ColladaMaterials, Controllers
from motorcade.animation.formats.collada.library import Library, parse_xml
from motorcade.animation.formats.collada.scene import read_clips, read_scene
from motorcade.animation.formats.limits import MAX_TEXT_BYTES, expected, read_bounded
from motorcade.animation.formats.rig.values import Rig

AXES = {
    "X_UP": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "Y_UP": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "Z_UP": ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
}


def read_collada(path: Path) -> Rig:
    """Read a `.dae`.

    Raises:
        FormatError: XML that is broken or dangerous, or a document that is not consistent.
    """
    library = Library(parse_xml(read_bounded(path, MAX_TEXT_BYTES)))
    asset = library.root.first("asset")
    axis = None if asset is None else asset.first("up_axis")
    unit = None if asset is None else asset.first("unit")
    name = "Y_UP" if axis is None else axis.text.strip()
    if name not in AXES:
        raise expected("asset up_axis", ", ".join(AXES), name)
    up, forward = AXES[name]
    scene = read_scene(library)
    materials = ColladaMaterials(library, path.parent)
    controllers = Controllers(library, scene, materials)
    surfaces, joints = controllers.surfaces()
    clips, notices_of_clips = read_clips(library, scene)
    return Rig(
        scene.tree,
        joints,
        surfaces,
        clips,
        up=up,
        forward=forward,
        unit_m=_unit_m("" if unit is None else unit.get("meter")),
        notices=(*scene.notices, *controllers.notices, *materials.notices, *notices_of_clips),
    )


def _unit_m(text: str) -> float:
    """Metres a unit; 1 where the asset does not say."""
    try:
        value = float(text or 1.0)
    except ValueError as fault:
        raise expected("asset unit", "metres", text) from fault
    if not 1e-6 <= value <= 1e6:
        raise expected("asset unit", "metres from 1e-6 to 1e6", text)
    return value
