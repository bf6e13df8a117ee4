"""glTF 2.0: read `.glb` and `.gltf`, write `.glb`.

Source: Khronos Group, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from motorcade.animation.formats.gltf.read import read_gltf
from motorcade.animation.formats.gltf.writing.write import (
    CameraPath,
    CharacterOnPath,
    write_cast_gltf,
    write_gltf,
)

__all__ = ["CameraPath", "CharacterOnPath", "read_gltf", "write_cast_gltf", "write_gltf"]
