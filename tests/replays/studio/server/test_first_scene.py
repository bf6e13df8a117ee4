"""An editor opens with those in the scene whom the run itself put into its footage."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import place_on_plane, write_gltf
from motorcade.animation.authoring import scene_of, scene_text
from motorcade.animation.behaviour import LookTarget
from motorcade.ga import Motor
from motorcade.replays.io.readers.manifest.cast import read_cast
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acted import acted
from motorcade.replays.stages.view.acting import character_named, played
from motorcade.replays.studio.desk import first_scene
from tests.props import box
from tests.replays.studio.server.stage import filmed

CAST = """\
[[characters]]
name = "visitor"
path = [[0.0, 0.0], [0.3, 0.05]]
height_m = 0.2
acts = ["wave"]
waits_s = 0.4
layers = [{clip = "wave", joints = "right_arm", during = "walk"}]

[[characters]]
name = "guard"
start = [0.4, 0.5]
heading_deg = 70.0
"""


def test_nobody_stands_in_a_run_without_anybody(tmp_path: Path) -> None:
    scene = first_scene(filmed(), tmp_path)
    assert list(scene.anchors) == ["ground"]
    assert not scene.parents


@pytest.mark.parametrize("walks", [False, True])
def test_a_character_stands_where_the_run_stood_it(tmp_path: Path, walks: bool) -> None:
    who = character_named("mannequin")
    placement = place_on_plane(who, np.array([0.1, -0.2]), 0.7, height_m=0.2)
    way = np.array([[0.1, -0.2], [0.4, 0.1]]) if walks else np.zeros((0, 2))
    clip = "walk" if walks else "wave"
    stands = PlacedCharacter(
        "mannequin", clip, placement, "the table", way, placement.world_T_character
    )
    scene = first_scene(replace(filmed(), placed=stands), tmp_path)
    (name,) = scene.parents
    part = scene.part(name)
    assert part.height_m == pytest.approx(0.2)
    if walks:
        assert part.walk is not None
        np.testing.assert_array_equal(part.walk.path_m, way)
        assert part.walk.gaits == ("walk",)
    else:
        assert part.clip == "wave"
        at = scene.pose(name).as_similarity()
        np.testing.assert_allclose(at.translation_m, [0.1, -0.2, 0.0], atol=1e-12)
        assert at.rotor.as_euler()[2] == pytest.approx(0.7)


def test_a_cast_walks_and_acts_when_it_did(tmp_path: Path) -> None:
    file = tmp_path / "cast.toml"
    file.write_text(CAST)
    camera = LookTarget(np.zeros(1), np.array([[0.0, -1.0, 0.5]]))
    parts, _ = played(read_cast(file), Motor.identity(), 0.2, camera, 6.0)
    first = parts[0]
    stands = PlacedCharacter(first.character, "walk", first.placement, "the table", parts=parts)
    seen = replace(filmed(), placed=stands, knobs={"cast": file})
    scene = first_scene(seen, tmp_path)
    assert list(scene.parents) == ["visitor", "guard"]
    walker, guard = scene.part("visitor"), scene.pose("guard").as_similarity()
    assert walker.walk is not None
    assert walker.walk.start_s == pytest.approx(0.4)
    (act,) = [state for state in first.states if state.state == "act"]
    (over,) = [layer for layer in walker.layers if layer.joints == "whole"]
    assert (over.start_s, over.clip) == (act.start_s, "wave")
    assert any(layer.joints == "right_arm" for layer in walker.layers)
    np.testing.assert_allclose(guard.translation_m, [0.4, 0.5, 0.0], atol=1e-12)
    assert np.degrees(guard.rotor.as_euler()[2]) == pytest.approx(70.0)
    # It arrives when it arrived.
    way = acted(scene, "visitor", tmp_path, 6.0).parent_T_character
    assert way is not None
    arrives_s = next(state.start_s for state in first.states if state.state == "arrive")
    at = way.translation_m[int(60 * arrives_s)]
    assert np.linalg.norm(at[:2] - [0.3, 0.05]) < 0.03


def test_files_of_a_run_are_named_from_the_scene(tmp_path: Path) -> None:
    there, here = tmp_path / "models", tmp_path / "run"
    there.mkdir()
    here.mkdir()
    write_gltf(there / "box.glb", box(shade=0.5))
    entry = {"name": "box", "kind": "prop", "file": "box.glb"}
    (there / "scene.json").write_text(scene_text(scene_of({"objects": [entry]}, "")))
    who = character_named("mannequin")
    placement = place_on_plane(who, np.zeros(2), 0.0, height_m=0.2)
    stands = PlacedCharacter("mannequin", "idle", placement, "the table")
    seen = replace(filmed(), placed=stands, knobs={"scene": there / "scene.json"})
    scene = first_scene(seen, here)
    assert scene.part("box").file == "../models/box.glb"
    assert len(acted(scene, "box", here, 1.0).character.vertices)
