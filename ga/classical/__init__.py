"""What motors are compared with: plain array code for quaternions, dual quaternions, Euler angles,
and values around it with the versors' verbs.

None of it is built on the versors of this room; the one thing shared is the check of inputs.
"""

from __future__ import annotations

from motorcade.ga.classical.dual_quaternion_pose import DualQuaternion
from motorcade.ga.classical.euler_pose import EulerPose
from motorcade.ga.classical.pose import Pose
from motorcade.ga.classical.quaternion_pose import QuaternionPose

__all__ = ["DualQuaternion", "EulerPose", "Pose", "QuaternionPose"]
