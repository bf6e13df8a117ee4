"""Scene authoring: objects turned, moved and grown by drags, on rotors or on Euler angles."""

from motorcade.animation.authoring.drags import Drag, Snapping
from motorcade.animation.authoring.editor import SceneEditor, replay
from motorcade.animation.authoring.edits import Edit
from motorcade.animation.authoring.gestures import Dragged, Gesture, gesture_of, read_gestures
from motorcade.animation.authoring.parts import (
    SceneAnchor,
    ScenePart,
    SceneWalk,
    between_keyframes,
    compare_interpolations,
)
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import read_scene, scene_of, scene_text

__all__ = [
    "Drag",
    "Dragged",
    "Edit",
    "EulerObjectPose",
    "Gesture",
    "ObjectPose",
    "Scene",
    "SceneAnchor",
    "SceneEditor",
    "ScenePart",
    "SceneWalk",
    "Snapping",
    "VersorObjectPose",
    "between_keyframes",
    "compare_interpolations",
    "gesture_of",
    "read_gestures",
    "read_scene",
    "replay",
    "scene_of",
    "scene_text",
]
