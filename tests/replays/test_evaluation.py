"""Errors pair by pair, as a table and as an image, are those of the figures."""

from __future__ import annotations

import csv
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from motorcade.fusion.metrics import Delta, evaluate_matched, match
from motorcade.fusion.metrics.poses.pose_error import Statistics
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.replays.tasks.editing import error_image, error_rows

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def matched(rng):
    truth = MOTIONS["walk_and_look"].sampled(30.0, 8.0)
    estimates = {"near": Gaussian(0.002, 0.01), "far, far": Gaussian(0.02, 0.01)}
    return {name: match(noise.apply(truth, rng), truth, "se3") for name, noise in estimates.items()}


def texts(svg: str) -> list[str]:
    return [text.text or "" for text in ElementTree.fromstring(svg).iter(f"{SVG}text")]


def test_rows_have_every_pair_and_its_errors(matched):
    rows = list(csv.DictReader(error_rows(matched)))
    assert len(rows) == sum(len(one.pairs) for one in matched.values())
    for name, one in matched.items():
        figures = evaluate_matched(one)
        own = [row for row in rows if row["estimate"] == name]
        for column, expected in (
            ("position_error_m", figures.ape_m),
            ("rotation_error_deg", figures.rotation_deg),
        ):
            assert Statistics.of(np.array([float(row[column]) for row in own])) == expected
        assert [int(row["time_ns"]) for row in own] == one.pairs.time_ns.tolist()
        steps = np.diff([float(row["distance_m"]) for row in own])
        positions = one.pairs.reference.translation_m
        np.testing.assert_allclose(steps, np.linalg.norm(np.diff(positions, axis=0), axis=1))


def test_the_image_names_what_it_shows_and_is_the_same_each_time(matched):
    svg = error_image(matched, Delta(0.5, "m"))
    assert svg == error_image(matched, Delta(0.5, "m"))
    shown = texts(svg)
    for name in matched:
        assert shown.count(name) == 2  # in the legend, and above its map
    assert "relative position error over 0.5 m, consecutive pairs" in shown
    assert {"error (m)", "error (°)", "position error (m)"} <= set(shown)
    assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", svg)


@pytest.mark.parametrize(
    ("plane", "axes"), [("xz", ["x (m)", "z (m)"]), (None, ["x (m)", "y (m)"])]
)
def test_maps_lie_in_the_plane_that_was_asked_for_or_the_widest(matched, plane, axes):
    shown = texts(error_image(matched, Delta(), plane))
    assert [text for text in shown if re.fullmatch("[xyz] \\(m\\)", text)] == axes * len(matched)


def test_a_single_pair_and_a_path_too_short_for_the_delta_are_drawn(matched):
    one = matched["near"]
    alone = match(one.estimate[:1], one.reference)
    assert "near" in texts(error_image({"near": alone}, Delta()))
    assert "near" in texts(error_image({"near": one}, Delta(1e3, "m")))
