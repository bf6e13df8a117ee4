"""Drawn rooms with a light that is known, to be found from their images without depth.

A table top with a checkerboard on it, things that stand about, and in some rooms markers on the
sides of boxes, drawn by the house's renderer with shadows from many points of a sun of some width
and of the sky, which things hide from the table; then vignetted, exposed anew for every image,
and grained. Poses are the true ones. The five rooms that are judged, and as many others as asked
for, whose constants may be looked at:

    python -m tests.bench.view.rooms              # the five
    python -m tests.bench.view.rooms --others 20  # twenty others
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from motorcade.animation import Placement, mannequin, place_on_plane
from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Sun, Surface
from motorcade.render.light import Prints, lighting_without_depth, monocular, sun_share
from motorcade.render.light.ground import ground_map
from motorcade.render.light.monocular import LightDirection
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.tracking.boards import Checkerboard
from motorcade.tracking.cameras.camera import Camera
from tests.bench.view.printed import printed_surface

__all__ = [
    "CAMERA",
    "FIVE",
    "HEIGHT_M",
    "Room",
    "RoomImages",
    "draw_room",
    "found_in",
    "mean_light",
    "off_deg",
    "others",
]

CAMERA = Camera(480, 360, 420.0, 420.0, 239.5, 179.5)
BOARD = Checkerboard(7, 5, 0.035)
VIEWS = 16
SUN_RADIUS_RAD, SUN_POINTS, SKY_POINTS = 0.08, 7, 24
LEVEL = 0.85
"""Light on what lies: white paper is lit nearly fully."""
HEIGHT_M = 0.15
PIXELS_PER_M = 1500.0
_LINEAR = to_linear(np.arange(256) / 255.0).astype(np.float32)


@dataclass(frozen=True)
class Room:
    """What a room is lit by and what stands in it.

    Attributes:
        azimuth_deg: of the light, from the world's x towards its y.
        elevation_deg: of the light.
        share: of the light on the table that is the sun's.
        things: how many stand about the board.
        faces: whether boxes carry markers on their sides.
        seed: of all else.
    """

    azimuth_deg: float
    elevation_deg: float
    share: float
    things: int
    faces: bool
    seed: int

    @property
    def towards(self) -> FloatArray:
        """(3,) unit, to the light."""
        a, e = np.deg2rad([self.azimuth_deg, self.elevation_deg])
        return np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])


FIVE = (
    Room(25.0, 42.0, 0.6, 4, False, 1),
    Room(160.0, 35.0, 0.45, 3, False, 2),
    Room(-70.0, 55.0, 0.7, 5, False, 3),
    Room(-130.0, 50.0, 0.55, 3, True, 4),
    Room(90.0, 60.0, 0.0, 4, False, 5),  # no sun at all: nothing to be told
)


@dataclass(frozen=True, eq=False)
class RoomImages:
    """What was drawn: stamped images, their poses, the prints, and the light in them."""

    frames: tuple[tuple[int, ImageArray, None], ...]
    path: Trajectory
    prints: Prints
    placement: Placement
    lighting: Lighting
    surfaces: list[Surface]


def off_deg(room: Room, found: LightDirection) -> float:
    """Angle between the room's light and what was found; NaN where nothing was told."""
    if found.towards is None:
        return float("nan")
    return float(np.rad2deg(np.arccos(np.clip(room.towards @ found.towards, -1.0, 1.0))))


def found_in(made: RoomImages) -> LightDirection:
    """The direction of light that the images tell."""
    seen = monocular._posed(made.frames, made.path)
    ground = ground_map(seen, CAMERA, made.placement.world_T_character, made.prints)
    on_prints = monocular._on_prints(seen, CAMERA, made.prints)
    return monocular._direction(ground, made.placement, made.prints, on_prints)


def draw_room(room: Room) -> RoomImages:
    """Draw a room's images.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    rng = np.random.default_rng(room.seed)
    surfaces, prints = furniture(room, rng)
    poses = _cameras(rng)
    light = mean_light(surfaces, poses, room)
    stamps = 100_000_000 * np.arange(VIEWS, dtype=np.int64)
    frames = tuple(
        (int(stamp), _taken(one, rng), None) for stamp, one in zip(stamps, light, strict=True)
    )
    placement = place_on_plane(mannequin(), (0.0, 0.0), 0.0, height_m=HEIGHT_M)
    path = Trajectory(stamps, poses, "world", "camera")
    return RoomImages(frames, path, prints, placement, _lit(room.towards, room.share), surfaces)


def mean_light(surfaces: list[Surface], poses: Motor, room: Room) -> FloatArray:
    """Linear images (N, h, w, 3) of all poses in the room's light: sun and sky by points."""
    points = [(towards, room.share / towards[2] / SUN_POINTS) for towards in _suns(room.towards)]
    points += [(towards, 2.0 * (1.0 - room.share) / SKY_POINTS) for towards in _sky()]
    light = np.zeros((len(poses), CAMERA.height, CAMERA.width, 3), np.float32)
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        for towards, weight in points:
            if weight == 0.0:
                continue
            x, y, z = (-towards).tolist()
            sun = Sun((x, y, z), np.pi * LEVEL)
            renderer.show(surfaces, Lighting((0.0, 0.0, 0.0), sun, (), (0.0, 0.0, 0.05), 0.75))
            for total, pose in zip(light, poses, strict=True):
                total += np.float32(weight) * _LINEAR[renderer.render(CAMERA, pose).rgba[..., :3]]
    return light.astype(np.float64)


