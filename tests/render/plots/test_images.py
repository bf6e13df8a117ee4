"""Plots show the figures that they were given: lines are read back from the SVG by its ticks."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render.plots import (
    Band,
    plot_allan,
    plot_bands,
    plot_path_3d,
    plot_plan_and_elevation,
    plot_rotation_and_twist,
    plot_series,
    plot_squares,
    plot_within_sigma,
    standing_alone,
)
from motorcade.render.plots.style import thinned, with_own_ids
from motorcade.render.plots.trajectories import rotation_vectors_rad, twists
from tests.bench.timing_bars import Timing, plot_timings

SVG = "{http://www.w3.org/2000/svg}"
LINK = "{http://www.w3.org/1999/xlink}"
Points = NDArray[np.float64]


@dataclass
class Axis:
    """One direction of axes: from points on the page to values, by the ticks that have a label."""

    slope: float
    start: float
    logarithmic: bool

    @classmethod
    def read(cls, axes: ElementTree.Element, side: int, logarithmic: bool = False) -> "Axis":
        at, values = [], []
        for tick in axes.iter(f"{SVG}g"):
            if tick.get("id", "").startswith(f"{'xy'[side]}tick"):
                texts = [text.text for text in tick.iter(f"{SVG}text") if text.text]
                grid = tick.find(f".//{SVG}path")
                if texts and grid is not None and len(points(grid.get("d"))) == 2:
                    at.append(points(grid.get("d"))[0, side])
                    values.append(float(texts[0].replace("−", "-")))
        fit = np.polyfit(at, np.log(values) if logarithmic else values, 1)
        return cls(float(fit[0]), float(fit[1]), logarithmic)

    def value(self, at: Points) -> Points:
        found = self.slope * at + self.start
        return np.exp(found) if self.logarithmic else found


def points(path: str) -> Points:
    """Corners of a path, in order; strokes of no length once."""
    # After the two numbers of an M or L come further corners without a letter (SVG 1.1, 8.3.3).
    assert re.fullmatch(r"[MLCQz\s\d.e+-]*", path), "only absolute strokes are written"
    corners: list[list[float]] = []
    for letter, numbers in re.findall(r"([MLCQz])([^MLCQz]*)", path):
        values = [float(number) for number in numbers.split()]
        if letter in "ML":
            corners += [values[at : at + 2] for at in range(0, len(values), 2)]
    return np.array(corners)


def panels(svg: str) -> list[ElementTree.Element]:
    root = ElementTree.fromstring(svg)
    return [g for g in root.iter(f"{SVG}g") if re.fullmatch(r"axes_\d+", g.get("id", ""))]


def strokes(axes: ElementTree.Element, colour: str) -> list[Points]:
    """Paths that are drawn and not filled, of a colour, in points on the page."""
    return [
        points(path.get("d"))
        for path in axes.iter(f"{SVG}path")
        if "fill: none" in path.get("style", "") and f"stroke: var({colour})" in path.get("style")
    ]


def tints(axes: ElementTree.Element) -> list[Points]:
    """Outlines of filled bands, which are defined in one place and used in another."""
    outlines = {one.get("id"): points(one.get("d", "")) for one in axes.iter(f"{SVG}path")}
    return [
        outlines[use.get(f"{LINK}href", "")[1:]] + [float(use.get("x")), float(use.get("y"))]
        for use in axes.iter(f"{SVG}use")
        if "opacity" in use.get("style", "")
    ]


def shown(axes: ElementTree.Element, colour: str, log: bool = True) -> tuple[Points, Points]:
    """What the one line of a colour says: across and up."""
    (line,) = strokes(axes, colour)
    return Axis.read(axes, 0).value(line[:, 0]), Axis.read(axes, 1, log).value(line[:, 1])


def path(count: int = 60) -> Trajectory:
    time_ns = (np.arange(count) * 5e7).astype(np.int64)
    t = time_ns * 1e-9
    turn = np.stack([2.5 * t, 0.2 * np.sin(3 * t), 0.1 * np.cos(t)], axis=-1)
    place = np.stack([np.sin(t), np.cos(2.0 * t), 0.1 * t], axis=-1)
    return Trajectory(
        time_ns, Motor.from_rotor_translation(Rotor.from_rotation_vector(turn), place)
    )


NAMES = ("series", "bands", "sigma", "squares", "timings", "paths", "space", "motion", "allan")


def all_plots(rng: np.random.Generator) -> dict[str, str]:
    time_s = np.linspace(0.0, 5.0, 80)
    line = np.exp(rng.normal(size=80))
    tau = np.geomspace(0.1, 100.0, 12)
    three = np.exp(rng.normal(size=(12, 3)))
    return {
        "series": plot_series({"motor": (time_s, line)}, "a", "error (mm)", log_scale=True),
        "bands": plot_bands({"motor": Band(time_s, line, 2 * line, 3 * line)}, "b", "error (°)"),
        "sigma": plot_within_sigma(time_s, rng.normal(size=(80, 3)), np.ones((80, 3)), "c", "mm"),
        "squares": plot_squares({"motor": (time_s, line)}, 6.0, (1.2, 14.4), "d", "NEES"),
        "timings": plot_timings([Timing("a job", 3.0, 4.0)], "a rival", "e", "ns"),
        "paths": plot_plan_and_elevation({"motor": path()}),
        "space": plot_path_3d({"motor": path(), "truth": path()}),
        "motion": plot_rotation_and_twist(path()),
        "allan": plot_allan({"gyroscope": (tau, three, three)}, {"gyroscope": "rad/s"}),
    }


@pytest.fixture(scope="module")
def plots() -> dict[str, str]:
    return all_plots(np.random.default_rng(3))


@pytest.mark.parametrize("logarithmic", [False, True])
def test_lines_are_the_figures_given(logarithmic, rng):
    time_s, values = np.linspace(2.0, 7.0, 50), np.exp(2.0 * rng.normal(size=50))
    svg = plot_series({"quaternion": (time_s, values)}, "", "m", log_scale=logarithmic)
    (axes,) = panels(svg)
    across, up = shown(axes, "--line-orange", logarithmic)
    np.testing.assert_allclose(across, time_s, atol=2e-3)
    if logarithmic:
        np.testing.assert_allclose(up, values, rtol=3e-3)
    else:
        np.testing.assert_allclose(up, values, atol=1e-3 * np.ptp(values))


def test_squares_of_one_run_are_dots_at_their_places(rng):
    time_s, squares = np.linspace(0.0, 4.0, 300), rng.chisquare(6, 300)
    svg = plot_squares({"fused": (time_s, squares)}, 6.0, (1.24, 14.45), "", "NIS", dots=True)
    (axes,) = panels(svg)
    across, up = shown(axes, "--line-sky")
    np.testing.assert_allclose(across[::2], time_s, atol=2e-3)
    np.testing.assert_allclose(up[::2], squares, rtol=5e-3)
    (expected,) = strokes(axes, "--ink")
    np.testing.assert_allclose(Axis.read(axes, 1, True).value(expected[:, 1]), 6.0, rtol=5e-3)
    band = next(
        points(one.get("d")) for one in axes.iter(f"{SVG}path") if "999999" in one.get("style", "")
    )
    ends = Axis.read(axes, 1, True).value(np.unique(band[:, 1]))
    np.testing.assert_allclose(sorted(ends), (1.24, 14.45), rtol=5e-3)


def test_bands_reach_from_low_to_high(rng):
    time_s = np.linspace(0.0, 9.0, 40)
    middle = np.exp(rng.normal(size=40))
    svg = plot_bands({"euler": Band(time_s, 0.3 * middle, middle, 4.0 * middle)}, "", "°")
    (axes,) = panels(svg)
    up = Axis.read(axes, 1, True)
    np.testing.assert_allclose(shown(axes, "--line-vermilion")[1], middle, rtol=5e-3)
    (tint,) = tints(axes)
    np.testing.assert_allclose(up.value(tint[:, 1].max()), 0.3 * middle.min(), rtol=5e-3)
    np.testing.assert_allclose(up.value(tint[:, 1].min()), 4.0 * middle.max(), rtol=5e-3)


def test_errors_stand_in_their_deviations(rng):
    time_s = np.linspace(0.0, 3.0, 70)
    errors, sigma = rng.normal(size=(70, 3)), np.full((70, 3), (0.5, 1.0, 2.0))
    svg = plot_within_sigma(time_s, errors, sigma, "", "mm")
    for column, (axes, colour) in enumerate(
        zip(panels(svg), ("--line-vermilion", "--line-green", "--line-blue"), strict=True)
    ):
        up = Axis.read(axes, 1)
        (line,) = strokes(axes, colour)
        np.testing.assert_allclose(up.value(line[:, 1]), errors[:, column], atol=0.02)
        reach = [np.abs(up.value(tint[:, 1])).max() for tint in tints(axes)]
        np.testing.assert_allclose(
            sorted(reach), [sigma[0, column], 2 * sigma[0, column]], rtol=0.02
        )


def test_bars_are_as_long_as_their_figures():
    timings = [Timing("one", 5.0, 25.3), Timing("two", 1.5, 2.7), Timing("three", 80.0)]
    (axes,) = panels(plot_timings(timings, "a rival", "", "ns a joint"))
    across = Axis.read(axes, 0)
    bars = [
        points(one.get("d"))
        for one in axes.iter(f"{SVG}path")
        if "fill: var(--line-green)" in one.get("style", "")
    ]
    np.testing.assert_allclose(
        [across.value(bar[:, 0].max()) for bar in bars], [5.0, 1.5, 80.0], rtol=1e-2
    )
    assert all(abs(float(across.value(bar[:, 0].min()))) < 0.1 for bar in bars)
    marks = [float(across.value(mark[0, 0])) for mark in strokes(axes, "--ink")]
    np.testing.assert_allclose(marks, [25.3, 2.7], rtol=1e-2)


def test_turns_of_more_than_half_go_on():
    """4.9 rad about x over the path, which scipy tells as less than π the other way."""
    one = path(40)
    found = rotation_vectors_rad(one)
    turns = Rotation.from_quat(one.motors.rotor.as_quaternion(), scalar_first=True)
    since = (turns[0].inv() * turns).as_rotvec()
    np.testing.assert_allclose(
        np.exp(1j * np.linalg.norm(found, axis=-1)).real,
        np.cos(np.linalg.norm(since, axis=-1)),
        atol=1e-9,
    )
    assert np.abs(np.diff(found, axis=0)).max() < 0.2
    assert found[-1, 0] > 4.5
    np.testing.assert_allclose(
        Rotation.from_rotvec(found).as_matrix(), Rotation.from_rotvec(since).as_matrix(), atol=1e-9
    )


def test_the_twist_carries_each_pose_to_the_next():
    one = path()
    middles_s, twist = twists(one)
    step_s = np.diff(one.time_s)
    again = one.motors[:-1] @ Motor.from_twist(twist * step_s[:, None])
    np.testing.assert_allclose(again.as_matrix(), one.motors[1:].as_matrix(), atol=1e-12)
    np.testing.assert_allclose(np.diff(middles_s), step_s[1:])
    turned, turning, speed = panels(plot_rotation_and_twist(one, int(one.time_ns[0]) - 10**9))
    across = Axis.read(speed, 0)
    for axes, values, at_s in (
        (turned, np.rad2deg(rotation_vectors_rad(one)), one.time_s),
        (turning, np.rad2deg(twist[:, :3]), middles_s),
        (speed, twist[:, 3:], middles_s),
    ):
        (line,) = strokes(axes, "--line-vermilion")
        drawn = Axis.read(axes, 1).value(line[:, 1])
        np.testing.assert_allclose(
            drawn,
            np.interp(across.value(line[:, 0]) - 1.0, at_s, values[:, 0]),
            atol=8e-3 * np.ptp(values),
        )


def test_the_path_in_space_is_the_path_seen_from_one_side():
    """Affine in x, y and z, with z up."""
    one = path()
    svg = plot_path_3d({"motor": one})
    (axes,) = panels(svg)
    place = one.poses.translation_m
    shape = np.column_stack([place, np.ones(len(place))])
    lines = [line for line in strokes(axes, "--line-green") if len(line) == len(place)]
    fits = [np.linalg.lstsq(shape, line, rcond=None)[0] for line in lines]
    for fit, line in zip(fits, lines, strict=True):
        np.testing.assert_allclose(shape @ fit, line, atol=0.02)
    upward, flat = sorted(float(fit[2, 1]) for fit in fits)
    assert upward < -10.0
    assert abs(flat) < 0.1, "the shadow on the ground"
    assert len(strokes(axes, "--line-green")) == 2 + 9, "cameras"


@pytest.mark.parametrize("stretch", [(1, 1, 9), (9, 1, 1), (1, 9, 1), (3, 3, 1)])
def test_the_path_in_space_fits_with_its_cameras_and_its_shadow(stretch):
    time_ns = (np.arange(40) * 5e7).astype(np.int64)
    place = np.linspace(-1.0, 1.0, 40)[:, None] * np.array(stretch, np.float64)
    looking = Rotor.from_rotation_vector(np.linspace([0.0, 0.0, 0.0], [3.0, 1.0, 0.0], 40))
    one = Trajectory(time_ns, Motor.from_rotor_translation(looking, place))
    svg = plot_path_3d({"motor": one})
    width, height = map(float, ElementTree.fromstring(svg).get("viewBox", "").split()[2:])
    (axes,) = panels(svg)
    drawn = np.concatenate(strokes(axes, "--line-green"))
    assert np.all(drawn > 0.0)
    assert np.all(drawn < [width, height])
    taken = np.ptp(drawn, axis=0) / [width, height]
    assert taken.max() > 0.5, "and is not lost in it"
    clipped = [g for g in axes.iter(f"{SVG}path") if "--line-green" in g.get("style", "")]
    assert not any("clip-path" in one.attrib for one in clipped)


@pytest.mark.parametrize("along", [0, 1])
def test_the_side_is_seen_from_where_the_path_is_long(along):
    one = path()
    place = one.poses.translation_m * 0.1
    place[:, along] = np.linspace(0.0, 5.0, len(place)) ** 2
    moved = Trajectory(one.time_ns, Motor.from_rotor_translation(one.motors.rotor, place))
    above, side = panels(plot_plan_and_elevation({"motor": moved}))
    for axes, across, up in ((above, 0, 1), (side, along, 2)):
        drawn = shown(axes, "--line-green", log=False)
        for values, column in zip(drawn, (across, up), strict=True):
            np.testing.assert_allclose(values, place[:, column], atol=0.05)


def test_lengths_are_in_the_unit_given():
    one = {"motor": path()}
    for svg, told in (
        (plot_plan_and_elevation(one, "units"), {"x (units)", "y (units)", "z (units)"}),
        (plot_path_3d(one, "units"), {"x (units)", "y (units)", "z (units)"}),
        (plot_rotation_and_twist(path(), None, "units"), {"speed (units/s)"}),
    ):
        texts = {text.text for text in ElementTree.fromstring(svg).iter(f"{SVG}text")}
        assert told <= texts
        assert not any("(m" in (text or "") for text in texts)


def test_long_lines_keep_their_ends_and_peaks(rng):
    time_s, values = np.arange(50_000) * 1e-2, rng.normal(size=50_000)
    values[31_234], values[17] = 40.0, -30.0
    at_s, kept = thinned(time_s, values)
    assert len(kept) <= 1202
    assert kept.max() == 40.0
    assert kept.min() == -30.0
    assert (at_s[0], at_s[-1]) == (time_s[0], time_s[-1])
    assert np.all(np.diff(at_s) > 0)
    np.testing.assert_array_equal(kept, values[np.rint(at_s * 100).astype(int)])
    for span in np.array_split(np.arange(50_000), 60):
        inside = (at_s >= time_s[span[0]]) & (at_s <= time_s[span[-1]])
        assert kept[inside].max() >= np.sort(values[span])[-3]


@pytest.mark.parametrize("name", NAMES)
def test_plots_can_be_read_on_a_phone_and_by_all(name, plots):
    """Letters of 8 pixels or more on 328; axes labelled with units; a label for who cannot see."""
    root = ElementTree.fromstring(plots[name])
    width = float(root.get("viewBox", "").split()[2])
    texts = [text for text in root.iter(f"{SVG}text") if text.text]
    sizes = [float(size) for size in re.findall(r"font-size: ([\d.]+)px", plots[name])]
    if name != "allan":  # a file of its own, which is looked at by itself
        assert min(sizes) * 328.0 / width >= 8.0
    labels = [text.text for text in texts if re.search(r"\(.+\)$|^N[EI]|^ns", text.text or "")]
    assert len(labels) >= 2 or name == "timings"
    assert root.get("role") == "img"
    assert root.get("aria-label")


@pytest.mark.parametrize("name", NAMES)
def test_plots_take_every_colour_from_the_page(name, plots):
    fixed = set(re.findall(r"(?:fill|stroke|stop-color): (#[0-9a-f]+)", plots[name]))
    assert fixed <= {"#999999"}
    alone = standing_alone(plots[name])
    used = set(re.findall(r"var\((--[a-z-]+)\)", alone))
    defined = set(re.findall(r"(--[a-z-]+):#", alone))
    assert used <= defined
    assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", alone)


def test_two_plots_on_one_page_share_no_id(plots):
    one, other = (with_own_ids(plots["series"], mark) for mark in ("a", "b"))
    ids = [set(re.findall(r'\bid="([^"]+)"', text)) for text in (one, other)]
    assert not ids[0] & ids[1]
    for text, known in zip((one, other), ids, strict=True):
        assert set(re.findall(r"url\(#([^)]+)\)", text)) <= known
        assert set(re.findall(r'xlink:href="#([^"]+)"', text)) <= known


def test_the_same_figures_give_the_same_bytes(plots):
    assert all_plots(np.random.default_rng(3)) == plots
    assert set(plots) == set(NAMES)
