"""Drawn shadows beside the footage's own, in pixels.

In the drawn rooms (`rooms`) a figure is drawn standing in the room, and is set into the images of
the empty one as into any footage, in the light that these images tell: what both take from the
same pixels of the ground is compared. In `vamr_board` the body of the computer mouse, an ellipsoid
fitted to its outlines in five frames, is given the shadow that a figure in its place would get, and
that is compared with the shadow that the mouse throws on the desk:

    python -m tests.bench.view.shadows              # the five rooms and the mouse
    python -m tests.bench.view.shadows --others 10  # ten other rooms
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation import Character, Placement, mannequin, place_on_plane, skin
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.render import Lighting, Surface, render_overlay
from motorcade.render.light import Prints, lighting_without_depth, sun_share
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.render.shadow import GRID, ShadowLook, ground_shade
from motorcade.replays.stages.view.overlay import LIT_FRAMES, _Footage
from motorcade.tracking.cameras.camera import Camera
from tests.bench.data import data_folder
from tests.bench.view.registration import vamr_board
from tests.bench.view.rooms import CAMERA, FIVE, HEIGHT_M, Room, draw_room, mean_light, others

__all__ = ["Shade", "mouse_shade", "room_shades"]

SHOWN = (1, 6, 11)
"""Images of a room that are compared."""
LEAST_LIGHT, TOUCHED = 0.15, 0.04
"""Ground is compared where it is bright enough to tell, and either shadow takes more than this."""
FULL = 0.9
"""The quantile of a shadow that counts as its full darkness: no single pixel does."""
MOUSE_M, MOUSE_HALF_M = (0.549, -0.013), (0.028, 0.046, 0.030)
"""Of the mouse on the desk, in the board's frame: fitted, for four fifths to nine tenths of its
outline, by hand, where the desk is as high as the board."""
BESIDE_M, CLEAR_M = (0.004, 0.040), (0.050, 0.080)
"""From the mouse's outline: where its shadow is judged, and desk that it does not reach."""
OVEREXPOSED = 245


@dataclass(frozen=True)
class Shade:
    """Two shadows on the same ground, the footage's and the drawn one.

    Attributes:
        true: share of light that the footage's shadow takes where it is full.
        drawn: by the one that is drawn.
        apart: mean difference, as a share of the light, wherever either is.
        true_m: (2,) its middle from the foot, on the ground.
        drawn_m: (2,) of the drawn one.
    """

    true: float
    drawn: float
    apart: float
    true_m: tuple[float, float]
    drawn_m: tuple[float, float]

    @property
    def ratio(self) -> float:
        """Drawn darkening over true."""
        return self.drawn / max(self.true, 1e-6)


@cache
def _figure() -> Character:
    """The mannequin by colours of its vertices, which the room's renderer draws too."""
    return replace(mannequin(), appearance=None)


