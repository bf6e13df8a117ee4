"""Scene authoring: objects turned, moved and grown by drags, on rotors or on Euler angles."""

from motorcade.animation.authoring.editor import Drag, SceneEditor, Snapping, read_gestures, replay
from motorcade.animation.authoring.interpolations import (
    InterpolationFigures,
    compare_interpolations,
)
from motorcade.animation.authoring.keyframes import between_keyframes
from motorcade.animation.authoring.parts import (
    JointKeyframe,
    SceneAnchor,
    SceneKeyframe,
    SceneLayer,
    ScenePart,
    SceneWalk,
)
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.animation.authoring.scene_file import read_scene, scene_of

__all__ = [
    "Drag",
    "EulerObjectPose",
    "InterpolationFigures",
    "JointKeyframe",
    "ObjectPose",
    "Scene",
    "SceneAnchor",
    "SceneEditor",
    "SceneKeyframe",
    "SceneLayer",
    "ScenePart",
    "SceneWalk",
    "Snapping",
    "VersorObjectPose",
    "between_keyframes",
    "compare_interpolations",
    "read_gestures",
    "read_scene",
    "replay",
    "scene_of",
]
