from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

class Engine:
    def imu(self, time_ns: int, gyro: Any, accel: Any) -> None: ...
    def samples(self, time_ns: NDArray[Any], gyro: NDArray[Any], accel: NDArray[Any]) -> None: ...
    def hold(self, time_ns: NDArray[Any], gyro: NDArray[Any], accel: NDArray[Any]) -> None: ...
    def play(self) -> None: ...
    def add(
        self,
        kind: int,
        time_ns: int,
        number: int,
        data: NDArray[Any],
        predict: Callable[[int, NDArray[Any]], NDArray[Any]] | None,
        source: int,
    ) -> None: ...
    def schedule(
        self,
        kind: int,
        time_ns: NDArray[Any],
        data: NDArray[Any],
        noise: NDArray[Any] | None,
        numbers: NDArray[Any] | None,
        predict: Callable[[int, NDArray[Any]], NDArray[Any]] | None,
        source: int,
    ) -> None: ...
    def outputs(
        self,
        time_ns: NDArray[Any],
        pose: NDArray[Any],
        velocity: NDArray[Any],
        bias: NDArray[Any],
        covariance: NDArray[Any],
        others: NDArray[Any],
        whole: NDArray[Any] | None,
        final: bool,
    ) -> None: ...
    def smooth(self) -> None: ...
    def state(self) -> Any: ...
    def state_at(self, time_ns: int) -> Any: ...
    def judged(self) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def doubted(self) -> tuple[NDArray[Any], int | None]: ...
    def held(self) -> tuple[int, int]: ...

def engine(
    model: tuple[float, float, float, float, float],
    start: tuple[float, float, float, float, float, float],
    known: tuple[float, float, float, float],
    gate: tuple[float, ...],
    middle: tuple[float, ...],
    most_noise: float,
    gap: tuple[float, float, float],
    history_s: float,
    lag_s: float,
    check_every: int,
    imu_T_camera: tuple[float, ...],
    delay_s: float,
    rest: tuple[float, float, float, float, float],
    keeps_earlier: bool,
) -> Engine: ...
def increments(
    first: NDArray[Any],
    dt_s: NDArray[Any],
    rate: NDArray[Any],
    force: NDArray[Any],
    bias: NDArray[Any],
    squares: tuple[float, float, float, float],
    pose: NDArray[Any],
    velocity: NDArray[Any],
    transition: NDArray[Any],
    covariance: NDArray[Any],
) -> None: ...
def held_increments(
    first: NDArray[Any],
    dt_s: NDArray[Any],
    rate: NDArray[Any],
    force: NDArray[Any],
    bias: NDArray[Any],
    squares: tuple[float, float, float, float],
    pose: NDArray[Any],
    velocity: NDArray[Any],
    transition: NDArray[Any],
    covariance: NDArray[Any],
) -> None: ...
def process_noise(
    dt_s: NDArray[Any], squares: tuple[float, float, float, float], made: NDArray[Any]
) -> None: ...
