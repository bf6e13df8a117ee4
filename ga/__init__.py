"""Rigid motions and similarities as versors of geometric algebra: poses, paths, and the algebra.

A pose is named for the frames it connects: ``world_T_camera`` maps camera coordinates to world
coordinates. ``@`` composes from right to left, so that the frames in the middle meet:

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> world_T_camera = Motor.from_euler_translation([0.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0])
    >>> camera_T_imu = Motor.from_translation([0.0, 0.1, 0.0])
    >>> world_T_imu = world_T_camera @ camera_T_imu
    >>> np.round(world_T_imu.apply([0.0, 0.0, 0.0]), 6) + 0.0
    array([0.9, 0. , 0. ])
    >>> np.round(world_T_imu.inverse().apply([0.9, 0.0, 0.0]), 6) + 0.0
    array([0., 0., 0.])

Units are metres, radians and seconds; stamps are integer nanoseconds, quaternions wxyz, Euler
angles intrinsic. Worlds are right-handed with z up; cameras look along z with y down, as OpenCV's.
Small motions are twists in a pose's own frame, rotation vector first: see `Motor.retract`.

Leading dimensions are batch and broadcast: one motor and a million are the same function. Values
are frozen, and what does not fit is refused with its name. Needs NumPy only.
"""

from __future__ import annotations

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.classical import DualQuaternion, EulerPose, QuaternionPose
from motorcade.ga.motion import ScrewPath, SplineSample, TwistSample
from motorcade.ga.on_demand import compile, show
from motorcade.ga.splines import CumulativeBSpline, SimilaritySpline
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.averages import blend, mean
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.similarity import Similarity
from motorcade.ga.versors.versor import Versor

__all__ = [
    "CGA3",
    "EGA3",
    "PGA3",
    "Algebra",
    "CumulativeBSpline",
    "DualQuaternion",
    "EulerPose",
    "Motor",
    "Multivector",
    "QuaternionPose",
    "Rotor",
    "ScrewPath",
    "Similarity",
    "SimilaritySpline",
    "SplineSample",
    "Trajectory",
    "TwistSample",
    "Versor",
    "blend",
    "compile",
    "mean",
    "show",
]
