"""`python -m tests.end_to_end.replacement [--count N] [--seed S] [--images DIR]`: by replacement.

A drawn room has a figure standing on its board. It is taken out, and its twin is set in at its
place by the overlay, in the light that the images of the empty room tell. Both films are compared
beside the figure: the shadow's direction from the foot, its darkening, the width of its penumbra,
the contact's darkening under the soles, and SSIM about the figure; and of the figure its brightest
byte of a hundred and its mean, beside it as the room's camera takes it.

Rooms are drawn by a path of their own, which shares nothing with the overlay: bodies' triangles are
projected on the ground from points of the lamp and of the sky, the ground goes into the image by
a homography, and things are painted from far to near. Each room is lit twice: by a lamp, and by a
window so bright that white paper is overexposed. Courtyards have no board, gravel or slabs for a
ground, and the sun. A row each; ends with 1 where a shadow is beyond its bounds.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.metrics import structural_similarity

from motorcade.animation import Character, Placement, mannequin, place_on_plane, skin
from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.animation.vectors import unit
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import render_overlay
from motorcade.render.light import ExposureMeter, Prints, lighting_without_depth
from motorcade.render.light.ground import GroundMap
from motorcade.render.light.monocular import ground_of_footage
from motorcade.render.scene import ImageArray
from motorcade.tracking.boards import Checkerboard
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(480, 360, 420.0, 420.0, 239.5, 179.5)
BOARD = Checkerboard(7, 5, 0.035)
HEIGHT_M, VIEWS, SHOWN = 0.15, 16, (2, 8, 13)
CELL_M, HALF_M = 0.002, 0.8
CELLS = round(2.0 * HALF_M / CELL_M)
SUNS, SKIES, FINE = 48, 64, 2
VEIL = 0.01
TURNED_DEG, DARKER, WIDER, ALIKE = 15.0, 0.15, 0.30, 0.95
SEEN_LIGHT, TOUCHED = 0.1, 0.04
COMPARED_M, COARSE_M, CONTACT_M = 0.30, 0.004, 0.012

Polygon = FloatArray


@dataclass(frozen=True)
class Light:
    """A lamp or a window: where it is, its apparent radius, its share of the light on what lies,
    and the exposure, above 1 where white is overexposed.
    """

    name: str
    azimuth_rad: float
    elevation_rad: float
    radius_rad: float
    share: float
    exposure: float

    @property
    def towards(self) -> FloatArray:
        """(3,) unit, to its middle."""
        a, e = self.azimuth_rad, self.elevation_rad
        return np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])


@dataclass(frozen=True, eq=False)
class Thing:
    """A prism that stands: corners (n, 2) of its foot, its height, and its paint (3,)."""

    foot_m: FloatArray
    height_m: float
    paint: FloatArray

    def faces(self) -> list[Polygon]:
        """Its sides and its top, (k, 3) each."""
        low = np.pad(self.foot_m, ((0, 0), (0, 1)))
        high = low + np.array([0.0, 0.0, self.height_m])
        turned = [np.roll(part, -1, axis=0) for part in (low, high)]
        sides = np.stack([low, turned[0], turned[1], high], axis=1)
        return [*sides, high]


@dataclass(frozen=True, eq=False)
class Room:
    """Paint (CELLS, CELLS, 3) of the ground, what stands on it, the cameras (VIEWS,), and whether
    a board lies there.
    """

    paint: FloatArray
    things: list[Thing]
    poses: Motor
    board: bool = True


@dataclass(frozen=True)
class Replaced:
    """A twin's shadow beside the one that it replaces.

    Attributes:
        summary: what the overlay says of the light.
        turned_deg: from the true direction; NaN where it is said to be unknown.
        darkening: mean of the drawn one over that of the true one.
        penumbra: width of the drawn one's rim over that of the true one's.
        contact: darkening about the soles, drawn over true.
        ssim: about the figure.
        brightest: bytes by which the figure's brightest percent is brighter than it would be.
        mean: bytes by which all of it is.
    """

    summary: str
    turned_deg: float
    darkening: float
    penumbra: float
    contact: float
    ssim: float
    brightest: float
    mean: float

    @property
    def beyond(self) -> list[str]:
        """The bounds that it breaks."""
        broken = {
            "direction": abs(self.turned_deg) > TURNED_DEG,
            "darkening": abs(self.darkening - 1.0) > DARKER,
            "penumbra": abs(self.penumbra - 1.0) > WIDER,
            "ssim": self.ssim < ALIKE,
        }
        return [name for name, is_broken in broken.items() if is_broken]


def drawn_room(rng: np.random.Generator) -> Room:
    """A table with a board, and boxes and cups that stand about it."""
    noise = cv2.GaussianBlur(rng.normal(0.0, 1.0, (CELLS, CELLS)), (0, 0), 2.0)
    wood = np.array([(0.62, 0.55, 0.45), (0.78, 0.78, 0.76), (0.45, 0.45, 0.48)][rng.integers(3)])
    paint = np.clip(to_linear(wood) * (1.0 + 0.03 * noise[..., None] / noise.std()), 0.0, 1.0)
    print_px, origin = BOARD.draw(1.0 / CELL_M)
    middle = 0.5 * (BOARD.points_m[:, :2].min(axis=0) + BOARD.points_m[:, :2].max(axis=0))
    first = np.rint(
        0.5 * CELLS + (-middle / CELL_M) * [1, 1] - [origin[0], print_px.shape[0] - 1 - origin[1]]
    )
    x, y = first.astype(int)
    board = 0.05 + 0.80 * to_linear(print_px[::-1] / 255.0)
    paint[y : y + board.shape[0], x : x + board.shape[1]] = board[..., None]
    things = []
    for k in range(count := int(rng.integers(3, 6))):
        turn = 2.0 * np.pi * (k + rng.uniform(-0.2, 0.2)) / count
        at = rng.uniform(0.22, 0.32) * np.array([np.cos(turn), np.sin(turn)])
        corners = (4, 20)[int(rng.integers(2))]
        angle = 2.0 * np.pi * (np.arange(corners) + rng.uniform()) / corners
        foot = rng.uniform(0.02, 0.035) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        things.append(Thing(foot + at, rng.uniform(0.03, 0.1), rng.uniform(0.02, 0.6, 3)))
    return Room(paint, things, _hand_held(rng))


def drawn_courtyard(rng: np.random.Generator) -> Room:
    """Gravel, or slabs with joints, and posts and boxes that stand on it; no board."""
    coarse, fine = (
        cv2.GaussianBlur(rng.normal(0.0, 1.0, (CELLS, CELLS)), (0, 0), sigma) for sigma in (12, 1.2)
    )
    grain = rng.uniform(0.05, 0.12) * coarse / coarse.std() + rng.uniform(0.08, 0.2) * (
        fine / fine.std()
    )
    stone = to_linear(np.array([(0.70, 0.67, 0.62), (0.55, 0.53, 0.52), (0.40, 0.47, 0.28)]))
    paint = stone[rng.integers(3)] * np.exp(grain)[..., None]
    if rng.random() < 0.5:
        width = int(rng.integers(50, 90))
        joint = (np.arange(CELLS) % width) < 3
        paint = paint * np.where(joint[:, None] | joint, 0.5, 1.0)[..., None]
    things = []
    for k in range(count := int(rng.integers(2, 5))):
        turn = 2.0 * np.pi * (k + rng.uniform(-0.3, 0.3)) / count
        at = rng.uniform(0.16, 0.30) * np.array([np.cos(turn), np.sin(turn)])
        corners = (4, 6, 20)[int(rng.integers(3))]
        angle = 2.0 * np.pi * (np.arange(corners) + rng.uniform()) / corners
        foot = rng.uniform(0.015, 0.045) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        things.append(Thing(foot + at, rng.uniform(0.04, 0.14), rng.uniform(0.02, 0.6, 3)))
    return Room(np.clip(paint, 0.0, 1.0), things, _hand_held(rng, (30.0, 50.0)), board=False)


def _hand_held(rng: np.random.Generator, high_deg: tuple[float, float] = (40.0, 55.0)) -> Motor:
    """Cameras (VIEWS,) on a hand's way about the board, looking at it."""
    start, span = rng.uniform(0.0, 2.0 * np.pi), np.deg2rad(rng.uniform(40.0, 80.0))
    poses = []
    for share in np.linspace(0.0, 1.0, VIEWS):
        turn, high = start + span * share, np.deg2rad(rng.uniform(*high_deg))
        level = np.array([np.cos(turn) * np.cos(high), np.sin(turn) * np.cos(high), np.sin(high)])
        eye = rng.uniform(0.60, 0.72) * level
        z = rng.normal(0.0, 0.02, 3) * [1, 1, 0] - eye
        z /= np.linalg.norm(z)
        x = np.cross(z, [0.0, 0.0, 1.0])
        x /= np.linalg.norm(x)
        rotor = Rotor.from_matrix(np.stack([x, np.cross(z, x), z], axis=1))
        poses.append(Motor.from_rotor_translation(rotor, eye))
    return Motor.stack(poses)


