"""Planes move as conformal vectors do, rays meet them where linear algebra says, fits are SVD's."""

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares

from motorcade.ga import Motor
from motorcade.ga.algebra import conformal
from motorcade.tracking import Camera
from motorcade.tracking.planes import Plane, fit_plane

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def square(world_T_plane: Motor) -> Plane:
    return Plane(world_T_plane, SQUARE, 4, 0.0, np.zeros((3, 3)))


def scattered(rng: np.random.Generator, pose: Motor, count: int, sigma_m: float) -> np.ndarray:
    """Points of a 2 by 1 m rectangle in a frame's z = 0."""
    local = rng.uniform((-1.0, -0.5, 0.0), (1.0, 0.5, 0.0), (count, 3))
    local[:, 2] = sigma_m * rng.standard_normal(count)
    return pose.apply(local)


def test_a_plane_is_its_conformal_vector_and_moves_like_it(rng: np.random.Generator) -> None:
    plane = square(Motor.random(rng))
    motion = Motor.random(rng)
    moved = plane.transformed_by(motion)
    vector, before = (conformal.plane(one.normal, one.distance_m) for one in (moved, plane))
    np.testing.assert_allclose(conformal.normal(vector), moved.normal, atol=1e-12)
    assert conformal.plane_distance(vector) == pytest.approx(moved.distance_m, abs=1e-12)
    versor = conformal.of_versor(motion)
    sandwich = (versor * before * ~versor).grade(1)
    np.testing.assert_allclose(conformal.normal(sandwich), moved.normal, atol=1e-12)
    assert conformal.plane_distance(sandwich) == pytest.approx(moved.distance_m, abs=1e-12)
    # And in matrices: M = T R acts on (n, d) as n' = R n, d' = d + n' . t.
    matrix = motion.as_matrix()
    turned = matrix[:3, :3] @ plane.normal
    np.testing.assert_allclose(moved.normal, turned, atol=1e-12)
    assert moved.distance_m == pytest.approx(plane.distance_m + turned @ matrix[:3, 3], abs=1e-12)
    np.testing.assert_allclose(moved.outline_m, motion.apply(plane.outline_m), atol=1e-12)
    np.testing.assert_allclose(moved.distances_m(moved.outline_m), 0.0, atol=1e-12)


def test_rays_hit_where_the_linear_system_says(rng: np.random.Generator) -> None:
    for _ in range(20):
        plane = square(Motor.random(rng))
        origin = rng.standard_normal(3)
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        met = plane.met_by(origin, direction)
        # origin + t direction = centre + a x + b y
        axes = plane.world_T_plane.as_matrix()[:3, :2]
        a, b, t = np.linalg.solve(np.column_stack([axes, -direction]), origin - plane.centre_m)
        if t < 0.0:
            assert np.isnan(met).all()
            continue
        np.testing.assert_allclose(met, origin + t * direction, atol=1e-9)
        assert plane.holds(met) == (max(abs(a), abs(b)) <= 0.5)


def test_rays_along_the_plane_and_away_from_it_hit_nothing() -> None:
    floor = square(Motor.identity())
    ways = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, 0, -1.0], [np.nan] * 3])
    hits = floor.met_by(np.array([0.1, 0.2, 3.0]), ways)
    np.testing.assert_array_equal(np.isfinite(hits).all(axis=1), [False, False, True, False])
    np.testing.assert_allclose(hits[2], [0.1, 0.2, 0.0])


