"""What joints are (hips, thighs, hands …), what is up and ahead: told by tree, bones and motion."""

from motorcade.animation.anatomy.body import Body, body_from
from motorcade.animation.anatomy.tree import JointTree

__all__ = ["Body", "JointTree", "body_from"]
