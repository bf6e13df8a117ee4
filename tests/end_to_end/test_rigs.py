"""Rigs of all kinds stand, and each motion is played by each; see `rigs` for the whole table."""

from __future__ import annotations

import pytest

from tests.bench.data import data_folder
from tests.end_to_end.rigs import MOTIONS, RIGS, TARGETS, on_rig, standing

SUNK = {
    ("jacks", "astroboy"): 0.021,
    ("walk", "bob"): 0.023,
    ("run", "bob"): 0.024,
    ("run", "cesium"): 0.024,
    ("jog", "astroboy"): 0.022,
}
"""Pairs whose soles sink farther than the bound, and as what share of the height at most.

AstroBoy's boots are longer than the marks of his soles. The actor of walk, jog and run rests in a
stride, which tells no soles: figures are put on the ground as a whole, and at a few moments heels
that strike and tips that roll off are below it until feet are planted.
"""

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
    missed = {rig: row for rig in TARGETS if (row := on_rig(motion, rig)).missed}
    known = {rig: most for (name, rig), most in SUNK.items() if name == motion}
    assert set(missed) <= set(known), [str(row) for row in missed.values()]
    for rig, row in missed.items():
        assert set(row.missed) <= {"ground", "sunk"}, str(row)
        assert all(row.figures[one] >= -known[rig] for one in row.missed), str(row)
