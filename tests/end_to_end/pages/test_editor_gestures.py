"""Gestures on the page in numbers: on other lenses, near gimbal lock, back and forth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from motorcade.animation.authoring.gimbal import gimbal_rows
from motorcade.tracking import Camera
from tests.end_to_end.pages.conftest import Browser
from tests.end_to_end.pages.editor_tab import POSE, Tab
from tests.end_to_end.pages.gimbal_table import dragged_rings
from tests.replays.studio.server.conftest import running
from tests.replays.studio.server.stage import RunDesk, desk, stands
from tests.replays.studio.server.test_session import LENSES

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("pages")]
DRAGS, PINCHES = 50, 12
# An image that reaches above the horizon.
WIDE = Camera(848, 800, 200.0, 200.0, 417.0, 403.0, "equidistant", (-0.009, 0.05, -0.047, 0.009))


@pytest.fixture
def tab(browser: Browser) -> Iterator[Callable[..., Tab]]:
    """Open the editor of a desk in a tab."""
    closing: list[Callable[[], object]] = []

    def opened(at: RunDesk, width: int = 1400, height: int = 900) -> Tab:
        server = running(at)
        access, _, _ = server.__enter__()
        made = Tab(browser, access.link(), width, height, "light")
        closing.extend([made.close, lambda: server.__exit__(None, None, None)])
        return made

    yield opened
    for close in closing:
        close()
    browser.events.clear()


def grabbed(one: Tab, rng: np.random.Generator) -> tuple[int, int] | None:
    """A place of the page where the person is touched, remembered there; None beside it."""
    x, y = one.place(rng.uniform(0.2, 0.8)).round().astype(int).tolist()
    held = one.evaluate(
        f"(() => {{ const got = editor.pick({x}, {y}, false);"
        "if (got?.name !== 'Person' || got.handle) return false;"
        f"window.was = {POSE}; window.point = got.point; return true }})()"
    )
    return (x, y) if held else None


def image_box(one: Tab) -> np.ndarray:
    return np.array(
        one.evaluate(
            "(({x, y, width, height}) => [x, y, width, height])("
            "editor.stage.ground.getBoundingClientRect())"
        )
    )


@pytest.mark.parametrize("lens", LENSES)
def test_what_is_grabbed_stays_under_the_mouse_on_every_lens(
    tab: Callable[..., Tab], tmp_path: Path, lens: str
) -> None:
    rng = np.random.default_rng(11)
    at = desk(tmp_path, LENSES[lens])
    one = tab(at)
    one.somebody()
    left, top, wide, high = image_box(one)
    off, moved = [], 0
    for _ in range(3 * DRAGS):
        if moved == DRAGS:
            break
        if (start := grabbed(one, rng)) is None:
            continue
        goal = np.array([left, top]) + rng.uniform([0.3, 0.45], [0.7, 0.8]) * [wide, high]
        way = np.linspace(start, goal.round(), 4).round().astype(int)
        one.drag([(x, y) for x, y in way.tolist()])
        one.settled()
        now = one.evaluate(
            f"editor.stage.placeOf(point.clone().applyMatrix4(was.invert()).applyMatrix4({POSE}))"
        )
        off.append(float(np.hypot(*(np.array(now) - way[-1]))))
        moved += 1
    print(f"{lens}: {moved} drags, at most {max(off):.2e} px off")
    assert moved == DRAGS
    assert max(off) < 0.5
    assert one.complaints() == []


@pytest.mark.parametrize("lens", LENSES)
def test_two_fingers_turn_and_grow_on_every_lens(
    tab: Callable[..., Tab], tmp_path: Path, lens: str
) -> None:
    """By what the fingers say on the ground, from rays of the camera alone."""
    rng = np.random.default_rng(12)
    at = desk(tmp_path, LENSES[lens])
    one = tab(at, 390, 844)
    one.somebody()
    for _ in range(PINCHES):
        x, y = one.place(0.05).round().astype(int).tolist()
        before = stands(at, "Person", 0)
        seen = np.array([(x - 30, y), (x + 30, y)])
        ends = seen + rng.integers(-14, 15, (2, 2))
        way = np.linspace(seen, ends, 5).round().astype(int).tolist()
        one.fingers([[(u, v) for u, v in places] for places in way])
        one.settled()
        ground = []
        for pairs in (seen, ends):
            pixels = [one.evaluate(f"editor.pixelAt({u}, {v})") for u, v in pairs.tolist()]
            origin, rays = at.filmed.rays(0, pixels)
            ground.append([origin - origin[2] / ray[2] * ray for ray in rays])
        ways = [complex(*(second - first)[:2]) for first, second in ground]
        done = stands(at, "Person", 0) @ before.inverse()
        np.testing.assert_allclose(float(done.scale), abs(ways[1] / ways[0]), rtol=1e-3)
        turned = np.degrees(done.rotor.as_rotation_vector()[2] - np.angle(ways[1] / ways[0]))
        assert abs((turned + 180.0) % 360.0 - 180.0) < 0.1
        one.press("Undo")
        one.settled()
    assert one.complaints() == []


def test_a_drag_above_the_horizon_is_refused(tab: Callable[..., Tab], tmp_path: Path) -> None:
    """What is dragged stays where the finger last pointed at the ground."""
    at = desk(tmp_path, WIDE)
    one = tab(at)
    one.somebody()
    x, y = one.place(0.4).round().astype(int).tolist()
    left, top, wide, _ = image_box(one)
    # Near the upper edge: far more up from the axis than the camera looks down.
    sky = (round(left + 0.49 * wide), round(top + 8))
    _, rays = at.filmed.rays(0, [one.evaluate(f"editor.pixelAt({sky[0]}, {sky[1]})")])
    assert rays[0][2] > 0.0
    one.drag([(x, y), (x + 10, y - 10), sky])
    one.settled()
    assert np.abs(stands(at, "Person", 0).translation_m).max() < 10.0
    assert one.complaints() == []


def test_the_gimbal_table_comes_out_of_the_page(tab: Callable[..., Tab], tmp_path: Path) -> None:
    """Rotors end where they were dragged; Euler angles where the library's table says."""
    at = desk(tmp_path)
    made = list(dragged_rings(tab(at), at))
    assert len(made) == 9
    for row in made:
        assert abs(row.asked_deg) > 5.0
        assert row.rotor_off_deg < 1e-9
        told = {one.axis: one for one in gimbal_rows([row.pitch_deg], row.asked_deg)}
        assert row.euler_off_deg == pytest.approx(told[row.axis].euler_off_deg, abs=1e-4)
        if row.axis == "x":
            assert row.euler_off_deg > abs(row.asked_deg)
