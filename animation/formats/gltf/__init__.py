"""glTF 2.0: read `.glb` and `.gltf`, write `.glb`.

Source: Khronos Group, glTF 2.0 specification (ISO/IEC 12113:2022).
"""

from motorcade.animation.formats.gltf.read import read_gltf
from motorcade.animation.formats.gltf.write import CameraPath, write_gltf

__all__ = ["CameraPath", "read_gltf", "write_gltf"]
