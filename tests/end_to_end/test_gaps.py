"""Whatever takes a path or a stream gives a result, or refuses, however long a gap is.

`tests.end_to_end.gaps` measures what that costs, of commands too; here functions are tried once.
"""

import importlib
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import ImuStream, VibrationSpectrum
from tests.end_to_end import gap_doors, gap_paths
from tests.end_to_end.gap_doors import FUNCTIONS
from tests.end_to_end.gap_paths import Case, shapes

DAYS_NS = 30 * 86_400 * 10**9
FACES = (
    "fusion",
    "fusion.filter",
    "fusion.graph",
    "fusion.imu",
    "fusion.metrics",
    "fusion.motions.degradations",
    "fusion.smoothing",
    "fusion.sync",
    "fusion.visual_inertial",
    "render.plots",
)
ELSEWHERE = {
    # bases of what is tried
    "CausalFilter", "Degradation", "InTurn", "KalmanFilter", "FilterMethod",
    # results, whose methods are called where they are made
    "Alignment", "InertialStart", "AutomaticPath", "SmootherChoice", "SmoothingResult",
    "Synchronised",
    # they run what they are given
    "seconds_per_pose",
    # `start_inertial` and `preintegrate`, which refuse for them, are tried
    "adjust_visual_inertial", "metric_map",
    # it wants ten seconds without a gap, and is tried below
    "VibrationSpectrum",
}  # fmt: skip


@pytest.mark.parametrize("door", FUNCTIONS)
@pytest.mark.parametrize("shape", ["one gap", "gaps alone"])
@pytest.mark.filterwarnings("ignore")
def test_a_gap_of_thirty_days_gives_a_result_or_a_refusal(door, shape, tmp_path):
    try:
        FUNCTIONS[door](Case.of(shapes(DAYS_NS)[shape], tmp_path / "case"))
    except ValueError as refused:
        message = str(refused)
    except RuntimeError as refused:  # of jobs, which say what each was refused for
        message = str(refused)
        assert "failed; the others are kept" in message
    else:
        return
    assert message


def test_vibration_is_learnt_beside_a_gap_of_thirty_days(rng):
    steps_ns = np.full(6000, 5_000_000)
    steps_ns[1000] = DAYS_NS
    shaken = rng.normal(0.0, 0.5, (2, 6000, 3))
    gapped = ImuStream(np.cumsum(steps_ns), *shaken)
    alone = ImuStream(gapped.time_ns[1000:], *shaken[:, 1000:])
    learnt, expected = (VibrationSpectrum.learnt(one) for one in (gapped, alone))
    np.testing.assert_allclose(learnt.accel_rms_m_s2, expected.accel_rms_m_s2, rtol=1e-12)


@pytest.mark.parametrize("face", FACES)
def test_every_public_function_that_takes_a_path_or_stream_is_tried(face):
    tried = Path(gap_doors.__file__).read_text() + Path(gap_paths.__file__).read_text()
    package = importlib.import_module(f"motorcade.{face}")
    missing = {
        name
        for name in package.__all__
        if _takes_paths(getattr(package, name)) and name not in tried and name not in ELSEWHERE
    }
    assert not missing


def _takes_paths(public: object) -> bool:
    """Whether a function, or a method of a class, takes a trajectory, stream or measurements."""
    functions = [public]
    if inspect.isclass(public):
        functions = [
            getattr(one, "__func__", one)
            for name, one in vars(public).items()
            if not name.startswith("_")
        ]
    kinds = re.compile("Trajectory|ImuStream|PoseMeasurements")
    return any(
        name != "return" and kinds.search(str(kind))
        for function in functions
        if inspect.isfunction(function)
        for name, kind in function.__annotations__.items()
    )
