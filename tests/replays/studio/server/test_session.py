"""Fingers on the image, several browsers at once, and what is kept of all they do."""

import shlex
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Clip
from motorcade.ga import Rotor
from motorcade.replays.cli import runs
from motorcade.replays.cli.main import command_parser
from motorcade.replays.stages.view.acted import acted
from motorcade.replays.studio.desk import offered
from motorcade.tracking import Camera
from tests.replays.studio.server.stage import FRAMES, STRAIGHT, Visitor, desk, seen, stands

LENSES = {
    "pinhole": STRAIGHT,
    "off centre": Camera(640, 480, 500.0, 480.0, 200.0, 300.25),
    "radtan": Camera(752, 480, 458.7, 457.3, 367.2, 248.4, "radtan", (-0.28, 0.07, 2e-3, -1e-3)),
    "equidistant": Camera(
        848, 800, 286.1, 286.2, 417.0, 403.0, "equidistant", (-0.009, 0.05, -0.047, 0.009)
    ),
}


@pytest.fixture
def one(tmp_path: Path) -> Visitor:
    return Visitor(desk(tmp_path))


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("on", ["ground", "marker 7"])
def test_what_is_grabbed_stays_under_the_finger(tmp_path: Path, lens: str, on: str) -> None:
    rng = np.random.default_rng(3)
    at = desk(tmp_path, LENSES[lens])
    one, size = Visitor(at), np.array([at.filmed.camera.width, at.filmed.camera.height])
    name = one.put()
    if on != "ground":
        one.done("hang", object=name, on=on, frame=0)
    worst = 0.0
    for _ in range(50):
        frame = int(rng.integers(FRAMES))
        before = stands(at, name, frame)
        grabbed = before.apply(rng.normal(size=3) * 0.05)
        pixel = seen(at, frame, grabbed)
        if not np.all((pixel > 0) & (pixel < size)):
            one.done("undo")
            continue
        begun = one.ask(
            "begin", object=name, gesture="move", frame=frame,
            pixels=[pixel.tolist()], point=grabbed.tolist(),
        )  # fmt: skip
        if not begun["ok"] or "said" in begun:
            continue
        to = rng.uniform(0.3, 0.7, 2) * size
        told = one.done("drag", pixels=[to.tolist()])
        if "poses" not in told:  # beyond the horizon
            one.done("cancel")
            continue
        one.done("end")
        after = stands(at, name, frame)
        moved = after.apply(before.inverse().apply(grabbed))
        worst = max(worst, float(np.linalg.norm(seen(at, frame, moved) - to)))
    assert 0.0 < worst < 1e-6


@pytest.mark.parametrize("lens", LENSES)
def test_two_fingers_turn_and_grow_what_they_hold(tmp_path: Path, lens: str) -> None:
    rng = np.random.default_rng(4)
    at = desk(tmp_path, LENSES[lens])
    one, name = Visitor(at), ""
    name = one.put()
    for _ in range(20):
        before = stands(at, name, 3)
        middle = before.translation_m
        angle, factor = rng.uniform(-2.0, 2.0), float(np.exp(rng.uniform(-0.5, 0.5)))
        turn = Rotor.from_rotation_vector([0.0, 0.0, angle])
        shift = np.append(rng.uniform(-0.05, 0.05, 2), 0.0)
        held = middle + np.append(rng.uniform(-0.1, 0.1, 2), 0.0) + [[0.03, 0, 0], [-0.03, 0.01, 0]]
        to = middle + shift + factor * turn.apply(held - middle)
        first, last = seen(at, 3, held), seen(at, 3, to)
        one.done("begin", object=name, gesture="pinch", frame=3, pixels=first.tolist())
        for share in (0.3, 0.7, 1.0):
            one.done("drag", pixels=(first + share * (last - first)).tolist())
        one.done("end")
        done = stands(at, name, 3) @ before.inverse()
        np.testing.assert_allclose(float(done.scale), factor, rtol=1e-9)
        np.testing.assert_allclose(
            done.rotor.apply([1.0, 0, 0]), turn.apply([1.0, 0, 0]), atol=1e-9
        )
        np.testing.assert_allclose(seen(at, 3, done.apply(held)), last, atol=1e-6)
        one.done("undo")


