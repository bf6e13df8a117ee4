"""Objects of CGA3 against Euclidean closed forms: what they hold, where they meet, their size."""

import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.ga.algebra import CGA3, Multivector
from motorcade.ga.algebra import conformal as cga

close = np.testing.assert_allclose


def units(rng: np.random.Generator, count: int) -> np.ndarray:
    drawn = rng.standard_normal((count, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def largest(x: Multivector) -> float:
    return max((float(np.max(np.abs(value))) for value in x.values), default=0.0)


@pytest.fixture
def spots(rng: np.random.Generator) -> np.ndarray:
    """Four points in each of twenty rows."""
    return rng.standard_normal((4, 20, 3))


def test_points_are_null_and_their_product_is_their_distance(spots: np.ndarray) -> None:
    a, b = cga.point(spots[0]), cga.point(spots[1])
    distance = np.linalg.norm(spots[0] - spots[1], axis=1)
    close(a.norm_squared(), 0.0, atol=1e-14)
    close(np.sqrt(-2.0 * (a | b).coefficient("1")), distance, rtol=1e-12)
    close(cga.distance_to_point(a, b), distance, rtol=1e-14)
    close((a | cga.infinity()).coefficient("1"), -1.0)
    close(cga.coordinates(a), spots[0], atol=1e-15)
    close(cga.coordinates(-3.0 * a), spots[0], atol=1e-15)


def test_near_points_keep_their_distance() -> None:
    a, b = cga.point([1.0, 2.0, 3.0]), cga.point([1.0, 2.0, 3.0 + 1e-9])
    assert cga.distance_to_point(a, b) == pytest.approx(1e-9, rel=1e-6)


def test_sphere_is_read_back(spots: np.ndarray, rng: np.random.Generator) -> None:
    radius = rng.uniform(0.5, 2.0, 20)
    sphere = 2.5 * cga.sphere(spots[0], radius)
    close(cga.center(sphere), spots[0], atol=1e-14)
    close(cga.radius(sphere), radius, rtol=1e-13)
    off = np.linalg.norm(spots[1] - spots[0], axis=1) - radius
    close(cga.distance_to_sphere(cga.point(spots[1]), sphere), off, atol=1e-13)
    surface = spots[0] + radius[:, None] * units(rng, 20)
    close((cga.point(surface) | sphere).coefficient("1"), 0.0, atol=1e-13)


def test_plane_is_read_back(spots: np.ndarray, rng: np.random.Generator) -> None:
    normal, height = units(rng, 20), rng.standard_normal(20)
    plane = 0.3 * cga.plane(normal, height)
    close(cga.normal(plane), normal, atol=1e-15)
    close(cga.plane_distance(plane), height, atol=1e-15)
    signed = np.sum(normal * spots[0], axis=1) - height
    close(cga.distance_to_plane(cga.point(spots[0]), plane), signed, atol=1e-14)


def test_line_is_read_back(spots: np.ndarray, rng: np.random.Generator) -> None:
    along = units(rng, 20)
    line = 4.0 * cga.line(spots[0], along)
    foot = spots[0] - np.sum(spots[0] * along, axis=1, keepdims=True) * along
    close(cga.direction(line), along, atol=1e-15)
    close(cga.nearest_to_origin(line), foot, atol=1e-14)
    off = np.linalg.norm(np.cross(spots[1] - spots[0], along), axis=1)
    close(cga.distance_to_line(cga.point(spots[1]), line), off, atol=1e-14)


def test_circle_is_read_back(spots: np.ndarray, rng: np.random.Generator) -> None:
    normal, radius = units(rng, 20), rng.uniform(0.5, 2.0, 20)
    circle = 0.7 * cga.circle(spots[0], normal, radius)
    close(cga.center(circle), spots[0], atol=1e-13)
    close(cga.radius(circle), radius, rtol=1e-12)
    close(cga.normal(circle), normal, atol=1e-14)
    close(cga.plane_distance(cga.carrier(circle)), np.sum(normal * spots[0], 1), atol=1e-13)


def test_circle_through_three_points_is_their_circumcircle(spots: np.ndarray) -> None:
    a, b, c, _ = spots
    circle = cga.circle_through(a, b, c)
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((b, c), (c, a), (a, b))]
    across = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(across, axis=1)
    close(cga.radius(circle), sides[0] * sides[1] * sides[2] / (4.0 * area), rtol=1e-11)
    weights = [s**2 * (np.sum(np.square(sides), 0) - 2 * s**2) for s in sides]
    barycentric = sum(w[:, None] * p for w, p in zip(weights, (a, b, c), strict=True))
    close(cga.center(circle), barycentric / sum(weights)[:, None], atol=1e-10)
    close(cga.normal(circle), across / (2.0 * area[:, None]), atol=1e-13)
    for x in (a, b, c):
        assert largest(cga.point(x) | circle) < 1e-12


def test_sphere_through_four_points_solves_the_linear_system(spots: np.ndarray) -> None:
    sphere = cga.sphere_through(*spots)
    edges = np.moveaxis(spots[1:] - spots[0], 0, 1)
    squares = np.sum(spots**2, axis=2)
    center = np.linalg.solve(2.0 * edges, (squares[1:] - squares[0]).T[..., None])[..., 0]
    close(cga.center(sphere), center, rtol=1e-9, atol=1e-9)
    radius = np.linalg.norm(spots[0] - center, axis=1)
    close(cga.radius(sphere), radius, rtol=1e-9)
    close(sphere.coefficient("e0"), 1.0)


def test_flats_through_points(spots: np.ndarray) -> None:
    a, b, c, _ = spots
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    close(cga.normal(cga.plane_through(a, b, c)), across, atol=1e-13)
    way = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    close(cga.direction(cga.line_through(a, b)), way, atol=1e-14)
    for x in (a, b):
        close(cga.distance_to_line(cga.point(x), cga.line_through(a, b)), 0.0, atol=1e-14)


def test_constructions_are_duals_of_outer_products_of_points(spots: np.ndarray) -> None:
    a, b, c, d = map(cga.point, spots)
    far = cga.infinity()
    pairs = [
        (cga.point_pair(*spots[:2]), a ^ b),
        (cga.line_through(*spots[:2]), a ^ b ^ far),
        (cga.circle_through(*spots[:3]), a ^ b ^ c),
        (cga.plane_through(*spots[:3]), a ^ b ^ c ^ far),
        (cga.sphere_through(*spots), a ^ b ^ c ^ d),
    ]
    for inner, outer in pairs:
        ratio = next(iter(inner.values)) / next(iter(outer.dual().values))
        assert largest(inner - outer.dual() * ratio) < 1e-11
        for x in spots[:2]:
            assert largest(cga.point(x) ^ inner.undual()) < 1e-11
            assert largest(cga.point(x) | inner) < 1e-11


def test_point_pair_keeps_its_order(spots: np.ndarray) -> None:
    first, second = cga.two_points(2.0 * cga.point_pair(spots[0], spots[1]))
    close(first, spots[0], atol=1e-12)
    close(second, spots[1], atol=1e-12)
    pair = cga.point_pair(spots[0], spots[1])
    half = 0.5 * np.linalg.norm(spots[1] - spots[0], axis=1)
    close(cga.radius(pair), half, rtol=1e-12)
    close(cga.center(pair), 0.5 * (spots[0] + spots[1]), atol=1e-13)


@pytest.mark.parametrize("gap", [0.5, 1.3, 2.6])
def test_spheres_meet_in_the_circle_of_the_closed_form(gap: float) -> None:
    start, way = np.array([0.4, -1.0, 2.0]), np.array([2.0, -1.0, 2.0]) / 3.0
    r1, r2 = 1.5, 1.2
    circle = cga.meet(cga.sphere(start, r1), cga.sphere(start + gap * way, r2))
    along = (gap**2 + r1**2 - r2**2) / (2.0 * gap)
    close(cga.center(circle), start + along * way, atol=1e-13)
    close(cga.radius(circle), np.sqrt(r1**2 - along**2), rtol=1e-12)
    close(cga.normal(circle), way, atol=1e-13)


def test_spheres_that_miss_meet_in_an_imaginary_circle() -> None:
    circle = cga.meet(cga.sphere([0.0, 0.0, 0.0], 1.0), cga.sphere([4.0, 0.0, 0.0], 1.0))
    assert cga.radius_squared(circle) == pytest.approx(1.0 - 4.0)
    close(cga.center(circle), [2.0, 0.0, 0.0], atol=1e-15)
    with pytest.raises(ValueError, match="negative squared radius"):
        cga.radius(circle)


def test_line_meets_sphere_plane_and_plane(rng: np.random.Generator) -> None:
    start, along = rng.standard_normal(3), units(rng, 1)[0]
    line = cga.line(start, along)
    normal = units(rng, 1)[0]
    spot = start + (0.8 - normal @ start) / (normal @ along) * along
    close(cga.flat_position(cga.meet(line, cga.plane(normal, 0.8))), spot, rtol=1e-12)
    center = (
        start
        + 0.3 * along
        + 0.4 * np.cross(along, normal) / np.linalg.norm(np.cross(along, normal))
    )
    pair = cga.meet(line, cga.sphere(center, 0.5))
    ends = np.stack(cga.two_points(pair))
    expected = np.stack([start, start + 0.6 * along])
    order = np.argsort(ends @ along)
    close(ends[order], expected, atol=1e-12)


def test_planes_meet_in_a_line_and_three_in_a_point(rng: np.random.Generator) -> None:
    normals, spot = units(rng, 3), rng.standard_normal(3)
    planes = [cga.plane(n, float(n @ spot)) for n in normals]
    line = cga.meet(*planes[:2])
    along = np.cross(normals[0], normals[1])
    close(cga.direction(line), along / np.linalg.norm(along), atol=1e-14)
    close(cga.distance_to_line(cga.point(spot), line), 0.0, atol=1e-13)
    close(cga.flat_position(cga.meet(*planes)), spot, atol=1e-12)


def test_tangent_line_meets_the_sphere_in_one_point() -> None:
    line = cga.line([3.0, 2.0, 0.0], [0.0, 0.0, 1.0])
    first, second = cga.two_points(cga.meet(line, cga.sphere([3.0, 0.0, 7.0], 2.0)))
    close(first, [3.0, 2.0, 7.0], atol=1e-6)
    close(second, [3.0, 2.0, 7.0], atol=1e-6)


def test_joins_hold_what_they_join(spots: np.ndarray) -> None:
    a, b, c, d = map(cga.point, spots)
    plane = cga.join(cga.line_through(*spots[:2]), c)
    across = cga.normal(plane)
    close(np.abs(np.sum(across * cga.normal(cga.plane_through(*spots[:3])), 1)), 1.0)
    sphere = cga.join(cga.circle_through(*spots[:3]), d)
    close(cga.center(sphere), cga.center(cga.sphere_through(*spots)), atol=1e-9)
    for joined in (plane, sphere, cga.join(cga.point_pair(*spots[:2]), c)):
        for x in (a, b, c):
            assert largest(x | joined) < 1e-11
    line = cga.join(cga.point_pair(*spots[:2]), cga.infinity())
    direction = cga.direction(cga.line_through(*spots[:2]))
    close(np.abs(np.sum(cga.direction(line) * direction, 1)), 1.0)
    close(cga.distance_to_line(a, line), 0.0, atol=1e-13)


def test_a_point_on_the_object_joins_to_nothing(spots: np.ndarray) -> None:
    line = cga.line_through(spots[0], spots[1])
    middle = cga.point(0.5 * (spots[0] + spots[1]))
    assert largest(cga.join(line, middle)) < 1e-13


def test_motors_move_every_object_as_a_body(spots: np.ndarray, rng: np.random.Generator) -> None:
    motor = Motor.random(rng, (20,))
    versor, moved = cga.of_versor(motor), [motor.apply(x) for x in spots]
    for build, count in (
        (cga.point_pair, 2),
        (cga.line_through, 2),
        (cga.circle_through, 3),
        (cga.plane_through, 3),
        (cga.sphere_through, 4),
    ):
        carried, expected = versor.sandwich(build(*spots[:count])), build(*moved[:count])
        assert carried.grades == expected.grades
        assert largest(carried - expected) < 1e-9 * max(1.0, largest(expected))


def test_inversion_in_a_sphere() -> None:
    sphere, x = cga.sphere([0.0, 0.0, 0.0], 2.0), np.array([1.0, -2.0, 2.0])
    image = sphere.sandwich(cga.point(x))
    close(cga.coordinates(image), 4.0 * x / (x @ x), rtol=1e-14)


def test_reflection_in_a_plane() -> None:
    mirror = cga.plane([0.6, 0.0, 0.8], 1.5)
    x = np.array([3.0, 1.0, -2.0])
    image = x - 2.0 * (x @ [0.6, 0.0, 0.8] - 1.5) * np.array([0.6, 0.0, 0.8])
    close(cga.coordinates(mirror.sandwich(cga.point(x))), image, atol=1e-14)


def test_infinity_is_on_flats_only() -> None:
    far = cga.infinity()
    assert largest(far | cga.plane([0.0, 0.0, 1.0], 2.0)) == 0.0
    assert largest(far | cga.line([1.0, 2.0, 3.0], [0.0, 0.0, 1.0])) == 0.0
    assert largest(far | cga.circle([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 1.0)) > 0.5
    assert far.algebra == CGA3
