"""The mannequin as other files would hold it: other names, lies, sizes, and poses of its nodes."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Skeleton, mannequin, write_gltf
from motorcade.animation.formats import FormatError, read_character, read_motion
from motorcade.animation.retarget import body_of, legs_of, retarget
from motorcade.ga import Motor, Rotor

LIMBS = ("thigh", "calf", "foot", "upper_arm", "forearm", "hand")


@pytest.fixture(scope="module")
def figure():
    return mannequin()


def _written(figure, path: Path, change) -> Path:
    """The figure's glTF after a change of its JSON, said to come from elsewhere."""
    write_gltf(path, figure)
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    document["asset"]["generator"] = "another"
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    path.write_bytes(head + struct.pack("<I4s", len(text), b"JSON") + text + rest)
    return path


def _under(**transform):
    """A change that hangs the whole scene under one more node."""

    def change(document):
        scene = document["scenes"][0]
        document["nodes"].append({"children": scene["nodes"], **transform})
        scene["nodes"] = [len(document["nodes"]) - 1]

    return change


def _stands_like(found, figure):
    """Joints of limbs lie about the hips as the figure's do, within a thousandth of its height."""
    own, other = body_of(found.skeleton), body_of(figure.skeleton)
    scale = figure.height_m / found.height_m
    hips, others = found.skeleton.rest_world[own["hips"]], figure.skeleton.rest_world[other["hips"]]
    aside = (others.translation_m - scale * hips.translation_m) * [1.0, 1.0, 0.0]
    for side in ("left", "right"):
        for part in LIMBS:
            role = f"{side}_{part}"
            at = scale * found.skeleton.rest_world.translation_m[own[role]] + aside
            expected = figure.skeleton.rest_world.translation_m[other[role]]
            np.testing.assert_allclose(at, expected, atol=1e-3 * figure.height_m)
    assert abs(found.vertices[:, 2].min()) < 1e-6


def _renamed(figure, rng):
    skeleton = figure.skeleton
    letters = np.array(list("bcdfghjkmpqstvwxz"))
    names = tuple("".join(rng.choice(letters, 8)) + str(k) for k in range(len(skeleton)))
    return replace(figure, skeleton=Skeleton(names, skeleton.parents, skeleton.rest))


TURNS = {
    "as written": {},
    "turned to the left": {"rotation": [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]},
    "turned about": {"rotation": [0.0, 1.0, 0.0, 0.0]},
    "lying": {"rotation": [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]},
    "in centimetres": {"scale": [100.0] * 3},
    "in millimetres": {"scale": [1000.0] * 3},
    "above the ground": {"translation": [0.0, 1.0, 0.0]},
}


@pytest.mark.parametrize("lie", list(TURNS))
@pytest.mark.parametrize("names", ["its own", "random"])
def test_a_figure_stands_and_faces_ahead_however_its_file_lies(figure, tmp_path, rng, lie, names):
    given = figure if names == "its own" else _renamed(figure, rng)
    given = replace(given, clips=())
    found = read_character(_written(given, tmp_path / "lies.glb", _under(**TURNS[lie])))
    _stands_like(found, figure)
    assert found.height_m == pytest.approx(figure.height_m, rel=1e-3)
    told = " ".join(found.notices)
    assert ("its unit is not known" in told) == lie.startswith("in ")
    assert ("where the format says" in told) == lie.startswith("turned")


