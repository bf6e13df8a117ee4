"""`python -m tests.tracking.self_calibration.coverage`: how often two sigmas hold the focal length.

Corners are drawn as a phone's clip shows them, not rendered: a hand round a board, of which parts
lie outside, are hidden or glare; that is seen head on at first; a lens that breathes; prints that
are not flat; errors that a view's corners have in common. Exit status 1 where fewer than 95 % of
the focal lengths lie within two of their standard deviations, or good clips are told to worse than
one per cent in the median.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.tracking import Camera, Checkerboard, SelfCalibration, self_calibrate_board
from motorcade.tracking.boards import BoardCorners
from tests.tracking.self_calibration.clips import FACE_DOWN, pixels

KINDS = ("good", "half seen", "head on first", "breathing", "cut off", "glare", "head on")
FRAMES, RATE_HZ, SQUARES = 180, 30.0, ((7, 5), (9, 6), (8, 6), (7, 4), (10, 7))
MUST_COVER, MUST_TELL = 0.95, 0.01


@dataclass(frozen=True, eq=False)
class DrawnClip:
    """What a clip shows, and the focal length behind it."""

    kind: str
    size: tuple[int, int]
    focal: float
    views: list[BoardCorners | None]
    time_ns: np.ndarray


def drawn_clip(kind: str, rng: np.random.Generator) -> DrawnClip:
    """A clip of a kind, anything else of it at random."""
    size = ((1920, 1080), (1080, 1920), (1280, 720), (720, 1280), (640, 480))[rng.integers(5)]
    long = max(size)
    focal = long * rng.uniform(0.62, 1.05)
    middle = 0.5 * (np.array(size) - 1.0) + 0.006 * long * rng.standard_normal(2)
    k1, k2 = 0.06 * rng.standard_normal(), 0.05 * rng.standard_normal()
    camera = Camera(*size, focal, focal, *middle, "radtan", (k1, k2))
    board = Checkerboard(*SQUARES[rng.integers(len(SQUARES))], 1.0)
    points = board.points_m - board.points_m.mean(axis=0)
    path = _path(kind, points, camera, rng)
    half = 0.5 * np.ptp(points, axis=0).max()
    x, y = points[:, :1] / half, points[:, 1:2] / half
    sag = rng.normal(0.0, 0.004) * (x**2 + rng.normal() * y**2)
    bent = half * (sag + rng.normal(0.0, 0.001) * x**3 + rng.normal(0.0, 0.001) * y**4)
    readout_s = (0.0, float(rng.choice([0.0, 0.008, 0.02])))
    px = pixels(camera, path, points + bent * [0.0, 0.0, 1.0], readout_s)
    t = np.linspace(0.0, 1.0, FRAMES)
    breath = np.zeros(FRAMES)
    if kind == "breathing":
        breath = rng.uniform(0.01, 0.04) * np.tanh(6.0 * (t - rng.uniform(0.3, 0.7)))
        breath -= breath.mean()
    px = middle + (px - middle) * (1.0 + breath)[:, None, None]
    px = px + _errors(kind, px, long, rng)
    return DrawnClip(kind, size, focal, _seen(kind, board, px, size, rng), _stamps())


def _stamps() -> np.ndarray:
    return np.arange(FRAMES) * 33_333_333


def _path(kind: str, points: np.ndarray, camera: Camera, rng: np.random.Generator) -> Motor:
    """Poses ``camera_T_board`` of a hand."""
    t = np.arange(FRAMES) / RATE_HZ
    rate, phase = rng.uniform(0.5, 1.4, (6, 1)), rng.uniform(0.0, 6.3, (6, 1))
    wave = np.sin(rate * t + phase)
    turn = np.radians(rng.uniform(15.0, 30.0)) * wave[:3] * [[1.0], [1.0], [0.4]]
    turn += np.radians(rng.uniform(-25.0, 25.0, (3, 1))) * [[1.0], [1.0], [0.3]]
    if kind == "head on first":
        turn *= 1.0 / (1.0 + np.exp(-4.0 * (t - 0.6 * t[-1])))
    elif kind == "head on":
        turn *= 0.15
    extent = float(np.ptp(points, axis=0).max())
    fills = rng.uniform(0.45, 0.75) * (1.9 if kind in ("half seen", "cut off") else 1.0)
    depth = extent * camera.fx / (fills * min(camera.width, camera.height))
    aside = 0.5 if kind == "cut off" else 0.15
    place = np.stack(
        [aside * extent * wave[3], aside * extent * wave[4], depth * (1 + 0.15 * wave[5])]
    )
    return Motor.from_rotor_translation(Rotor.from_rotation_vector(turn.T) @ FACE_DOWN, place.T)


def _errors(kind: str, px: np.ndarray, long: int, rng: np.random.Generator) -> np.ndarray:
    """Each corner's own, a view's own, of one blur for a while, and of a glare that goes about."""
    scale = long / 1280.0
    frames = len(px)
    own = rng.uniform(0.08, 0.2) * rng.standard_normal(px.shape)
    slow = np.cumsum(rng.standard_normal((frames, 2, 3)), axis=0) / np.sqrt(frames)
    spread = (px - px.mean(axis=1, keepdims=True)) / (0.3 * long)
    common = 0.15 * (spread[..., :1] * spread[..., 1:] * slow[:, None, :, 0])
    common += 0.1 * spread**2 * slow[:, None, :, 1]
    errors = own + common
    if kind == "glare":
        at = np.array([0.5, 0.4]) * px.reshape(-1, 2).max(axis=0)
        near = np.exp(-((np.linalg.norm(px - at, axis=-1) / (0.12 * long)) ** 2))
        errors = errors + 0.8 * near[..., None] * rng.standard_normal(2)
    return scale * errors


def _seen(
    kind: str,
    board: Checkerboard,
    px: np.ndarray,
    size: tuple[int, int],
    rng: np.random.Generator,
) -> list[BoardCorners | None]:
    """Of each frame the corners that show: three neighbours at each of 24 places, as runs do."""
    inside = np.all((px > 3.0) & (px < np.array(size) - 4.0), axis=-1)
    if kind == "glare":
        inside &= rng.uniform(size=inside.shape) > 0.1
    middles = np.linspace(1, FRAMES - 2, 24).astype(int)
    sampled = np.isin(np.arange(FRAMES), (middles[:, None] + [-1, 0, 1]).ravel())
    views: list[BoardCorners | None] = []
    for frame, shown in enumerate(inside):
        ids = np.flatnonzero(shown)
        if not sampled[frame] or len(ids) < max(12, 0.3 * len(shown)):
            views.append(None)
            continue
        view = BoardCorners(ids, px[frame, ids], board.points_m[ids])
        views.append(view if view.spanning else None)
    return views


def calibrated(clip: DrawnClip) -> SelfCalibration:
    """Its camera, as a run finds it."""
    return self_calibrate_board(clip.views, clip.size, clip.time_ns)


def main() -> int:
    """Draw, calibrate, count."""
    parser = argparse.ArgumentParser(prog="python -m tests.tracking.self_calibration.coverage")
    parser.add_argument("--clips", type=int, default=50)
    parser.add_argument("--seed", type=int, default=34)
    arguments = parser.parse_args()
    print("| clip | kind | focal length, px | off | sigma | off / sigma | lens |")
    print("|---|---|---|---|---|---|---|")
    rows: list[tuple[str, float, float]] = []
    for number in range(arguments.clips):
        rng = np.random.default_rng([arguments.seed, number])
        clip = drawn_clip(KINDS[number % len(KINDS)], rng)
        try:
            found = calibrated(clip)
        except ValueError as why:
            print(f"| {number} | {clip.kind} | {clip.focal:.0f} | refused: {why} | | | |")
            rows.append((clip.kind, np.inf, 1.0))
            continue
        off, sigma = found.camera.fx / clip.focal - 1.0, found.sigma_focal
        rows.append((clip.kind, off, sigma))
        lens = found.reason.split(":")[0]
        lens += f", breathing {found.breathing:.1%}" if found.breathing else ""
        print(
            f"| {number} | {clip.kind} | {clip.focal:.0f} | {off:+.2%} | {sigma:.2%} | "
            f"{off / sigma:+.1f} | {lens} |",
            flush=True,
        )
    covered = float(np.mean([abs(off) <= 2.0 * sigma for _, off, sigma in rows]))
    good = float(np.median([sigma for kind, _, sigma in rows if kind == "good"]))
    print(f"{covered:.0%} within 2 sigma; good clips' sigma {good:.2%} in the median")
    return int(covered < MUST_COVER or good > MUST_TELL)


if __name__ == "__main__":
    sys.exit(main())
