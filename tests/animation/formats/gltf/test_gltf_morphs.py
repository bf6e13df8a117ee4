"""Morph targets of glTF files: mixed into the rest pose by their node's weights, and by clips."""

from copy import deepcopy

import numpy as np
import pytest

from motorcade.animation import read_character
from motorcade.animation.formats import FormatError
from tests.animation.formats.dressed import dressed_gltf, encoded
from tests.animation.formats.samples import Gltf, Write, tower

RAISED, TURNED = np.zeros((12, 3)), np.zeros((12, 3))
RAISED[8:, 1] = 0.5
TURNED[:4, 0] = 1.0


def morphing(interpolation: str = "LINEAR", outputs: object = None) -> Gltf:
    """A tower under a node that doubles it; its top rises, its foot shifts along x."""
    made = Gltf()
    vertices, triangles, _ = tower()
    keys = made.add([0.0, 1.0, 2.0])
    values = made.add([0.0, 0.5, 1.0, 0.5, 0.0, 0.25] if outputs is None else outputs)
    part = {
        "attributes": {"POSITION": made.add(vertices)},
        "indices": made.add(triangles.reshape(-1), "uint32"),
        "targets": [{"POSITION": made.add(RAISED)}, {"POSITION": made.add(TURNED)}],
    }
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    sampler = {"input": keys, "output": values, "interpolation": interpolation}
    made.document |= {
        "meshes": [
            {"primitives": [part], "weights": [0.0, 0.25], "extras": {"targetNames": ["up", "x"]}}
        ],
        "nodes": [{"name": "tower", "mesh": 0, "scale": [2.0, 2.0, 2.0]}],
        "animations": [{"name": "breathe", "samplers": [sampler], "channels": [channel]}],
    }
    return made


def test_weights_move_what_their_targets_say(write: Write) -> None:
    found = read_character(write("morphing.glb", morphing().glb()))
    assert [one.name for one in found.morphs] == ["up", "x"]
    assert [clip.name for clip in found.clips] == ["breathe"]
    (clip,) = found.clips
    np.testing.assert_allclose(
        clip.morph_weights([0.0, 0.5, 1.5, 9.0]), [[0, 0.5], [0.5, 0.5], [0.5, 0.375], [0, 0.25]]
    )
    back = found.character_T_file.inverse()
    plain, _, _ = tower()
    for weights, expected in (
        (None, 2.0 * (plain + 0.25 * TURNED)),
        ([0.0, 0.0], 2.0 * plain),
        ([1.0, 0.5], 2.0 * (plain + RAISED + 0.5 * TURNED)),
    ):
        np.testing.assert_allclose(back.apply(found.shaped(weights).vertices), expected, atol=1e-9)


def test_steps_and_cubics_of_weights_are_followed(write: Write) -> None:
    stepped = read_character(write("steps.glb", morphing("STEP").glb())).clips[0]
    np.testing.assert_allclose(stepped.morph_weights([0.99, 1.0]), [[0, 0.5], [1, 0.5]])
    cubic = np.zeros((3, 3, 2))  # slopes of zero around values 0, 1, 0 and 0
    cubic[1, 1, 0] = 1.0
    eased = read_character(write("c.glb", morphing("CUBICSPLINE", cubic.reshape(-1)).glb())).clips[
        0
    ]
    u = np.array([0.25, 0.5, 0.8])
    found = eased.morph_weights(u)
    assert found is not None
    np.testing.assert_allclose(found[:, 0], 3 * u**2 - 2 * u**3, atol=2e-3)


def test_weights_that_do_not_fit_their_targets_are_refused(write: Write) -> None:
    with pytest.raises(FormatError, match="weights: expected 3 keys"):
        read_character(write("few.glb", morphing(outputs=[0.0] * 5).glb()))
    broken = morphing()
    broken.document["meshes"][0]["weights"] = [1.0]
    with pytest.raises(FormatError, match="weights: expected 2 numbers"):
        read_character(write("one.glb", broken.glb()))
    short = morphing()
    short.document["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = short.add(
        np.zeros((5, 3))
    )
    with pytest.raises(FormatError, match="expected 12 values"):
        read_character(write("short.glb", short.glb()))


def test_a_mesh_at_two_nodes_is_read_as_two_meshes_are(write: Write) -> None:
    found = []
    for own in (False, True):
        made = dressed_gltf((encoded("PNG"),))
        nodes, meshes = made.document["nodes"], made.document["meshes"]
        meshes[0].pop("weights")
        meshes += [deepcopy(meshes[0]), deepcopy(meshes[0])] if own else []
        for number, weights in ((2, {"weights": [0.5, 1.0]}), (3, {})):
            mesh = number if own else 0
            nodes.append({**nodes[3], "name": f"twin {number}", "mesh": mesh} | weights)
            made.document["scenes"][0]["nodes"].append(len(nodes) - 1)
        found.append(read_character(write(f"{own}.glb", made.glb())))
    shared, apart = found
    for name in ("vertices", "normals", "triangles", "colors", "joints", "weights"):
        assert np.array_equal(getattr(shared, name), getattr(apart, name)), name
    assert len(shared.triangles) > 20
    assert [one.weight for one in shared.morphs] == [0.0, 0.0, 0.5, 1.0, 0.0, 0.0]
    assert [one.weight for one in apart.morphs] == [one.weight for one in shared.morphs]
    for one, other in zip(shared.morphs, apart.morphs, strict=True):
        assert np.array_equal(one.rows, other.rows)
        assert np.array_equal(one.positions, other.positions)
