from .dual_quaternion import dual_quaternion_apply as dual_quaternion_apply
from .dual_quaternion import (
    dual_quaternion_as_quaternion_translation as dual_quaternion_as_quaternion_translation,
)
from .dual_quaternion import dual_quaternion_blend as dual_quaternion_blend
from .dual_quaternion import dual_quaternion_conjugate as dual_quaternion_conjugate
from .dual_quaternion import dual_quaternion_exp as dual_quaternion_exp
from .dual_quaternion import (
    dual_quaternion_from_quaternion_translation as dual_quaternion_from_quaternion_translation,
)
from .dual_quaternion import dual_quaternion_log as dual_quaternion_log
from .dual_quaternion import dual_quaternion_mean as dual_quaternion_mean
from .dual_quaternion import dual_quaternion_multiply as dual_quaternion_multiply
from .dual_quaternion import dual_quaternion_normalize as dual_quaternion_normalize
from .dual_quaternion import dual_quaternion_screw as dual_quaternion_screw
from .euler import EulerPose as EulerPose
from .euler import euler_rates_from_body as euler_rates_from_body
from .euler import follow_euler as follow_euler
from .euler import interpolate_euler as interpolate_euler
from .euler import nearest_branch as nearest_branch
from .euler import nearest_euler as nearest_euler
from .pose import Pose as Pose
from .quaternion import nearest_sign as nearest_sign
from .quaternion import quaternion_apply as quaternion_apply
from .quaternion import quaternion_as_matrix as quaternion_as_matrix
from .quaternion import quaternion_as_rotation_vector as quaternion_as_rotation_vector
from .quaternion import quaternion_conjugate as quaternion_conjugate
from .quaternion import quaternion_from_matrix as quaternion_from_matrix
from .quaternion import quaternion_from_rotation_vector as quaternion_from_rotation_vector
from .quaternion import quaternion_mean as quaternion_mean
from .quaternion import quaternion_multiply as quaternion_multiply
from .quaternion import quaternion_nlerp as quaternion_nlerp
from .quaternion import quaternion_normalize as quaternion_normalize
from .quaternion import quaternion_slerp as quaternion_slerp
from .quaternion_poses import DualQuaternion as DualQuaternion
from .quaternion_poses import QuaternionPose as QuaternionPose
