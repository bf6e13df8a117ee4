"""The script that turns an image in the browser draws what Python draws."""

import json
import re
import shutil
import subprocess
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.ga.algebra import conformal
from motorcade.ga.drawing import Drawing, Styled, show, svg
from motorcade.ga.drawing.view import View

NODE = shutil.which("node")
SCRIPT = Path(svg.__file__).parent / "turning.js"
VIEWS = [View(), View(213.0, -41.0, 500, 300), View(10.0, 90.0), View(-77.0, 3.0, 400, 700)]

pytestmark = pytest.mark.skipif(NODE is None, reason="no node here")


def image() -> Drawing:
    ball, ground = conformal.sphere([0, 0, 1], 1.0), conformal.plane([0, 0, 1], 0.6)
    line = conformal.line_through([-1, -1, 0], [1, 1, 1.6])
    far = conformal.meet(conformal.sphere([4, 0, 0], 1.0), conformal.sphere([7, 0, 0], 1.0))
    path = Motor.identity().interpolate(
        Motor.from_translation([2.0, 1.0, 0.0]), np.linspace(0, 1, 9)
    )
    dots = np.random.default_rng(4).uniform(-2.0, 3.0, (150, 3))
    return show(
        dots,
        Styled(ball, "<ball> & 'co' \x01", "red"), conformal.sphere([2, 2, 0], 0.7), ground=ground,
        circle=conformal.meet(ball, ground), line=line, pair=conformal.meet(ball, line),
        far=far, path=path,
        long_name_of_a_point_that_is_cut_off_somewhere=conformal.point([1, 2, 0.5]),
    )  # fmt: skip


def in_node(drawing: Drawing) -> str:
    marks, projection = drawing._placed()
    told = json.dumps(svg.scene(marks, projection))
    use = "process.stdout.write(drawnElements(JSON.parse(require('fs').readFileSync(0)), 'own'));"
    done = subprocess.run(
        ["node", "-e", SCRIPT.read_text(encoding="utf-8") + use],
        input=told, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout


def pieces(text: str) -> Counter[tuple[str, ...]]:
    """Every piece of a path, circle or text with how it looks, its places in steps of pixels."""
    found: Counter[tuple[str, ...]] = Counter()
    for tag, attributes in re.findall(r"<(path|circle|text)([^>]*)>", text):
        given = dict(re.findall(r' ([\w-]+)="([^"]*)"', attributes))
        looks = [f"{k}={v}" for k, v in given.items() if k not in ("d", "cx", "cy", "r", "x", "y")]
        for part in given.get("d", "one").split("M")[-1 if tag != "path" else 1 :]:
            count = str(part.count(" "))
            found[tag, count, *looks] += 1
    return found


def places(text: str) -> np.ndarray:
    numbers = [
        [float(x) for x in re.findall(r"-?\d+\.?\d*", part)]
        for d in re.findall(r' d="M([^"]*)"', text)
        for part in d.split("M")
    ]
    return np.array(sorted([np.mean(n[::2]), np.mean(n[1::2])] for n in numbers))


def halves_before(text: str) -> np.ndarray:
    """For each dot its place, and how many halves of balls are drawn before it."""
    rows, halves = [], 0
    for x, y, rest in re.findall(r'<circle cx="(\S+)" cy="(\S+)"([^>]*)', text):
        if "url(" in rest or 'opacity="0.1"' in rest:
            halves += 1
        else:
            rows.append([float(x), float(y), halves])
    return np.array(rows)


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_the_browser_draws_what_python_draws(view: View) -> None:
    drawing = replace(image(), view=view)
    marks, projection = drawing._placed()
    mine = svg.elements(marks, projection).replace("url(#", "url(#own-")
    theirs = in_node(drawing)
    assert pieces(theirs) == pieces(mine)
    mine_halves, theirs_halves = halves_before(mine), halves_before(theirs)
    assert len(set(mine_halves[:, 2])) >= 4, "dots before, inside and behind both balls"
    for x, y, halves in mine_halves:
        off = np.abs(theirs_halves[:, :2] - [x, y]).max(axis=1)
        assert halves in theirs_halves[off <= 0.21, 2]
    texts = [re.findall(r">([^<>]+)</text>", text) for text in (mine, theirs)]
    assert texts[0] == texts[1]
    ends = [
        np.array(re.findall(r'<text x="(\S+)" y="(\S+)"', text), float) for text in (mine, theirs)
    ]
    np.testing.assert_allclose(ends[0], ends[1], atol=0.21)
    circle = r'cx="(\S+)" cy="(\S+)" r="(\S+)"'
    rings = [np.array(re.findall(circle, text), float) for text in (mine, theirs)]
    apart = np.abs(rings[0][:, None] - rings[1]).max(axis=2)
    assert apart.min(axis=1).max() <= 0.21
    assert apart.min(axis=0).max() <= 0.21
    assert np.abs(places(mine).sum(axis=0) - places(theirs).sum(axis=0)).max() < 5.0


def test_a_turned_image_is_the_one_of_that_view() -> None:
    front = in_node(replace(image(), view=View(0.0, 0.0)))
    assert pieces(front) != pieces("")
    assert front != in_node(replace(image(), view=View(1.0, 0.0)))
