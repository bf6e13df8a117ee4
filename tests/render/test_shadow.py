"""Shadows on the ground, against boxes and rays computed by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.shadow import GRID, ShadowLook, ground_shade


def cube(half_m: float, bottom_m: float) -> tuple[np.ndarray, np.ndarray]:
    """A cube in small triangles, its centre above the origin."""
    steps = np.linspace(-1.0, 1.0, 25)
    u, v = np.meshgrid(steps, steps)
    grid = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    k = (np.arange(24)[:, None] * 25 + np.arange(24)).reshape(-1, 1)
    face = np.concatenate([np.hstack([k, k + 1, k + 26]), np.hstack([k, k + 26, k + 25])])
    turns = [np.roll(np.eye(3), s, axis=1) for s in range(3)]
    turns += [turn @ np.diag([-1.0, 1.0, -1.0]) for turn in turns]
    vertices = np.concatenate([grid @ turn.T for turn in turns]) * half_m
    triangles = np.concatenate([face + 625 * n for n in range(6)])
    vertices[:, 2] += bottom_m + half_m
    return vertices, triangles


def test_shadow_of_a_cube_lies_where_the_light_carries_it() -> None:
    vertices, triangles = cube(0.1, 0.4)
    light = np.array([0.6, 0.0, -0.8])
    look = ShadowLook(strength=1.0, lamp_radius_rad=0.01, contact=0.0)
    shade = ground_shade(vertices, triangles, light, 1.0, look, 1.0, 0.1)
    # centre height 0.5 m, slope 0.75: the middle of the shadow is 0.375 m along +x
    y, x = np.mgrid[:GRID, :GRID]
    middle = np.array([np.sum(shade * x), np.sum(shade * y)]) / shade.sum()
    metres = (middle + 0.5) * (2.0 / GRID) - 1.0
    np.testing.assert_allclose(metres, [0.375, 0.0], atol=0.01)
    assert shade[GRID // 2, int((0.375 + 1.0) / 2.0 * GRID)] > 0.85
    assert shade[GRID // 2, GRID // 10] == 0.0


def test_a_shadow_softens_with_height() -> None:
    light = np.array([0.0, 0.0, -1.0])
    look = ShadowLook(strength=1.0, lamp_radius_rad=0.1, contact=0.0)
    widths = []
    for bottom in (0.0, 0.3, 0.8):
        vertices, triangles = cube(0.1, bottom)
        row = ground_shade(vertices, triangles, light, 1.0, look, 1.0, 0.1)[GRID // 2]
        widths.append(np.count_nonzero((row > 0.1) & (row < 0.8)))
    assert widths[0] < widths[1] < widths[2]


def box_of_12(half_m: FloatArray) -> tuple[FloatArray, IntArray]:
    """A box on the ground of as few triangles as may be."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (0.0, 2.0)]) * half_m
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([[s[0], *s[k : k + 2]] for s in sides for k in (1, 2)])


def inside(box_half_m: FloatArray, at_m: FloatArray, towards: FloatArray) -> NDArray[np.bool_]:
    """Whether rays (D, 3) from points (N, 2) of the ground meet the box: (N, D), by its slabs."""
    start = np.append(at_m, np.zeros((len(at_m), 1)), axis=1)[:, None]
    low, high = np.array([-1, -1, 0.0]) * box_half_m, np.array([1, 1, 2.0]) * box_half_m
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = (low - start) / towards, (high - start) / towards
    enter, leave = np.minimum(one, two).max(axis=2), np.maximum(one, two).min(axis=2)
    return np.asarray(leave > np.maximum(enter, 0.0))


@pytest.mark.parametrize("half_m", [(0.1, 0.1, 0.1), (0.05, 0.2, 0.15), (0.03, 0.03, 0.3)])
def test_what_hides_the_sky_darkens_the_ground_about_it(
    rng: np.random.Generator, half_m: tuple[float, float, float]
) -> None:
    """Against rays to 4000 random points of the sky, as likely as they light the ground."""
    box = np.array(half_m)
    shade = ground_shade(
        *box_of_12(box), np.array([0, 0, -1.0]), 1.0, ShadowLook(0.0, 0.1, 1.0), 0.0, 0.1
    )
    turn, square = 2.0 * np.pi * rng.random(4000), rng.random(4000)
    level = np.sqrt(square)
    sky = np.stack([level * np.cos(turn), level * np.sin(turn), np.sqrt(1.0 - square)], axis=1)
    cells = rng.integers(int(0.35 * GRID), int(0.65 * GRID), (400, 2))
    at_m = (cells + 0.5) * (2.0 / GRID) - 1.0
    beside = np.max(np.abs(at_m) / box[:2], axis=1) > 1.0
    hidden = inside(box, at_m[beside], sky).mean(axis=1)
    found = shade[cells[beside, 1], cells[beside, 0]]
    assert hidden.max() > 0.25  # the bounds below say something
    assert np.abs(found - hidden).mean() < 0.03
    assert found.mean() == pytest.approx(hidden.mean(), rel=0.2)
    assert shade[GRID // 2, GRID // 2] > 0.8  # what stands on the ground hides all sky


def test_a_box_of_few_triangles_throws_the_shadow_of_a_box() -> None:
    box, light = np.array([0.1, 0.2, 0.15]), np.array([0.48, 0.36, -0.8])
    shade = ground_shade(*box_of_12(box), light, 1.0, ShadowLook(contact=0.0), 0.6, 0.05)
    along = (np.arange(GRID) + 0.5) * (2.0 / GRID) - 1.0
    at_m = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    true = 0.6 * inside(box, at_m, -light[None]).reshape(GRID, GRID)
    touched = (true > 0.0) | (shade > 0.01)
    assert np.abs(shade - true)[touched].mean() < 0.06
    assert shade[true > 0.0].mean() == pytest.approx(0.6, rel=0.1)


def test_folds_of_a_mesh_darken_no_more_than_its_outline() -> None:
    """A leaf of ten layers: as dark in the soft rim as one of a single layer."""
    leaf = np.array([[-0.1, -0.1, 0.3], [0.1, -0.1, 0.3], [0.1, 0.1, 0.3], [-0.1, 0.1, 0.3]])
    both = np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]])
    layered = np.concatenate([leaf + np.array([0.0, 0.0, 1e-4 * k]) for k in range(10)])
    faces = np.concatenate([both + 4 * k for k in range(10)])
    light, look = np.array([0.0, 0.0, -1.0]), ShadowLook(contact=0.0)
    one, ten = (ground_shade(*mesh, light, 1.0, look, 1.0, 0.3)
                for mesh in ((leaf, both), (layered, faces)))  # fmt: skip
    np.testing.assert_allclose(ten, one, atol=0.06)


def test_light_from_below_the_ground_is_refused() -> None:
    vertices, triangles = cube(0.1, 0.0)
    with pytest.raises(ValueError, match="light from above"):
        ground_shade(vertices, triangles, np.array([0.0, 0.0, 1.0]), 1.0, ShadowLook(), 1.0, 0.1)