def _lit(towards: FloatArray, share: float) -> Lighting:
    """Light of which the sun has a share on what lies."""
    ambient = LEVEL * (1.0 - share)
    x, y, z = (-towards).tolist()
    sun = Sun(
        (x, y, z), np.pi * LEVEL * share / max(towards[2], 0.05), (1.0, 1.0, 1.0), SUN_RADIUS_RAD
    )
    return Lighting((ambient, ambient, ambient), sun, (), (0.0, 0.0, 0.05), 0.75)


def _sky() -> FloatArray:
    """Directions spread evenly over the half sphere above."""
    k = np.arange(SKY_POINTS) + 0.5
    z, turn = k / SKY_POINTS, k * np.pi * (3.0 - np.sqrt(5.0))
    level = np.sqrt(1.0 - z * z)
    return np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)


def _suns(towards: FloatArray) -> Iterator[FloatArray]:
    side = np.cross(towards, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    for k in range(SUN_POINTS):
        radius, turn = SUN_RADIUS_RAD * np.sqrt((k + 0.5) / SUN_POINTS), k * 2.4
        off = np.cos(turn) * side + np.sin(turn) * np.cross(side, towards)
        point = towards + radius * off
        yield point / np.linalg.norm(point)


def _cameras(rng: np.random.Generator) -> Motor:
    """A hand's way about the board, looking at it."""
    start, span = rng.uniform(0.0, 2.0 * np.pi), np.deg2rad(rng.uniform(40.0, 80.0))
    poses = []
    for u in np.linspace(0.0, 1.0, VIEWS):
        turn, high = start + span * u, np.deg2rad(rng.uniform(42.0, 55.0))
        distance = rng.uniform(0.62, 0.72)
        eye = distance * np.array(
            [np.cos(turn) * np.cos(high), np.sin(turn) * np.cos(high), np.sin(high)]
        )
        ahead = rng.normal(0.0, 0.02, 3) * [1, 1, 0] - eye
        z = ahead / np.linalg.norm(ahead)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        rotor = Rotor.from_matrix(np.stack([x, np.cross(z, x), z], axis=1))
        poses.append(Motor.from_rotor_translation(rotor, eye))
    return Motor.stack(poses)


def furniture(room: Room, rng: np.random.Generator) -> tuple[list[Surface], Prints]:
    """The table, its board and things, and what is printed."""
    image, origin = BOARD.draw(PIXELS_PER_M)
    low = BOARD.points_m[:, :2].min(axis=0)
    high = BOARD.points_m[:, :2].max(axis=0)
    world_T_board = Motor.from_translation([*(-0.5 * (low + high)), 0.0005])
    wood = rng.integers(0, 3)
    table = _table((0.62, 0.55, 0.45) if wood == 0 else (0.78, 0.78, 0.76), rng)
    surfaces = [table, printed_surface(image, PIXELS_PER_M, origin, world_T_board)]
    poses, lows, highs = [world_T_board], [low], [high]
    for k in range(room.things):
        turn = 2.0 * np.pi * (k + rng.uniform(-0.2, 0.2)) / room.things
        at = rng.uniform(0.24, 0.30) * np.array([np.cos(turn), np.sin(turn)])
        size = rng.uniform([0.03, 0.03, 0.04], [0.06, 0.06, 0.10])
        stand = Motor.from_rotor_translation(
            Rotor.from_rotation_vector([0.0, 0.0, rng.uniform(0.0, 2.0)]), [*at, 0.0]
        )
        surfaces.append(_box(stand, size, rng.uniform(0.1, 0.8, 3)))
        if room.faces:
            for side in range(4):
                side_T = Motor.from_rotor_translation(
                    Rotor.from_rotation_vector([0.0, 0.0, 0.5 * np.pi * side])
                    @ Rotor.from_matrix(np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])),
                    [0.0, 0.0, 0.0],
                )
                out = 0.5 * size[side % 2] + 0.0005
                middle = Motor.from_translation([0.0, 0.5 * size[2], out])
                world_T_print = stand @ side_T @ middle
                half = 0.42 * min(size[(side + 1) % 2], size[2])
                surfaces.append(_marker(world_T_print, half, rng))
                poses.append(world_T_print)
                lows.append(np.array([-half, -half]))
                highs.append(np.array([half, half]))
    return surfaces, Prints(Motor.stack(poses), np.stack(lows), np.stack(highs))


