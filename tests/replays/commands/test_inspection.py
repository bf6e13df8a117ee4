"""`inspect` counts what is there and finds the gaps."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.replays.tasks.inspection import describe_stream


@pytest.fixture
def stamps() -> Callable[..., Any]:
    return lambda *seconds: np.round(np.array(seconds) * 1e9).astype(np.int64)


def test_an_even_stream_has_a_rate_and_no_gaps(stamps: Callable[..., Any]) -> None:
    about = describe_stream("imu", stamps(*np.arange(0.0, 2.0, 0.005)))
    assert about["imu_count"] == 400
    assert about["imu_rate_hz"] == pytest.approx(200.0)
    assert about["imu_gaps"] == 0
    assert about["imu_duration_s"] == pytest.approx(1.995)


def test_gaps_are_steps_far_beyond_the_usual(stamps: Callable[..., Any]) -> None:
    about = describe_stream("frames", stamps(0.0, 0.1, 0.2, 0.9, 1.0, 1.1, 1.3))
    assert about["frames_gaps"] == 1
    assert about["frames_longest_gap_s"] == pytest.approx(0.7)


def test_a_single_stamp_has_no_rate(stamps: Callable[..., Any]) -> None:
    assert describe_stream("truth", stamps(5.0)) == {"truth_count": 1}
