"""What the RTS smoother and the 1€ filter promise on the standard motions."""

from __future__ import annotations

import pytest

from motorcade.fusion.motions import MOTIONS
from tests.bench.smoothing.lag import (
    OneEuroRow,
    RtsRow,
    lag_table,
    one_euro_row,
    rts_row,
)


def check(row: RtsRow) -> None:
    assert row.linear_jitter_cut >= 10.0
    assert row.angular_jitter_cut >= 10.0
    assert row.ape_share < 1.0
    assert row.rotation_error_share < 1.0
    for lag_ms in (row.position_lag_ms, row.angular_rate_lag_ms):
        assert lag_ms is None or abs(lag_ms) <= 2.0


def test_the_smoother_takes_jitter_without_lag_in_the_hand() -> None:
    row = rts_row("handheld")
    check(row)
    assert row.position_lag_ms is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MOTIONS if name != "handheld"])
def test_the_smoother_takes_jitter_without_lag(name: str) -> None:
    check(rts_row(name))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "quantity"),
    [("walk_and_look", "rotation"), ("stop_and_go", "rotation"), ("stop_and_go", "position")],
)
def test_one_euro_lags_half_as_much_at_equal_jitter(name: str, quantity: str) -> None:
    row = one_euro_row(name, quantity)
    assert row.one_euro_jitter <= 1.02 * row.exponential_jitter
    assert row.exponential_jitter < row.raw_jitter
    assert row.lag_share <= 0.5


@pytest.mark.slow
def test_at_steady_speed_one_euro_is_a_plain_low_pass() -> None:
    """Who walks on and on opens the filter to one cut-off, and nothing is gained in position."""
    row = one_euro_row("walk_and_look", "position", 4.0)
    assert row.lag_share == pytest.approx(1.0, abs=0.15)


def test_the_table_holds_every_row() -> None:
    smoother = RtsRow("screw", 1.0, 1.0, 20.0, 30.0, 0.4, 0.5, 0.1, None)
    filters = OneEuroRow("stop", "position", 4.0, (1.0, 2.0, 3.0), 9.0, 4.0, 4.0, 20.0, 8.0, 0.4)
    text = lag_table({"rts": [vars(smoother)], "one_euro": [vars(filters)]})
    assert "screw" in text
    assert "stop, position, 4.0 Hz" in text
    assert text.count("\n") == 6
