"""The place on a plane that is seen best, where nothing stands."""

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.stages.view.candidates import best_place, share_seen, tall_at
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(320, 240, 300.0, 300.0, 159.5, 119.5)
OUTLINE = np.array([[-3.0, -2.0], [3.0, -2.0], [3.0, 2.0], [-3.0, 2.0]])
NOTHING = np.zeros((0, 3))
HEIGHT_M = 1.0
ENDS = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, HEIGHT_M]])


def level(eyes_m: FloatArray, heading_rad: float = 0.0) -> Motor:
    """Cameras that look level along x, turned towards y."""
    axes = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    turn = Rotor.from_rotation_vector([0.0, 0.0, heading_rad]) @ Rotor.from_matrix(axes)
    count = len(eyes_m)
    return Motor.from_rotor_translation(Rotor.identity((count,)) @ turn, eyes_m)


def whole(place: tuple[float, float], plane_T_camera: Motor) -> FloatArray:
    """Whether each camera has the character whole in its image."""
    seen = plane_T_camera.inverse().reshape(-1, 1).apply(ENDS + np.array([*place, 0.0]))
    ahead = np.all(seen[..., 2] > 0.0, axis=1)
    pixels = CAMERA.project(np.where(ahead[:, None, None], seen, [0.0, 0.0, 1.0]))
    inside = np.all((pixels >= 0.0) & (pixels <= [319.0, 239.0]), axis=(1, 2))
    return np.asarray(ahead & inside)


def test_a_camera_that_goes_by_has_it_whole_as_long_as_any_place_allows() -> None:
    """Forward over the plane's middle: a place there would soon be behind the camera."""
    ride = level(np.stack([np.linspace(-5, 0, 30), np.zeros(30), np.full(30, 0.8)], axis=-1))
    found = best_place(OUTLINE, HEIGHT_M, CAMERA, ride, NOTHING, 0.0)[0]
    assert np.count_nonzero(whole(found, ride)) >= 29
    assert np.count_nonzero(whole((0.0, 0.0), ride)) < 25


def test_seen_alike_the_middle_is_taken() -> None:
    far = level(np.tile([-9.0, 0.0, 0.8], (5, 1)))
    ring = best_place(OUTLINE[:, ::-1][::-1] * [0.1, 0.1], HEIGHT_M, CAMERA, far, NOTHING, 0.0)[0]
    np.testing.assert_allclose(ring, 0.0, atol=0.05)


def test_where_something_stands_it_does_not(rng: np.random.Generator) -> None:
    look = level(np.tile([-5.0, 0.0, 0.8], (5, 1)))
    free = np.array(best_place(OUTLINE, HEIGHT_M, CAMERA, look, NOTHING, 0.0)[0])
    mug = np.append(free, 0.2) + rng.uniform(-0.1, 0.1, (200, 3))
    other = np.array(best_place(OUTLINE, HEIGHT_M, CAMERA, look, mug, 0.01)[0])
    assert np.linalg.norm(other - free) > 0.2
    assert whole((other[0], other[1]), look).all()
    # Paper on the table, a lamp above its head, and a few wrong points are in nobody's way.
    flat, above = mug * [1.0, 1.0, 0.1], mug + np.array([0.0, 0.0, 2.0])
    harmless = np.concatenate([flat, above, mug[:2]])
    same = best_place(OUTLINE, HEIGHT_M, CAMERA, look, harmless, 0.01)[0]
    np.testing.assert_array_equal(same, free)


@pytest.mark.parametrize("crowded", [True, False])
def test_out_of_view_or_room_it_still_has_a_place(crowded: bool, rng: np.random.Generator) -> None:
    look = level(np.tile([-5.0, 0.0, 0.8], (5, 1)), 0.0 if crowded else np.pi)
    crowd = rng.uniform([-3.5, -2.5, 0.2], [3.5, 2.5, 0.9], (20_000, 3))
    found = best_place(OUTLINE, HEIGHT_M, CAMERA, look, crowd if crowded else NOTHING, 0.01)[0]
    assert np.all(np.isfinite(found))
    if not crowded:
        assert found == (0.0, 0.0)


