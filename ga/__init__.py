"""Geometric algebra room: rotors, motors, similarities, trajectories, and the kernels under them.

Needs NumPy only. Values are frozen and validated, batch in the leading dimensions. Poses are
named ``world_T_camera`` (maps camera coordinates to world), versors act by ``X' = M X ~M``.
"""

from __future__ import annotations

from motorcade.ga import kernels
from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats, frozen
from motorcade.ga.classical import DualQuaternion, EulerPose, QuaternionPose
from motorcade.ga.motion import TwistSample
from motorcade.ga.screw_path import ScrewPath
from motorcade.ga.splines import CumulativeBSpline, SimilaritySpline, SplineSample
from motorcade.ga.trajectory import Trajectory
from motorcade.ga.versors.blend import blend
from motorcade.ga.versors.mean import mean
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
    "FloatArray",
    "IntArray",
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
    "checked_floats",
    "frozen",
    "kernels",
    "mean",
]