def test_a_second_finger_goes_on_from_where_the_first_has_come(one: Visitor) -> None:
    name = one.put()
    before = stands(one.at, name, 0).translation_m
    pixel = seen(one.at, 0, before)
    one.done("begin", object=name, gesture="move", frame=0, pixels=[pixel.tolist()])
    one.done("drag", pixels=[(pixel + np.array([20, 5])).tolist()])
    two = [(pixel + np.array([20, 5])).tolist(), (pixel + np.array([60, 5])).tolist()]
    one.done("begin", object=name, gesture="pinch", frame=0, pixels=two)
    told = one.done("drag", pixels=two)
    np.testing.assert_allclose(
        seen(one.at, 0, np.array(told["poses"][name][:3])), pixel + np.array([20, 5]), atol=1e-6
    )
    one.done("end")
    told = one.done("undo")
    assert told["scene"]["undo"], "one gesture, one step: the other was to put it there"
    np.testing.assert_array_equal(stands(one.at, name, 0).translation_m, before)


def test_the_page_tells_the_command_that_draws_the_film(tmp_path: Path) -> None:
    folder = tmp_path / "a run; of mine"
    folder.mkdir()
    words = shlex.split(desk(folder).about()["film"])
    told = command_parser([runs.add_run]).parse_args(words[1:])
    assert told.recordings == [Path("table").absolute()]
    assert told.scene == folder / "scene.json"
    assert told.out == folder / "scene-film"


def test_fingers_above_the_horizon_move_nothing(one: Visitor) -> None:
    name = one.put()
    pixel = seen(one.at, 0, stands(one.at, name, 0).translation_m)
    one.done("begin", object=name, gesture="move", frame=0, pixels=[pixel.tolist()])
    here = one.done("drag", pixels=[(pixel + 3.0).tolist()])["poses"][name]
    above = one.done("drag", pixels=[[320.0, -2000.0]])
    assert "poses" not in above
    assert above["said"]
    one.done("end")
    np.testing.assert_allclose(stands(one.at, name, 0).translation_m, here[:3], atol=1e-15)


def test_axes_and_rings_go_by_what_they_are_told(one: Visitor) -> None:
    name = one.put()
    one.done("edit", edit={"do": "set", "object": name, "euler_deg": [20, 85, 40]})
    for frame in ("local", "parent", "global"):
        before = stands(one.at, name, 0)
        axes = {"local": before.rotor}.get(frame, Rotor.identity())
        axis = axes.apply([0.0, 0.0, 1.0])
        start, end = before.translation_m + 0.03 * axis, before.translation_m + 0.08 * axis
        said = {"object": name, "gesture": "axis", "axis": [0, 0, 1], "in": frame, "frame": 0}
        one.done("begin", pixels=[seen(one.at, 0, start).tolist()], **said)
        one.done("drag", pixels=[seen(one.at, 0, end).tolist()])
        one.done("end")
        moved = stands(one.at, name, 0).translation_m - before.translation_m
        np.testing.assert_allclose(moved, 0.05 * axis, atol=1e-9)
        one.done("undo")
        across = axes.apply([1.0, 0.0, 0.0])
        turn = Rotor.from_rotation_vector(0.6 * axis)
        rim = before.translation_m + 0.05 * np.stack([across, turn.apply(across)])
        one.done("begin", **{**said, "gesture": "ring"}, pixels=[seen(one.at, 0, rim[0]).tolist()])
        one.done("drag", pixels=[seen(one.at, 0, rim[1]).tolist()])
        one.done("end")
        turned = stands(one.at, name, 0).rotor @ before.rotor.inverse()
        np.testing.assert_allclose(turned.as_rotation_vector(), 0.6 * axis, atol=1e-9)
        one.done("undo")


def test_steps_are_snapped_to_where_asked(one: Visitor) -> None:
    name = one.put()
    one.done("begin", object=name, gesture="turn", frame=0, snap=True)
    one.done("drag", amount=0.5)
    one.done("end")
    turned = one.ask("numbers", object=name, frame=0)["numbers"]["euler_deg"][2]
    one.done("undo")
    was = one.ask("numbers", object=name, frame=0)["numbers"]["euler_deg"][2]
    np.testing.assert_allclose(turned - was, 30.0, atol=1e-9)


def test_a_way_that_is_drawn_is_walked(one: Visitor) -> None:
    name = one.put()
    line = np.column_stack([np.linspace(-0.3, 0.3, 60), np.full(60, 0.1), np.zeros(60)])
    told = one.done("walk", object=name, frame=2, pixels=seen(one.at, 2, line).tolist())
    about = told["scene"]["objects"][0]
    assert about["walk"]
    path = one.at.session.history.scene.part(name).walk.path_m
    np.testing.assert_allclose(path[[0, -1]], line[[0, -1], :2], atol=0.03)
    assert about["track"]["shape"] == [FRAMES, 8]
    for pixels in ([], [[320, 240]], [[320.0, -900.0], [300.0, -900.0]]):
        assert not one.ask("walk", object=name, frame=2, pixels=pixels)["ok"]


