"""From where light comes without depth: drawn rooms whose light is known, and maps made by hand."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render.light import ExposureMeter
from motorcade.render.light.cast import CastShadow, cast_shadows, things_seen
from motorcade.render.light.ground import VEIL, GroundMap
from motorcade.render.light.monocular import LightDirection, light_direction
from motorcade.tracking.cameras.camera import Camera
from tests.bench.view.rooms import FIVE, Room, draw_room, found_in, off_deg
from tests.end_to_end import replacement

UP = np.array([0.0, 0.0, 1.0])
N = 128
NO_FACES = np.zeros((0, 3)), np.zeros(0)


def table(
    shadow_rad: float | None,
    dark: float = 0.5,
    elevation_deg: float = 45.0,
    radius_rad: float = 0.0,
    feet: tuple[tuple[float, float], ...] = ((0.0, 0.0),),
    paint: float = 0.2,
) -> GroundMap:
    """Even ground that eight cameras see, with round posts of 7 cells by 14, and their shadows to
    one side: outlines of the post's rims, seen from the eyes and from points of the lamp.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 40)
    rim = 7.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    middle = 0.5 * (N - 1)
    both = np.concatenate([rim, rim + np.array([0.0, 0.0, 14.0])])
    posts = [both + np.array([x, y, 0.0]) for x, y in feet]

    def covered(outlines: list[FloatArray]) -> FloatArray:
        mask = np.zeros((N, N), np.uint8)
        for at in outlines:
            hull = cv2.convexHull(np.float32(at + middle))
            cv2.fillConvexPoly(mask, np.rint(16.0 * hull).astype(np.int32), 1, cv2.LINE_8, 4)
        return mask.astype(np.float64)

    lost = np.zeros((N, N))
    if shadow_rad is not None:
        high = np.deg2rad(elevation_deg)
        k = np.arange(60)
        disc = radius_rad * np.sqrt((k + 0.5) / 60) * np.exp(2.39996j * k)
        for off in disc:
            slope = 1.0 / np.tan(high + off.real)
            way = shadow_rad + off.imag / np.cos(high)
            step = slope * np.array([np.cos(way), np.sin(way)])
            lost += dark / 60 * covered([post[:, :2] + post[:, 2:] * step for post in posts])
    ground = cv2.GaussianBlur(0.6 * (1.0 - lost), (0, 0), 0.7)
    turns = np.deg2rad(np.linspace(-120.0, -60.0, 8))
    eyes = 100.0 * np.stack([np.cos(turns), np.sin(turns), np.ones(8)], axis=1)
    hidden = [
        covered([eye[:2] + (post[:, :2] - eye[:2]) / (1.0 - post[:, 2:] / 100.0) for post in posts])
        for eye in eyes
    ]
    shade = paint * np.linspace(0.7, 1.4, 8)[:, None, None]  # another face for each
    levels = np.log(np.where(np.array(hidden) > 0.0, shade, ground) + VEIL)
    light = np.median(levels, axis=0)
    scatter = 1.4826 * np.median(np.abs(levels - light), axis=0) + 0.005
    none = np.zeros((N, N), bool)
    return GroundMap(
        Motor.identity(),
        0.005,
        np.exp(light) - VEIL,
        scatter,
        none,
        none,
        0.05,
        levels,
        0.005 * eyes,
    )


@pytest.mark.parametrize("shadow_deg", [-150.0, -90.0, -40.0, 10.0, 175.0])
@pytest.mark.parametrize("dark", [0.3, 0.7])
def test_a_shadow_tells_the_side_and_how_dark_it_is(shadow_deg: float, dark: float) -> None:
    (found,) = cast_shadows(table(np.deg2rad(shadow_deg), dark))
    towards = np.rad2deg(np.arctan2(found.towards[1], found.towards[0]))
    assert abs((towards - shadow_deg + 360.0) % 360.0 - 180.0) < 5.0
    assert found.darkening == pytest.approx(dark, rel=0.1)


def test_no_shadow_and_paint_on_all_sides_tell_nothing() -> None:
    assert cast_shadows(table(None)) == []
    ringed = table(None)
    y, x = np.mgrid[:N, :N] - 0.5 * (N - 1)
    ring = (np.hypot(x, y) < 12.0) & (ringed.levels == ringed.levels.max())
    assert cast_shadows(replace(ringed, levels=ringed.levels - 0.7 * ring)) == []
    found = light_direction(table(None), [], *NO_FACES, UP)
    assert found.towards is None
    assert "no shadow" in found.reason


def shadows(*towards_deg: float) -> list[CastShadow]:
    turns = np.deg2rad(towards_deg)
    return [CastShadow(np.zeros(2), np.array([np.cos(t), np.sin(t)]), 0.5) for t in turns]


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


@pytest.mark.parametrize("radius_rad", [0.005, 0.12, 0.25])
def test_a_lamp_is_as_wide_as_its_shadow_grows_soft(radius_rad: float) -> None:
    (found,) = cast_shadows(table(0.4, 0.7, radius_rad=radius_rad))
    assert np.sqrt(max(found.radius2, 0.0)) == pytest.approx(radius_rad, abs=0.06)
    assert found.darkening == pytest.approx(0.7, rel=0.15)  # the softest is nowhere full


@pytest.mark.parametrize("paint", [0.05, 0.3])
@pytest.mark.parametrize("elevation_deg", [25.0, 40.0, 58.0])
def test_how_much_a_thing_hides_tells_how_high_the_light_is(
    elevation_deg: float, paint: float
) -> None:
    """Dark things too, which hide their own shadow's beginning."""
    feet = ((-28.0, 0.0), (22.0, 8.0))
    found = cast_shadows(table(0.7, 0.6, elevation_deg, 0.0, feet, paint))
    assert len(found) == 2
    for shadow in found:
        assert np.rad2deg(shadow.elevation_rad) == pytest.approx(elevation_deg, abs=4.0)
        assert shadow.elevation_sigma_rad < 0.15
        assert np.min(np.linalg.norm(shadow.middle_m / 0.005 - np.array(feet), axis=1)) < 2.0


def test_one_sharp_shadow_is_believed() -> None:
    ground = table(0.7, 0.8, 35.0)
    found = light_direction(ground, cast_shadows(ground), *NO_FACES, UP)
    assert found.towards is not None
    light = [-np.cos(0.7) * np.cos(0.61), -np.sin(0.7) * np.cos(0.61), np.sin(0.61)]
    assert np.rad2deg(np.arccos(found.towards @ light)) < 8.0
    assert found.darkening == pytest.approx(0.8, rel=0.1)


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
