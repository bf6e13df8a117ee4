"""The built-in character: a small explorer, shipped as a glTF file."""

from motorcade.animation.mannequin.figure import mannequin

__all__ = ["mannequin"]
