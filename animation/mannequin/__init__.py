"""The built-in character: a wooden mannequin, its shape and its motions made in code."""

from motorcade.animation.mannequin.figure import mannequin

__all__ = ["mannequin"]
