"""A print lies or stands by how dense up is there, not by how many directions there are."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.stages.view.anchored import PRINT_SURE, Grounds
from motorcade.replays.stages.view.ground import Ground
from motorcade.tracking.planes import UpEstimate

FACE = Ground(Motor.identity(), (0.5, -0.5), 0.2, "the board", np.array([[0.0, -1.0], [1.0, 0.0]]))


def estimate(lies: float, stands: float) -> UpEstimate:
    """So much of up along the board's normal, so much evenly across it, the rest elsewhere."""
    rng = np.random.default_rng(0)
    turn = rng.uniform(0.0, 2.0 * np.pi, 300)
    across = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    away = np.array([[0.0, 0.6, 0.8]])
    directions = np.concatenate([[[0.0, 0.0, 1.0]], across, away])
    mass = np.concatenate([[lies], np.full(300, stands / 300), [1.0 - lies - stands]])
    return UpEstimate(directions[0], lies, 0.1, directions, mass)


@pytest.mark.parametrize(
    ("lies", "stands", "name"),
    [
        (0.9, 0.01, "the board"),
        (0.25, 0.5, "the board"),  # a desk filmed from above
        (0.015, 0.35, "the board"),  # up hardly known at all
        (0.007, 0.77, "the board"),  # a sheet below a phone held level
        (0.001, 0.8, "the top edge of the board"),
        (0.0, 0.3, "the top edge of the board"),
    ],
)
def test_the_denser_of_the_two_is_taken_and_doubted_where_it_is_a_guess(
    lies: float, stands: float, name: str
) -> None:
    scene: Any = SimpleNamespace(
        recording=SimpleNamespace(camera=None), camera_poses=SimpleNamespace(metric=True)
    )
    grounds = Grounds(scene.recording, scene.camera_poses, None, None)  # type: ignore[arg-type]
    first, second = grounds._of_print(FACE, estimate(lies, stands))
    assert first.name == name
    assert first.rank >= second.rank
    assert first.rank + second.rank == pytest.approx(lies + stands, abs=1e-6)
    assert ("guess" in first.doubt) == (first.rank < PRINT_SURE)
