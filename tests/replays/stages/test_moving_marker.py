"""A character on a marker: it stands where the marker is, moves with it, and never pops."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer, render_performers
from motorcade.replays.io.recording import LooseMarkers, Recording
from motorcade.replays.stages.camera.marker_poses import _drawn, marker_poses
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.view import PlacedCharacter
from motorcade.replays.stages.view.acting import character_named, clip_named
from motorcade.replays.stages.view.placed import placed
from motorcade.tracking import Board, MarkerGrid, MarkerMap, SingleMarker
from motorcade.tracking.markers.corner_stream import CornerStream
from tests.bench.tracking.tag_scene import TagScene, handheld_path, wall_of_markers
from tests.replays.carried_marker import (
    CAMERA,
    FRAMES,
    ID,
    RATE_HZ,
    SIDE_M,
    TIME_NS,
    Images,
    recorded,
    still,
    wandering,
)

HIDDEN = range(4, 16)


def leaping(frame: int) -> Motor:
    away = Motor.from_translation([0.2, -0.1, 0.0])
    return still(0) if frame < 20 else away @ still(0)


def feet_m(made: PlacedCharacter) -> FloatArray:
    """Where the character's soles are at every frame (FRAMES, 3), world."""
    own = made.placement.apply([0.0, 0.0, 0.0])
    if made.ground_motion is None:
        return np.tile(own, (FRAMES, 1))
    np.testing.assert_array_equal(made.ground_motion.time_ns, TIME_NS)
    return made.ground_motion.motors.apply(own)


def middles_m(where: Callable[[int], Motor]) -> FloatArray:
    half = [0.5 * SIDE_M, -0.5 * SIDE_M, 0.0]
    return np.array([where(k).apply(half) for k in range(FRAMES)])


def pixels(points_m: FloatArray) -> FloatArray:
    return CAMERA.project(handheld_path(FRAMES, 0.7).inverse().apply(points_m))


def on_marker(given: tuple[Recording, Integrity, CameraPoses]) -> PlacedCharacter:
    recording, smoothed, found = given
    return placed(recording, found, smoothed, on="marker", marker=ID, heading_deg=30.0)


def test_it_moves_with_the_marker() -> None:
    made = on_marker(recorded(wandering))
    assert made.stands_on == "marker 7, which moves"
    apart = np.linalg.norm(pixels(feet_m(made)) - pixels(middles_m(wandering)), axis=1)
    assert apart.max() < 1.0
    assert made.ground_motion is not None
    up = (made.ground_motion.motors @ made.placement.world_T_character).rotor.apply([0.0, 0.0, 1.0])
    wanted = np.array([wandering(k).rotor.apply([0.0, 0.0, 1.0]) for k in range(FRAMES)])
    tilted = np.arccos(np.clip(np.sum(up * wanted, axis=1), -1.0, 1.0))
    assert np.rad2deg(tilted).max() < 4.0
    np.testing.assert_allclose(made.ground_motion.motors[0].as_matrix(), np.eye(4), atol=1e-9)


@pytest.mark.usefixtures("opengl")
def test_it_is_drawn_where_the_marker_is() -> None:
    """What differs from the footage stands over the marker's middle in every frame."""
    recording, smoothed, _ = given = recorded(wandering)
    made = on_marker(given)
    path = smoothed.drawn
    figure = character_named(made.character)
    clip = clip_named(figure, made.clip)
    frames = [(frame.time_ns, frame.image()) for frame in recording.frames][::8]
    who = Performer(figure, clip, made.placement, ground_motion=made.ground_motion)
    made_of = render_performers(frames, CAMERA, path, [who])
    ends_m = np.array([[0.5, -0.5, 0.0], [0.5, -0.5, 1.0]]) * SIDE_M
    for (stamp, before), after in zip(frames, made_of, strict=True):
        k = int(np.flatnonzero(stamp == TIME_NS)[0])
        changed = np.any(np.abs(after.astype(int) - before[..., None]) > 20, axis=2)
        rows, columns = np.nonzero(changed)
        assert len(rows) > 60
        view = handheld_path(FRAMES, 0.7)[k].inverse()
        for column, row in CAMERA.project(view.apply(wandering(k).apply(ends_m))):
            assert np.hypot(columns - column, rows - row).min() < 6.0


def test_unseen_it_waits_and_then_glides_back() -> None:
    shown = feet_m(on_marker(recorded(wandering, HIDDEN)))
    true = middles_m(wandering)
    waits = shown[HIDDEN.start - 1 : HIDDEN.stop]
    np.testing.assert_allclose(waits, np.tile(waits[0], (len(waits), 1)), atol=1e-12)
    missed = float(np.linalg.norm(true[HIDDEN.stop] - waits[0]))
    assert missed > 0.05
    # No frame goes farther than the marker itself, and what the glide's first frame makes good.
    steps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    own = np.linalg.norm(np.diff(true, axis=0), axis=1)
    glide = missed * (1.0 - np.exp(-1.0 / (0.25 * RATE_HZ)))
    assert np.all(steps < own + 1.1 * glide + 1e-3)
    assert np.linalg.norm(shown[-1] - true[-1]) < 0.15 * missed


