"""Equations of reprojection; see motorcade.tracking.optimise and motorcade.tracking.slam."""

from collections.abc import Sequence

from motorcade.ga.arrays import FloatArray, IntArray

class Lens:
    def __init__(
        self, model: str, fx: float, fy: float, cx: float, cy: float, distortion: Sequence[float]
    ) -> None: ...

class Sight:
    """What was seen from many poses, whatever these are."""

    def __init__(
        self,
        lens: Lens,
        pose_of: IntArray,
        point_of: IntArray,
        slot: IntArray,
        px: FloatArray,
        depth: FloatArray,
        disparity: float,
        huber: float,
        nearest: float,
    ) -> None: ...
    def evaluate(
        self, camera_T_world: FloatArray, points: FloatArray
    ) -> tuple[float, FloatArray]: ...
    def linearise(
        self, camera_T_world: FloatArray, points: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]: ...

class View:
    """What was seen from one pose, whatever it is."""

    def __init__(
        self, lens: Lens, points: FloatArray, px: FloatArray, huber: float, outlier: float
    ) -> None: ...
    def evaluate(self, camera_T_world: FloatArray) -> tuple[float, FloatArray]: ...
    def refine(
        self,
        world_T_camera: FloatArray,
        steps: int,
        gain: float,
        damping: float,
        most_damping: float,
    ) -> tuple[FloatArray, FloatArray]: ...
    def linearise(
        self, camera_T_world: FloatArray, most_px: float
    ) -> tuple[FloatArray, FloatArray]: ...

def invert(blocks: FloatArray) -> FloatArray | None: ...
def eliminate(
    inverted: FloatArray,
    gradient: FloatArray,
    block_of: IntArray,
    group_of: IntArray,
    coupling: FloatArray,
    information: FloatArray,
    right: FloatArray,
) -> tuple[FloatArray, FloatArray]: ...
def substitute(
    inverted: FloatArray,
    gradient: FloatArray,
    block_of: IntArray,
    group_of: IntArray,
    coupling: FloatArray,
    kept: FloatArray,
) -> FloatArray: ...
