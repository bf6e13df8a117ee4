"""The same tower read from every format stands, moves and looks as it was made."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from motorcade.animation import Character
from motorcade.animation.formats import FormatError, NoMeshError, read_character, read_motion
from motorcade.ga import Motor, Similarity
from tests.animation.formats import samples
from tests.animation.formats.samples import Write

FORMATS = ("glb", "gltf", "dae", "md5mesh")


def bent(character: Character, fraction: float) -> Motor:
    clip = character.clips[0]
    poses = clip.at(clip.time_s[0] + fraction * clip.duration_s)
    assert isinstance(poses, Motor)
    return character.skeleton.world(poses)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_tower_stands_at_the_ground_with_its_joints_inside(
    towers: dict[str, Path], kind: str
) -> None:
    made = read_character(towers[kind])
    unit = 0.5 if kind == "dae" else 1.0
    assert made.skeleton.names == ("base", "top")
    assert made.skeleton.parents.tolist() == [-1, 0]
    places = made.skeleton.rest_world.translation_m
    np.testing.assert_allclose(places, [[0, 0, 0], [0, 0, unit]], atol=1e-7)
    np.testing.assert_allclose(made.vertices.min(axis=0), [-0.2 * unit, -0.2 * unit, 0], atol=1e-7)
    np.testing.assert_allclose(
        made.vertices.max(axis=0), [0.2 * unit, 0.2 * unit, 2 * unit], atol=1e-7
    )


@pytest.mark.parametrize("kind", FORMATS)
def test_triangles_run_counter_clockwise_and_normals_point_outwards(
    towers: dict[str, Path], kind: str
) -> None:
    made = read_character(towers[kind])
    a, b, c = (made.vertices[made.triangles[:, corner]] for corner in range(3))
    volume = np.sum(a * np.cross(b, c)) / 6.0
    unit = 0.5 if kind == "dae" else 1.0
    assert volume == pytest.approx(0.16 * 2.0 * unit**3, rel=1e-6)
    outwards = made.vertices * (1.0, 1.0, 0.0)
    assert np.all(np.sum(outwards * made.normals, axis=1) > 0.0)


@pytest.mark.parametrize("kind", FORMATS)
def test_joints_share_vertices_as_the_file_says(towers: dict[str, Path], kind: str) -> None:
    made = read_character(towers[kind])
    share = np.zeros((len(made.vertices), 2))
    for k in range(4):
        np.add.at(share, (np.arange(len(share)), made.joints[:, k]), made.weights[:, k])
    height = made.vertices[:, 2] / made.vertices[:, 2].max()
    np.testing.assert_allclose(share[:, 1], height, atol=1e-6)


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("fraction", [0.0, 0.37, 1.0])
def test_the_clip_turns_the_upper_joint_by_a_quarter(
    towers: dict[str, Path], kind: str, fraction: float
) -> None:
    """About the file's z axis: forward in glTF, up in the others."""
    world = bent(read_character(towers[kind]), fraction)
    axis = [1.0, 0.0, 0.0] if kind in ("glb", "gltf") else [0.0, 0.0, 1.0]
    wanted = Rotation.from_rotvec(np.array(axis) * fraction * np.pi / 2.0).as_matrix()
    held = [np.eye(3), wanted]
    np.testing.assert_allclose(world.rotor.as_matrix() @ _rest_back(kind), held, atol=2e-7)


def _rest_back(kind: str) -> np.ndarray:
    """What turns a joint's frame back into axes of the character: joints keep the file's axes."""
    if kind in ("glb", "gltf"):
        return np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]).T
    return np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).T


@pytest.mark.parametrize("scale", [0.01, 0.0254, 40.0])
def test_scale_above_the_joints_ends_in_the_mesh(write: Write, scale: float) -> None:
    made = read_character(write("scaled.glb", samples.gltf_tower(scale).glb()))
    plain = read_character(write("plain.glb", samples.gltf_tower().glb()))
    np.testing.assert_allclose(made.vertices, scale * plain.vertices, rtol=1e-6, atol=1e-9)
    assert isinstance(made.clips[0].poses, Motor)
    np.testing.assert_allclose(
        made.skeleton.world(made.clips[0].poses).translation_m,
        scale * plain.skeleton.world(plain.clips[0].poses).translation_m,
        rtol=1e-6,
        atol=1e-9,
    )


