"""A whole scene as glTF, opened by readers that share no code with the writer."""

from __future__ import annotations

import json
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from motorcade.animation import skin
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.pipeline.runs import Shown, write_run_gltf
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.placed import placed
from tests.animation.formats.gltf_vertices import GltfVertices
from tests.props import write_props
from tests.replays.carried_marker import CAMERA, ID, RATE_HZ, TIME_NS, recorded, wandering

SCENE = {
    "anchors": {"tag": {"on": "marker", "marker": ID}, "ground": {"on": "floor"}},
    "objects": [
        {
            "name": "walker",
            "kind": "character",
            "file": "mannequin",
            "parent": "tag",
            "height_m": 0.08,
            "walk": {"path_m": [[0.0, -0.02], [0.1, -0.02]]},
        },
        {
            "name": "guest",
            "kind": "character",
            "file": "mannequin",
            "parent": "tag",
            "position_m": [0.1, -0.1, 0.0],
            "scale": 0.05,
            "clip": "wave",
        },
        {
            "name": "guide",
            "kind": "character",
            "file": "mannequin",
            "parent": "ground",
            "height_m": 0.3,
            "layers": [{"clip": "wave", "joints": "left_arm", "start_s": 0.3}],
        },
        {
            "name": "box",
            "kind": "prop",
            "file": "box.glb",
            "parent": "walker",
            "position_m": [0.0, 0.0, 0.08],
            "scale": 0.1,
        },
        {
            "name": "ball",
            "kind": "prop",
            "file": "ball.glb",
            "parent": "ground",
            "keyframes": [
                {"time_s": 0.2, "position_m": [0.0, 0.0, 0.1], "scale": 0.2},
                {"time_s": 1.7, "position_m": [0.3, 0.1, 0.1], "euler_deg": [20, 80, 150]},
            ],
        },
    ],
}


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Shown:
    """Three characters and two props, on a marker that is carried about and on the floor."""
    folder = tmp_path_factory.mktemp("scene")
    write_props(folder)
    (folder / "scene.json").write_text(json.dumps(SCENE))
    recording, smoothed, found = recorded(wandering)
    made = placed(recording, found, smoothed, scene=folder / "scene.json")
    cast = dict(zip([part.name for part in made.parts], performers(made), strict=True))
    return Shown(recording, CAMERA, {}, smoothed.drawn, cast, np.zeros((0, 3)))


def vertices_m(shown: Shown, stamp: int) -> FloatArray:
    """Of everything at a stamp, in glTF's axes, which have y up."""
    time_s = 1e-9 * (stamp - int(shown.recording.frames.time_ns[0]))
    made = []
    for one in shown.cast.values():
        vertices, _ = skin(one.character, one.clip.at(time_s), "linear")
        used = vertices[np.unique(one.character.triangles)]
        made.append(one.world_T_character(stamp).apply(used))
    return np.concatenate(made)[:, [1, 2, 0]]


def apart(one: FloatArray, other: FloatArray) -> float:
    return float(max(cKDTree(one).query(other)[0].max(), cKDTree(other).query(one)[0].max()))


def test_every_vertex_of_the_file_is_where_the_scene_has_it(shown: Shown, tmp_path: Path) -> None:
    """At frames and between, to what 32 bits hold."""
    write_run_gltf(shown, tmp_path / "scene.glb")
    found = GltfVertices(tmp_path / "scene.glb")
    for frame in (0, 7.5, 19, 30.25, 39):
        stamp = round(1e9 * frame / RATE_HZ)
        assert apart(found.at(1e-9 * stamp), vertices_m(shown, stamp)) < 1e-5


def test_a_path_that_begins_late_brings_clips_along(shown: Shown, tmp_path: Path) -> None:
    late = replace(shown, path=shown.path[7:30])
    write_run_gltf(late, tmp_path / "late.glb")
    found = GltfVertices(tmp_path / "late.glb")
    for frame in (7, 12, 29):
        time_s = 1e-9 * float(TIME_NS[frame] - TIME_NS[7])
        assert apart(found.at(time_s), vertices_m(late, int(TIME_NS[frame]))) < 1e-5


class Assimp:
    """Where nodes are over time, by assimp's own dump of a file: text of six digits."""

    def __init__(self, path: Path) -> None:
        told = path.with_suffix(".xml")
        subprocess.run(["assimp", "dump", str(path), str(told)], check=True, capture_output=True)
        root = ElementTree.parse(told).getroot()
        animation, self._above = root.find(".//Animation"), {}
        assert animation is not None
        self._ticks = float(animation.attrib["tick_cnt"])
        self._channels = {one.attrib["node"]: one for one in animation.iter("NodeAnim")}
        for node in root.iter("Node"):
            for child in node.findall("NodeList/Node"):
                self._above[child.attrib["name"]] = node

    def keys(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Times (N,) in seconds and world matrices (N, 4, 4) at a node's own keys."""
        channel, above, one = self._channels[name], np.eye(4), name
        while one in self._above:
            node = self._above[one]
            above, one = _numbers(node.find("Matrix4")).reshape(4, 4) @ above, node.attrib["name"]
        time_s, places = self._list(channel, "Position")
        _, turns = self._list(channel, "Rotation")
        _, scales = self._list(channel, "Scaling")
        own = np.tile(np.eye(4), (len(time_s), 1, 1))
        own[:, :3, :3] = Rotation.from_quat(turns).as_matrix() * scales[:, None, :]
        own[:, :3, 3] = places
        return time_s, above @ own

    def _list(self, channel: ElementTree.Element, kind: str) -> tuple[FloatArray, FloatArray]:
        keys = channel.findall(f"{kind}KeyList/{kind}Key")
        at = np.array([float(key.attrib["time"]) for key in keys]) / self._ticks
        return at, np.array([_numbers(key) for key in keys])


def _numbers(element: ElementTree.Element | None) -> FloatArray:
    assert element is not None
    return np.array((element.text or "").split(), dtype=np.float64)


@pytest.mark.skipif(shutil.which("assimp") is None, reason="assimp is not installed")
def test_assimp_has_everything_at_the_same_places(shown: Shown, tmp_path: Path) -> None:
    """Origins and axes of all objects at all keys, in the world, to 1e-5 of a metre."""
    write_run_gltf(shown, tmp_path / "scene.glb")
    read = Assimp(tmp_path / "scene.glb")
    assert set(shown.cast) == {"walker", "guest", "guide", "box", "ball"}
    upright = Motor.from_quaternion_translation([0.5, -0.5, -0.5, -0.5], [0.0, 0.0, 0.0])
    for name, one in shown.cast.items():
        time_s, found = read.keys(f"{name} path")
        stamps = TIME_NS[0] + np.rint(1e9 * time_s).astype(np.int64)
        poses = one.world_T_character(np.clip(stamps, TIME_NS[0], TIME_NS[-1]))
        wanted = Similarity.from_motor_scale(upright).reshape(1) @ poses
        np.testing.assert_allclose(found, wanted.as_matrix(), atol=1e-5)
    moved = {name: read.keys(f"{name} path")[1][:, :3, 3] for name in ("walker", "ball")}
    assert all(np.ptp(places, axis=0).max() > 0.05 for places in moved.values())
