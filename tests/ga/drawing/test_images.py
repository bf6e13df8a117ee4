"""Images: where things come to lie, in which order, and that no name breaks them."""

import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import motorcade.ga
from motorcade.ga import CGA3, Motor
from motorcade.ga.algebra import conformal
from motorcade.ga.drawing import Styled, show
from motorcade.ga.drawing.mark import BallMark, Dot, Face, Label, Mark, Stroke
from motorcade.ga.drawing.svg import LONGEST_NAME
from motorcade.ga.drawing.view import MARGIN, View, placed, projection_of

SPACE = "{http://www.w3.org/2000/svg}"
VIEWS = [View(), View(200.0, -35.0, 500, 300), View(0.0, 90.0), View(90.0, 0.0, 300, 600)]


def turned(points: np.ndarray, view: View) -> np.ndarray:
    """Right, up and towards the viewer, by two turns that bring the viewer onto the x axis."""
    turn = Rotation.from_euler("zy", [-view.azimuth_deg, view.elevation_deg], degrees=True)
    return turn.apply(points)[:, [1, 2, 0]]


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_marks_are_projected_and_fill_the_image(view: View) -> None:
    rng = np.random.default_rng(7)
    points = 10.0 + 3.0 * rng.normal(size=(40, 3))
    marks: list[Mark] = [Dot(point, "blue") for point in points]
    projection = projection_of(view, marks)
    made, space = projection.place(points), turned(points, view)
    size = np.array([view.width, view.height])
    scale = np.min((size - 2 * MARGIN) / np.ptp(space[:, :2], axis=0))
    assert projection.scale == pytest.approx(scale)
    middle = (space.min(axis=0) + space.max(axis=0)) / 2
    expected = size / 2 + scale * (space - middle)[:, :2] * [1.0, -1.0]
    np.testing.assert_allclose(made[:, :2], expected, atol=1e-9)
    assert np.argsort(made[:, 2]).tolist() == np.argsort(space[:, 2]).tolist()
    assert made[:, :2].min() >= MARGIN - 1e-9
    assert np.all(made[:, :2] <= size - MARGIN + 1e-9)


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_the_outline_of_a_ball_is_that_of_its_points(view: View) -> None:
    rng = np.random.default_rng(3)
    center = np.array([1.0, -2.0, 0.5])
    projection = projection_of(view, [BallMark(center, 1.5, "blue"), Dot(np.zeros(3), "red")])
    surface = rng.normal(size=(20000, 3))
    surface = center + 1.5 * surface / np.linalg.norm(surface, axis=1, keepdims=True)
    middle = projection.place(center[None])[0, :2]
    reach = np.linalg.norm(projection.place(surface)[:, :2] - middle, axis=1).max()
    assert reach == pytest.approx(1.5 * projection.scale, rel=1e-3)


def test_what_is_inside_a_ball_comes_between_its_halves_and_the_rest_before_or_behind() -> None:
    rng = np.random.default_rng(11)
    view, marks = View(35.0, 20.0), []
    balls = [
        BallMark(np.array([0.0, 0.0, 0.0]), 1.0, "blue"),
        BallMark(np.array([3.0, 1.0, 0.0]), 0.7, "red"),
    ]
    dots = [Dot(point, "green") for point in rng.uniform(-2.0, 4.0, (400, 3))]
    marks = [*balls, *dots]
    order = placed(list(marks), projection_of(view, list(marks)))
    at = {(id(one.mark), one.near): i for i, one in enumerate(order)}
    seen = {"before": 0, "inside": 0, "behind": 0}
    for ball in balls:
        far, near = at[id(ball), False], at[id(ball), True]
        (middle,) = turned(ball.center[None], view)
        for dot in dots:
            off = turned(dot.point[None], view)[0] - middle
            on_surface = abs(np.linalg.norm(off) - ball.radius) < 0.15 * ball.radius
            if np.hypot(off[0], off[1]) >= ball.radius or on_surface:
                continue
            place = at[id(dot), False]
            if np.linalg.norm(off) < ball.radius:
                kind, right = "inside", far < place < near
            elif off[2] > 0:
                kind, right = "before", place > near
            else:
                kind, right = "behind", place < far
            seen[kind] += 1
            assert right, (kind, off)
    assert min(seen.values()) >= 5


