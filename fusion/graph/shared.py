"""What all nodes of a graph share, and how nodes are named.

They share, where it is asked for, the direction of gravity, the camera's pose on the IMU and its
time offset. gtsam's inertial factor knows one gravity: nodes therefore live in a world whose z is
up, and ``world_R_up = Exp(tilt)``, two numbers, turns it to the world that poses are measured in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.measurements.interface import (
    skew,
)
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    import gtsam

# What is known for certain, beside what is estimated with it, in rad and in metres.
_CERTAIN = 1e-6


@dataclass(frozen=True)
class NodeKeys:
    """gtsam's keys of a node."""

    pose: int
    velocity: int
    bias: int


def keys(index: int) -> NodeKeys:
    """Keys of the node of that number."""
    import gtsam

    return NodeKeys(*(gtsam.symbol(letter, index) for letter in "xvb"))


@dataclass(frozen=True, eq=False)
class SharedUnknowns:
    """What all nodes share: as first guessed, with deviations; zero: it is known.

    Fields:
        imu_T_camera, time_offset_s: first guesses.
        tilt_sigma_rad: of the world's z from up, about x and about y.
        turn_sigma_rad, shift_sigma_m: of the camera's pose on the IMU.
        offset_sigma_s: of the time offset.
    """

    imu_T_camera: Motor
    time_offset_s: float
    tilt_sigma_rad: float
    turn_sigma_rad: float
    shift_sigma_m: float
    offset_sigma_s: float

    @property
    def keys(self) -> dict[str, int]:
        """Gtsam's keys of what is estimated: tilt, camera, offset."""
        import gtsam

        wanted = {
            "tilt": self.tilt_sigma_rad > 0.0,
            "camera": self.turn_sigma_rad > 0.0 or self.shift_sigma_m > 0.0,
            "offset": self.offset_sigma_s > 0.0,
        }
        return {name: gtsam.symbol(name[0], 0) for name, asked in wanted.items() if asked}

    def priors(self) -> list[gtsam.NonlinearFactor]:
        """What is believed of it beforehand."""
        import gtsam

        priors: list[gtsam.NonlinearFactor] = []
        own = self.keys
        if "tilt" in own:
            model = gtsam.noiseModel.Isotropic.Sigma(2, self.tilt_sigma_rad)
            priors.append(gtsam.PriorFactorVector(own["tilt"], np.zeros(2), model))
        if "camera" in own:
            sigmas = np.repeat([self.turn_sigma_rad, self.shift_sigma_m], 3)
            certain = gtsam.noiseModel.Diagonal.Sigmas(np.maximum(sigmas, _CERTAIN))
            pose = gtsam.Pose3(self.imu_T_camera.as_matrix())
            priors.append(gtsam.PriorFactorPose3(own["camera"], pose, certain))
        if "offset" in own:
            model = gtsam.noiseModel.Isotropic.Sigma(1, self.offset_sigma_s)
            guess = np.array([self.time_offset_s])
            priors.append(gtsam.PriorFactorVector(own["offset"], guess, model))
        return priors

    def insert(self, values: gtsam.Values) -> None:
        """Add the first guesses."""
        import gtsam

        own = self.keys
        if "tilt" in own:
            values.insert(own["tilt"], np.zeros(2))
        if "camera" in own:
            values.insert(own["camera"], gtsam.Pose3(self.imu_T_camera.as_matrix()))
        if "offset" in own:
            values.insert(own["offset"], np.array([self.time_offset_s]))

    def tilt(self, values: gtsam.Values) -> FloatArray:
        """The rotation vector ``(3,)`` from up to the world's z."""
        if "tilt" not in self.keys:
            return np.zeros(3)
        return np.append(values.atVector(self.keys["tilt"]), 0.0)

    def camera(self, values: gtsam.Values) -> Motor:
        """The camera's pose on the IMU."""
        if "camera" not in self.keys:
            return self.imu_T_camera
        pose = values.atPose3(self.keys["camera"])
        return _motor(pose.rotation().matrix().tobytes(), pose.translation().tobytes())

    def offset_s(self, values: gtsam.Values) -> float:
        """The time offset of the camera."""
        if "offset" not in self.keys:
            return self.time_offset_s
        return float(values.atVector(self.keys["offset"])[0])


@lru_cache(maxsize=8)
def _motor(rotation: bytes, translation: bytes) -> Motor:
    """Every factor asks for the same, many times a step."""
    matrix = np.frombuffer(rotation).reshape(3, 3)
    return Motor.from_rotor_translation(Rotor.from_matrix(matrix), np.frombuffer(translation))


def lean(tilt: FloatArray) -> FloatArray:
    """How two numbers of tilt turn the world, on the right of ``world_R_up``: ``(3, 2)``."""
    return Rotor.right_jacobian(tilt)[:, :2]


def leans(pose: gtsam.Pose3, leaning: FloatArray) -> FloatArray:
    """How they move a pose in its own axes: ``(6, 2)``."""
    moved: FloatArray = pose.inverse().AdjointMap()[:, :3] @ leaning
    return moved


def lean_velocity(pose: gtsam.Pose3, speed: FloatArray, leaning: FloatArray) -> FloatArray:
    """How they move a velocity in the axes of its pose: ``(3, 2)``."""
    moved: FloatArray = -pose.rotation().matrix().T @ skew(speed) @ leaning
    return moved