def test_two_browsers_move_two_objects_at_once_and_lose_nothing(tmp_path: Path) -> None:
    at = desk(tmp_path)
    one, other = Visitor(at, 1), Visitor(at, 2)
    first, second = one.put(), one.put()
    pixels = {name: seen(at, 0, stands(at, name, 0).translation_m) for name in (first, second)}
    one.done("begin", object=first, gesture="move", frame=0, pixels=[pixels[first].tolist()])
    assert one.news["holds"] == [first]
    other.done("begin", object=second, gesture="move", frame=0, pixels=[pixels[second].tolist()])
    for step in range(1, 4):
        one.done("drag", pixels=[(pixels[first] + 5 * step).tolist()])
        assert one.news["poses"][first], "others see it move"
        other.done("drag", pixels=[(pixels[second] - 5 * step).tolist()])
    assert "moving" in Visitor(at, 3).ask("edit", edit={"do": "remove", "object": first})["error"]
    assert "moving" in Visitor(at, 3).ask("undo")["error"]
    one.done("end")
    other.done("end")
    for name, step in ((first, 15), (second, -15)):
        now = seen(at, 0, stands(at, name, 0).translation_m)
        np.testing.assert_allclose(now, pixels[name] + step, atol=1e-6)
    for name in (second, first):
        one.done("undo")
        now = seen(at, 0, stands(at, name, 0).translation_m)
        np.testing.assert_allclose(now, pixels[name], atol=1e-6)


def test_an_object_is_held_by_one_alone_until_it_goes(tmp_path: Path) -> None:
    at = desk(tmp_path)
    one, other = Visitor(at, 1), Visitor(at, 2)
    name = one.put()
    grab = {"object": name, "gesture": "move", "frame": 0, "pixels": [[320, 300]]}
    one.done("begin", **grab)
    assert other.ask("begin", **grab)["error"] == f"Somebody else is moving {name}."
    one.done("drag", pixels=[[330, 300]])
    news = at.left(1)
    assert news["free"] == [name]
    assert news["holds"] == []
    other.done("begin", **grab)


REFUSED = [
    {"do": "nothing"},
    {},
    {"do": ["begin"]},
    {"do": "drag", "pixels": [[1, 2]]},
    {"do": "end"},
    {"do": "begin"},
    {"do": "begin", "object": "nobody", "gesture": "move", "pixels": [[1, 2]]},
    {"do": "begin", "object": "Person", "gesture": "fly", "pixels": [[1, 2]]},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [[1]]},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [[1, 2], [3, 4]]},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [[1, 2]] * 3},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [["a", 2]]},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [[1e300, 2]]},
    {"do": "begin", "object": "Person", "gesture": "move", "pixels": [[True, 2]]},
    {"do": "begin", "object": "Person", "gesture": "pinch", "pixels": [[1, 2]]},
    {"do": "begin", "object": "Person", "gesture": "move", "frame": 99, "pixels": [[1, 2]]},
    {"do": "begin", "object": "Person", "gesture": "move", "frame": True, "pixels": [[1, 2]]},
    {"do": "begin", "object": "Person", "gesture": "ring", "in": "mine", "pixels": [[320, 300]]},
    {
        "do": "begin",
        "object": "Person",
        "gesture": "ring",
        "axis": [0, 0, 0],
        "pixels": [[320, 300]],
    },
    {"do": "place", "file": "/etc/passwd"},
    {"do": "place", "file": "../secret.glb"},
    {"do": "edit"},
    {
        "do": "edit",
        "edit": {"do": "add", "object": {"name": "x", "kind": "prop", "file": "/etc/x"}},
    },
    {"do": "edit", "edit": {"do": "set", "object": "Person", "file": "../x.glb"}},
    {"do": "edit", "edit": {"do": "set", "object": "Person", "clip": "fly"}},
    {"do": "edit", "edit": {"do": "set", "object": "Person", "unknown": 1}},
    {"do": "edit", "edit": {"do": "remove", "object": "nobody"}},
    {"do": "edit", "edit": {f"key {k}": k for k in range(5000)}},
    {"do": "hang", "object": "Person", "on": "marker 99"},
    {"do": "copy", "object": "nobody"},
    {"do": "walk", "object": "Person", "pixels": [[1, 2]] * 1001},
]