def test_without_balls_far_marks_come_first() -> None:
    rng = np.random.default_rng(2)
    marks: list[Mark] = [
        Stroke(rng.normal(size=(2, 3)), "blue")
        if k % 2
        else Face(rng.normal(size=(4, 3)), "red", 0.3, 0)
        for k in range(60)
    ]
    order = placed(marks, projection_of(VIEWS[1], marks))
    depths = [turned(one.mark.points, VIEWS[1])[:, 2].mean() for one in order]  # type: ignore[union-attr]
    assert depths == sorted(depths)


def scene() -> Any:
    ball, ground = conformal.sphere([0, 0, 1], 1.0), conformal.plane([0, 0, 1], 0.6)
    line = conformal.line_through([-1, -1, 0], [1, 1, 1.6])
    path = Motor.identity().interpolate(
        Motor.from_translation([2.0, 1.0, 0.0]), np.linspace(0, 1, 9)
    )
    return show(
        Styled(ball, "ball", "red"), ground=ground, circle=conformal.meet(ball, ground), line=line,
        pair=conformal.meet(ball, line), at=conformal.point([1, 2, 0.5]), path=path,
    )  # fmt: skip


def test_everything_has_its_name_and_nothing_is_cut_off() -> None:
    image = scene()
    assert repr(image) == (
        "Drawing(ball: sphere, ground: plane, circle: circle, line: line, pair: point pair, "
        "at: point, path: path)"
    )
    root = ET.fromstring(image.svg())
    texts = {text.text for text in root.iter(f"{SPACE}text")}
    assert {"ball", "ground", "circle", "line", "pair", "at", "path", "x", "y", "z"} <= texts
    for element in root.iter():
        numbers = [float(x) for x in re.findall(r"-?[\d.]+", element.get("d", ""))]
        across, down = numbers[::2], numbers[1::2]
        assert all(0.0 <= x <= 640.0 for x in across)
        assert all(0.0 <= y <= 480.0 for y in down)


def test_names_keep_clear_of_each_other() -> None:
    root = ET.fromstring(scene().svg())
    boxes = [
        (float(t.get("x", "")), float(t.get("y", "")) - 11.5, 7.4 * len(t.text or ""), 15.0)
        for t in root.iter(f"{SPACE}text")
    ]
    for i, (x, y, w, h) in enumerate(boxes):
        assert 0.0 <= x <= 640.0 - w
        assert 0.0 <= y <= 480.0 - h
        for x2, y2, w2, h2 in boxes[:i]:
            apart = x + w < x2 + 0.2 or x2 + w2 < x + 0.2 or y + h < y2 + 0.2 or y2 + h2 < y + 0.2
            assert apart


def test_the_same_objects_give_the_same_bytes() -> None:
    assert scene().svg() == scene().svg()
    assert scene().html() == scene().html()


HOSTILE = [
    "</script><script>alert(1)</script>", '"><img src=x onerror=alert(1)>',
    "a & b < c > d \"e' ]]>",
    "\x00\x07\x1f\ufffe\ud800", "名前 ∞ 🙂", "x" * 500, "</title></svg>", "url(#m) {} \\u003c",
]  # fmt: skip


