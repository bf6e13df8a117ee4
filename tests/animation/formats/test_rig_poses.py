"""Where a rig is bound, which way it faces and which way is up, when its file says little."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.animation.formats import FormatError, read_character, read_motion
from motorcade.animation.formats.rig.stance import guessed_unit_m
from motorcade.ga import Motor
from tests.animation.formats import samples
from tests.animation.formats.samples import Gltf, Write


def posed_tower() -> Gltf:
    """The tower bound straight up, whose nodes stand with the top turned by a quarter.

    Its upper part is light, so that most of it stands upright.
    """
    made = samples.gltf_tower()
    made.document["animations"] = []
    _, _, level = samples.tower()
    weights = np.zeros((12, 4))
    weights[:, 0] = level < 2
    weights[:, 1] = level == 2
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"]["WEIGHTS_0"] = made.add(weights)
    made.document["nodes"][2]["rotation"] = [0.0, 0.0, samples.QUARTER, samples.QUARTER]
    return made


def test_a_mesh_is_bound_upright_though_its_nodes_stand_in_a_pose(write: Write) -> None:
    """Some exporters leave a frame of a motion in the nodes."""
    plain = read_character(write("plain.glb", samples.gltf_tower().glb()))
    found = read_character(write("posed.glb", posed_tower().glb()))
    np.testing.assert_allclose(found.vertices, plain.vertices, atol=1e-6)
    np.testing.assert_allclose(
        found.skeleton.rest_world.as_matrix(), plain.skeleton.rest_world.as_matrix(), atol=1e-6
    )
    assert any("another pose than that in which the mesh was bound" in n for n in found.notices)
    assert not any("another pose" in notice for notice in plain.notices)


def test_joints_of_other_skins_stay_where_they_were_on_the_joint_above(write: Write) -> None:
    """The hat's own joint lies half a unit above the top, bound or posed."""
    made = posed_tower()
    document = made.document
    document["nodes"][2]["children"] = [4]
    document["nodes"] += [
        {"name": "tip", "translation": [0.0, 0.5, 0.0]},
        {"name": "hat", "mesh": 1, "skin": 1},
    ]
    document["scenes"][0]["nodes"].append(5)
    hat = samples.tower()[0] * 0.1
    document["skins"].append({"joints": [4]})
    document["meshes"].append(
        {
            "primitives": [
                {
                    "attributes": {
                        "POSITION": made.add(hat),
                        "JOINTS_0": made.add(np.zeros((12, 4)), "uint8"),
                        "WEIGHTS_0": made.add(np.tile([1.0, 0.0, 0.0, 0.0], (12, 1))),
                    }
                }
            ]
        }
    )
    found = read_character(write("hat.glb", made.glb()))
    rest = found.skeleton.rest_world
    top, tip = (found.skeleton.index(name) for name in ("top", "tip"))
    np.testing.assert_allclose(rest[top].translation_m, [0.0, 0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(rest[tip].translation_m, [0.0, 0.0, 1.5], atol=1e-6)
    np.testing.assert_allclose(found.vertices[12:].min(axis=0), [-0.02, -0.02, 1.5], atol=1e-6)


def test_a_mesh_bound_aslant_stays_so(write: Write) -> None:
    """Only turns by quarters are taken for other axes; here half of the tower is turned by one."""
    made = samples.gltf_tower()
    made.document["animations"] = []
    made.document["nodes"][2]["rotation"] = [0.0, 0.0, samples.QUARTER, samples.QUARTER]
    found = read_character(write("slanted.glb", made.glb()))
    plain = read_character(write("plain.glb", samples.gltf_tower().glb()))
    apart = found.skeleton.rest_world[0].rotor.inverse() @ plain.skeleton.rest_world[0].rotor
    assert float(apart.angle()) == pytest.approx(np.pi / 4, abs=1e-6)
    lengths = [np.linalg.norm(np.diff(one.vertices, axis=0), axis=1) for one in (found, plain)]
    np.testing.assert_allclose(lengths[0], lengths[1], atol=1e-6)


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_bind_matrices_without_an_inverse_are_refused(write: Write, value: float) -> None:
    made = samples.gltf_tower()
    matrices = np.tile(np.eye(4), (2, 1, 1))
    matrices[1, 0, 0] = value
    made.document["skins"][0]["inverseBindMatrices"] = made.add(matrices.reshape(2, 16))
    message = "expected finite numbers" if np.isnan(value) else "expected invertible ones, got 1"
    with pytest.raises(FormatError, match=message):
        read_character(write("flat.glb", made.glb()))


def _walker(step: tuple[float, float, float], toe: str = "LeftToe") -> bytes:
    """Hips with a foot below, whose toe lies a step away; the file's y is up, and z ahead."""
    made = Gltf()
    turn = made.add([[0.0, 0.0, 0.0, 1.0]] * 2)
    made.document |= {
        "nodes": [
            {"name": "Hips", "translation": [0.0, 1.0, 0.0], "children": [1]},
            {"name": "LeftFoot", "translation": [0.1, -0.9, 0.0], "children": [2]},
            {"name": toe, "translation": list(step)},
        ]
    }
    keys = made.add([0.0, 1.0])
    samples.animate(made, "stand", keys, {(node, "rotation"): turn for node in range(3)})
    return made.glb()


@pytest.mark.parametrize(
    ("step", "axis"),
    [((0.2, 0, 0), "+x"), ((-0.2, 0, 0.01), "-x"), ((0, -0.05, -0.2), "-z"), ((0, 0, 0.2), "")],
)
def test_toes_tell_the_facing_where_they_point_elsewhere(
    write: Write, step: tuple[float, float, float], axis: str
) -> None:
    """Read, every figure faces +x; a notice says where the file's differs from the format's."""
    found = read_motion(write("toes.glb", _walker(step)))
    places = found.skeleton.rest_world.translation_m
    ahead = (places[2] - places[1]) * (1.0, 1.0, 0.0)
    np.testing.assert_allclose(ahead / np.linalg.norm(ahead), [1.0, 0.0, 0.0], atol=0.06)
    told = [notice for notice in found.notices if "its toes point to" in notice]
    assert len(told) == bool(axis)
    assert all(f"to {axis} where the format says +z" in notice for notice in told)


@pytest.mark.parametrize(
    ("step", "toe"),
    [
        ((0.2, 0, 0.2), "LeftToe"),
        ((0, -0.1, 0), "LeftToe"),
        ((0.2, 0, 0), "LeftToeRoll"),
        ((0.2, 0, 0), "Control LeftToe"),
    ],
)
def test_toes_between_axes_and_controls_tell_nothing(
    write: Write, step: tuple[float, float, float], toe: str
) -> None:
    found = read_motion(write("toes.glb", _walker(step, toe)))
    assert any("no toes tell the facing: assumed +z" in notice for notice in found.notices)


@pytest.mark.parametrize(
    ("head", "foot", "wanted"),
    [
        ("Head", "LeftFoot", "+y by head and feet"),
        ("Top", "LeftFoot", "+y by habit"),
        ("Head", "Low", "+y by head and feet"),
        ("Top", "Low", "+y by habit"),
    ],
)
def test_head_and_feet_tell_up_and_else_habit(
    write: Write, head: str, foot: str, wanted: str
) -> None:
    """A toe is as good as a foot."""
    text = samples.BVH.decode().replace("Head", head).replace("LeftFoot", foot)
    found = read_motion(write("up.bvh", text.encode()))
    assert any(f"which way is up: {wanted}" in notice for notice in found.notices)


def test_a_figure_that_lies_is_stood_up_by_its_head(write: Write) -> None:
    """The same figure with its z up: read, its head is above its foot by as much."""
    turned = samples.BVH.decode()
    for old, new in (
        ("0 5 0\n    CH", "0 0 5\n    CH"),
        ("0.5 -5 0", "0.5 0 -5"),
        ("0 -0.1 1", "0 -1 -0.1"),
    ):
        assert old in turned
        turned = turned.replace(old, new)
    found = read_motion(write("lying.bvh", turned.encode()), unit_m=1.0)
    assert any("which way is up: +z by head and feet" in notice for notice in found.notices)
    places = found.skeleton.rest_world.translation_m
    head, foot = (found.skeleton.index(name) for name in ("Head", "LeftFoot"))
    assert places[head, 2] - places[foot, 2] == pytest.approx(10.0)


def test_joints_turned_inside_out_by_a_clip_are_told(write: Write) -> None:
    made = samples.gltf_tower()
    keys = made.add([0.0, 1.0])
    samples.animate(made, "flip", keys, {(2, "scale"): made.add([[-1.0] * 3, [-1.0] * 3])})
    found = read_character(write("flip.glb", made.glb()))
    assert "clips turn joints inside out: their mirroring was left out" in found.notices
    assert isinstance(found.clip("flip").poses, Motor)


def test_joints_mirrored_at_rest_keep_right_handed_frames(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["nodes"][2]["scale"] = [-1.0, -1.0, -1.0]
    found = read_character(write("mirrored.glb", made.glb()))
    assert "1 joints are mirrored: their frames stay right-handed" in found.notices
    turns = found.skeleton.rest_world.rotor.as_matrix()
    np.testing.assert_allclose(np.linalg.det(turns), 1.0, atol=1e-9)


@pytest.mark.parametrize("unit_m", [1.0, 0.1, 0.0254, 0.01, 0.001])
@pytest.mark.parametrize("height_m", [1.55, 1.7, 1.9])
def test_people_tell_the_unit(unit_m: float, height_m: float) -> None:
    assert guessed_unit_m(height_m / unit_m)[0] == unit_m


def test_what_has_neither_limbs_nor_size_says_so(write: Write) -> None:
    """One joint; and a snake along the ground, as long as it lies."""
    lines = ["HIERARCHY", "ROOT a {", "OFFSET 0 0 0", "CHANNELS 0"]
    end = ["End Site {", "OFFSET 0 0 0", "}"]
    motion = ["MOTION", "Frames: 1", "Frame Time: 1", ""]
    snake = [word for k in range(19) for word in (f"JOINT b{k} {{", "OFFSET 0 0 20", "CHANNELS 0")]
    for body, told in (
        ([*lines, *end, "}"], "it has no size that tells: taken as metre"),
        ([*lines, *snake, *end, *"}" * 20], "taken as centimetre, which makes it 3.80 m large"),
    ):
        found = read_motion(write("odd.bvh", "\n".join([*body, *motion]).encode()))
        assert any(told in notice for notice in found.notices)
        for option in ("--up", "--front"):
            assert any(f"say another with {option}" in notice for notice in found.notices)
