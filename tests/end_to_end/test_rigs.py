"""Rigs of all kinds stand, and each motion is played by each; see `rigs` for the whole table."""

from __future__ import annotations

import pytest

from tests.bench.data import data_folder
from tests.end_to_end.rigs import MOTIONS, RIGS, TARGETS, on_rig, standing

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not all((data_folder() / file).exists() for file in RIGS.values()), reason="no rigs here"
    ),
]


@pytest.mark.parametrize("rig", list(RIGS))
def test_a_rig_faces_ahead_and_stands_on_its_soles(rig):
    assert not standing(rig).missed


@pytest.mark.parametrize("motion", list(MOTIONS))
def test_a_motion_is_played_by_every_rig_with_limbs_as_the_actors(motion):
    missed = [str(row) for rig in TARGETS if (row := on_rig(motion, rig)).missed]
    assert not missed
