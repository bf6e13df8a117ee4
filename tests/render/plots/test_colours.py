"""Lines can be told apart by everybody, on light pages and on dark ones."""

import re
from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.color import deltaE_ciede2000, rgb2lab

from motorcade.render.plots.style import AXIS_COLOURS, COLOURS, HUES, ON_PAGES, page_colours
from motorcade.replays.web.pages import page_environment

# G. M. Machado, M. M. Oliveira and L. A. F. Fernandes, A physiologically-based model for simulation
# of color vision deficiency, IEEE TVCG 15(6), 2009: severity 1, on linear RGB.
SEEN_BY = {
    "everybody": np.eye(3),
    "protanopes": np.array([
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ]),
    "deuteranopes": np.array([
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]),
    "tritanopes": np.array([
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ]),
}  # fmt: skip
REPORT = (
    "measured",
    "fused",
    "motor",
    "quaternion",
    "euler_best",
    "euler_unwrapped",
    "euler",
    "truth",
)
COMPARISON = (
    "truth",
    "motor",
    "similarity",
    "rotor",
    "dual_quaternion",
    "quaternion",
    "euler",
    "euler_best",
    "euler_unwrapped",
)
CONSISTENCY = ("motor", "quaternion", "euler", "euler_exact")
GROUNDS = ("light", "dark")


def rgb(code: str) -> NDArray[np.float64]:
    return np.array([int(code[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])


def linear(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def encoded(light: NDArray[np.float64]) -> NDArray[np.float64]:
    light = np.clip(light, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def contrast(one: str, other: str) -> float:
    """WCAG 2.1, relative luminance."""
    a, b = (float(linear(rgb(code)) @ [0.2126, 0.7152, 0.0722]) + 0.05 for code in (one, other))
    return max(a, b) / min(a, b)


def seen(code: str, by: str) -> NDArray[np.float64]:
    return rgb2lab(encoded(SEEN_BY[by] @ linear(rgb(code))))


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, str]]:
    """What CSS variables are on light and on dark pages, read from a page."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "page.html").write_text('{% extends "base.html" %}')
    css = page_environment(folder).get_template("page.html").render()
    blocks = re.findall(r"(@media[^{]*\{\s*)?:root ?\{(.*?)\}", css, re.DOTALL)
    found = [
        dict(re.findall(r"--([a-z-]+): ?(#[0-9a-f]{6})", " ".join(texts)))
        for texts in (
            [text for media, text in blocks if not media],
            [text for media, text in blocks if "dark" in media],
        )
    ]
    return dict(zip(GROUNDS, found, strict=True))


def shade(name: str, variables: dict[str, str]) -> str:
    return variables[ON_PAGES[name].removeprefix("var(--").removesuffix(")")]


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("name", [*COLOURS, "x", "y", "z"])
def test_every_line_stands_out_from_the_page(name, ground, pages):
    variables = pages[ground]
    for paper in ("page", "card"):
        at_least = 3.0 if paper == "page" else 2.85
        assert contrast(shade(name, variables), variables[paper]) >= at_least


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("by", SEEN_BY)
@pytest.mark.parametrize("names", [REPORT, COMPARISON, CONSISTENCY, ("x", "y", "z")])
def test_lines_of_one_plot_differ_to_all_eyes(names, by, ground, pages):
    shades = {name: seen(shade(name, pages[ground]), by) for name in names}
    for one, other in combinations(names, 2):
        assert deltaE_ciede2000(shades[one], shades[other]) >= 12.0, (one, other)


def test_the_eyes_are_what_they_should_be():
    """Greys stay as they are for all; red and green of one lightness meet for deuteranopes."""
    for by, matrix in SEEN_BY.items():
        np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-5, err_msg=by)
    red, green = "#b6540f", "#776d00"
    assert deltaE_ciede2000(seen(red, "everybody"), seen(green, "everybody")) > 25.0
    assert deltaE_ciede2000(seen(red, "deuteranopes"), seen(green, "deuteranopes")) < 15.0


def test_the_plots_shades_are_those_of_light_pages():
    assert {COLOURS[name] for name in COLOURS if name != "truth"} <= {
        one for one, _ in HUES.values()
    }
    assert set(AXIS_COLOURS) <= {light for light, _ in HUES.values()}
    assert len({light for light, _ in HUES.values()}) == len(HUES)
    for hue, (light, dark) in HUES.items():
        assert f"--line-{hue}:{light}" in page_colours()
        assert f"--line-{hue}:{dark}" in page_colours()