def room_shades(room: Room) -> tuple[Shade, float]:
    """Shadows of a figure in a room and set into it; and the sun's share that was drawn.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    made = draw_room(room)
    lighting, _ = lighting_without_depth(
        made.frames, CAMERA, made.path, made.placement, HEIGHT_M, made.prints
    )
    poses, time_ns = made.path.motors[list(SHOWN)], made.path.time_ns[list(SHOWN)]
    empty = mean_light(made.surfaces, poses, room)
    figure = _figure()
    given = [made.frames[k][1] for k in SHOWN]
    drawn = render_overlay(
        list(zip(time_ns.tolist(), given, strict=True)),
        CAMERA,
        made.path,
        figure,
        figure.clip("idle"),
        made.placement,
        lighting=lighting,
    )
    parts = []
    for k, image in enumerate(drawn):
        body = _standing(made.placement, 1e-9 * float(time_ns[k] - time_ns[0]))
        full = mean_light([body, *made.surfaces], poses[k : k + 1], room)[0]
        before, after = (to_linear(one / 255.0).mean(axis=2) for one in (given[k], image))
        ground_m = _on_ground(poses[k])
        seen = (
            ~_covered(body, poses[k])
            & (empty[k].mean(axis=2) > LEAST_LIGHT)
            & (before > LEAST_LIGHT)
        )
        seen &= (given[k].max(axis=2) < 255) & (np.linalg.norm(ground_m, axis=2) < 1.5 * HEIGHT_M)
        true = 1.0 - full.mean(axis=2)[seen] / empty[k].mean(axis=2)[seen]
        parts.append((true, 1.0 - after[seen] / before[seen], ground_m[seen]))
    true, lost, at_m = (np.concatenate(part) for part in zip(*parts, strict=True))
    share = sun_share(lighting, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    return _shade(true, lost, at_m), share


def _shade(true: FloatArray, drawn: FloatArray, at_m: FloatArray) -> Shade:
    true, drawn = np.maximum(true, 0.0), np.maximum(drawn, 0.0)
    touched = (true > TOUCHED) | (drawn > TOUCHED)
    dark = [float(np.quantile(one[one > TOUCHED], FULL, method="nearest"))
            if np.any(one > TOUCHED) else 0.0 for one in (true, drawn)]  # fmt: skip
    middles = [(one @ at_m / max(float(one.sum()), 1e-9)).tolist() for one in (true, drawn)]
    apart = float(np.abs(true - drawn)[touched].mean())
    return Shade(dark[0], dark[1], apart, (*middles[0],), (*middles[1],))


def _standing(placement: Placement, time_s: float) -> Surface:
    """The figure in the room, at a moment of its clip."""
    figure = _figure()
    vertices, normals = skin(figure, figure.clip("idle").at(time_s))
    turned = placement.world_T_character.rotor.apply(normals)
    at_m = placement.apply(vertices)
    return Surface(at_m, turned, figure.triangles, figure.colors, roughness=0.42)


def _covered(body: Surface, pose: Motor) -> NDArray[np.bool_]:
    """Pixels that a body hides, and those next to them."""
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        renderer.show([body], None)
        alpha = renderer.render(CAMERA, pose).rgba[..., 3]
    return np.asarray(cv2.dilate(alpha, np.ones((5, 5), np.uint8)) > 0)


def _on_ground(pose: Motor) -> FloatArray:
    """(h, w, 2) where each pixel's ray meets z = 0, metres; far off where it does not."""
    x = (np.arange(CAMERA.width) - CAMERA.cx) / CAMERA.fx
    y = (np.arange(CAMERA.height) - CAMERA.cy) / CAMERA.fy
    u, v = np.meshgrid(x, y)
    ray = pose.rotor.apply(np.stack([u, v, np.ones_like(u)], axis=-1))
    eye = pose.translation_m
    far = np.where(ray[..., 2] < -1e-6, -eye[2] / np.minimum(ray[..., 2], -1e-6), 1e6)
    return np.asarray(eye[:2] + far[..., None] * ray[..., :2])


def mouse_shade() -> tuple[Shade, float, int]:
    """The mouse's own shadow on the desk of `vamr_board` and one that is drawn for its body, beside
    it where the desk is not overexposed; the sun's share that is drawn; and of how many frames.

    Raises:
        OSError: the recording is not here.
    """
    recording, board, _, track = vamr_board()
    footage = _Footage(recording, distorted=False)
    camera, path = footage.camera, track.measurements.trajectory
    corners = board.points_m[:, :2]
    low, high = corners.min(axis=0), corners.max(axis=0)
    prints = Prints(Motor.identity((1,)), low[None], high[None])
    placement = place_on_plane(mannequin(), tuple(0.5 * (low + high)), 0.0, height_m=0.13)
    some = np.unique(np.linspace(0, len(recording.frames) - 1, LIT_FRAMES).round()).astype(int)
    seen = [shot[:3] for shot in footage.frames(recording.frames[k] for k in some)]
    lighting, _ = lighting_without_depth(seen, camera, path, placement, 0.13, prints)
    share = sun_share(lighting, np.array([*MOUSE_M, 0.0]), np.array([0.0, 0.0, 1.0]))
    at_m, drawn = _mouse_drawn(lighting, share)
    parts = []
    for stamp, image, *_ in footage.frames(recording.frames[k] for k in range(0, 250, 5)):
        if path.time_ns[0] <= stamp <= path.time_ns[-1]:
            lost = _mouse_lost(image, camera, path.motors_at(np.int64(stamp)), at_m)
            if lost is not None:
                parts.append(lost)
    true = np.nanmedian(parts, axis=0)
    told = np.isfinite(true) & _beside(at_m)
    return _shade(true[told], drawn[told], at_m[told] - MOUSE_M), share, len(parts)