def test_scale_that_changes_makes_a_clip_of_similarities(write: Write) -> None:
    made = read_character(write("rich.glb", samples.rich_gltf().glb()))
    growing = made.clip("growing")
    assert isinstance(growing.poses, Similarity)
    assert all(isinstance(made.clip(name).poses, Motor) for name in ("bend", "steps", "curve"))
    world = made.skeleton.world(growing.at(0.5))
    assert isinstance(world, Similarity)
    np.testing.assert_allclose(world.scale, [1.0, 1.5], rtol=1e-6)
    np.testing.assert_allclose(world.translation_m[1], [0.0, 0.0, 0.01], atol=1e-8)


def test_scale_is_inherited_by_what_hangs_below(write: Write) -> None:
    """A growing base moves the top away, as matrices say."""
    made = samples.gltf_tower()
    keys = made.add([0.0, 1.0])
    samples.animate(made, "grow", keys, {(1, "scale"): made.add([[1.0] * 3, [2.0] * 3])})
    character = read_character(write("grown.glb", made.glb()))
    world = character.skeleton.world(character.clip("grow").at(1.0))
    np.testing.assert_allclose(world.translation_m[1], [0.0, 0.0, 2.0], atol=1e-6)


def test_steps_jump_and_hold(write: Write) -> None:
    made = read_character(write("rich.glb", samples.rich_gltf().glb()))
    clip = made.clip("steps")
    places = made.skeleton.world(clip.at([0.1, 0.4999, 0.5, 0.9, 1.0])).translation_m[:, 0]
    wanted = np.array([[0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0]]) * 0.01
    np.testing.assert_allclose(places, wanted, atol=1e-9)
    assert clip.key_count == 3


def test_cubic_splines_agree_with_scipy(write: Write) -> None:
    keys, rng = np.array([0.0, 0.4, 1.0]), np.random.default_rng(5)
    values, into, out = (rng.normal(size=(3, 3)) for _ in range(3))
    made = samples.gltf_tower()
    rows = np.stack([into, values, out], axis=1).reshape(9, 3)
    samples.animate(
        made, "curve", made.add(keys), {(1, "translation"): made.add(rows)}, "CUBICSPLINE"
    )
    character = read_character(write("cubic.glb", made.glb()))
    times = np.linspace(0.0, 1.0, 41)
    found = character.skeleton.world(character.clip("curve").at(times)).translation_m[:, 0]
    parts = [
        CubicHermiteSpline(keys[i : i + 2], values[i : i + 2], [out[i], into[i + 1]])
        for i in range(2)
    ]
    wanted = np.where((times < 0.4)[:, None], parts[0](times), parts[1](times))
    np.testing.assert_allclose(found, wanted[:, [2, 0, 1]], atol=2e-4)


def test_scales_along_curves_agree_with_scipy_between_their_keys(write: Write) -> None:
    """Samples are set wherever even growth would leave the curve."""
    keys, sizes = np.array([0.0, 0.4, 1.0]), np.array([1.0, 3.0, 0.5])
    slopes = np.array([4.0, -2.0, 1.0])
    made = samples.gltf_tower()
    rows = np.stack([slopes, sizes, slopes], axis=1).reshape(9, 1) * np.ones(3)
    samples.animate(made, "grow", made.add(keys), {(2, "scale"): made.add(rows)}, "CUBICSPLINE")
    character = read_character(write("cubic.glb", made.glb()))
    times = np.linspace(0.0, 1.0, 67)
    world = character.skeleton.world(character.clip("grow").at(times))
    assert isinstance(world, Similarity)
    wanted = CubicHermiteSpline(keys, sizes, slopes)(times)
    np.testing.assert_allclose(world.scale[:, 1], wanted, rtol=5e-4)


def test_sparse_and_normalised_accessors_are_unpacked(write: Write) -> None:
    made = read_character(write("rich.gltf", samples.rich_gltf().gltf()))
    np.testing.assert_allclose(
        made.vertices[[1, 3]], 0.01 * np.array([[0.2, 0.3, 0.0], [0.2, -0.3, 0.0]]), atol=1e-8
    )
    linear = np.array([0.5, 128 / 255, 0.0])
    np.testing.assert_allclose(
        made.colors[0],
        1.055 * linear ** (1 / 2.4) * [1, 1, 0] - 0.055 * np.array([1, 1, 0]),
        atol=1e-6,
    )
    assert len(made.morphs) == 1


