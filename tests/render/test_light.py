"""Light found in made-up images whose light is known, and light that stands for it."""

import numpy as np
import pytest

from motorcade.animation import Placement, mannequin, place_on_plane
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Sun
from motorcade.render.light import sun_share
from motorcade.render.light.estimate import (
    LightEstimate,
    ShadedPoints,
    estimate_light,
    harmonics,
    shaded_points,
)
from motorcade.render.light.lamps import estimated_lighting
from motorcade.tracking.cameras.camera import Camera

TO_SUN = np.array([0.48, -0.6, 0.64])
CAMERA = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)


def painted_balls(rng: np.random.Generator, paints: int = 6) -> ShadedPoints:
    """Points on balls of a few paints under a sun and light from all sides, a few in shadow."""
    normals = rng.normal(size=(6000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    paint = rng.integers(0, paints, len(normals))
    albedo = rng.uniform(0.15, 0.8, (paints, 3))[paint]
    falling = 0.4 + 1.2 * np.maximum(normals @ TO_SUN, 0.0)
    falling[rng.random(len(normals)) < 0.1] = 0.4
    noise = rng.normal(1.0, 0.03, (len(normals), 1))
    return ShadedPoints(0.3 * normals, normals, albedo * falling[:, None] * noise)


def test_the_sun_of_painted_balls_is_found(rng: np.random.Generator) -> None:
    found = estimate_light(painted_balls(rng), [0.0, 0.0, 0.0], 1.0)
    assert np.rad2deg(np.arccos(found.towards_light @ TO_SUN)) < 5.0
    sun, ambient = found.sun_and_ambient()
    assert sun / ambient == pytest.approx(1.2 / 0.4, rel=0.4)


def test_light_from_all_sides_has_no_direction(rng: np.random.Generator) -> None:
    seen = painted_balls(rng)
    even = ShadedPoints(seen.points_m, seen.normals, np.full_like(seen.colors, 0.3))
    assert estimate_light(even, [0.0, 0.0, 0.0], 1.0).contrast < 0.02


def test_one_wall_alone_tells_no_direction(rng: np.random.Generator) -> None:
    count = 500
    points = np.column_stack([rng.uniform(-1, 1, (count, 2)), np.zeros(count)])
    wall = ShadedPoints(points, np.tile([0.0, 0.0, 1.0], (count, 1)), np.full((count, 3), 0.5))
    found = estimate_light(wall, [0.0, 0.0, 0.0], 1.0)
    assert np.all(np.isfinite(found.irradiance))
    assert found.contrast < 0.6


def test_sun_and_ambient_have_the_estimates_mean_and_first_band(rng: np.random.Generator) -> None:
    found = estimate_light(painted_balls(rng), [0.0, 0.0, 0.0], 1.0)
    sun, ambient = found.sun_and_ambient()
    v = rng.normal(size=(200_000, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    made = ambient + sun * np.maximum(v @ found.towards_light, 0.0)
    bands = 4.0 * np.pi * (harmonics(v, 1) * made[:, None]).mean(axis=0)
    np.testing.assert_allclose(bands, found.irradiance[:4], atol=0.02 * found.irradiance[0])


def test_normals_from_depth_are_those_of_the_plane() -> None:
    """A slanted wall before a turned camera."""
    normal = np.array([0.3, -0.2, -0.93])
    normal /= np.linalg.norm(normal)
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = CAMERA.unproject(np.stack([x, y], axis=-1).astype(float))
    depth = (2.0 * normal[2] / (rays @ normal)).astype(np.float32)
    depth[:20] = 0.0
    pose = Motor.from_rotor_translation(Rotor.from_rotation_vector([0.2, 1.0, -0.4]), [1.0, 2, 3])
    frame = np.full((CAMERA.height, CAMERA.width, 3), 188, dtype=np.uint8)
    seen = shaded_points(frame, depth, CAMERA, pose)
    assert len(seen.points_m) > 300
    np.testing.assert_allclose(
        seen.normals, np.tile(pose.rotor.apply(normal), (len(seen.normals), 1)), atol=2e-4
    )
    np.testing.assert_allclose(seen.colors, 0.5029, atol=1e-3)
    offset = pose.apply(np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose((seen.points_m - offset) @ pose.rotor.apply(normal), 0.0, atol=1e-5)


@pytest.fixture(scope="module")
def placement() -> Placement:
    return place_on_plane(mannequin(), (0.0, 0.0), 0.0, height_m=1.0)


def light(towards: FloatArray) -> LightEstimate:
    """Light whose first band points somewhere."""
    bands = np.zeros(9)
    bands[0], bands[[3, 1, 2]] = 1.0, 0.4 * towards
    return LightEstimate(bands, np.ones(3))


def test_an_estimated_sun_below_the_ground_is_raised(placement: Placement) -> None:
    for towards in (TO_SUN, np.array([0.6, 0.0, -0.8]), np.array([0.0, 0.0, -1.0])):
        made = estimated_lighting(placement, 1.0, light(towards))
        direction = np.array(made.sun.direction)
        assert direction[2] < -0.29
        assert np.linalg.norm(direction) == pytest.approx(1.0)
    kept = estimated_lighting(placement, 1.0, light(TO_SUN))
    np.testing.assert_allclose(kept.sun.direction, -TO_SUN, atol=1e-12)


def test_a_direction_that_hardly_shows_gives_way_to_the_assumed_one(placement: Placement) -> None:
    assumed = np.array([0.0, 0.6, -0.8])
    for contrast, share in ((0.05, 0.0), (0.2, 0.5), (0.5, 1.0)):
        bands = np.zeros(9)
        bands[0], bands[[3, 1, 2]] = 1.0, contrast / np.sqrt(3.0) * TO_SUN
        found = LightEstimate(bands, np.ones(3))
        assert found.contrast == pytest.approx(contrast)
        made = np.array(estimated_lighting(placement, 1.0, found, assumed).sun.direction)
        wanted = (1.0 - share) * assumed - share * TO_SUN
        np.testing.assert_allclose(made, wanted / np.linalg.norm(wanted), atol=1e-12)


def test_the_suns_share_is_its_irradiance_over_all() -> None:
    sun = Sun((0.0, 0.0, -2.0), np.pi * 0.6)
    lighting = Lighting((0.2, 0.2, 0.2), sun, (), (0.0, 0.0, 0.0), 1.0)
    up = np.array([0.0, 0.0, 1.0])
    assert sun_share(lighting, np.zeros(3), up) == pytest.approx(0.75)
    assert sun_share(lighting, np.zeros(3), -up) == 0.0


def test_images_that_tell_nothing_are_refused(rng: np.random.Generator) -> None:
    few = ShadedPoints(np.zeros((3, 3)), np.zeros((3, 3)), np.ones((3, 3)))
    with pytest.raises(ValueError, match="50 points or more, got 3"):
        estimate_light(few, [0.0, 0.0, 0.0], 1.0)
    with pytest.raises(ValueError, match="reach_m"):
        estimate_light(painted_balls(rng), [0.0, 0.0, 0.0], 0.0)
    with pytest.raises(ValueError, match="shape"):
        ShadedPoints(np.zeros((3, 3)), np.zeros((4, 3)), np.ones((3, 3)))
    frame, depth = np.zeros((9, 9, 3), dtype=np.uint8), np.ones((9, 9), dtype=np.float32)
    with pytest.raises(ValueError, match="expected a frame and depth"):
        shaded_points(frame, depth, CAMERA, Motor.identity())
