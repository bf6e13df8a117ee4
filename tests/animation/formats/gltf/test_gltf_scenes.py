"""Scenes of several roots: every mesh is kept, and stands where the file has it."""

import numpy as np

from motorcade.animation import Character, read_character, skin
from motorcade.ga import Similarity
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
