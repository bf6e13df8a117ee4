"""`python -m tests.end_to_end.passers [--count N] [--seed S] [--images DIR]`: who walks in front.

The textured room, in which somebody walks before a standing figure and through the view, drawn by
projecting a body and laying it over the room's image. Masks are as drawn, at an eighth of the
size, and three pixels too small or too large, for which there is no bound. Against the empty room's
own film: the share of the edge between passer and figure that lies within a pixel; against SLAM's
path of the empty room: the path with the passer, with masks and without. A row a room; ends with 1
where a bound does not hold.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation import mannequin, place_on_plane, skin
from motorcade.fusion.metrics import evaluate
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import render_overlay
from motorcade.replays.io.recording import Frame
from motorcade.replays.io.trajectories import even_stamps
from motorcade.tracking.masks import refine_mask
from motorcade.tracking.slam import VisualSlam
from tests.textured_room.scenarios import RATE_HZ, Scenario, scenario

Image = NDArray[np.uint8]
FRAMES, HEIGHT_M, AWAY_M, PASSES_M = 75, 1.0, 2.4, 1.5
FLOOR_M, WALKS_M_S, FINE = 0.0, 0.9, 4
WITHIN, LONGER = 0.95, 1.2


@dataclass(frozen=True, eq=False)
class PassedRoom:
    """A room with somebody walking through the view: images (h, w), exact depth, masks, poses."""

    scene: Scenario
    truth: Trajectory
    empty: list[Image]
    passed: list[Image]
    masks: list[Image]
    depth_m: list[NDArray[np.float32]]
    place_m: FloatArray
    facing_rad: float


def draw_room(seed: int, frames: int = FRAMES, *, behind: bool = False) -> PassedRoom:
    """A room of a seed; the passer walks before the figure, or `behind` it."""
    scene = scenario("handheld", seed=seed, frames=frames)
    rng, truth, camera = np.random.default_rng([seed, 7]), scene.truth(), scene.sensor.camera
    middle = truth.motors[frames // 2]
    ahead = middle.rotor.apply([0.0, 0.0, 1.0]) * [1.0, 1.0, 0.0]
    ahead /= np.linalg.norm(ahead)
    aside = np.array([-ahead[1], ahead[0], 0.0])
    eye = middle.translation_m * [1.0, 1.0, 0.0]
    away_m = AWAY_M + rng.uniform(-0.1, 0.3)
    passes_m = away_m + 0.5 if behind else PASSES_M + rng.uniform(-0.2, 0.3)
    body, texture = mannequin(), _texture(rng)
    walk, sign = body.clip("walk"), rng.choice([-1.0, 1.0])
    heading = float(np.arctan2(sign * aside[1], sign * aside[0]))
    empty, passed, masks, depths = [], [], [], []
    for row, view in enumerate(scene.views()):
        time_s = row / RATE_HZ
        along = sign * WALKS_M_S * (time_s - 0.5 * frames / RATE_HZ)
        stand = eye + passes_m * ahead + along * aside
        place = place_on_plane(body, stand[:2], heading, height_m=1.6 if not behind else 1.4)
        vertices, _ = skin(body, walk.at(time_s))
        px = camera.project(truth.motors[row].inverse().apply(place.apply(vertices)))
        mask = _silhouette(px, body.triangles, view.gray.shape)
        x, y = np.rint(px.mean(axis=0)).astype(int)
        own = np.roll(texture, (y, x), (0, 1))[: mask.shape[0], : mask.shape[1]]
        share = mask / 255.0
        passed.append(np.rint(share * own + (1.0 - share) * view.gray).astype(np.uint8))
        empty.append(view.gray)
        masks.append(mask)
        depths.append(view.depth_m)
    place_m = eye + away_m * ahead
    facing = float(np.arctan2(-ahead[1], -ahead[0]))
    return PassedRoom(scene, truth, empty, passed, masks, depths, place_m, facing)


def _texture(rng: np.random.Generator) -> Image:
    """Clothes of many corners, dark or bright, larger than any image."""
    coarse = rng.normal(rng.choice([50.0, 190.0]), 18.0, (140, 160)).astype(np.float32)
    fine = cv2.resize(coarse, (1280, 1120), interpolation=cv2.INTER_CUBIC)
    return np.asarray(np.clip(fine + rng.normal(0.0, 1.0, fine.shape), 0, 255), np.uint8)


def _silhouette(px: FloatArray, triangles: NDArray[np.int64], shape: tuple[int, ...]) -> Image:
    """How much (of 255) of each pixel a mesh covers, (h, w)."""
    large = np.zeros((FINE * shape[0], FINE * shape[1]), np.uint8)
    corners = np.rint(FINE * (px[triangles] + 0.5) - 0.5).astype(np.int32)
    for corner in corners:
        cv2.fillConvexPoly(large, corner, 255)
    return np.asarray(cv2.resize(large, shape[::-1], interpolation=cv2.INTER_AREA), np.uint8)


def mask_kinds() -> dict[str, Callable[[Image], Image]]:
    """What models for people do to a mask."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))

    def coarse(mask: Image) -> Image:
        small = cv2.resize(mask, None, fx=0.125, fy=0.125, interpolation=cv2.INTER_AREA)
        return np.asarray(cv2.resize(small, mask.shape[::-1], interpolation=cv2.INTER_LINEAR))

    return {
        "drawn": lambda mask: mask,
        "an eighth": coarse,
        "too small": lambda mask: np.asarray(cv2.erode(mask, disc)),
        "too large": lambda mask: np.asarray(cv2.dilate(mask, disc)),
    }


