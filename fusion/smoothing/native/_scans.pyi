from motorcade.ga.arrays import FloatArray, IntArray

_Blocks = tuple[float, float, float]

class Scan:
    def update(self, pose: FloatArray, time_ns: int, out: FloatArray) -> None: ...
    def run(
        self,
        poses: FloatArray,
        time_ns: IntArray,
        out: FloatArray,
        noise: FloatArray | None = None,
    ) -> None: ...
    def measured_with(self, deviations: _Blocks) -> None: ...
    @property
    def log_likelihood(self) -> float: ...

def exponential(representation: str, scale: bool, cutoff_hz: float) -> Scan: ...
def double_exponential(
    representation: str, scale: bool, cutoff_hz: float, trend_cutoff_hz: float
) -> Scan: ...
def one_euro(
    representation: str,
    scale: bool,
    min_cutoff_hz: float,
    slopes: _Blocks,
    derivative_cutoff_hz: float,
) -> Scan: ...
def kalman(
    representation: str, scale: bool, order: int, densities: _Blocks, deviations: _Blocks
) -> Scan: ...
def rts(
    representation: str,
    scale: bool,
    order: int,
    poses: FloatArray,
    time_ns: IntArray,
    noise: FloatArray,
    densities: _Blocks,
    out: FloatArray,
    states: tuple[FloatArray, FloatArray] | None = None,
) -> float: ...
def layout(representation: str, scale: bool) -> tuple[list[int], list[float], int]: ...
def coordinates(representation: str, scale: bool, poses: FloatArray) -> FloatArray: ...
def poses(representation: str, scale: bool, coordinates: FloatArray) -> FloatArray: ...
def local(
    representation: str, scale: bool, coordinates: FloatArray, base: FloatArray
) -> FloatArray: ...
def retract(
    representation: str, scale: bool, base: FloatArray, vectors: FloatArray
) -> FloatArray: ...
