"""From where light comes without depth: drawn rooms whose light is known, and maps made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.light import ExposureMeter
from motorcade.render.light.cast import cast_shadows, things_seen
from motorcade.render.light.ground import GroundMap
from motorcade.render.light.monocular import LightDirection, light_direction
from motorcade.render.light.sides import CastShadow
from motorcade.tracking.cameras.camera import Camera
from tests.bench.view.rooms import FIVE, Room, draw_room, found_in, off_deg
from tests.end_to_end import replacement

UP = np.array([0.0, 0.0, 1.0])
N = 128
NO_FACES = np.zeros((0, 3)), np.zeros(0)


def table(shadow_rad: float | None, dark: float = 0.5) -> GroundMap:
    """Even ground with a round thing in the middle, and its shadow to one side."""
    y, x = np.mgrid[:N, :N] - 0.5 * (N - 1)
    light, scatter = np.full((N, N), 0.6), np.full((N, N), 0.005)
    if shadow_rad is not None:
        along = x * np.cos(shadow_rad) + y * np.sin(shadow_rad)
        across = y * np.cos(shadow_rad) - x * np.sin(shadow_rad)
        light[(np.abs(across) < 7.0) & (along > 0.0) & (along < 22.0)] *= 1.0 - dark
    scatter[np.hypot(x, y) < 9.0] = 0.5
    none = np.zeros((N, N), bool)
    return GroundMap(Motor.identity(), 0.005, light, scatter, none, none, 0.05, np.array([0, -0.5]))


@pytest.mark.parametrize("shadow_deg", [-150.0, -90.0, -40.0, 10.0, 175.0])
@pytest.mark.parametrize("dark", [0.3, 0.7])
def test_a_shadow_tells_the_side_and_how_dark_it_is(shadow_deg: float, dark: float) -> None:
    (found,) = cast_shadows(table(np.deg2rad(shadow_deg), dark))
    towards = np.rad2deg(np.arctan2(found.towards[1], found.towards[0]))
    # Where the thing hides a part of its shadow, that part is missing.
    assert abs((towards - shadow_deg + 360.0) % 360.0 - 180.0) < 22.0
    assert found.darkening == pytest.approx(dark, rel=0.1)


def test_no_shadow_and_paint_on_all_sides_tell_nothing() -> None:
    assert cast_shadows(table(None)) == []
    ringed = table(None)
    y, x = np.mgrid[:N, :N] - 0.5 * (N - 1)
    light = np.where(np.hypot(x, y) < 12.0, 0.3, ringed.light)
    assert cast_shadows(replace(ringed, light=light)) == []
    found = light_direction(table(None), [], *NO_FACES, UP)
    assert found.towards is None
    assert "no shadow" in found.reason


def shadows(*towards_deg: float) -> list[CastShadow]:
    turns = np.deg2rad(towards_deg)
    return [CastShadow(np.zeros(2), np.array([np.cos(t), np.sin(t)]), 0.5, 1.0) for t in turns]


def told(*towards_deg: float) -> LightDirection:
    return light_direction(table(None), shadows(*towards_deg), *NO_FACES, UP)


def test_shadows_that_agree_are_believed_and_such_that_do_not_are_not() -> None:
    agreed = told(30.0, 42.0, 36.0)
    assert agreed.towards is not None
    assert np.rad2deg(np.arctan2(*agreed.towards[1::-1])) == pytest.approx(36.0, abs=2.0)
    assert agreed.doubt_rad < np.deg2rad(25.0)
    apart = told(30.0, -150.0)
    assert apart.towards is None
    assert "apart" in apart.reason
    assert apart.doubt_rad > agreed.doubt_rad


def test_faces_of_paper_tell_the_direction_by_lamberts_law(rng: np.random.Generator) -> None:
    """Light on faces computed by hand, ambient 0.3 and a lamp of 0.6."""
    normals = rng.normal(size=(12, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lamp = np.array([0.48, -0.6, 0.64])
    falling = 0.3 + 0.6 * np.maximum(normals @ lamp, 0.0)
    found = light_direction(None, [], normals, falling, UP)
    assert found.towards is not None
    assert np.rad2deg(np.arccos(found.towards @ lamp)) < 12.0
    assert light_direction(None, [], np.tile(UP, (12, 1)), falling, UP).towards is None


@pytest.mark.parametrize("gain", [0.5, 0.8, 1.3])
def test_exposure_is_what_the_ground_shows(gain: float) -> None:
    """Bytes by IEC 61966-2-1, beside what the camera is pointed at."""
    ground = table(None)
    down = Motor.from_quaternion_translation([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.6])
    camera = Camera(160, 120, 140.0, 140.0, 79.5, 59.5)
    light: FloatArray = np.full((120, 160), 0.6 * gain)
    stored = np.rint(255.0 * (1.055 * light ** (1.0 / 2.4) - 0.055)).astype(np.uint8)
    meter = ExposureMeter(ground)
    assert meter.gain(stored, camera, down) == pytest.approx(gain, rel=0.02)
    overexposed = np.full_like(stored, 255)
    assert meter.gain(overexposed, camera, down) == pytest.approx(gain, rel=0.02)


@pytest.mark.parametrize("hidden", range(12))
def test_one_face_in_a_shadow_does_not_turn_the_light(
    rng: np.random.Generator, hidden: int
) -> None:
    """Light on faces computed by hand, of which one, whichever, gets almost none."""
    normals = rng.normal(size=(12, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lamp = np.array([0.48, -0.6, 0.64])
    falling = 0.3 + 0.6 * np.maximum(normals @ lamp, 0.0)
    falling[hidden] = 0.1
    found = light_direction(None, [], normals, falling, UP)
    assert found.towards is None or np.arccos(found.towards @ lamp) < 2.0 * found.doubt_rad


@pytest.mark.slow
@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("room", FIVE, ids=lambda room: f"room {room.seed}")
def test_a_rooms_light_lies_within_its_doubt_or_is_said_to_be_unknown(room: Room) -> None:
    found = found_in(draw_room(room))
    if room.share == 0.0:
        assert found.towards is None
    elif found.towards is not None:
        assert off_deg(room, found) < 2.5 * np.rad2deg(found.doubt_rad)
        assert found.darkening is None or abs(found.darkening - room.share) < 0.2
    if room == FIVE[2]:  # bright, with five things that throw shadows: no excuse to know nothing
        assert off_deg(room, found) < 25.0


@pytest.mark.parametrize("softness", [0.02, 0.1, 0.25])
def test_a_lamp_is_as_wide_as_its_shadow_grows_soft(softness: float) -> None:
    """A shadow whose sides and end are the softer the farther they are from the thing."""
    ground = table(0.0)
    y, x = np.mgrid[:N, :N] - 0.5 * (N - 1)
    sigma = 0.7 + softness * np.maximum(x, 0.0)
    sides = norm.cdf((8.0 - y) / sigma) - norm.cdf((-8.0 - y) / sigma)
    lost = 0.7 * sides * norm.cdf((30.0 - x) / sigma) * (x > 0.0)
    (found,) = cast_shadows(replace(ground, light=0.6 * (1.0 - lost)))
    assert found.lamp_radius_rad == pytest.approx(1.2 * softness, abs=0.08)
    assert found.darkening == pytest.approx(0.7, rel=0.15)  # the softest is nowhere full


def test_how_far_a_top_is_seen_tells_how_high_the_light_is() -> None:
    """Two things that reach beyond their feet by 14 cells, whose shadows are 16 cells long."""
    y, x = np.mgrid[:N, :N] - 0.5 * (N - 1)
    light, scatter = np.full((N, N), 0.6), np.full((N, N), 0.005)
    for aside in (-25.0, 25.0):
        off = x - aside
        light[(np.abs(y) < 7.0) & (off > 0.0) & (off < 22.0)] *= 0.4
        # Of its foot what lies in front is seen alike from everywhere.
        scatter[(np.abs(off) < 7.0) & (y > -3.5) & (y < 21.0)] = 0.5
    none, eye = np.zeros((N, N), bool), np.array([0.0, -0.5])
    ground = GroundMap(Motor.identity(), 0.005, light, scatter, none, none, 0.05, eye, 0.5)
    found = cast_shadows(ground)
    assert len(found) == 2
    # Of what is seen beyond, 13.4 cells are 0.8: 17 of 100 + 7 + 17 that lie 100 below the eye.
    for shadow in found:
        assert shadow.elevation_rad == pytest.approx(np.arctan2(13.7, 16.0), abs=0.2)
        assert shadow.towards @ [-1.0, 0.0] > np.cos(np.deg2rad(7.5))


@pytest.mark.slow
@pytest.mark.parametrize(("number", "which"), [(1, 1), (2, 0)])
def test_shadows_of_drawn_things_fall_from_their_feet(number: int, which: int) -> None:
    """Cameras all on one side see a thing begin where it stands, and shadows turn to no side."""
    rng = np.random.default_rng([41, number])
    room = replacement.drawn_room(rng)
    light = replacement.two_lights(rng)[which]
    ground = replacement.empty_footage(room, light, number).ground
    assert ground is not None
    turned = [
        np.rad2deg(np.angle(complex(*one.towards) / np.exp(1j * light.azimuth_rad)))
        for one in cast_shadows(ground)
    ]
    assert len(turned) > 1
    assert abs(np.median(turned)) < 7.0


def test_things_without_shadows_are_counted() -> None:
    assert things_seen(table(None)) == 1
    nothing = table(None)
    assert things_seen(replace(nothing, scatter=0.0 * nothing.scatter)) == 0