def test_a_pixel_s_hit_projects_to_the_pixel(rng: np.random.Generator) -> None:
    camera = Camera(640, 480, 500.0, 505.0, 320.0, 241.0, "radtan", (-0.2, 0.05, 0.001, 0.0))
    pose = Motor.from_twist(np.array([2.6, 0.1, -0.3, 0.4, 0.2, 2.0]))
    pixels = rng.uniform((50, 50), (590, 430), (30, 2))
    rays = pose.rotor.apply(camera.bearings(pixels))
    hits = square(Motor.identity()).met_by(pose.translation_m, rays)
    np.testing.assert_allclose(hits[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(camera.project(pose.inverse().apply(hits)), pixels, atol=1e-6)


def test_the_fit_is_that_of_the_singular_value_decomposition(rng: np.random.Generator) -> None:
    points = scattered(rng, Motor.random(rng), 300, 0.02)
    plane = fit_plane(points)
    offset = points - points.mean(axis=0)
    normal = np.linalg.svd(offset)[2][2]
    assert abs(plane.normal @ normal) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(plane.centre_m, points.mean(axis=0), atol=1e-12)
    assert plane.rms_m == pytest.approx(np.sqrt(np.mean((offset @ normal) ** 2)), rel=1e-9)
    assert plane.distance_m < 0.0, "the normal points to the origin"
    assert fit_plane(points, towards_m=2.0 * plane.centre_m).distance_m > 0.0


def test_weights_are_those_of_weighted_least_squares(rng: np.random.Generator) -> None:
    sigma = rng.uniform(0.002, 0.05, 200)
    pose = Motor.random(rng)
    points = scattered(rng, pose, 200, 0.0)
    normal = pose.rotor.apply([0.0, 0.0, 1.0])
    points += (sigma * rng.standard_normal(200))[:, None] * normal

    def residuals(form: np.ndarray) -> np.ndarray:
        length = np.linalg.norm(form[:3])
        return (points @ form[:3] / length - form[3]) / sigma

    start = [*normal, float(normal @ pose.translation_m)]
    witness = least_squares(residuals, start, xtol=1e-14, ftol=1e-14, gtol=1e-14).x
    witness[:3] /= np.linalg.norm(witness[:3])
    plane = fit_plane(points, sigma)
    side = np.sign(plane.normal @ witness[:3])
    np.testing.assert_allclose(plane.normal * side, witness[:3], atol=1e-7)
    assert plane.distance_m * side == pytest.approx(witness[3], abs=1e-7)


def test_the_covariance_is_the_scatter_of_fits(rng: np.random.Generator) -> None:
    turned = Motor.from_twist(np.array([0.3, -0.2, 0.1, 0.5, 0.3, -2.0]))
    errors, stated = [], []
    for _ in range(400):
        plane = fit_plane(scattered(rng, turned, 150, 0.01))
        normal = turned.inverse().rotor.apply(plane.normal)
        normal = normal * np.sign(normal[2])
        height = turned.inverse().apply(plane.centre_m)[2]
        # Tilt about x moves the normal to -y, tilt about y to +x; the shift is at the fit's centre.
        errors.append([-normal[1], normal[0], height])
        stated.append(plane.covariance)
    np.testing.assert_allclose(np.var(errors, axis=0), np.diag(np.mean(stated, axis=0)), rtol=0.3)


def test_the_outline_leaves_out_what_lies_far_off(rng: np.random.Generator) -> None:
    points = np.zeros((600, 3))
    points[:, :2] = rng.uniform((0.0, 0.0), (2.0, 1.0), (600, 2))
    points[:5, :2] += (8.0, 3.0)
    plane = fit_plane(points, towards_m=[0.0, 0.0, 1.0])
    assert plane.support == 600
    assert cv2.contourArea(plane.outline.astype(np.float32)) == pytest.approx(2.0, rel=0.06)
    assert plane.holds([1.0, 0.5, 0.0])
    assert not plane.holds(points[0])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.eye(3)[:2], "expected 3 or more points"),
        (np.outer(np.arange(9.0), [1.0, 2.0, 3.0]), "expected points that do not lie on one line"),
        (np.full((5, 3), np.nan), "expected finite numbers"),
        (np.ones((5, 3)), "expected points that do not lie on one line"),
        (np.eye(4), "expected shape"),
    ],
)
def test_points_that_fix_no_plane_are_refused(points: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fit_plane(points)


def test_points_on_a_line_within_their_noise_are_refused(rng: np.random.Generator) -> None:
    points = np.outer(np.linspace(0.0, 2.0, 50), [1.0, 0.0, 0.0])
    points += 0.01 * rng.standard_normal(points.shape)
    with pytest.raises(ValueError, match="one line"):
        fit_plane(points, 0.01)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"outline": SQUARE[::-1]}, "Plane.outline: expected three or more corners anticlockwise"),
        ({"outline": SQUARE[:2]}, "Plane.outline"),
        ({"support": 2}, "got support=2"),
        ({"rms_m": -1.0}, "rms_m=-1.0"),
        ({"covariance": np.triu(np.ones((3, 3)))}, "Plane.covariance: expected one symmetric"),
        ({"world_T_plane": Motor.identity((2,))}, "Plane.world_T_plane: expected one pose"),
    ],
)
def test_planes_that_cannot_be_are_refused(change: dict[str, object], message: str) -> None:
    good = {
        "world_T_plane": Motor.identity(),
        "outline": SQUARE,
        "support": 4,
        "rms_m": 0.0,
        "covariance": np.zeros((3, 3)),
    }
    with pytest.raises(ValueError, match=message):
        Plane(**(good | change))