@pytest.mark.parametrize("names", ["its own", "random"])
def test_nodes_in_mid_jump_do_not_tell_how_a_figure_stands(figure, tmp_path, rng, names):
    """Turned, leaning, knees drawn up: the bind pose stands nevertheless, and so do clips."""
    given = figure if names == "its own" else _renamed(figure, rng)
    body = body_of(figure.skeleton)
    axis = figure.skeleton.rest_world.rotor.inverse().apply(np.array([0.0, 1.0, 0.0]))

    def jump(document):
        joints = document["skins"][0]["joints"]
        turns = {"left_thigh": -1.4, "right_thigh": -1.2, "left_calf": 2.0, "right_calf": 1.9}
        for role, angle in (turns | {"hips": 0.5}).items():
            node = document["nodes"][joints[body[role]]]
            x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
            bent = Rotor.from_quaternion([w, x, y, z]) @ Rotor.from_rotation_vector(
                angle * axis[body[role]]
            )
            w, x, y, z = bent.as_quaternion()
            node["rotation"] = [x, y, z, w]
            if role == "hips":
                node["translation"] = [0.1, 1.6, 0.2]

    path = _written(given, tmp_path / "jump.glb", jump)
    found = read_character(path)
    assert any("another pose" in notice for notice in found.notices)
    _stands_like(found, figure)
    at, expected = (
        who.skeleton.world(who.clip("walk").at(0.3)).translation_m[:, 2] for who in (found, figure)
    )
    np.testing.assert_allclose(at, expected, atol=0.01 * figure.height_m)
    skeleton = read_motion(path).skeleton
    np.testing.assert_allclose(
        np.ptp(skeleton.rest_world.translation_m, axis=0),
        np.ptp(figure.skeleton.rest_world.translation_m, axis=0),
        atol=1e-3,
    )


def test_clips_that_float_are_put_on_the_ground(figure, tmp_path):
    """All of them by one height, which a notice tells; files written here are left as they are."""
    floating = []
    for clip in figure.clips:
        poses = clip.poses.coefficients.copy()
        lift = figure.skeleton.rest[:1].from_translation([[0.0, 0.0, 0.1]])
        poses[:, 0] = (lift @ clip.poses[:, 0]).coefficients
        floating.append(replace(clip, poses=type(clip.poses)(poses)))
    given = replace(figure, clips=tuple(floating))
    found = read_character(_written(given, tmp_path / "floats.glb", lambda _: None))
    assert any("put on the ground by the clips" in notice for notice in found.notices)
    for clip in figure.clips:
        at, expected = (
            who.skeleton.world(who.clip(clip.name).at(0.5)).translation_m[:, 2]
            for who in (found, figure)
        )
        np.testing.assert_allclose(at, expected, atol=0.01 * figure.height_m)
    write_gltf(tmp_path / "own.glb", given)
    own = read_character(tmp_path / "own.glb")
    np.testing.assert_allclose(
        own.clips[0].poses.as_matrix()[0], floating[0].poses.as_matrix()[0], atol=1e-5
    )


def test_a_figure_of_no_size_is_told(figure, tmp_path):
    """Under a node of scale 0 no unit helps; a mesh of one point is no mesh."""
    given = replace(figure, clips=())
    found = read_character(_written(given, tmp_path / "none.glb", _under(scale=[0.0] * 3)))
    assert any("no unit in use makes a figure" in notice for notice in found.notices)
    write_gltf(tmp_path / "point.glb", replace(given, vertices=0.0 * given.vertices))
    with pytest.raises(FormatError, match="meshes: expected vertices apart"):
        read_character(tmp_path / "point.glb")


def test_callers_may_say_what_is_up_and_ahead(figure, tmp_path):
    path = _written(replace(figure, clips=()), tmp_path / "said.glb", lambda _: None)
    found = read_character(path, up="y", front="-z")
    toes = body_of(figure.skeleton)["left_toes"], body_of(figure.skeleton)["left_foot"]
    step = np.subtract(*found.skeleton.rest_world.translation_m[list(toes)])
    assert step[0] < -0.9 * np.linalg.norm(step[:2])  # it walks backwards, as was asked
    with pytest.raises(FormatError, match=r"front: .* across \+y, which is up, got \+y"):
        read_character(path, front="y")
    with pytest.raises(FormatError, match="up: expected one of x, -x"):
        read_character(path, up="top")


def test_a_motion_on_a_figure_of_other_names_keeps_feet_on_the_ground(figure, rng):
    other = _renamed(figure, rng)
    clip = figure.clip("run")
    made = retarget(clip, figure.skeleton, other.skeleton)
    joints = [other.skeleton.index(leg.ball) for leg in legs_of(other.skeleton)]
    heights = other.skeleton.world(made.at(np.linspace(0, 0.7, 30)).rigid).translation_m
    assert abs(heights[:, joints, 2].min()) < 0.02 * figure.height_m


