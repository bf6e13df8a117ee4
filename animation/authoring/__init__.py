"""Scene authoring: objects turned, moved and grown by drags, on rotors or on Euler angles."""

from motorcade.animation.authoring.editor import Drag, SceneEditor, Snapping, read_gestures, replay
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import Scene, read_scene

__all__ = [
    "Drag",
    "EulerObjectPose",
    "ObjectPose",
    "Scene",
    "SceneEditor",
    "Snapping",
    "VersorObjectPose",
    "read_gestures",
    "read_scene",
    "replay",
]