def _mouse_drawn(lighting: Lighting, share: float) -> tuple[FloatArray, FloatArray]:
    """Cells (N, 2) of the desk about the mouse, and what the shadow drawn for its body takes."""
    u, w = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 65), np.linspace(0.0, 0.5 * np.pi, 17))
    dome = np.stack([np.cos(u) * np.cos(w), np.sin(u) * np.cos(w), np.sin(w)], axis=-1)
    k = (np.arange(16)[:, None] * 65 + np.arange(64)).reshape(-1, 1)
    up = np.concatenate([np.hstack([k, k + 1, k + 66]), np.hstack([k, k + 66, k + 65])])
    vertices = dome.reshape(-1, 3) * MOUSE_HALF_M
    under = vertices * [1.0, 1.0, 0.0]
    faces = np.concatenate([up, up[:, ::-1] + len(vertices)])
    sun = np.array(lighting.sun.direction)
    half_m = 0.12
    shade = ground_shade(
        np.concatenate([vertices, under]),
        faces,
        sun / np.linalg.norm(sun),
        half_m,
        ShadowLook(),
        share,
        lighting.sun.radius_rad,
    )
    along = ((np.arange(GRID) + 0.5) / GRID * 2.0 - 1.0) * half_m
    x, y = np.meshgrid(along, along)
    return np.stack([x, y], axis=-1).reshape(-1, 2) + MOUSE_M, shade.ravel().astype(np.float64)


def _off_mouse_m(at_m: FloatArray) -> FloatArray:
    """Distance (N,) from the mouse's outline on the desk, nearly; below 0 beneath it."""
    own = (at_m - MOUSE_M) / MOUSE_HALF_M[:2]
    from_middle = np.maximum(np.linalg.norm(own, axis=1), 1e-9)
    return np.asarray(np.linalg.norm(at_m - MOUSE_M, axis=1) * (1.0 - 1.0 / from_middle))


def _beside(at_m: FloatArray) -> NDArray[np.bool_]:
    """The desk to the left of the mouse, which it hides from no camera."""
    off = _off_mouse_m(at_m)
    across = np.abs(at_m[:, 1] - MOUSE_M[1]) < 0.6 * MOUSE_HALF_M[1]
    return np.asarray(
        (off > BESIDE_M[0]) & (off < BESIDE_M[1]) & (at_m[:, 0] < MOUSE_M[0]) & across
    )


def _mouse_lost(
    image: ImageArray, camera: Camera, pose: Motor, at_m: FloatArray
) -> FloatArray | None:
    """Share of light (N,) that is gone from the desk in one image, by desk farther out; NaN where
    that is not told; None where too little of it is seen.
    """
    own = pose.inverse().apply(np.pad(at_m, ((0, 0), (0, 1))))
    x, y = camera.project(own).T.astype(np.float32)
    inside = (x > 4) & (y > 4) & (x < camera.width - 5) & (y < camera.height - 5)
    if not inside[_beside(at_m)].all():
        return None
    grey = image if image.ndim == 2 else image[..., 0]
    shown = cv2.remap(grey, x.reshape(GRID, -1), y.reshape(GRID, -1), cv2.INTER_LINEAR).ravel()
    off, light = _off_mouse_m(at_m), to_linear(shown / 255.0)
    clear = inside & (off > CLEAR_M[0]) & (off < CLEAR_M[1]) & (at_m[:, 0] < MOUSE_M[0])
    told = clear & (shown < OVEREXPOSED)
    if np.count_nonzero(told) < 0.3 * np.count_nonzero(clear):
        return None
    basis = np.column_stack([at_m - MOUSE_M, np.ones(len(at_m))])
    fitted = np.linalg.lstsq(basis[told], np.log(light[told]), rcond=None)[0]
    # Where the desk would be brighter than an image can show, what it shows is what is darkened.
    desk = np.minimum(np.exp(basis @ fitted), 1.0)
    return np.asarray(np.where(inside, 1.0 - light / desk, np.nan))


def _line(name: str, shade: Shade, share: float) -> str:
    (a, b), (c, d) = shade.true_m, shade.drawn_m
    turned = np.rad2deg(np.angle(complex(c, d) / complex(a, b))) if a or b else float("nan")
    return (
        f"{name}: takes {shade.true:.2f}, drawn {shade.drawn:.2f} ({shade.ratio:.2f} of it; sun "
        f"{share:.2f}), mean apart {shade.apart:.3f}; middle {100 * np.hypot(a, b):.1f} cm from the"
        f" foot, drawn {100 * np.hypot(c, d):.1f} cm, turned {turned:.0f}°"
    )


def main() -> None:
    """A line a room, and one for the mouse."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--others", type=int, default=0)
    given = parser.parse_args()
    if not given.others and (data_folder() / "replays" / "vamr_board").is_dir():
        shade, share, frames = mouse_shade()
        print(_line(f"the mouse, {frames} frames", shade, share), flush=True)
    for room in others(given.others) if given.others else FIVE:
        name = f"room {room.seed} (sun {room.share:.2f}, {room.elevation_deg:.0f}° high)"
        print(_line(name, *room_shades(room)), flush=True)


if __name__ == "__main__":
    main()
