"""The built-in character: a mannequin in a racing suit, its shape and motions made in code."""

from motorcade.animation.mannequin.figure import ground_speed_m_s, mannequin

__all__ = ["ground_speed_m_s", "mannequin"]