def _marker(world_T_print: Motor, half: float, rng: np.random.Generator) -> Surface:
    cells = np.kron(rng.integers(0, 2, (6, 6)), np.ones((8, 8))) * 255
    scale = len(cells) / (2.0 * half)
    origin = (0.5 * (len(cells) - 1), 0.5 * (len(cells) - 1))
    return printed_surface(cells.astype(np.uint8), scale, origin, world_T_print)


def _table(color: tuple[float, float, float], rng: np.random.Generator) -> Surface:
    grain = rng.normal(0.0, 1.0, (512, 512)).astype(np.float32)
    grain = cv2.GaussianBlur(grain, (0, 0), 2.0)
    grain = 1.0 + 0.04 * grain / grain.std()
    texture = np.clip(255.0 * np.array(color) * grain[..., None], 0, 255).astype(np.uint8)
    made = printed_surface(texture, 512 / 1.8, (255.5, 255.5), Motor.identity())
    return Surface(
        made.vertices,
        made.normals,
        made.triangles,
        texture=made.texture,
        texture_coordinates=made.texture_coordinates,
        roughness=1.0,
    )


def _box(stand: Motor, size: FloatArray, color: FloatArray) -> Surface:
    vertices: list[FloatArray] = []
    normals: list[FloatArray] = []
    triangles: list[list[int]] = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            n = sign * np.eye(3)[axis]
            u = np.eye(3)[(axis + 1) % 3]
            v = np.cross(n, u)
            first = 4 * len(normals)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                vertices.append(0.5 * (n + a * u + b * v) * size + [0, 0, 0.5 * size[2]])
            normals.append(np.tile(n, (4, 1)))
            triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    flat = np.concatenate(normals)
    return Surface(
        stand.apply(np.array(vertices)),
        stand.rotor.apply(flat),
        np.array(triangles),
        np.tile(color, (len(flat), 1)),
        roughness=0.9,
    )


def _taken(light: FloatArray, rng: np.random.Generator) -> ImageArray:
    """As a camera takes it: vignetted, exposed by chance, grained, stored as sRGB."""
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
    square = ((x - CAMERA.cx) ** 2 + (y - CAMERA.cy) ** 2) / CAMERA.fx**2
    seen = light * ((1.0 + square) ** -2.0)[..., None] * rng.uniform(0.85, 1.1)
    seen = np.rint(255.0 * to_srgb(seen) + rng.normal(0.0, 1.5, seen.shape))
    return np.asarray(np.clip(seen, 0, 255), np.uint8)


def others(count: int) -> list[Room]:
    """Rooms to look at while the method is made; none of them is judged."""
    rng = np.random.default_rng(100)
    return [
        Room(
            rng.uniform(-180.0, 180.0),
            rng.uniform(25.0, 70.0),
            rng.uniform(0.3, 0.75) if k % 5 else 0.0,  # some without a sun
            int(rng.integers(1, 6)),
            bool(rng.integers(0, 2)),
            1000 + k,
        )
        for k in range(count)
    ]


def rows(rooms: list[Room] | tuple[Room, ...]) -> Iterator[dict[str, float | str]]:
    """What was found in each room."""
    for room in rooms:
        made = draw_room(room)
        found = found_in(made)
        lighting, _ = lighting_without_depth(
            made.frames, CAMERA, made.path, made.placement, HEIGHT_M, made.prints
        )
        ground, up = np.zeros(3), np.array([0.0, 0.0, 1.0])
        yield {
            "azimuth_deg": room.azimuth_deg,
            "elevation_deg": room.elevation_deg,
            "off_deg": off_deg(room, found),
            "doubt_deg": float(np.rad2deg(found.doubt_rad)),
            "share": room.share,
            "drawn_share": sun_share(lighting, ground, up),
            "told": found.reason,
        }


def main() -> None:
    """A line a room."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--others", type=int, default=0)
    given = parser.parse_args()
    for row in rows(others(given.others) if given.others else FIVE):
        print(
            f"light at {row['azimuth_deg']:6.0f}°, {row['elevation_deg']:3.0f}° high: "
            f"off {row['off_deg']:5.1f}° (doubt {row['doubt_deg']:4.1f}°), takes "
            f"{row['share']:.2f}, drawn {row['drawn_share']:.2f}; {row['told']}",
            flush=True,
        )


if __name__ == "__main__":
    main()
