"""Soles measured on meshes: boots longer than feet neither sink nor drag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from docs.making.figure.proportions import HEEL_BACK_M, TOE_FORWARD_M, TOE_LENGTH_M
from motorcade.animation import GroundPath, mannequin, retarget, skin, walk_along
from motorcade.animation.formats import read_character
from motorcade.animation.ik import GroundHeights, Leg, fitted_legs
from motorcade.animation.ik.feet import sole_clearance_m
from motorcade.animation.place import on_the_spot
from motorcade.animation.retarget import legs_of
from motorcade.animation.skeleton import turned_joint
from motorcade.ga import Rotor

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


@pytest.mark.parametrize("name", ["mannequin", *BOOTS])
def test_a_tilted_foot_is_as_low_as_its_lowest_skin(request, name: str):
    """Tilted to either side, on its toes and on its heel; the witness is the skin itself."""
    if name == "mannequin":
        who = mannequin()
    else:
        who = read_character(request.getfixturevalue("data_dir") / "rigs" / BOOTS[name])
    skeleton, joints = who.skeleton, who.influences[0][:, 0]
    plain = legs_of(skeleton)[0]
    (leg,) = fitted_legs([plain], who)
    ankle, ball = leg.foot(skeleton)
    of_foot = np.isin(joints, (ankle, *np.flatnonzero(skeleton.parents == ankle), ball))
    of_foot |= np.isin(joints, np.flatnonzero(skeleton.parents == ball))
    off = []
    for axis in np.eye(3)[:2]:
        for angle in np.radians([-40.0, -15.0, 0.0, 15.0, 40.0]):
            world = skeleton.rest_world.rotor
            turn = Rotor.from_rotation_vector(angle * axis)
            above = world[skeleton.parents[ankle]].inverse()
            pose = turned_joint(skeleton.rest, ankle, above @ turn @ world[ankle])
            lowest = skin(who, pose, "linear")[0][of_foot, 2].min()
            feet = tuple(skeleton.world(pose)[[joint]] for joint in (ankle, ball))
            flat = GroundHeights().height_m
            lows = [
                float(sole_clearance_m(skeleton, feet, one.sole(skeleton), flat)[0])
                for one in (leg, plain)
            ]
            off.append((np.array(lows) - lowest) / who.height_m)
    found = np.abs(off).max(axis=0)
    print(name, "edges and centre lines, off the skin in heights:", found.round(4))
    assert found[0] < 0.004
    assert found[1] > 2.0 * found[0]


def test_a_leg_without_skin_near_the_ground_stays_as_it_is():
    hip, knee, ankle, ball = "left_upper_arm", "left_forearm", "left_hand", "left_middle_1"
    arm = [Leg(hip, knee, ankle, ball)]
    assert fitted_legs(arm, mannequin()) == arm


def test_a_leg_without_a_ball_has_its_edges_measured_alone():
    plain = Leg("left_thigh", "left_calf", "left_foot")
    (leg,) = fitted_legs([plain], mannequin())
    assert (leg.heel, leg.tip, leg.foot_m) == (plain.heel, plain.tip, ())
    assert np.ptp(leg.toes_m, axis=0)[0] > 0.2