def test_two_skins_make_one_mesh(write: Write) -> None:
    """The second was bound in a frame of its own, ten times larger and moved away."""
    made = samples.gltf_tower()
    away = np.diag([0.1, 0.1, 0.1, 1.0])
    away[:3, 3] = (3.0, -1.0, 2.0)
    vertices, _, _ = samples.tower()
    apart = (vertices - away[:3, 3]) * 10.0
    binds = np.stack([away, away])
    binds[1, 1, 3] -= 1.0
    document = made.document
    document["skins"].append(
        {
            "joints": [1, 2],
            "inverseBindMatrices": made.add(binds.swapaxes(1, 2).reshape(-1, 16)),
        }
    )
    first = document["meshes"][0]["primitives"][0]
    second = json.loads(json.dumps(first))
    second["attributes"]["POSITION"] = made.add(apart)
    document["meshes"].append({"primitives": [second]})
    document["nodes"].append({"name": "other", "mesh": 1, "skin": 1})
    document["scenes"][0]["nodes"].append(4)
    character = read_character(write("two.glb", made.glb()))
    assert len(character.triangles) == 40
    np.testing.assert_allclose(character.vertices[12:], character.vertices[:12], atol=1e-6)


def test_meshes_that_hang_on_joints_follow_them(write: Write) -> None:
    made = samples.gltf_tower()
    vertices, triangles, _ = samples.tower()
    part = {
        "attributes": {"POSITION": made.add(vertices)},
        "indices": made.add(triangles.reshape(-1), "uint16"),
    }
    made.document["meshes"].append({"primitives": [part]})
    made.document["nodes"][2]["children"] = [4]
    made.document["nodes"].append({"name": "hat", "mesh": 1, "translation": [0.0, 1.5, 0.0]})
    character = read_character(write("hat.glb", made.glb()))
    hat = slice(12, 24)
    assert np.all(character.joints[hat, 0] == 1)
    assert character.vertices[hat, 2].min() == pytest.approx(2.5, abs=1e-6)