def two_lights(rng: np.random.Generator) -> tuple[Light, Light]:
    """A lamp, and a window that overexposes white paper."""
    azimuth, lamp, window = rng.uniform(-np.pi, np.pi), *np.deg2rad(rng.uniform(30, 60, 2))
    return (
        Light("lamp", azimuth, lamp, 0.04, rng.uniform(0.5, 0.8), rng.uniform(0.9, 1.1)),
        Light("window", azimuth, window, 0.22, rng.uniform(0.5, 0.8), rng.uniform(1.3, 1.7)),
    )


def sunlight(rng: np.random.Generator) -> tuple[Light]:
    """The sun in a clear sky."""
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.deg2rad(rng.uniform(25.0, 60.0))
    return (Light("sun", azimuth, elevation, 0.0047, rng.uniform(0.7, 0.9), rng.uniform(0.9, 1.4)),)


def points_of(light: Light) -> list[tuple[FloatArray, float]]:
    """Points (3,) unit of lamp and sky, each with its share of the light on what lies."""
    side = np.cross(light.towards, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    up, points = np.cross(side, light.towards), []
    for k in range(SUNS):
        radius, turn = np.tan(light.radius_rad) * np.sqrt((k + 0.5) / SUNS), 2.39996 * k
        point = light.towards + radius * (np.cos(turn) * side + np.sin(turn) * up)
        points.append((point / np.linalg.norm(point), light.share / SUNS))
    for k in range(SKIES):  # spread as they light what lies
        level, turn = np.sqrt((k + 0.5) / SKIES), 2.39996 * k
        point = np.array([level * np.cos(turn), level * np.sin(turn), np.sqrt(1.0 - level**2)])
        points.append((point, (1.0 - light.share) / SKIES))
    return points


def ground_light(bodies: list[FloatArray], light: Light) -> FloatArray:
    """Light (CELLS, CELLS) on the ground, 1 where nothing stands before it.

    Args:
        bodies: polygons (n, k, 3) of what stands on it.
        light: that falls on it.
    """
    total = np.zeros((CELLS, CELLS), np.float32)
    hidden = np.zeros((CELLS, CELLS), np.uint8)
    for towards, share in points_of(light):
        hidden[:] = 0
        for polygons in bodies:
            at = polygons[..., :2] - polygons[..., 2:] * (towards[:2] / towards[2])
            cells = np.rint(16.0 * (at / CELL_M + 0.5 * CELLS - 0.5))
            cells = np.clip(cells, -(2**20), 2**20).astype(np.int32)
            for polygon in cells:
                cv2.fillConvexPoly(hidden, polygon, 1, cv2.LINE_8, 4)
        total += np.float32(share) * (1 - hidden)
    return total.astype(np.float64)


def photograph(
    room: Room, falling: FloatArray, light: Light, pose: Motor, body: FloatArray | None = None
) -> FloatArray:
    """Linear light (h, w, 3) that a camera sees of a room, and of a `body` (T, 3, 3) in it."""
    wide = replace(
        CAMERA,
        width=FINE * CAMERA.width,
        height=FINE * CAMERA.height,
        fx=FINE * CAMERA.fx,
        fy=FINE * CAMERA.fy,
        cx=FINE * (CAMERA.cx + 0.5) - 0.5,
        cy=FINE * (CAMERA.cy + 0.5) - 0.5,
    )
    camera_T_world = pose.inverse()
    matrix = np.column_stack(
        [camera_T_world.rotor.apply(np.eye(3)[:2]).T, camera_T_world.translation_m]
    )
    first = CELL_M * (0.5 - 0.5 * CELLS)
    cells = np.array([[CELL_M, 0.0, first], [0.0, CELL_M, first], [0.0, 0.0, 1.0]])
    size = (wide.width, wide.height)
    lit = (room.paint * falling[..., None]).astype(np.float32)
    seen = cv2.warpPerspective(
        lit, wide.matrix @ matrix @ cells, size, flags=cv2.INTER_LINEAR, borderValue=(0.05,) * 3
    )
    eye = pose.translation_m
    for thing in sorted(room.things, key=lambda one: -np.linalg.norm(one.foot_m.mean(0) - eye[:2])):
        for polygon in thing.faces():
            normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
            normal /= np.linalg.norm(normal)
            if normal @ (eye - polygon[0]) > 0.0:
                sun = light.share * max(0.0, normal @ light.towards) / light.towards[2]
                sky = (1.0 - light.share) * (0.6 + 0.4 * normal[2])
                px = np.rint(16.0 * wide.project(camera_T_world.apply(polygon))).astype(np.int32)
                shade = (thing.paint * (sun + sky)).tolist()
                cv2.fillConvexPoly(seen, px, shade, cv2.LINE_8, 4)
    if body is not None:
        _paint_body(seen, body, light, wide, pose)
    small = cv2.resize(seen, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(small, (0, 0), 0.5), np.float64)


def _paint_body(
    seen: NDArray[np.float32], body: FloatArray, light: Light, camera: Camera, pose: Motor
) -> None:
    """Lay a body's triangles (T, 3, 3) over an image, far ones first; it shades itself nowhere."""
    normals = unit(np.cross(body[:, 1] - body[:, 0], body[:, 2] - body[:, 0]))
    sun = light.share * np.maximum(normals @ light.towards, 0.0) / light.towards[2]
    sky = (1.0 - light.share) * (0.6 + 0.4 * normals[:, 2])
    shades = _paint() * (sun + sky)[:, None]
    away = body.mean(axis=1) - pose.translation_m
    px = camera.project(pose.inverse().apply(body.reshape(-1, 3))).reshape(-1, 3, 2)
    px = np.rint(16.0 * px).astype(np.int32)
    for k in np.argsort(-np.linalg.norm(away, axis=1)):
        if normals[k] @ away[k] < 0.0:
            cv2.fillConvexPoly(seen, px[k], shades[k].tolist(), cv2.LINE_8, 4)


@cache
def _paint() -> FloatArray:
    """Linear paint (T, 3) of the figure's triangles."""
    assert _figure().colors is not None
    return np.asarray(to_linear(_figure().colors[_figure().triangles].mean(axis=1)))


def taken(light: FloatArray, exposure: float, rng: np.random.Generator) -> ImageArray:
    """As a camera stores it: exposed, clipped, grained, sRGB."""
    stored = 255.0 * to_srgb(np.minimum(exposure * light + VEIL, 1.0))
    return np.asarray(
        np.clip(np.rint(stored + rng.normal(0.0, 1.2, light.shape)), 0, 255), np.uint8
    )


@cache
def _figure() -> Character:
    return replace(mannequin(), appearance=None)


def _placement() -> Placement:
    return place_on_plane(_figure(), (0.0, 0.0), 0.0, height_m=HEIGHT_M)


def _body(time_s: float) -> tuple[FloatArray, FloatArray]:
    """Vertices (V, 3) and triangles (T, 3, 3) of the figure on the board, metres."""
    vertices = _placement().apply(skin(_figure(), _figure().clip("idle").at(time_s))[0])
    return vertices, vertices[_figure().triangles]


@dataclass(frozen=True, eq=False)
class EmptyFootage:
    """A room without its figure: its frames with their exposures (VIEWS,), what is known of them,
    the ground as they show it, and polygons of what stands there.
    """

    frames: list[tuple[int, ImageArray, None]]
    exposures: FloatArray
    path: Trajectory
    prints: Prints | None
    ground: GroundMap | None
    solid: list[FloatArray]


def empty_footage(room: Room, light: Light, seed: int) -> EmptyFootage:
    """Take images of a room without its figure."""
    rng = np.random.default_rng(seed)
    stamps = 100_000_000 * np.arange(VIEWS, dtype=np.int64)
    path = Trajectory(stamps, room.poses, "world", "camera")
    faces: dict[int, list[FloatArray]] = {}
    for thing in room.things:
        for polygon in thing.faces():
            faces.setdefault(len(polygon), []).append(polygon)
    solid = [np.stack(group) for group in faces.values()]
    empty = ground_light(solid, light)
    exposures = light.exposure * rng.uniform(0.95, 1.05, VIEWS)
    frames = [
        (
            int(t),
            taken(photograph(room, empty, light, pose), gain, np.random.default_rng([seed, k])),
            None,
        )
        for k, (t, pose, gain) in enumerate(zip(stamps, room.poses, exposures, strict=True))
    ]
    corners = BOARD.points_m[:, :2] - 0.5 * (
        BOARD.points_m[:, :2].min(0) + BOARD.points_m[:, :2].max(0)
    )
    prints = None
    if room.board:
        prints = Prints(Motor.identity((1,)), corners.min(axis=0)[None], corners.max(axis=0)[None])
    ground = ground_of_footage(frames, CAMERA, path, _placement(), prints)
    return EmptyFootage(frames, exposures, path, prints, ground, solid)


def replaced(room: Room, light: Light, seed: int, images: Path | None = None) -> Replaced:
    """Take the figure out of a room, set its twin in, and compare.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    footage, placement = empty_footage(room, light, seed), _placement()
    frames, prints, ground = footage.frames, footage.prints, footage.ground
    lighting, summary = lighting_without_depth(
        frames, CAMERA, footage.path, placement, HEIGHT_M, prints, ground
    )
    film = render_overlay(
        [frames[k] for k in SHOWN],
        CAMERA,
        footage.path,
        _figure(),
        _figure().clip("idle"),
        placement,
        lighting=lighting,
        prints=prints,
        meter=None if ground is None else ExposureMeter(ground),
    )
    parts, alike, shown, looks = [], [], [], []
    for k, drawn in zip(SHOWN, film, strict=True):
        vertices, triangles = _body(1e-9 * float(frames[k][0] - frames[SHOWN[0]][0]))
        dark = ground_light([*footage.solid, triangles], light)
        real = taken(
            photograph(room, dark, light, room.poses[k], triangles),
            float(footage.exposures[k]),
            np.random.default_rng([seed, k]),
        )
        body = _covered(vertices, triangles, room.poses[k])
        before = frames[k][1]
        parts.append(_lost(before, real, drawn, body, room, room.poses[k]))
        alike.append(_about(real, drawn, body))
        inner = cv2.erode(body.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
        looks.append([(np.quantile(one[inner], 0.99), one[inner].mean()) for one in (real, drawn)])
        shown.append(np.hstack([real, drawn]))
    if images is not None:
        images.mkdir(parents=True, exist_ok=True)
        file = images / f"{seed}_{light.name}.png"
        cv2.imwrite(str(file), np.vstack(shown)[..., ::-1])
    at_m, true, lost = (np.concatenate(part) for part in zip(*parts, strict=True))
    brightest, mean = np.mean(np.diff(looks, axis=1)[:, 0], axis=0).tolist()
    return _compared(at_m, true, lost, summary, (float(np.mean(alike)), brightest, mean))


def _covered(vertices: FloatArray, triangles: FloatArray, pose: Motor) -> NDArray[np.bool_]:
    """Pixels (h, w) that a body hides, and those next to them."""
    mask = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
    px = CAMERA.project(pose.inverse().apply(triangles.reshape(-1, 3))).reshape(-1, 3, 2)
    for polygon in np.rint(16.0 * px).astype(np.int32):
        cv2.fillConvexPoly(mask, polygon, 1, cv2.LINE_8, 4)
    return np.asarray(cv2.dilate(mask, np.ones((5, 5), np.uint8)) > 0)


def _lost(
    before: ImageArray,
    real: ImageArray,
    drawn: ImageArray,
    body: NDArray[np.bool_],
    room: Room,
    pose: Motor,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ground (N, 2) that is seen about the figure, and the light that it lost in either image."""
    x = (np.arange(CAMERA.width) - CAMERA.cx) / CAMERA.fx
    y = (np.arange(CAMERA.height) - CAMERA.cy) / CAMERA.fy
    ray = pose.rotor.apply(np.stack([*np.meshgrid(x, y), np.ones(body.shape)], axis=-1))
    eye = pose.translation_m
    at_m = eye[:2] + (-eye[2] / np.minimum(ray[..., 2], -1e-6))[..., None] * ray[..., :2]
    things = np.zeros(body.shape, np.uint8)
    for thing in room.things:
        for polygon in thing.faces():
            px = np.rint(CAMERA.project(pose.inverse().apply(polygon))).astype(np.int32)
            cv2.fillConvexPoly(things, px, 1)
    light = [
        to_linear(cv2.blur(image, (3, 3)) / 255.0).mean(axis=2) for image in (before, real, drawn)
    ]
    near = (np.linalg.norm(at_m, axis=2) < COMPARED_M) & (ray[..., 2] < 0.0)
    seen = near & ~body & (cv2.dilate(things, np.ones((5, 5), np.uint8)) == 0)
    seen &= light[0] > SEEN_LIGHT
    return at_m[seen], 1.0 - light[1][seen] / light[0][seen], 1.0 - light[2][seen] / light[0][seen]


def _about(real: ImageArray, drawn: ImageArray, body: NDArray[np.bool_]) -> float:
    """SSIM of the surroundings of a figure: its box, as wide again on all sides, without itself."""
    rows, columns = np.flatnonzero(body.any(axis=1)), np.flatnonzero(body.any(axis=0))
    high, wide = len(rows), len(columns)
    top, left = max(rows[0] - high // 2, 0), max(columns[0] - wide, 0)
    part = np.s_[top : rows[-1] + high // 2, left : columns[-1] + wide]
    a, b = (np.where(body[..., None], 0, image)[part].astype(np.float64) for image in (real, drawn))
    full = structural_similarity(
        a, b, channel_axis=2, data_range=255, gaussian_weights=True, sigma=1.5, full=True
    )[1]
    return float(
        full[
            ~cv2.dilate(body.astype(np.uint8), np.ones((7, 7), np.uint8))[part].astype(bool)
        ].mean()
    )


def _compared(
    at_m: FloatArray, true: FloatArray, drawn: FloatArray, summary: str, looks: tuple[float, ...]
) -> Replaced:
    n = round(2.0 * COMPARED_M / COARSE_M)
    column, row = np.clip(at_m.T / COARSE_M + 0.5 * n, 0, n - 1).astype(int)
    count = np.bincount(row * n + column, minlength=n * n)
    known = (count > 0).reshape(n, n)
    maps = [
        (
            np.bincount(row * n + column, weights=one, minlength=n * n) / np.maximum(count, 1)
        ).reshape(n, n)
        for one in (true, drawn)
    ]
    along = (np.arange(n) + 0.5 - 0.5 * n) * COARSE_M
    x, y = np.meshgrid(along, along)
    near = known & (np.hypot(x, y) < CONTACT_M + 0.12 * HEIGHT_M)
    touched = known & ((maps[0] > TOUCHED) | (maps[1] > TOUCHED))
    middles, means, rims, contacts = [], [], [], []
    for lost in maps:
        shade = np.where(touched & (lost > TOUCHED), lost, 0.0)
        middles.append(complex((shade * x).sum(), (shade * y).sum()))
        means.append(np.where(touched, lost, 0.0).sum())
        rims.append(_rim(np.where(known, shade, 0.0)))
        contacts.append(lost[near].mean() if near.any() else np.nan)
    turned = float(np.rad2deg(np.angle(middles[1] / middles[0]))) if middles[0] else 0.0
    told = "assumed" not in summary
    return Replaced(
        summary,
        turned if told else float("nan"),
        float(means[1] / means[0]),
        rims[1] / max(rims[0], 1e-9),
        float(contacts[1] / contacts[0]),
        *looks,
    )


def _rim(shade: FloatArray) -> float:
    """Width of a shadow's rim, cells: its area between a fifth and four fifths of its full
    darkness over the length of the line between.
    """
    some = shade[shade > TOUCHED]
    if not some.size:
        return 0.0
    level = cv2.GaussianBlur(shade / np.quantile(some, 0.9), (0, 0), 0.7)
    lines, _ = cv2.findContours(
        (level > 0.5).astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE
    )
    length = sum(cv2.arcLength(line, True) for line in lines)
    return float(np.count_nonzero((level > 0.2) & (level < 0.8)) / max(length, 1.0))


def main() -> None:
    """A row a room and light, and how many hold their bounds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--kind", choices=("rooms", "courtyards"), default="rooms")
    parser.add_argument("--images", type=Path)
    arguments = parser.parse_args()
    failed = shown = 0
    for number in range(arguments.count):
        rng = np.random.default_rng([arguments.seed, number])
        sunny = arguments.kind == "courtyards"
        room = drawn_courtyard(rng) if sunny else drawn_room(rng)
        for light in sunlight(rng) if sunny else two_lights(rng):
            shown += 1
            result = replaced(room, light, 100 * arguments.seed + number, arguments.images)
            failed += bool(result.beyond)
            print(
                f"room {number}, {light.name:6} (share {light.share:.2f}): "
                f"turned {result.turned_deg:6.1f}°, darkening × {result.darkening:.2f}, "
                f"penumbra × {result.penumbra:.2f}, contact × {result.contact:.2f}, "
                f"SSIM {result.ssim:.3f}, "
                f"brightest {result.brightest:+.0f}, mean {result.mean:+.0f} "
                f"{', '.join(result.beyond) or 'holds'}; {result.summary}",
                flush=True,
            )
    print(f"{failed} of {shown} beyond their bounds")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