@pytest.mark.parametrize("message", REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused_is_said_in_a_line_and_changes_nothing(
    one: Visitor, message: dict[str, object]
) -> None:
    one.put()
    before = one.at.session.history.scene
    lines = (one.at.session.history.write_log.gestures).read_bytes()
    answer = one.at.answer(1, {"n": 1, **message})
    assert answer.reply["ok"] is False
    assert 0 < len(answer.reply["error"]) <= 300
    assert "\n" not in answer.reply["error"]
    assert answer.news is None
    assert one.at.session.history.scene is before
    assert one.at.session.history.write_log.gestures.read_bytes() == lines
    one.done("begin", object="Person", gesture="move", frame=0, pixels=[[320, 300]])


def test_a_newcomer_stands_where_nobody_is_and_in_the_image(tmp_path: Path) -> None:
    """Where somebody was carried to the place that would be next, and for two people at once."""
    at = desk(tmp_path)
    one, other = Visitor(at), Visitor(at, 2)
    names = [one.put(frame=0), other.put(frame=0)]
    places = [stands(at, name, 0).translation_m for name in names]
    one.done("edit", frame=0, edit={"do": "remove", "object": names[0]})
    there = {"do": "set", "object": names[1], "position_m": places[0].tolist(), "time_s": 0.0}
    other.done("edit", frame=0, edit=there)
    names = [names[1], *(who.put(frame=5) for who in (one, other, one, other))]
    feet = np.array([stands(at, name, 5).translation_m for name in names])
    apart = np.linalg.norm(feet[:, None] - feet[None], axis=-1)[np.triu_indices(len(feet), 1)]
    assert apart.min() > 0.4 * at.filmed.height_m - 1e-9
    heads = feet + np.array([0.0, 0.0, at.filmed.height_m])
    for point in np.concatenate([feet, heads]):
        x, y = seen(at, 5, point)
        assert 0.0 < x < 639.0
        assert 0.0 < y < 479.0


def test_two_that_are_hung_on_a_marker_stand_apart(one: Visitor) -> None:
    names = [one.put(frame=0), one.put(frame=0)]
    for name in names:
        one.done("hang", object=name, on="marker 7", frame=3)
    first, second = (stands(one.at, name, 3).translation_m for name in names)
    tall = one.at.filmed.height_m
    assert 0.4 * tall < np.linalg.norm(first - second) < 2.0 * tall


def test_a_scene_without_a_run_says_how_to_get_one(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"holds no run\. .*`motorcade author .*scene.json --run"):
        offered(tmp_path / "scene.json")


def test_a_walk_has_a_start_a_speed_and_the_gait_for_its_size(one: Visitor) -> None:
    name = one.put()
    line = {"do": "set", "object": name, "walk": {"path_m": [[0.0, 0.0], [0.3, 0.1]]}}
    about = one.done("edit", edit=line)["scene"]["objects"][0]
    walks = about["walks"]
    assert walks["start_s"] == 0.0
    assert 0.02 < walks["speed_m_s"] < 0.4  # at 20 cm height, a tenth of a person's
    assert walks["gait"] == "walk"
    one.done("walk", object=name, start_s=0.1)
    refused = one.ask("walk", object=name, speed_m_s=5.0)
    assert "goes at" in str(refused["error"])
    low, high = (float(word) for word in str(refused["error"]).split() if word[0].isdigit())
    gaits = []
    for speed in (0.995 * low, 0.5 * (low + high), high):
        one.done("walk", object=name, speed_m_s=speed)
        walk = one.at.session.history.scene.part(name).walk
        assert walk.start_s == 0.1, "the rest of a walk stays"
        gaits.append(walk.gaits)
    assert gaits[0] == ("walk",)
    assert "run" in gaits[2]
    assert "jog" in gaits[1]


def test_a_way_that_is_moved_is_not_walked_anew(one: Visitor) -> None:
    rng, name = np.random.default_rng(6), one.put()
    path = np.cumsum(rng.uniform(0.05, 0.1, (5, 2)), axis=0)
    line = {"do": "set", "object": name, "walk": {"path_m": path.tolist(), "start_s": 0.05}}
    about = one.done("edit", edit=line)["scene"]["objects"][0]
    played, folder = one.at.session.played, one.at.session.played.folder
    for turn in (0.0, 2.0):
        moved = {
            "position_m": [*rng.uniform(-0.5, 0.5, 2).tolist(), 0.0],
            "euler_deg": [0, 0, turn],
        }
        again = one.done("edit", edit={"do": "set", "object": name, **moved})["scene"]["objects"][0]
        assert again["motion"] == about["motion"]
        scene = one.at.session.history.scene
        drawn = acted(scene, name, folder, float(one.at.filmed.time_s[-1]))
        way = Clip("way", drawn.time_s, drawn.parent_T_character.reshape(-1, 1))
        expected = way.at(one.at.filmed.time_s).rigid[:, 0]
        shown = played.parent_T_object(scene, name)
        np.testing.assert_allclose(shown.translation_m, expected.translation_m, atol=1e-7)
        np.testing.assert_allclose(
            shown.rotor.apply([1.0, 0, 0]), expected.rotor.apply([1.0, 0, 0]), atol=1e-6
        )
