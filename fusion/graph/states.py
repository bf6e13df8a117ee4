"""What a graph found: states at its nodes, with their covariances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from motorcade.fusion.graph.kinds import KindFactor
from motorcade.fusion.graph.shared import SharedUnknowns, lean
from motorcade.fusion.measurements.interface import (
    OFFSET,
    TILT,
    PredictedState,
    turn,
)
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray

if TYPE_CHECKING:
    import gtsam


@dataclass(frozen=True, eq=False)
class GraphStates:
    """States at N nodes, seen in the world that poses are measured in.

    Fields:
        world_T_imu, velocity_m_s: Motor ``(N,)``, ``(N, 3)``.
        bias: ``(N, 6)``, gyroscope first.
        covariance: ``(N, 15, 15)`` or ``(N, 24, 24)``, as of `motorcade.fusion.filter.Fused`.
        world_R_up: ``(3, 3)``; turns z to where up is.
        imu_T_camera, time_offset_s: of the camera.
    """

    world_T_imu: Motor
    velocity_m_s: FloatArray
    bias: FloatArray
    covariance: FloatArray
    world_R_up: FloatArray
    imu_T_camera: Motor
    time_offset_s: float

    @classmethod
    def of(
        cls,
        poses: Motor,
        velocity_m_s: FloatArray,
        bias: FloatArray,
        covariance: FloatArray,
        shared: SharedUnknowns,
        values: gtsam.Values,
    ) -> GraphStates:
        """Of gtsam's poses, velocities and covariances ``(N, n, n)``, pose, velocity, bias first.

        gtsam's velocity is in the world of nodes and its accelerometer's bias comes first.
        """
        tilt, own = shared.tilt(values), shared.keys
        whole = 24 if own else 15
        change = np.zeros((len(covariance), whole, covariance.shape[-1]))
        turned = poses.rotor.inverse().as_matrix()
        change[:, range(6), range(6)] = 1.0
        change[:, 6:9, 6:9] = turned
        change[:, range(9, 15), [12, 13, 14, 9, 10, 11]] = 1.0
        first = 15
        for name in own:
            if name == "tilt":
                leaning = lean(tilt)
                across = poses.inverse().adjoint()[..., :3] @ leaning
                change[:, :6, first : first + 2] = across
                speeds = np.cross(velocity_m_s[:, :, None], leaning[None], axis=1)
                change[:, 6:9, first : first + 2] = -turned @ speeds
                change[:, TILT, first : first + 2] = leaning[:2]
                first += 2
            elif name == "camera":
                change[:, range(17, 23), range(first, first + 6)] = 1.0
                first += 6
            else:
                change[:, OFFSET, first] = 1.0
        spread: FloatArray = change @ covariance @ change.swapaxes(-1, -2)
        world_R_up = turn(tilt)
        world_T_up = Motor.from_rotor_translation(Rotor.from_matrix(world_R_up), np.zeros(3))
        return cls(
            world_T_up @ poses,
            velocity_m_s @ world_R_up.T,
            bias,
            0.5 * (spread + spread.swapaxes(-1, -2)),
            world_R_up,
            shared.camera(values),
            shared.offset_s(values),
        )

    def squared(self, of: KindFactor) -> float:
        """The square of a measurement's normalised residual."""
        row = of.index
        before = row if of.earlier is None else of.earlier
        poses, bias = self.world_T_imu, self.bias[row]
        state = PredictedState(
            poses[row].rotor.as_matrix(),
            poses[row].translation_m,
            poses[before].rotor.as_matrix(),
            poses[before].translation_m,
            self.velocity_m_s[row],
            of.reading_rad_s - bias[:3],
            bias[:3],
            bias[3:],
            self.world_R_up,
            self.imu_T_camera.coefficients,
            self.time_offset_s,
        )
        residual = of.measurements.residual(of.row, state)
        return float(residual @ np.linalg.solve(of.measurements.covariance[of.row], residual))
