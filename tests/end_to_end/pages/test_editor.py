"""The editor in a real browser: what is grabbed stays under mouse and fingers, others see it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from websockets.sync.client import connect

from tests.end_to_end.pages.conftest import Browser
from tests.end_to_end.pages.editor_tab import PATIENCE_S, POSE, Tab
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import RunDesk, desk, stands

pytestmark = pytest.mark.slow


@pytest.fixture
def at(tmp_path: Path) -> RunDesk:
    return desk(tmp_path)


@pytest.fixture
def tab(browser: Browser, at: RunDesk) -> Iterator[Callable[..., Tab]]:
    """Open the editor in a tab."""
    tabs: list[Tab] = []
    with running(at) as (access, _, _):

        def opened(width: int = 1400, height: int = 900, scheme: str = "light") -> Tab:
            tabs.append(Tab(browser, access.link(), width, height, scheme))
            return tabs[-1]

        yield opened
        for one in tabs:
            one.close()
        browser.events.clear()


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1400, 900, "light"), (390, 844, "dark"), (844, 390, "light")]
)
def test_what_is_grabbed_stays_under_mouse_and_finger(
    tab: Callable[..., Tab], width: int, height: int, scheme: str
) -> None:
    rng, one = np.random.default_rng(2), tab(width, height, scheme)
    one.somebody()
    moved = 0
    for _ in range(12):
        x, y = one.place(rng.uniform(0.2, 0.8)).round().astype(int).tolist()
        held = one.evaluate(
            f"(() => {{ const got = editor.pick({x}, {y}, false);"
            "if (got?.name !== 'Person' || got.handle) return false;"
            f"window.was = {POSE}; window.point = got.point; return true }})()"
        )
        box = "editor.stage.ground.getBoundingClientRect()"
        left, top, wide, high = one.evaluate(
            f"(({{x, y, width, height}}) => [x, y, width, height])({box})"
        )
        goal = np.array([left, top]) + rng.uniform([0.3, 0.45], [0.7, 0.8]) * [wide, high]
        goal = goal.round().astype(int)
        if not held:
            continue
        way = np.linspace([x, y], goal, 8).round().astype(int)
        one.drag([tuple(place) for place in way.tolist()])
        one.settled()
        now = one.evaluate(
            f"editor.stage.placeOf(point.clone().applyMatrix4(was.invert()).applyMatrix4({POSE}))"
        )
        assert np.hypot(*(np.array(now) - goal)) < 0.5
        moved += 1
    assert moved > 5
    assert one.complaints() == []
    sides = one.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert sides[0] <= sides[1], "nothing scrolls sideways"
    small = one.evaluate(
        "[...document.querySelectorAll('.bar button, .bar a, .panel button, .timeline > button')]"
        ".filter((b) => b.offsetParent && (b.offsetWidth < 44 || b.offsetHeight < 44))"
        ".map((b) => b.title)"
    )
    assert small == [], "fingers need 44 pixels"


COLOURED = """(() => {
  editor.choose(null);
  editor.draw();
  const { width, height } = editor.stage.canvas;
  const gl = editor.stage.renderer.getContext(), bytes = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let [drawn, coloured] = [0, 0];
  for (let k = 0; k < bytes.length; k += 4) {
    drawn += bytes[k + 3] > 200;
    coloured += bytes[k + 3] > 200 && Math.abs(bytes[k] - bytes[k + 2]) > 8;
  }
  return [drawn, coloured];
})()"""


@pytest.mark.parametrize("grey", [True, False])
def test_figures_have_colour_where_the_footage_has(
    tab: Callable[..., Tab], at: RunDesk, grey: bool
) -> None:
    at.filmed.__dict__["grey"] = grey
    one = tab()
    one.somebody()
    drawn, coloured = one.evaluate(COLOURED)
    assert drawn > 1000
    assert coloured == 0 if grey else coloured > 0.2 * drawn


def test_two_fingers_turn_and_grow(tab: Callable[..., Tab], at: RunDesk) -> None:
    one = tab(390, 844)
    one.somebody()
    x, y = one.place(0.05).round().astype(int).tolist()
    before = stands(at, "Person", 0)
    seen = [(x - 30, y), (x + 30, y)]
    ends = [(x - 40, y - 12), (x + 44, y + 10)]
    way = np.linspace(np.array(seen), np.array(ends), 10).round().astype(int).tolist()
    one.fingers([[tuple(place) for place in places] for places in way])
    one.settled()
    ground = []
    for pairs in (seen, ends):
        pixels = [one.evaluate(f"editor.pixelAt({u}, {v})") for u, v in pairs]
        origin, rays = at.filmed.rays(0, pixels)
        ground.append([origin - origin[2] / ray[2] * ray for ray in rays])
    ways = [complex(*(second - first)[:2]) for first, second in ground]
    done = stands(at, "Person", 0) @ before.inverse()
    np.testing.assert_allclose(float(done.scale), abs(ways[1] / ways[0]), rtol=1e-3)
    turned = np.degrees(done.rotor.as_rotation_vector()[2] - np.angle(ways[1] / ways[0]))
    assert abs(turned) < 0.1


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_a_hand_is_dragged_and_stays_under_mouse_and_finger(
    tab: Callable[..., Tab], at: RunDesk, width: int, height: int
) -> None:
    one = tab(width, height)
    one.somebody()
    one.press("Pose")
    one.until("editor.posing.on && !editor.posing.handles.get('left_hand').hidden")
    one.settled()
    small = one.evaluate(
        "[...document.querySelectorAll('.joint')].filter((b) => !b.hidden)"
        ".map((b) => Math.min(b.offsetWidth, b.offsetHeight))"
    )
    assert len(small) == 5
    assert min(small) >= 44, "fingers need 44 pixels"
    hand = (
        "editor.stage.placeOf(editor.actors.get('Person').joint(editor.one.held_by.left_hand[0]))"
    )
    start = np.array(one.evaluate(hand))
    down = start.round().astype(int)
    shoulder = np.array(
        one.evaluate(
            "editor.stage.placeOf(editor.actors.get('Person').joint("
            "editor.one.held_by.left_hand[0] - 2))"
        )
    )
    up = (down + 0.3 * (shoulder - start)).round().astype(int)
    way = np.linspace(down, up, 6).round().astype(int).tolist()
    one.drag([tuple(place) for place in way])
    one.until("editor.one.turns.length === 1")
    one.settled()
    one.until("editor.actors.get('Person').pose === null")
    one.settled()
    moved = np.array(one.evaluate(hand)) - start
    assert np.hypot(*(moved - (up - down))) < 0.5
    assert np.hypot(*moved) > 3.0
    assert len(at.session.history.scene.part("Person").joint_keyframes) == 1
    one.press("Undo")
    one.until("editor.one.turns.length === 0")
    one.settled()
    one.until(f"Math.hypot({hand}[0] - {start[0]}, {hand}[1] - {start[1]}) < 0.1")
    assert one.complaints() == []


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_layers_and_poses_come_end_and_go(
    tab: Callable[..., Tab], at: RunDesk, width: int, height: int
) -> None:
    one = tab(width, height)
    one.somebody()
    one.press("Do")
    one.press("Add a layer")
    one.until("editor.one.layers.length === 1")
    x, y = one.middle(".share input")
    wide = one.evaluate("document.querySelector('.share input').offsetWidth")
    one.drag([(x + wide // 2 - 8, y), (x + 4, y), (x, y)])
    one.until("Math.abs(editor.one.layers[0].weight - 0.5) < 0.06")
    one.settled()
    one.press("Close")
    x, y = one.middle(".mark.layer .grip.end")
    wide = one.evaluate("document.querySelector('.lane').offsetWidth")
    one.drag([(x - round(share * wide), y) for share in np.linspace(0.0, 0.5, 8)])
    one.until("editor.one.layers[0].end_s !== undefined")
    one.settled()
    layer = at.session.history.scene.part("Person").layers[0]
    assert (layer.clip, layer.joints) == ("wave", "right_arm")
    assert layer.end_s == pytest.approx(0.5 * at.filmed.time_s[-1], abs=0.03)
    one.evaluate("editor.seek(0)")
    one.press("Pose")
    hand = "editor.stage.placeOf(editor.actors.get('Person').joint(editor.one.held_by.head[0]))"
    one.until("editor.posing.on && !editor.posing.handles.get('head').hidden")
    one.settled()
    x, y = np.round(one.evaluate(hand)).astype(int).tolist()
    one.drag([(x, y), (x + 6, y), (x + 14, y + 4)])
    one.until("editor.one.turns.length === 1")
    one.settled()
    for part, share, done in (
        (".mark.pose .grip.end", -0.6, "turns[0][1] !== null"),
        (".mark.pose", 0.2, "turns[0][0] > 0"),
    ):
        x, y = one.middle(part)
        one.drag([(x + round(far * wide), y) for far in np.linspace(0.0, share, 8)])
        one.until(f"editor.one.{done}")
        one.settled()
    last = float(at.filmed.time_s[-1])
    held = at.session.history.scene.part("Person").joint_keyframes[0]
    assert held.time_s == pytest.approx(0.2 * last, abs=0.06)
    assert held.end_s == pytest.approx(0.6 * last, abs=0.06)
    one.drag([one.middle(".mark.pose")])
    one.press("Remove this pose")
    one.until("editor.one.turns.length === 0")
    for back in ("turns.length === 1", "turns[0][0] === 0", "turns[0][1] === null"):
        one.press("Undo")
        one.until(f"editor.one.{back}")
        one.settled()
    assert at.session.history.scene.part("Person").joint_keyframes[0].end_s is None
    one.drag([one.middle(".mark.layer")])
    one.press("Remove this layer")
    one.until("editor.one.layers.length === 0")
    one.press("Undo")
    one.until("editor.one.layers.length === 1")
    assert one.complaints() == []


def test_a_drawn_way_is_walked_and_others_hear_of_it(tab: Callable[..., Tab], at: RunDesk) -> None:
    one = tab(390, 844)
    address = one.evaluate("editor.link.address")
    origin = one.evaluate("location.origin")
    with connect(address, origin=origin, proxy=None) as other:
        one.somebody()
        x, y = one.place().round().astype(int).tolist()
        one.press("Walk")
        one.until("editor.draws")
        one.drag([(x - 4 * k, y + (k % 7)) for k in range(30)])
        one.until("editor.one?.walk === true")
        assert at.session.history.scene.part("Person").walk is not None
        one.until("editor.timeline.playing || editor.frame > 0")
        one.press("Undo")
        one.until("editor.one?.walk === false")
        heard = [json.loads(other.recv(PATIENCE_S)) for _ in range(4)]
    walks = [[thing["walk"] for thing in news["scene"]["objects"]] for news in heard]
    assert walks == [[], [False], [True], [False]]
    assert one.complaints() == []
