"""Scenes of several roots: every mesh is kept, and stands where the file has it."""

import numpy as np
import pytest

from motorcade.animation import Character, read_character, skin
from motorcade.animation.formats import FormatError, write_gltf
from motorcade.ga import Similarity
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.samples import Gltf, Write, tower


def scene(nodes: list[dict[str, object]]) -> Gltf:
    """One tower a node that names mesh 0, no skin."""
    made = Gltf()
    vertices, triangles, _ = tower()
    part = {
        "attributes": {"POSITION": made.add(vertices)},
        "indices": made.add(triangles.reshape(-1), "uint32"),
    }
    made.document["meshes"] = [{"primitives": [part]}]
    made.document["nodes"] = nodes
    return made


def as_found(character: Character) -> np.ndarray:
    """Vertices in the pose of the file, brought back into the file's own axes and unit."""
    assert character.found_pose is not None
    vertices, _ = skin(character, character.found_pose, "linear")
    return np.asarray(character.character_T_file.inverse().apply(vertices))


def test_every_root_keeps_its_meshes_where_the_file_has_them(write: Write) -> None:
    turned = [0.0, np.sin(0.4), 0.0, np.cos(0.4)]
    nodes: list[dict[str, object]] = [
        {"name": "left", "mesh": 0, "translation": [3.0, 0.0, 0.0]},
        {"name": "mirrored", "mesh": 0, "scale": [1.0, 1.0, -1.3], "translation": [0, 0.5, 2]},
        {"name": "stretched", "scale": [2.0, 0.25, 1.0], "children": [3]},
        {"name": "sheared", "mesh": 0, "rotation": turned, "translation": [-4.0, 0.0, 0.0]},
    ]
    found = read_character(write("scene.glb", scene(nodes).glb()))
    corners, _, _ = tower()
    turn = np.array([
        [np.cos(0.8), 0.0, np.sin(0.8)],
        [0.0, 1.0, 0.0],
        [-np.sin(0.8), 0.0, np.cos(0.8)],
    ])  # fmt: skip
    wanted = np.concatenate(
        [
            corners + np.array([3.0, 0.0, 0.0]),
            corners * [1.0, 1.0, -1.3] + [0.0, 0.5, 2.0],
            (corners @ turn.T + [-4.0, 0.0, 0.0]) * [2.0, 0.25, 1.0],
        ]
    )
    np.testing.assert_allclose(as_found(found), wanted, atol=1e-9)
    a, b, c = (found.vertices[found.triangles[:, corner]] for corner in range(3))
    facing = np.einsum("ti,ti->t", np.cross(b - a, c - a), found.normals[found.triangles].sum(1))
    assert facing.min() > 0.0  # mirrored or not, triangles go round their normals


def test_the_way_from_the_file_is_told(write: Write) -> None:
    """Metres, z up, facing +x, soles at zero, from y up, facing +z."""
    nodes: list[dict[str, object]] = [{"mesh": 0, "translation": [0.0, -2.5, 0.0]}]
    found = read_character(write("low.glb", scene(nodes).glb()), unit_m=0.5)
    way = found.character_T_file
    np.testing.assert_allclose(way.scale, 0.5)
    np.testing.assert_allclose(
        way.apply([[0, -2.5, 0], [0, -0.5, 1.0]]), [[0, 0, 0], [0.5, 0, 1]], atol=1e-12
    )
    assert isinstance(way, Similarity)


def test_only_the_scene_that_is_shown_is_read(write: Write) -> None:
    far: dict[str, object] = {"name": "far", "mesh": 0, "translation": [50.0, 0.0, 0.0]}
    nodes: list[dict[str, object]] = [{"children": [1]}, {"mesh": 0}, far]
    made = scene(nodes)
    made.document["scenes"] = [{"nodes": [2]}, {"nodes": [0]}]
    for chosen, middle in ((0, 50.0), (1, 0.0), (None, 50.0)):
        made.document.pop("scene", None)
        if chosen is not None:
            made.document["scene"] = chosen
        found = read_character(write("scenes.glb", made.glb()))
        assert len(found.vertices) == 12
        np.testing.assert_allclose(as_found(found)[:, 0].mean(), middle, atol=1e-9)
        assert "1 meshes outside of the scene that is shown are left out" in found.notices
    made.document |= {"scene": 2}
    with pytest.raises(FormatError, match="scene"):
        read_character(write("scenes.glb", made.glb()))
    made.document |= {"scene": 0, "scenes": [{"nodes": []}]}
    found = read_character(write("scenes.glb", made.glb()))
    assert len(found.vertices) == 24
    assert "no mesh stands in the scene that is shown: all are read" in found.notices


def test_a_mesh_on_a_node_that_moves_under_a_joint_moves_with_it(write: Write) -> None:
    """The hat lies on the tower's upper joint, and is lifted by 0.2 in the middle of the clip."""
    made = dressed_gltf((encoded("PNG"),))
    found = read_character(write("hat.glb", made.glb()))
    assert "hat" in found.skeleton.names
    hat = np.flatnonzero(found.joints[:, 0] == found.skeleton.index("hat"))
    assert len(hat) == 24  # of its two primitives
    corners, _, _ = tower()
    wanted = 0.2 * corners * [1.0, 1.5, -1.0] + [0.0, 2.0, 0.0]  # on the joint at 1, raised by 1
    clip = found.clip("greet")
    for time_s, lift in ((0.0, 0.0), (0.25, 0.1), (0.5, 0.2)):
        vertices, _ = skin(found, clip.at(time_s), "linear")
        way = found.character_T_file.inverse()
        at = np.asarray(way.apply(vertices[hat[:12]]))
        np.testing.assert_allclose(at, wanted + np.array([0.0, lift, 0.0]), atol=1e-9)


def test_tangents_turn_with_their_mesh_and_are_written(write: Write) -> None:
    made = dressed_gltf((encoded("PNG"),))
    found = read_character(write("turned.glb", made.glb()))
    look = found.appearance
    assert look is not None
    assert look.tangents is not None
    way = found.character_T_file.inverse()
    back = way.rotor.apply(look.tangents[:, :3].astype(float))
    np.testing.assert_allclose(back, np.tile([1.0, 0.0, 0.0], (len(back), 1)), atol=1e-6)
    hat = found.joints[:, 0] == found.skeleton.index("hat")  # mirrored along z
    assert set(look.tangents[hat, 3]) == {1.0}
    assert set(look.tangents[~hat, 3]) == {-1.0}
    again = write("again.glb", b"")
    write_gltf(again, found)
    second = read_character(again).appearance
    assert second is not None
    assert second.tangents is not None
    rows = {tuple(row) for row in look.tangents.round(5).tolist()}
    assert {tuple(row) for row in second.tangents.round(5).tolist()} == rows
