"""What is read of an object is what closed formulas say of it, in every algebra with images."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motorcade.ga import CGA3, EGA3, PGA3, Algebra, Motor, Similarity, Trajectory
from motorcade.ga.drawing.reading import MAX_OBJECTS, shapes_of
from motorcade.ga.drawing.shape import (
    Arrow,
    Circle,
    Frames,
    Line,
    PlaneShape,
    PointPair,
    Points,
    Sphere,
    is_flat,
)

CGA2 = Algebra(3, 1, null_pair=True)
PGA2 = Algebra(2, 0, 1, ("e1", "e2", "e0"))
SEEDS = pytest.mark.parametrize("seed", range(8))


def one(x: Any, form: Any = "inner") -> Any:
    (shape,) = shapes_of(x, form)
    return shape


def inner_sphere(algebra: Any, center: np.ndarray, radius_squared: float, weight: float) -> Any:
    """``c + ½ (c² - r²) ∞ + e0`` by its coefficients."""
    parts = {f"e{i + 1}": weight * v for i, v in enumerate(center)}
    far = 0.5 * (center @ center - radius_squared)
    return algebra.multivector(parts | {"einf": weight * far, "e0": weight})


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


@SEEDS
def test_spheres_and_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    center, radius, weight = rng.normal(size=3), rng.uniform(0.1, 3.0), rng.uniform(-2.0, -0.1)
    for squared, imaginary in ((radius**2, False), (-(radius**2), True)):
        x = inner_sphere(CGA3, center, squared, weight)
        for seen in (one(x), one(x.undual(), "outer")):
            assert isinstance(seen, Sphere)
            assert (seen.radius, seen.imaginary) == (pytest.approx(radius, rel=1e-9), imaginary)
            np.testing.assert_allclose(seen.center, center, atol=1e-12)
    far = inner_sphere(CGA3, 1e6 * center, (1e5 * radius) ** 2, 1.0)
    assert (one(far).kind, one(far).radius) == ("sphere", pytest.approx(1e5 * radius, rel=1e-6))
    point = inner_sphere(CGA3, center, 0.0, weight)
    for seen in (one(point), one(point, "outer"), one(point.undual(), "inner")):
        assert isinstance(seen, Points)
        np.testing.assert_allclose(seen.positions, [center], atol=1e-12)


@SEEDS
def test_circles_pairs_and_lines_by_what_they_go_through(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, c = 10.0 ** rng.integers(-3, 4) * rng.normal(size=(3, 3))
    near = 1e-8 * np.abs([a, b, c]).max()
    points = [inner_sphere(CGA3, place, 0.0, 1.0) for place in (a, b, c)]
    circle = one(points[0] ^ points[1] ^ points[2], "outer")
    # The circumcircle, by the law of sines and barycentric coordinates.
    lengths = [np.linalg.norm(b - c), np.linalg.norm(c - a), np.linalg.norm(a - b)]
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
    squares = np.square(lengths)
    weights = squares * (squares.sum() - 2 * squares)
    assert isinstance(circle, Circle)
    assert circle.radius == pytest.approx(np.prod(lengths) / (4 * area), rel=1e-9)
    np.testing.assert_allclose(circle.center, weights @ [a, b, c] / weights.sum(), rtol=1e-8)
    across = unit(np.cross(b - a, c - a))
    assert abs(circle.normal @ across) == pytest.approx(1.0, rel=1e-12)
    around = circle.around(24)
    np.testing.assert_allclose(np.linalg.norm(around - circle.center, axis=1), circle.radius)
    np.testing.assert_allclose((around - a) @ across, 0.0, atol=near)
    pair = one(points[0] ^ points[1], "outer")
    assert isinstance(pair, PointPair)
    ends = sorted(map(tuple, (pair.first, pair.second)))
    np.testing.assert_allclose(ends, sorted(map(tuple, (a, b))), atol=near)
    line = one(points[0] ^ points[1] ^ CGA3.blade("einf"), "outer")
    assert isinstance(line, Line)
    for place in (a, b):
        np.testing.assert_allclose(line.nearest(place), place, atol=near)
    plane = one(points[0] ^ points[1] ^ points[2] ^ CGA3.blade("einf"), "outer")
    assert isinstance(plane, PlaneShape)
    for place in (a, b, c):
        np.testing.assert_allclose(plane.nearest(place), place, atol=near)


def test_spheres_that_miss_each_other_meet_in_an_imaginary_circle() -> None:
    far = [inner_sphere(CGA3, np.array([x, 0.0, 0.0]), 1.0, 1.0) for x in (0.0, 4.0)]
    circle = one(far[0] ^ far[1])
    assert (circle.imaginary, circle.radius) == (True, pytest.approx(3.0**0.5))
    pair = one(far[0] ^ CGA3.multivector({"e2": 1.0}) ^ CGA3.multivector({"e1": 1.0, "einf": 2.0}))
    assert (pair.imaginary, pair.kind) == (True, "imaginary point pair")


@SEEDS
def test_the_conformal_plane(seed: int) -> None:
    rng = np.random.default_rng(seed)
    center, radius = rng.normal(size=2), rng.uniform(0.2, 2.0)
    x = inner_sphere(CGA2, center, radius**2, 1.7)
    for seen in (one(x), one(x.undual(), "outer")):
        assert isinstance(seen, Circle)
        assert is_flat(seen)
        np.testing.assert_allclose(seen.center, [*center, 0.0], atol=1e-12)
        assert seen.radius == pytest.approx(radius, rel=1e-9)
    a, b = rng.normal(size=(2, 2))
    points = [inner_sphere(CGA2, place, 0.0, 1.0) for place in (a, b)]
    pair = one(points[0] ^ points[1], "outer")
    ends = sorted(map(tuple, (pair.first, pair.second)))
    np.testing.assert_allclose(ends, sorted([(*a, 0.0), (*b, 0.0)]), atol=1e-9)
    line = one(points[0] ^ points[1] ^ CGA2.blade("einf"), "outer")
    np.testing.assert_allclose(line.nearest(np.array([*b, 0.0])), [*b, 0.0], atol=1e-9)
    np.testing.assert_allclose(one(points[0]).positions, [[*a, 0.0]], atol=1e-12)
    assert all(map(is_flat, (pair, line)))


@SEEDS
def test_plane_based_algebra(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = rng.normal(size=3)
    normals = [unit(n) for n in rng.normal(size=(3, 3))]
    planes = [
        PGA3.multivector({f"e{i + 1}": 2 * n[i] for i in range(3)} | {"e0": -2 * (n @ place)})
        for n in normals
    ]
    plane = one(planes[0])
    assert isinstance(plane, PlaneShape)
    np.testing.assert_allclose(abs(plane.normal @ normals[0]), 1.0)
    np.testing.assert_allclose(plane.nearest(place), place, atol=1e-12)
    line = one(planes[0] ^ planes[1])
    assert isinstance(line, Line)
    along = unit(np.cross(normals[0], normals[1]))
    np.testing.assert_allclose(abs(line.direction @ along), 1.0)
    np.testing.assert_allclose(line.nearest(place), place, atol=1e-9)
    np.testing.assert_allclose(one(planes[0] ^ planes[1] ^ planes[2]).positions, [place], atol=1e-8)
    x, y = place[:2]
    flat = PGA2.multivector({"e1": 1.0, "e0": -x}) ^ PGA2.multivector({"e2": 1.0, "e0": -y})
    np.testing.assert_allclose(one(flat).positions, [[x, y, 0.0]], atol=1e-12)
    across = PGA2.multivector({"e1": normals[0][0], "e2": normals[0][1], "e0": -0.3})
    found = one(across)
    assert is_flat(found)
    assert found.point @ normals[0] == pytest.approx(0.3)


@SEEDS
def test_euclidean_algebra(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, 3))
    arrow, disc = one(EGA3.vector(a)), one(EGA3.vector(a) ^ EGA3.vector(b))
    assert isinstance(arrow, Arrow)
    np.testing.assert_allclose(arrow.vector, a)
    assert np.pi * disc.radius**2 == pytest.approx(np.linalg.norm(np.cross(a, b)), rel=1e-9)
    assert (disc.kind, abs(disc.normal @ unit(np.cross(a, b)))) == ("bivector", pytest.approx(1.0))


@SEEDS
def test_motions_move_the_axes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, place = Rotation.random(rng=rng), rng.normal(size=3)
    w, x, y, z = np.roll(turn.as_quat(), 1)
    rotor = {"1": w, "e2^e3": -x, "e3^e1": -y, "e1^e2": -z}
    shift = {"1": 1.0} | {f"e{i + 1}^einf": -0.5 * v for i, v in enumerate(place)}
    motor = CGA3.multivector(shift) * CGA3.multivector(rotor)
    shift = {"1": 1.0} | {f"e{i + 1}^e0": 0.5 * v for i, v in enumerate(place)}
    flat = PGA3.multivector(shift) * PGA3.multivector(rotor)
    seen = [one(3.0 * motor), one(flat), one(~(~flat))]
    seen.append(one(Motor.from_quaternion_translation(turn.as_quat()[[3, 0, 1, 2]], place)))
    for frames in seen:
        assert isinstance(frames, Frames)
        np.testing.assert_allclose(frames.origins, [place], atol=1e-9)
        np.testing.assert_allclose(frames.axes[0], turn.as_matrix().T, atol=1e-9)


def test_similarities_and_paths() -> None:
    grown = one(Similarity.from_motor_scale(Motor.from_translation([1.0, 2.0, 3.0]), 2.5))
    np.testing.assert_allclose(grown.axes, 2.5 * np.eye(3)[None])
    poses = Motor.from_translation(np.arange(12.0).reshape(4, 3))
    path = one(Trajectory(np.arange(4), poses))
    assert path.kind == "path"
    np.testing.assert_allclose(path.origins, np.arange(12.0).reshape(4, 3))
    long = one(Motor.from_translation(np.zeros((3 * MAX_OBJECTS, 3))))
    assert len(long.origins) == MAX_OBJECTS


def test_batches_are_as_many_objects() -> None:
    x = np.linspace(0.0, 1.0, 5)
    points = CGA3.multivector({"e1": x, "einf": 0.5 * x * x, "e0": 1.0})
    np.testing.assert_allclose(one(points).positions[:, 0], x)
    planes = shapes_of(CGA3.multivector({"e3": 1.0, "einf": x}))
    assert [shape.point[2] for shape in planes] == pytest.approx(list(x))
    with pytest.raises(ValueError, match="expected at most 1000 objects, got 1001"):
        shapes_of(CGA3.multivector({"e3": 1.0, "einf": np.zeros(MAX_OBJECTS + 1)}))


def test_what_rounding_leaves_of_other_blades_is_not_looked_at() -> None:
    x = inner_sphere(CGA3, np.zeros(3), 1.0, 1.0) + CGA3.multivector({"e1^e2^e3": 1e-16})
    assert one(x).kind == "sphere"


@pytest.mark.parametrize(
    ("made", "form", "why"),
    [
        (CGA3.scalar(2.5), "inner", "it is the number 2.5"),
        (CGA3.multivector({"e1": 0.0}), "inner", "it is zero"),
        (CGA3.blade("einf"), "inner", "it is the point at infinity"),
        (CGA3.blade("e1^einf"), "inner", "at infinity"),
        (CGA3.multivector({"einf": 1.0, "e0": 1.0}), "outer", "a vector in outer form is a point"),
        (CGA3.multivector({"1": 1.0, "e1": 1.0}), "inner", "neither an object of one grade nor a"),
        (PGA3.blade("e0"), "inner", "it lies at infinity"),
        (PGA3.blade("e1^e0"), "inner", "it lies at infinity"),
        (EGA3.blade("e1^e2^e3"), "inner", "a pseudoscalar has no image"),
        (Algebra(1, 3).blade("e1"), "inner", "there is no image of objects of Algebra"),
        ("text", "inner", "expected multivectors, versors or points, got str"),
        ([1.0, np.nan, 2.0], "inner", r"expected finite points of shape \(\*, 2\) or \(\*, 3\)"),
    ],
)
def test_what_has_no_image_says_why(made: Any, form: Any, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        shapes_of(made, form)


def test_symbols_have_no_image() -> None:
    ca = pytest.importorskip("casadi", reason="CasADi is not installed")
    with pytest.raises(ValueError, match="expected numbers, got symbols"):
        shapes_of(CGA3.scalar(ca.SX.sym("x")) * CGA3.blade("e1"))
