"""Orientation from inertial readings; see motorcade.fusion.orientation."""

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray

class Settings:
    def __init__(
        self,
        *,
        gyro_density: float,
        gyro_walk: float,
        accel_density: float,
        gyro_matrix: float,
        gyro_wander: float,
        first_bias: float,
        first_tilt: float,
        speed: float,
        speed_time: float,
        gravity: float,
        interval: float,
        rest_rate: float,
        rest_force: float,
        rest_after: float,
        disturbance: float,
        disturbance_time: float,
        averaged: bool,
    ) -> None: ...

class Stream:
    def __init__(self, settings: Settings) -> None: ...
    def update(
        self,
        time_ns: int,
        rate: FloatArray,
        force: FloatArray,
        field: FloatArray | None,
        out: FloatArray,
    ) -> None: ...
    @property
    def bias(self) -> list[float]: ...
    @property
    def at_rest(self) -> bool: ...
    @property
    def tilt_deviation(self) -> float: ...
    @property
    def heading_deviation(self) -> float: ...
    @property
    def field_deviation(self) -> float: ...

def run(
    settings: Settings,
    rates: FloatArray,
    forces: FloatArray,
    fields: FloatArray | None,
    time_ns: IntArray,
    backward: bool,
    rotors: FloatArray,
    biases: FloatArray,
    deviations: FloatArray,
    disturbances: FloatArray,
    rest: NDArray[np.bool_],
) -> float: ...