def test_shear_is_told_and_the_nearest_similarity_stands_in(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["nodes"][1]["scale"] = [1.0, 1.2, 1.0]
    character = read_character(write("shear.glb", made.glb()))
    assert any("scales an axis" in notice for notice in character.notices)


def test_bvh_joints_lie_where_scipy_puts_them(write: Write) -> None:
    motion = read_motion(write("figure.bvh", samples.BVH), unit_m=0.1)
    poses = motion.clips[0].at(1.0)
    assert isinstance(poses, Motor)
    found = motion.skeleton.world(poses).translation_m
    hips = Rotation.from_euler("ZYX", [-90, 45, 60], degrees=True)
    toe = Rotation.from_euler("ZXY", [0, 0, 0], degrees=True)
    places = np.array([0.0, 5.0, 2.0])
    wanted = [places, places + hips.apply([0, 5, 0]), places + hips.apply([0.5, -5, 0])]
    wanted.append(wanted[2] + (hips * toe).apply([0, -0.1, 1]))
    np.testing.assert_allclose(found, 0.1 * np.array(wanted)[:, [2, 0, 1]], atol=1e-9)
    assert motion.skeleton.rest_world.translation_m[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert any("+y by head and feet" in notice for notice in motion.notices)


def test_a_motion_alone_is_no_character(write: Write) -> None:
    with pytest.raises(NoMeshError, match="meshes: expected one or more"):
        read_character(write("figure.bvh", samples.BVH))


def test_collada_bezier_curves_pass_where_their_polynomial_does(write: Write) -> None:
    character = read_character(write("tower.dae", samples.collada_tower("BEZIER")))
    clip = character.clips[0]
    for wanted_s in (0.1, 0.25, 0.6, 0.9):
        # time of the curve: 3 v² u 0.3 + 3 v u² 0.7 + u³, v = 1 - u
        roots = np.roots([3 * 0.3 - 3 * 0.7 + 1, 3 * 0.7 - 6 * 0.3, 3 * 0.3, -wanted_s])
        u = float(next(r.real for r in roots if abs(r.imag) < 1e-9 and -1e-9 <= r.real <= 1 + 1e-9))
        angle = 90.0 * (3 * (1 - u) * u**2 + u**3)
        world = character.skeleton.world(clip.at(wanted_s))
        turn = (world.rotor[0].inverse() @ world.rotor[1]).angle()
        assert np.degrees(turn) == pytest.approx(angle, abs=0.02)


def test_steps_of_collada_hold(write: Write) -> None:
    character = read_character(write("tower.dae", samples.collada_tower("STEP")))
    poses = character.clips[0].at([0.0, 0.5, 0.999, 1.0])
    angles = np.degrees(poses.rotor.angle()[:, 1])
    np.testing.assert_allclose(angles, [0.0, 0.0, 0.0, 90.0], atol=1e-6)


def test_texture_colours_come_from_the_nearest_pixel(write: Write, tmp_path: Path) -> None:
    from PIL import Image

    pixels = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)
    Image.fromarray(pixels).save(tmp_path / "skin.png")
    made = samples.gltf_tower()
    part = made.document["meshes"][0]["primitives"][0]
    uv = np.tile([0.25, 0.75], (12, 1))
    uv[0], uv[1] = (0.75, 0.25), (1.25, 0.25)
    part["attributes"]["TEXCOORD_0"] = made.add(uv)
    part["material"] = 0
    made.document |= {
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "skin.png"}],
    }
    character = read_character(write("painted.glb", made.glb()))
    np.testing.assert_allclose(character.colors[:3], [[0, 1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-6)


def test_an_unknown_suffix_is_refused_with_those_that_are_known(write: Write) -> None:
    with pytest.raises(FormatError, match=r"suffix: expected one of \.glb, .*got \.obj"):
        read_character(write("tower.obj", b"v 0 0 0"))


@pytest.mark.parametrize("moved", ["joint", "helper"])
def test_keys_of_a_joint_replace_its_fbx_helpers_and_keys_of_helpers_do_not(
    write: Write, moved: str
) -> None:
    made = samples.gltf_tower()
    nodes = made.document["nodes"]
    nodes[1]["children"] = [4]
    nodes.append(
        {"name": "top_$AssimpFbx$_Translation", "translation": [0.0, 1.0, 0.0], "children": [2]}
    )
    nodes[2]["translation"] = [0.0, 0.0, 0.0]
    node, place = (2, [0.0, 1.5, 0.0]) if moved == "joint" else (4, [0.0, 1.5, 0.0])
    samples.animate(
        made,
        "lift",
        made.add([0.0, 1.0]),
        {(node, "translation"): made.add([[0.0, 1.0, 0.0], place])},
    )
    character = read_character(write("helpers.glb", made.glb()))
    world = character.skeleton.world(character.clip("lift").at([0.0, 1.0]))
    np.testing.assert_allclose(world.translation_m[:, 1, 2], [1.0, 1.5], atol=1e-6)


def test_a_rigid_hierarchy_without_a_skin_is_a_character_too(write: Write) -> None:
    made = samples.gltf_tower()
    made.document.pop("skins")
    nodes = made.document["nodes"]
    nodes[3].pop("skin")
    nodes[2]["children"] = [3]
    part = made.document["meshes"][0]["primitives"][0]
    part["attributes"].pop("JOINTS_0")
    part["attributes"].pop("WEIGHTS_0")
    character = read_character(write("robot.glb", made.glb()))
    assert "top" in character.skeleton.names
    top = character.skeleton.index("top")
    carried = character.skeleton.world(character.clip("bend").at(1.0))
    axis = carried.rotor[top].as_matrix() @ character.skeleton.rest_world.rotor[top].as_matrix().T
    np.testing.assert_allclose(axis @ [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], atol=1e-6)
    assert character.vertices[:, 2].max() == pytest.approx(2.0, abs=1e-6)


def test_units_of_a_generator_that_keeps_them_are_guessed_only_where_they_cannot_be(
    write: Write,
) -> None:
    """Joints in centimetres under a node that scales them to metres are left alone."""
    made = samples.gltf_tower(0.01)
    made.document["asset"]["generator"] = "Open Asset Import Library (assimp v5.2.0)"
    made.document["nodes"][2]["translation"] = [0.0, 170.0, 0.0]
    for part in ("mesh", "skin"):
        made.document["nodes"][3].pop(part)
    motion = read_motion(write("fine.glb", made.glb()))
    assert motion.skeleton.rest_world.translation_m[1, 2] == pytest.approx(1.7, abs=1e-6)
    assert not any("unit" in notice for notice in motion.notices)
    made.document["nodes"][0]["scale"] = [1.0] * 3
    motion = read_motion(write("large.glb", made.glb()))
    assert any("unit is not known" in notice for notice in motion.notices)
    assert motion.skeleton.rest_world.translation_m[1, 2] == pytest.approx(1.7, abs=1e-6)


def test_a_missing_texture_is_told_and_leaves_a_plain_grey(write: Write) -> None:
    made = samples.gltf_tower()
    made.document["meshes"][0]["primitives"][0]["material"] = 0
    made.document |= {
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "lost.png"}],
    }
    character = read_character(write("grey.glb", made.glb()))
    assert any("'lost.png' was not read" in notice for notice in character.notices)
    np.testing.assert_allclose(character.colors, 0.8, atol=0.01)