def test_a_leap_is_glided_over_and_a_lone_wrong_frame_ignored() -> None:
    shown, true = feet_m(on_marker(recorded(leaping))), middles_m(leaping)
    leap = float(np.linalg.norm(true[-1] - true[0]))
    steps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    assert steps.max() < 1.05 * leap * (1.0 - np.exp(-1.0 / (0.25 * RATE_HZ)))
    assert np.linalg.norm(shown[-1] - true[-1]) < 0.05 * leap

    def once(frame: int) -> Motor:
        return leaping(25) if frame in (12, 13) else still(frame)

    quiet = feet_m(on_marker(recorded(once)))
    assert np.linalg.norm(quiet - middles_m(still), axis=1).max() < 0.05 * leap


@pytest.mark.parametrize(
    "board", [SingleMarker("tag36h11", ID, SIDE_M), MarkerGrid("tag36h11", 1, 1, SIDE_M, 0.02, ID)]
)
def test_a_marker_that_stands_still_is_the_board_that_it_is(board: Board) -> None:
    recording, smoothed, found = recorded(still, board=board)
    made = on_marker((recording, smoothed, found))
    usual = placed(recording, found, smoothed, on="board", heading_deg=30.0, height_m=SIDE_M)
    assert made.ground_motion is None
    assert made.stands_on == "marker 7"
    np.testing.assert_allclose(
        made.placement.world_T_character.as_matrix(),
        usual.placement.world_T_character.as_matrix(),
        atol=1e-9,
    )
    assert made.placement.scale == pytest.approx(usual.placement.scale)


def test_a_still_marker_that_no_map_knows_is_found_once_for_all_frames() -> None:
    made = on_marker(recorded(still, HIDDEN))
    assert made.ground_motion is None
    apart = np.linalg.norm(pixels(feet_m(made)) - pixels(middles_m(still)), axis=1)
    assert apart.max() < 0.5


def test_what_is_asked_for_and_not_there_is_refused() -> None:
    recording, smoothed, found = recorded(still, range(FRAMES))
    with pytest.raises(ValueError, match=r"drawn: placed\.marker=7, but no frame with a pose"):
        placed(recording, found, smoothed, on="marker", marker=ID)
    with pytest.raises(ValueError, match=r"placed\.marker: expected an id with placed\.on=marker"):
        placed(recording, found, smoothed, on="marker")
    with pytest.raises(ValueError, match=r"placed\.marker: expected an id with placed\.on=marker"):
        placed(recording, found, smoothed, marker=ID)
    nameless = Recording("plain", Path("plain"), "images", recording.frames, CAMERA)
    with pytest.raises(ValueError, match=r"plain: placed\.marker=7, but no family of markers"):
        placed(nameless, found, smoothed, on="marker", marker=ID)


def test_a_marker_that_is_said_to_move_does_no_harm_to_the_map() -> None:
    rng = np.random.default_rng(8)
    wall = wall_of_markers(3, 1, 0.16, 20.0, rng)
    cameras, images = handheld_path(FRAMES, 0.7), []
    for k in range(0, FRAMES, 3):
        poses = Motor.concatenate([wall, Motor.stack([wandering(k)])])
        scene = TagScene(CAMERA, "tag36h11", np.array([1, 2, 3, ID]), SIDE_M, poses)
        images.append(scene.image(cameras[k], rng))
    frames = Images(images)
    frames.time_ns = TIME_NS[::3]
    loose = LooseMarkers("tag36h11", SIDE_M)
    recording = Recording("wall", Path("wall"), "images", frames, CAMERA, markers=loose)
    clean, unsaid = marker_poses(recording, moving=(ID,)), marker_poses(recording)
    for one in (clean, unsaid):  # it is found where nobody said so, and named
        assert one.marker_map.marker_ids.tolist() == [1, 2, 3]
        assert np.median(one.reprojection_px) < 0.3
    assert [finding.name for finding in clean.audit if not finding.passed] == []
    (named,) = (finding for finding in unsaid.audit if not finding.passed)
    assert named.verdict == "contradicted"
    assert named.sentence.endswith(f"say marker_poses.moving={ID}")
    with pytest.raises(ValueError, match="wall: refine=photometric takes all markers"):
        marker_poses(recording, refine="photometric", moving=(ID,))


def test_prints_that_differ_in_size_are_each_drawn_in_their_own() -> None:
    """The witness by pixels takes sides from the map, of which one recording's may be several."""
    side_m = np.array([0.05, 0.12])
    known = MarkerMap(np.array([3, 8]), side_m, Rotor.identity((2,)), np.zeros((2, 3)))
    path = Trajectory(TIME_NS[:1], Motor.identity((1,)), "world", "camera")
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners_px = 100.0 + square * np.array([20.0, 40.0])[:, None, None]
    stream = CornerStream(CAMERA, TIME_NS[:1], np.zeros(2, int), known.marker_ids, corners_px)
    mapped: Any = SimpleNamespace(marker_map=known, trajectory=path)
    image = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    prints = [drawn for _, drawn, _ in _drawn({int(TIME_NS[0]): image}, stream, mapped, "tag36h11")]
    assert [(drawn.marker_id, drawn.side_m) for drawn in prints] == [(8, 0.12), (3, 0.05)]
