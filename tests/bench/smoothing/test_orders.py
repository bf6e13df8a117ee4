"""What the bench of Euler orders says, and that its table says it."""

from __future__ import annotations

from typing import Any

import pytest

from motorcade.fusion.motions import MOTIONS
from tests.bench.smoothing.orders import NAMES, losing, order_row, orders_table


@pytest.fixture(scope="module")
def crossing() -> dict[str, Any]:
    path = MOTIONS["gimbal_crossing"].sampled(30.0, 10.0)
    return order_row("gimbal_crossing", path, "gaussian", seeds=(1,))


def test_who_crosses_the_lock_of_an_order_loses_in_it(crossing: dict[str, Any]) -> None:
    assert crossing["best"] == "euler_yxz"
    assert {"euler_xyz", "euler_zyx", "euler_yxy"} <= set(losing(crossing))
    assert "euler_yxz" not in losing(crossing)
    assert crossing["nearest_lock_deg"]["euler_xyz"] < 2.0
    assert crossing["nearest_lock_deg"]["euler_yxz"] > 60.0


def test_triples_are_followed_better_than_each_angle_alone(crossing: dict[str, Any]) -> None:
    for figure in ("rotation", "jitter"):
        left = crossing[figure]
        assert left["euler_best"] < 1.03
        assert left["euler_best"] < left["euler_xyz"] < left["euler_unwrapped"] < left["euler"]


def test_the_table_holds_every_figure(crossing: dict[str, Any]) -> None:
    text = orders_table([crossing])
    for name in NAMES:
        assert f"{crossing['rotation'][name]:.3g}" in text
    assert "best is euler_yxz; xyz (1°), " in text
