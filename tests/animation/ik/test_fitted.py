"""Soles measured on meshes: boots longer than feet neither sink nor drag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from docs.making.figure.proportions import HEEL_BACK_M, TOE_FORWARD_M, TOE_LENGTH_M
from motorcade.animation import GroundPath, mannequin, retarget, skin, walk_along
from motorcade.animation.formats import read_character
from motorcade.animation.ik import Leg, fitted_legs
from motorcade.animation.place import on_the_spot
from motorcade.animation.retarget import legs_of

BOOTS = {"knight": "kaykit/Knight.glb", "bob": "md5/Bob.md5mesh"}


def test_the_mannequins_soles_are_as_long_as_they_were_made():
    figure = mannequin()
    for leg in fitted_legs(legs_of(figure.skeleton), figure):
        assert leg.heel == pytest.approx(HEEL_BACK_M / TOE_FORWARD_M, abs=0.1)
        assert leg.tip == pytest.approx(TOE_LENGTH_M / TOE_FORWARD_M, abs=0.1)


@pytest.mark.parametrize("name", BOOTS)
def test_a_walker_in_boots_neither_sinks_nor_drags_them(data_dir: Path, name: str):
    """As shares of its height, with soles measured and without."""
    who, lent = read_character(data_dir / "rigs" / BOOTS[name]), mannequin()
    clip = retarget(lent.clip("run"), lent.skeleton, who.skeleton)
    plain = legs_of(who.skeleton)
    found = []
    for legs in (fitted_legs(plain, who), plain):
        loop, speed_m_s = on_the_spot(clip, who.skeleton, legs)
        path = GroundPath(np.array([[0.0, 0.0], [1.5 * who.height_m, 0.0]]))
        made = walk_along(path, loop, who.skeleton, legs, speed_m_s)
        feet = [who.skeleton.index(part) for leg in legs for part in (leg.ankle, leg.ball)]
        rows = np.arange(len(who.joints))
        carried_by = who.joints[rows, np.argmax(who.weights, axis=1)]
        mine = np.isin(carried_by, feet) & (who.vertices[:, 2] < 0.02 * who.height_m)
        at = np.stack([skin(who, pose, "linear")[0][mine] for pose in made.poses[::2]])
        at = made.plane_T_character[::2].reshape(-1, 1).apply(at) / who.height_m
        touching = at[..., 2] < 0.0015
        steps = np.linalg.norm(np.diff(at[..., :2], axis=0), axis=-1)
        dragged = np.where(touching[1:] & touching[:-1], steps, 0.0).sum(axis=0).max()
        found.append((at[..., 2].min(), dragged))
    (low, dragged), (sunk, more) = found
    print(name, "lowest and most dragged skin, in heights:", np.round(found, 4).tolist())
    assert low > -0.01
    assert sunk < -0.01
    assert dragged < 0.06
    assert more > 3.0 * dragged


def test_a_leg_without_a_sole_on_the_mesh_stays_as_it_is():
    figure = mannequin()
    hip, knee, ankle, ball = "left_upper_arm", "left_forearm", "left_hand", "left_middle_1"
    legs = [Leg(hip, knee, ankle, ball), Leg("left_thigh", "left_calf", "left_foot")]
    assert fitted_legs(legs, figure) == legs
