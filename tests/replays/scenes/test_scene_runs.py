"""A scene bound to tracked poses: what hangs on a moving marker goes along, and all is drawn."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorcade.animation import mannequin
from motorcade.animation.place import GroundPath
from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer, render_performers
from motorcade.replays.stages.values.view import PlacedCharacter, PlayedPart
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.placed import placed
from tests.props import write_props
from tests.replays.carried_marker import (
    CAMERA,
    FRAMES,
    ID,
    SIDE_M,
    TIME_NS,
    recorded,
    still,
    wandering,
)

LASTS_S = 1e-9 * float(TIME_NS[-1])
BOX = {"name": "box", "kind": "prop", "file": "box.glb", "parent": "tag", "scale": 0.2}
ANCHORS = {"tag": {"on": "marker", "marker": ID}, "ground": {"on": "floor", "floor_m": -0.2}}


def scene(folder: Path, *objects: dict[str, Any]) -> Path:
    write_props(folder)
    path = folder / "scene.json"
    path.write_text(json.dumps({"anchors": ANCHORS, "objects": objects}))
    return path


def bound(path: Path, where: Any = wandering) -> PlacedCharacter:
    recording, smoothed, found = recorded(where)
    return placed(recording, found, smoothed, scene=path)


def parts(made: PlacedCharacter) -> dict[str, tuple[PlayedPart, Performer]]:
    return {part.name: (part, one) for part, one in zip(made.parts, performers(made), strict=True)}


def centers_m(one: Performer, own_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FloatArray:
    return one.world_T_character(TIME_NS).apply(own_m)


def test_what_hangs_on_a_moving_marker_goes_along_and_moves_over_it(tmp_path: Path) -> None:
    """A box that slides from corner to corner of the marker while that is carried about."""
    keys = [
        {"time_s": 0.0, "position_m": [0.0, -SIDE_M, 0.0], "scale": 0.2},
        {"time_s": LASTS_S, "position_m": [SIDE_M, 0.0, 0.0], "scale": 0.4},
    ]
    cup = {"name": "cup", "kind": "prop", "file": "ball.glb", "parent": "box", "scale": 0.5}
    cup |= {"position_m": [0.0, 0.0, 0.2]}
    made = parts(bound(scene(tmp_path, {**BOX, "keyframes": keys}, cup)))
    share = TIME_NS / TIME_NS[-1]
    for k in range(FRAMES):
        # Neither turns, so that the spiral between them is a straight line, evenly in log scale.
        grown = 0.2 * 2.0 ** share[k]
        along = (grown - 0.2) / 0.2
        inside = np.array([along * SIDE_M, (along - 1.0) * SIDE_M, 0.0])
        wanted = wandering(k).apply(inside)
        here = made["box"][1].world_T_character(int(TIME_NS[k]))
        assert float(here.scale) == pytest.approx(grown)
        assert np.linalg.norm(here.translation_m - wanted) < 0.006  # as the marker is tracked
        child = made["cup"][1].world_T_character(int(TIME_NS[k]))
        np.testing.assert_allclose(child.translation_m, here.apply([0.0, 0.0, 0.2]), atol=1e-9)
        assert float(child.scale) == pytest.approx(0.5 * grown)


def test_what_hangs_on_nothing_stays_in_the_world(tmp_path: Path) -> None:
    free = {"name": "free", "kind": "prop", "file": "box.glb", "position_m": [0.1, 0.2, 0.3]}
    made = bound(scene(tmp_path, BOX, free))
    (part, one) = parts(made)["free"]
    np.testing.assert_allclose(centers_m(one), np.tile([0.1, 0.2, 0.3], (FRAMES, 1)), atol=1e-12)
    assert part.ground_motion is None
    # Its shadow falls on the anchor that stays.
    assert part.placement.world_T_character.translation_m[2] == pytest.approx(-0.2)


def test_a_walker_walks_its_path_on_the_anchor_and_carries_its_child(tmp_path: Path) -> None:
    path = [[0.0, -0.05], [0.1, -0.05], [0.1, 0.05]]
    walk = {"path_m": path, "start_s": 0.2}
    who = {"name": "who", "kind": "character", "file": "mannequin", "parent": "tag"}
    who |= {"height_m": 0.06, "walk": walk}
    hat = {"name": "hat", "kind": "prop", "file": "ball.glb", "parent": "who", "scale": 0.1}
    hat |= {"position_m": [0.0, 0.0, 0.06]}
    made = parts(bound(scene(tmp_path, who, hat), still))
    part, one = made["who"]
    assert {state.state for state in part.states} >= {"idle", "walk"}
    inside = still(0).inverse().apply(centers_m(one))
    assert np.abs(inside[:, 2]).max() < 2e-4  # as the marker is tracked
    curve = GroundPath(np.array(path))
    ways = curve.at(np.linspace(0.0, curve.length_m, 2000))[0]
    off = np.linalg.norm(inside[:, None, :2] - ways[None], axis=-1).min(axis=1)
    assert off.max() < 2e-3
    np.testing.assert_allclose(inside[0, :2], path[0], atol=2e-3)
    assert np.linalg.norm(inside[-1] - inside[0]) > 0.02
    assert part.worst_slide_m is not None
    assert part.worst_slide_m < 0.01 * 0.06
    assert made["hat"][0].worst_slide_m is None
    crown = mannequin().height_m * float(one.world_T_character(0).scale)
    assert crown == pytest.approx(0.06)
    crowns_m = centers_m(one, (0.0, 0.0, mannequin().height_m))
    np.testing.assert_allclose(centers_m(made["hat"][1]), crowns_m, atol=1e-9)


def test_layers_and_turned_joints_are_played_over_the_clip(tmp_path: Path) -> None:
    turned = [0.5**0.5, 0.5**0.5, 0.0, 0.0]
    who = {"name": "who", "kind": "character", "file": "mannequin", "clip": "idle"}
    keys = [
        {"time_s": 0.5, "joints": {"head": [1, 0, 0, 0]}},
        {"time_s": 1.0, "joints": {"head": turned}},
    ]
    plain = parts(bound(scene(tmp_path, who)))["who"][0]
    layer = {"clip": "wave", "joints": "right_arm", "start_s": 0.4}
    both = {**who, "layers": [layer], "joint_keyframes": keys}
    part = parts(bound(scene(tmp_path, both)))["who"][0]
    skeleton = mannequin().skeleton
    head, hand, foot = (skeleton.index(name) for name in ("head", "right_hand", "left_foot"))
    at = [np.searchsorted(part.time_s, t) for t in (0.5, 0.75, 1.0, 1.9)]
    angle = [float(part.poses[k, head].rotor.angle()) for k in at]
    np.testing.assert_allclose(angle, [0.0, np.pi / 4, np.pi / 2, np.pi / 2], atol=1e-9)
    np.testing.assert_allclose(
        part.poses.coefficients[:, foot], plain.poses.coefficients[:, foot], atol=1e-14
    )
    hands = [skeleton.world(one.poses).translation_m[:, hand] for one in (part, plain)]
    early = part.time_s <= 0.4
    np.testing.assert_allclose(hands[0][early], hands[1][early], atol=1e-12)
    assert np.linalg.norm(hands[0] - hands[1], axis=1)[at[3]] > 0.2


def test_a_pose_that_ends_gives_the_joint_back_to_its_clip(tmp_path: Path) -> None:
    """Before it comes and after it went as if it were not there; between two, no leap."""
    who = {"name": "who", "kind": "character", "file": "mannequin", "clip": "walk"}
    turned = [0.6, 0.0, 0.8, 0.0]
    keys = [
        {"time_s": 0.5, "joints": {"head": turned}, "end_s": 0.8},
        {"time_s": 1.5, "joints": {"head": [1, 0, 0, 0]}, "end_s": 1.6},
    ]
    plain = parts(bound(scene(tmp_path, who)))["who"][0]
    part = parts(bound(scene(tmp_path, {**who, "joint_keyframes": keys})))["who"][0]
    head, time_s = mannequin().skeleton.index("head"), part.time_s
    rotors, before = part.poses[:, head].rotor, plain.poses[:, head].rotor
    off = np.asarray((rotors.inverse() @ before).angle())
    free = (time_s < 0.2) | ((time_s > 1.1) & (time_s < 1.2)) | (time_s > 1.9)
    assert off[free].max() < 1e-9
    asked = Rotor.from_quaternion(turned)
    away = np.asarray((rotors.inverse() @ asked).angle())
    assert away[(time_s >= 0.5) & (time_s <= 0.8)].max() < 1e-9
    assert np.asarray(rotors.angle())[(time_s >= 1.5) & (time_s <= 1.6)].max() < 1e-9
    step = np.asarray((rotors[:-1].inverse() @ rotors[1:]).angle())
    # At its fastest, smoothstep goes 1.5 times as fast as a straight line would.
    assert step.max() < 1.6 * (2.0 * np.arccos(0.6) + 0.1) / 0.3 / 60.0


def test_a_layer_rises_and_falls_within_its_fade(tmp_path: Path) -> None:
    who = {"name": "who", "kind": "character", "file": "mannequin", "clip": "idle"}
    layer = {"clip": "wave", "joints": "right_arm", "start_s": 0.2, "end_s": 1.8, "fade_s": 0.8}
    still = parts(bound(scene(tmp_path, who)))["who"][0]
    made = {}
    for fade_s in (0.0, 0.8):
        layers = [{**layer, "fade_s": fade_s}]
        made[fade_s] = parts(bound(scene(tmp_path, {**who, "layers": layers})))["who"][0]
    arm = mannequin().skeleton.index("right_upper_arm")
    base, over, faded = (one.poses[:, arm].rotor for one in (still, made[0.0], made[0.8]))
    whole = np.asarray((base.inverse() @ over).angle())
    part = np.asarray((base.inverse() @ faded).angle())
    time_s = still.time_s
    assert whole[(time_s > 0.5) & (time_s < 1.5)].min() > 0.1
    for when, share in ((0.21, 0.0), (0.6, 0.5), (1.0, 1.0), (1.4, 0.5), (1.79, 0.0)):
        at = np.searchsorted(time_s, when)
        assert part[at] == pytest.approx(share * whole[at], abs=0.02)


@pytest.mark.usefixtures("opengl")
def test_all_of_a_scene_is_drawn_where_it_is(tmp_path: Path) -> None:
    """Every frame differs from the footage about every object, and not beside them."""
    ball = {"name": "ball", "kind": "prop", "file": "ball.glb", "parent": "tag", "scale": 0.15}
    ball |= {"position_m": [0.16, -0.05, 0.0], "visible": [0.0, 1.0]}
    recording, smoothed, found = recorded(wandering)
    middle = {**BOX, "position_m": [0.05, -0.05, 0.0]}
    made = placed(recording, found, smoothed, scene=scene(tmp_path, middle, ball))
    assert made.stands_on == "marker 7, which moves"
    frames = [(frame.time_ns, frame.image()) for frame in recording.frames][::8]
    drawn = render_performers(frames, CAMERA, smoothed.drawn, performers(made))
    for (stamp, before), after in zip(frames, drawn, strict=True):
        k = int(np.flatnonzero(stamp == TIME_NS)[0])
        changed = np.any(np.abs(after.astype(int) - before[..., None]) > 20, axis=2)
        view = smoothed.drawn.motors[k].inverse()
        for own, there in (((0.05, -0.05, 0.02), True), ((0.16, -0.05, 0.015), k <= 20)):
            column, row = CAMERA.project(view.apply(wandering(k).apply(own))).round().astype(int)
            around = changed[row - 2 : row + 3, column - 2 : column + 3]
            assert around.mean() > 0.6 if there else around.mean() < 0.2


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        ({**BOX, "file": "none.glb"}, "scene, 'box': .*none.glb"),
        ({**BOX, "clip": "fly"}, "scene, 'box': .*no clip 'fly'"),
        ({**BOX, "parent": "lost"}, "expected an object named before, got 'lost'"),
        ({"name": "pair"}, "expected a character or a prop, got groups alone"),
    ],
)
def test_what_a_scene_asks_for_in_vain_is_refused_by_name(
    thing: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=said):
        bound(scene(tmp_path, thing))


def test_more_than_can_be_played_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    crowd = [{**BOX, "name": f"box {k}", "parent": "ground"} for k in range(101)]
    with pytest.raises(ValueError, match="expected at most 100 characters and props, got 101"):
        bound(scene(tmp_path, *crowd))
    monkeypatch.setattr("motorcade.replays.stages.view.placed.MOST_POSES", 300)
    with pytest.raises(ValueError, match=r"scene, 'box 1': expected at most 300 poses"):
        bound(scene(tmp_path, *crowd[:2]))
    monkeypatch.setattr("motorcade.replays.stages.view.acted.MOST_POSES", 5000)
    who = {"name": "who", "kind": "character", "file": "mannequin"}
    with pytest.raises(ValueError, match="scene, 'who': expected to be done earlier: 2 s are more"):
        bound(scene(tmp_path, who))


def test_an_anchor_that_is_not_there_is_named(tmp_path: Path) -> None:
    write_props(tmp_path)
    path = tmp_path / "scene.json"
    anchors = {"wall": {"on": "marker", "marker": 3}}
    path.write_text(json.dumps({"anchors": anchors, "objects": [{**BOX, "parent": "wall"}]}))
    with pytest.raises(ValueError, match=r"scene, anchor 'wall': .*placed\.marker=3"):
        bound(path)


def test_a_scene_says_in_place_of_knobs(tmp_path: Path) -> None:
    recording, smoothed, found = recorded(still)
    path = scene(tmp_path, BOX)
    with pytest.raises(ValueError, match=r"placed\.height_m: expected none beside placed\.scene"):
        placed(recording, found, smoothed, scene=path, height_m=1.0)
    with pytest.raises(ValueError, match=r"placed\.cast: expected none beside placed\.scene"):
        placed(recording, found, smoothed, scene=path, cast=tmp_path / "cast.toml")


def test_poses_between_frames_are_those_of_the_screw(tmp_path: Path) -> None:
    """Exposure and exports ask between frames: a turn of half a circle, 5 cm from the axis."""
    turned = {"time_s": LASTS_S, "position_m": [0.05, 0.05, 0.0], "euler_deg": [0, 0, 170]}
    start = {"time_s": 0.0, "position_m": [0.05, -0.05, 0.0]}
    made = parts(bound(scene(tmp_path, {**BOX, "keyframes": [start, turned]}), still))["box"][1]
    a, b = (
        Similarity.from_motor_scale(
            Motor.from_quaternion_translation(
                [np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)], place
            )
        )
        for angle, place in ((0.0, [0.05, -0.05, 0.0]), (np.radians(170.0), [0.05, 0.05, 0.0]))
    )
    for share in (0.123, 0.5, 0.777):
        stamp = int(share * TIME_NS[-1])
        inside = Similarity.from_motor_scale(still(0).inverse()) @ made.world_T_character(stamp)
        wanted = a.interpolate(b, np.array(share))
        assert np.linalg.norm(inside.translation_m - wanted.translation_m) < 2e-3
        away = (wanted.rotor.inverse() @ inside.rotor).angle()
        assert float(away) < 0.02
