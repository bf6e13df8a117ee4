"""Character and motion files: read into frozen values, and written as glTF.

Files are not trusted: sizes, depths and counts are limited (see `limits`), XML entities and
files outside the folder are refused, and whatever is wrong is a `FormatError`.
"""

from motorcade.animation.formats.door import SUFFIXES, read_character, read_motion
from motorcade.animation.formats.errors import FormatError, NoMeshError
from motorcade.animation.formats.gltf import (
    CameraPath,
    CharacterOnPath,
    write_cast_gltf,
    write_gltf,
)
from motorcade.animation.formats.rig import SkeletalMotion

__all__ = [
    "SUFFIXES",
    "CameraPath",
    "CharacterOnPath",
    "FormatError",
    "NoMeshError",
    "SkeletalMotion",
    "read_character",
    "read_motion",
    "write_cast_gltf",
    "write_gltf",
]