def test_what_stands_before_a_place_is_looked_past(rng: np.random.Generator) -> None:
    look = level(np.tile([-5.0, 0.0, 0.8], (5, 1)))
    free = np.array(best_place(OUTLINE, HEIGHT_M, CAMERA, look, NOTHING, 0.0)[0])
    chair = np.array([-2.5, 0.0, 0.4]) + rng.uniform(-0.3, 0.3, (200, 3))
    chair[:, 0] -= max(0.0, -2.0 - free[0])
    hidden = share_seen(free[None], HEIGHT_M, CAMERA, look, chair)
    other = np.array(best_place(OUTLINE, HEIGHT_M, CAMERA, look, chair, 0.01)[0])
    assert hidden[0] < 0.5
    assert share_seen(other[None], HEIGHT_M, CAMERA, look, chair)[0] > 2.0 * hidden[0]
    assert share_seen(free[None], HEIGHT_M, CAMERA, look, NOTHING)[0] > 0.9


@pytest.mark.parametrize("size", [(1280, 720), (720, 1280)])
@pytest.mark.parametrize("turned_deg", [0.0, 90.0])
def test_from_any_height_it_is_no_speck_and_no_giant(
    rng: np.random.Generator, size: tuple[int, int], turned_deg: float
) -> None:
    """Cameras 10 to 60 degrees above, upright or on their side, with all usual lenses."""
    for above_deg in np.append(rng.uniform(10.0, 60.0, 20), 60.0):
        focal_px, away = rng.uniform(0.6, 1.4) * 1280, rng.uniform(0.3, 30.0)
        camera = Camera(*size, focal_px, focal_px, 0.5 * (size[0] - 1), 0.5 * (size[1] - 1))
        pose = level(np.array([[-away, 0.0, 0.0]]))
        pitched = Motor.from_rotor_translation(
            Rotor.from_rotation_vector([0.0, np.deg2rad(above_deg), 0.0]), np.zeros(3)
        )
        rolled = Rotor.from_rotation_vector([0.0, 0.0, np.deg2rad(turned_deg)])
        eye = pitched @ pose @ Motor.from_rotor_translation(rolled, np.zeros(3))
        tall = tall_at((0.0, 0.0), camera, eye)
        ends = eye.inverse()[:, None].apply(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, tall]]))[0]
        share = np.max(np.abs(np.diff(camera.project(ends), axis=0)) / size)
        assert 0.12 < share < 0.32


def test_a_fifth_of_the_image() -> None:
    look = level(np.tile([-5.0, 0.0, 0.8], (5, 1)))
    assert tall_at((1.0, 0.0), CAMERA, look) == pytest.approx(0.2 * 240 * 6.0 / 300.0)


def test_of_places_seen_alike_one_that_nothing_hides_is_taken() -> None:
    look = level(np.tile([-5.0, 0.0, 0.8], (5, 1)))
    free, seen = best_place(OUTLINE, HEIGHT_M, CAMERA, look, NOTHING, 0.0)

    def unhidden(place: FloatArray) -> float:
        return 0.2 if np.linalg.norm(place - free) < 0.4 * HEIGHT_M else 0.95

    other, still_seen = best_place(OUTLINE, HEIGHT_M, CAMERA, look, NOTHING, 0.0, unhidden)
    assert np.linalg.norm(np.subtract(other, free)) > 0.4 * HEIGHT_M
    assert still_seen > 0.5 * seen
    nowhere = best_place(OUTLINE, HEIGHT_M, CAMERA, look, NOTHING, 0.0, lambda place: 0.3)
    assert nowhere[0] == free
    assert nowhere[1] == pytest.approx(0.3 * seen)