def film(room: PassedRoom, images: list[Image], masks: list[Image] | None) -> Iterator[Image]:
    """The figure set into images at the true poses."""
    body = mannequin()
    place = place_on_plane(body, room.place_m[:2], room.facing_rad, height_m=HEIGHT_M)
    frames = (
        (int(stamp), image, None, None if masks is None else refine_mask(masks[row], image))
        for row, (stamp, image) in enumerate(zip(room.truth.time_ns, images, strict=True))
    )
    return render_overlay(
        frames, room.scene.sensor.camera, room.truth, body, body.clip("idle"), place
    )


def edge_within(room: PassedRoom, masks: list[Image] | None) -> tuple[float, list[Image]]:
    """The share of the figure's edge along the passer that lies within a pixel, and the film."""
    bare, ours = film(room, room.empty, None), film(room, room.passed, masks)
    near, count, shown = 0, 0, []
    for row, (alone, image) in enumerate(zip(bare, ours, strict=True)):
        shown.append(image)
        figure, passer, inside = alone[..., 0].astype(int), room.passed[row], room.masks[row] >= 128
        drawn = np.abs(figure - room.empty[row]) > 6
        # Where it is the figure or its shade, and looks other than the passer before it.
        told = drawn & (np.abs(figure - passer) > 40)
        hidden = np.abs(image[..., 0].astype(int) - passer) < np.abs(image[..., 0] - figure)
        away = [
            cv2.distanceTransform(part.astype(np.uint8), cv2.DIST_L2, 5)
            for part in (inside, ~inside)
        ]
        off = told & (hidden != inside) & (away[0] + away[1] > 1.5)  # the first pixel is 1 away
        edge = _rim(inside) & (cv2.dilate(told.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
        wrong = cv2.dilate(off.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        near += int(np.count_nonzero(edge & ~wrong))
        count += int(np.count_nonzero(edge))
    return near / max(count, 1), shown


def _rim(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    cross = np.ones((3, 3), np.uint8)
    return np.asarray(inside & (cv2.erode(inside.astype(np.uint8), cross) == 0))


def path_error_m(
    room: PassedRoom, images: list[Image], masks: list[Image] | None, kind: str
) -> float:
    """Error (RMS, metres) of SLAM's path, by one camera after alignment with scale, or with depth.

    What a frame gives with a mask is what a recording's frame gives.
    """
    slam = VisualSlam(room.scene.sensor.camera)
    for row, stamp in enumerate(even_stamps(len(images), RATE_HZ).tolist()):
        read_mask = None if masks is None else partial(lambda mask: mask, masks[row])
        frame = Frame(
            stamp,
            "",
            partial(lambda image: image, images[row]),
            partial(lambda depth_m: depth_m, room.depth_m[row]),
            read_mask=read_mask,
        )
        slam.track(stamp, frame.gray(), frame.still().depth_m() if kind == "depth" else None)
    path = slam.finish().trajectory
    if path is None:
        return float("inf")
    align = "se3" if kind == "depth" else "sim3"
    lost = 1.0 - len(path) / len(images)
    return float(evaluate(path, room.truth, align=align).ape_m.rmse) * (1.0 + lost)


def main(arguments: list[str] | None = None) -> int:
    """Draw rooms, and compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.passers")
    parser.add_argument("--count", type=int, default=8, help="rooms (8)")
    parser.add_argument("--seed", type=int, default=100, help="of the first (100)")
    parser.add_argument("--images", type=Path, help="a folder for a few frames of each film")
    options = parser.parse_args(arguments)
    beyond = False
    for seed in range(options.seed, options.seed + options.count):
        room, cells = draw_room(seed), []
        for name, made in mask_kinds().items():
            share, shown = edge_within(room, [made(mask) for mask in room.masks])
            cells.append(f"{name} {100.0 * share:.1f} %")
            beyond |= share < WITHIN and name in ("drawn", "an eighth")
            if options.images is not None:
                options.images.mkdir(parents=True, exist_ok=True)
                for row in (30, 37, 44):
                    path = options.images / f"{seed}_{name.replace(' ', '_')}_{row}.png"
                    cv2.imwrite(str(path), shown[row])
        for kind in ("one camera", "depth"):
            alone = path_error_m(room, room.empty, None, kind)
            bare = path_error_m(room, room.passed, None, kind)
            masked = path_error_m(room, room.passed, room.masks, kind)
            cells.append(
                f"{kind} {1e3 * alone:.1f} mm, masked {masked / alone:.2f}, bare {bare / alone:.2f}"
            )
            beyond |= masked > LONGER * alone
        print(f"{seed}: " + "; ".join(cells), flush=True)
    return int(beyond)


if __name__ == "__main__":
    sys.exit(main())