class Tags(HTMLParser):
    """The elements of a page in order, and the text of its scripts."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[str] = []
        self.scripts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1] == "script" and data.strip():
            self.scripts.append(data)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_no_name_or_title_is_more_than_text(name: str) -> None:
    point = conformal.point([1.0, 2.0, 3.0])
    image = show(Styled(point, name), title=name)
    root = ET.fromstring(image.svg())
    plain = {f"{SPACE}{tag}" for tag in (
        "svg", "title", "style", "defs", "radialGradient", "stop", "rect", "g", "path", "circle",
        "text",
    )}  # fmt: skip
    assert {element.tag for element in root.iter()} <= plain
    shown = next(root.iter(f"{SPACE}text")).text
    short = name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"
    bad = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff\ud800-\udfff]")
    assert shown == bad.sub("\ufffd", short)
    page = Tags()
    page.feed(image.html())
    assert page.tags.count("script") == 2
    assert "img" not in page.tags
    assert not [attribute for attribute in page.attributes if attribute.startswith("on")]
    assert not {"src", "href", "style"} & set(page.attributes)
    marks = json.loads(page.scripts[0])["marks"]
    assert name in [mark[3] for mark in marks if mark[0] == "name"]


def test_a_page_asks_nothing_of_anywhere() -> None:
    html = scene().html()
    assert set(re.findall(r"https?://[^\s\"'<]+", html)) == {"http://www.w3.org/2000/svg"}
    assert not re.search(r"\b(fetch|import|XMLHttpRequest|WebSocket|eval)\b", html)


def test_colours_and_forms(tmp_path: Path) -> None:
    outer = conformal.sphere([0, 0, 0], 1.0).undual()
    image = show(Styled(outer, "s", "Green", "outer"), show_me=conformal.point([2, 0, 0]))
    assert [one.color for one in image.objects] == ["green", "blue"]
    assert repr(show(outer, form="outer")) == "Drawing(sphere)"
    with pytest.raises(ValueError, match=r"color: expected blue, .*black, got 'pink'"):
        show(Styled(outer, "s", "pink", "outer"))
    with pytest.raises(ValueError, match="show: ball: it is the number 2"):
        show(ball=CGA3.scalar(2.0))
    with pytest.raises(ValueError, match="show: object 0: expected multivectors"):
        show("text")
    with pytest.raises(ValueError, match="show: expected at least one object, got none"):
        show()
    for suffix, start in ((".svg", "<svg "), (".html", "<!doctype html>")):
        image.save(tmp_path / f"image{suffix}")
        assert (tmp_path / f"image{suffix}").read_text().startswith(start)
    with pytest.raises(ValueError, match=r"expected a name that ends in \.svg or \.html"):
        image.save(tmp_path / "image.png")


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e6, 1e9])
def test_images_of_any_size(size: float) -> None:
    at = [size, 2 * size, -size]
    image = show(ball=conformal.sphere(at, size), p=conformal.point([0.0, 0.0, 0.0]))
    (circle,) = [
        c for c in ET.fromstring(image.svg()).iter(f"{SPACE}circle") if "url" in c.get("fill", "")
    ]
    assert 40.0 < float(circle.get("r", "")) < 240.0


def test_one_point_far_away_is_an_image() -> None:
    root = ET.fromstring(show(p=conformal.point([1000.0, -500.0, 20.0])).svg())
    assert "p" in {text.text for text in root.iter(f"{SPACE}text")}


def test_plane_images_look_down_on_it() -> None:
    image = show(np.array([[0.0, 0.0], [2.0, 1.0]]))
    assert image.view.flat
    texts = {text.text for text in ET.fromstring(image.svg()).iter(f"{SPACE}text")}
    assert "z" not in texts
    assert {"x", "y", "1", "2"} <= texts
    assert not show(np.array([[0.0, 0.0, 1.0]])).view.flat


def test_names_that_fit_nowhere_stand_inside_all_the_same() -> None:
    names: list[Mark] = [Label("n" * 30, np.zeros((1, 3)), "black") for _ in range(3)]
    from motorcade.ga.drawing.svg import elements

    view = View(width=240, height=100, flat=True)
    text = elements(
        [Dot(np.zeros(3), "blue"), *names], projection_of(view, [Dot(np.zeros(3), "blue")])
    )
    places = [float(x) for x in re.findall(r'<text x="([-\d.]+)"', text)]
    assert len(places) == 3
    assert all(0.0 <= x <= 240.0 - 30 * 7.4 for x in places)


def test_show_is_a_name_of_the_room_and_costs_nothing_before_it_is_called() -> None:
    use = (
        "import sys, motorcade.ga as ga\n"
        "assert 'show' in ga.__all__\n"
        "assert not any(name.startswith('motorcade.ga.drawing') for name in sys.modules)\n"
        "from motorcade.ga.drawing import show as same\n"
        "pose = ga.Motor.from_translation([1.0, 2.0, 3.0])\n"
        "assert ga.show(pose=pose, title='it').svg() == same(pose=pose, title='it').svg()\n"
    )
    subprocess.run([sys.executable, "-c", use], check=True)
    for name in ("title", "view", "form"):
        assert signature(motorcade.ga.show).parameters[name] == signature(show).parameters[name]
