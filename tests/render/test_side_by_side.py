"""Images side by side with running errors, and the spin of Euler angles in them."""

import numpy as np
import pytest

from docs.making.side_by_side import (
    SEED,
    SIGMA_M,
    SIGMA_RAD,
    rotation_errors_deg,
    smoothed_paths,
    swing,
)
from docs.making.traces import ErrorTraces, beside
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.render.plots.style import COLOURS


def test_images_stand_in_a_row_over_their_strip() -> None:
    left = np.full((60, 80, 3), 10, dtype=np.uint8)
    right = np.full((60, 80, 3), 200, dtype=np.uint8)
    strip = np.full((70, 160, 3), 99, dtype=np.uint8)
    made = beside({"euler": left, "motor": right}, strip)
    assert made.shape == (130, 160, 3)
    np.testing.assert_array_equal(made[30:60, :80], left[30:])
    np.testing.assert_array_equal(made[30:60, 80:], right[30:])
    np.testing.assert_array_equal(made[60:], strip)
    with pytest.raises(ValueError, match="160 pixels across"):
        beside({"euler": left, "motor": right}, strip[:, :100])
    with pytest.raises(ValueError, match="one size"):
        beside({})


def test_traces_grow_with_time_and_end_at_their_values() -> None:
    time_s = np.linspace(0.0, 2.0, 21)
    traces = ErrorTraces(time_s, {"motor": np.full(21, 0.5)}, "deg", (400, 120), highest=1.0)
    green = np.array(list(bytes.fromhex(COLOURS["motor"][1:])))
    widths = []
    for now_s in (0.5, 1.0, 2.0):
        strip = traces.strip(now_s)[40:]
        columns = np.flatnonzero(np.any(np.all(strip == green, axis=2), axis=0))
        widths.append(columns.max() - columns.min())
    np.testing.assert_allclose(np.diff(widths), [81, 162], atol=3)
    with pytest.raises(ValueError, match="200 x 60"):
        ErrorTraces(time_s, {}, "deg", (0, 0))
    with pytest.raises(ValueError, match="finite"):
        ErrorTraces(time_s, {"motor": np.full(21, np.nan)}, "deg", (400, 120))


def test_euler_spins_where_quaternion_and_motor_stay() -> None:
    truth = swing()
    measured = Gaussian(SIGMA_M, SIGMA_RAD).apply(truth, np.random.default_rng(SEED))
    errors = {
        name: rotation_errors_deg(path, truth) for name, path in smoothed_paths(measured).items()
    }
    assert errors["euler"].max() > 45.0
    assert errors["quaternion"].max() < 1.5
    assert errors["motor"].max() < 1.5