def test_lost_scale_is_measured_over_all_clips(figure, tmp_path):
    """A thigh that a clip stretches along itself by a half."""
    thigh = body_of(figure.skeleton)["left_thigh"]

    def stretch(document):
        for animation in document["animations"]:
            if animation["name"] != "wave":
                continue
            node = document["skins"][0]["joints"][thigh]
            document["nodes"][node]["scale"] = [1.0, 1.0, 1.0]
            sampler = dict(animation["samplers"][0])
            count = document["accessors"][sampler["input"]]["count"]
            document["accessors"].append({"componentType": 5126, "count": count, "type": "VEC3"})
            at = len(document["accessors"]) - 1
            values = np.tile(np.float32([1.0, 1.0, 1.5]), (1, 1)).tobytes()
            document["buffers"].append({"byteLength": 12, "uri": _data(values)})
            document["bufferViews"].append(
                {"buffer": len(document["buffers"]) - 1, "byteLength": 12}
            )
            document["accessors"][at] |= {
                "bufferView": len(document["bufferViews"]) - 1,
                "count": 1,
            }
            key = [float(figure.clip("wave").time_s[0])]
            zero = np.float32(key).tobytes()
            document["buffers"].append({"byteLength": 4, "uri": _data(zero)})
            document["bufferViews"].append(
                {"buffer": len(document["buffers"]) - 1, "byteLength": 4}
            )
            document["accessors"].append(
                {
                    "bufferView": len(document["bufferViews"]) - 1,
                    "componentType": 5126,
                    "count": 1,
                    "type": "SCALAR",
                    "min": key,
                    "max": key,
                }
            )
            animation["samplers"].append({"input": at + 1, "output": at})
            animation["channels"].append(
                {
                    "sampler": len(animation["samplers"]) - 1,
                    "target": {"node": node, "path": "scale"},
                }
            )

    found = read_character(_written(figure, tmp_path / "stretch.glb", stretch))
    told = [notice for notice in found.notices if "different scales an axis" in notice]
    assert len(told) == 1
    assert "in clip 'wave'" in told[0]
    size = float(told[0].split("up to ")[1].split(" mm")[0])
    assert 20.0 < size < 300.0


def _data(values: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(values).decode()


def test_an_animal_lends_no_motion_to_a_figure_on_two_legs(figure):
    """Nor the other way about; pairs that a caller gives are taken."""
    leg = [[0.0, 0.0, 0.5], [0.05, 0.0, 0.25], [-0.03, 0.0, 0.05], [0.05, 0.0, 0.0]]
    at = [[0, 0, 0.55], [0.3, 0, 0.57], [0.6, 0, 0.55], [0.75, 0, 0.65], [0.9, 0, 0.65]]
    parents = [-1, 0, 1, 2, 3]
    for x, above in ((0.0, 0), (0.6, 2)):
        for y in (0.1, -0.1):
            for k, place in enumerate(leg[: 4 if x == 0.0 else 3]):
                at.append([place[0] + x, place[1] + y, place[2]])
                parents.append(above if k == 0 else len(at) - 2)
    above_m = [at[p] if p >= 0 else [0.0, 0.0, 0.0] for p in parents]
    step = np.subtract(at, above_m)
    names = tuple(f"bone {k}" for k in range(len(at)))
    dog = Skeleton(names, np.array(parents), Motor.from_translation(step))
    assert [leg.ball for leg in legs_of(dog)] == ["bone 8", "bone 12", "bone 15", "bone 18"]
    with pytest.raises(ValueError, match="as many legs, got four of the target"):
        retarget(figure.clip("walk"), figure.skeleton, dog)
    made = retarget(figure.clip("walk"), figure.skeleton, dog, {"bone 4": "head"})
    assert made.poses.shape[1] == len(dog)
