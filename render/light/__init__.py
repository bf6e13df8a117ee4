"""Light of a scene: chosen for the viewer, or estimated from the pictures."""

from motorcade.render.light.lamps import character_lighting, sunlight_direction, viewer_frame

__all__ = ["character_lighting", "sunlight_direction", "viewer_frame"]
