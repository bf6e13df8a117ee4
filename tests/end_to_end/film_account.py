"""`python -m tests.end_to_end.film_account [--count N] [--seed S]`: do films say what they show?

Figures are placed at random before a camera, alone and in pairs, in view, cut by the image's edge,
behind a wall of known depth and behind a mask. What the film says of each (`FigureSeen`) is
compared with a count on its pixels: over black and over white footage a pixel differs by the light
that nothing drawn covers, so that their difference is its coverage. Heights come from the rows that
are covered, and how low a figure stands from its own vertices. A row for each that is more than 2 %
off, and a summary; ends with 1 where there is such a row.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from motorcade.animation import mannequin, place_on_plane, skin
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer
from motorcade.render.figures import FigureSeen
from motorcade.render.overlay import render_performers
from motorcade.render.scene import ImageArray
from motorcade.render.shadow import ShadowLook
from motorcade.render.shots import StampedFrame
from motorcade.tracking.cameras.camera import Camera

CAMERA = Camera(320, 240, 280.0, 280.0, 159.5, 119.5)
NO_SHADE = ShadowLook(strength=0.0, contact=0.0)
WITHIN, LEAST_PX = 0.02, 150.0
"""Of its pixels, of the share that is seen, of its height; and the smallest that is judged."""


@dataclass(frozen=True)
class Account:
    """What a film says of a figure, and what is counted: pixels, share hidden, rows, bottom."""

    said: tuple[float, ...]
    counted: tuple[float, ...]

    @property
    def off(self) -> list[str]:
        """What is said wrongly."""
        names = ("visible", "hidden", "height", "bottom")
        bounds = (WITHIN * max(self.counted[0], LEAST_PX), WITHIN, WITHIN * self.counted[2] + 1.0)
        return [
            name
            for name, said, true, bound in zip(
                names, self.said, self.counted, (*bounds, 1e-3), strict=True
            )
            if abs(said - true) > bound
        ]


def draw_account(rng: np.random.Generator, figures: int, hidden_by: str) -> list[Account]:
    """Place figures, film them, and count.

    Args:
        rng: that draws where they and the camera stand.
        figures: one or two, which may stand before one another.
        hidden_by: "nothing", "wall" or "mask".

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    body = mannequin()
    pitch, aside = rng.uniform(0.1, 0.7), rng.uniform(-0.5, 0.5)
    away_m = rng.uniform(2.0, 4.0)
    eye = np.array([0.0, -away_m, away_m * np.tan(pitch) + rng.uniform(0.2, 0.6)])
    rotor = Rotor.from_rotation_vector([-0.5 * np.pi - pitch, 0.0, 0.0])
    pose = Motor.from_rotor_translation(rotor, eye)
    path = Trajectory(np.array([0, 10**9]), Motor.stack([pose, pose]), "world", "camera")
    stands = [
        place_on_plane(
            body,
            (aside + k * rng.uniform(-0.4, 0.4), k * rng.uniform(0.3, 1.0)),
            rng.uniform(-np.pi, np.pi),
            height_m=rng.uniform(0.5, 1.1),
        )
        for k in range(figures)
    ]
    clip = body.clip("idle")
    cast = [Performer(body, clip, stand) for stand in stands]
    column = int(rng.integers(60, 260))
    wall, mask = np.zeros((240, 320), np.float32), np.zeros((240, 320), np.uint8)
    wall[:, :column], mask[:, :column] = 0.5, 255
    hiding = (wall if hidden_by == "wall" else None, mask if hidden_by == "mask" else None)
    said, shown, _ = _filmed(cast, path, hiding)
    alone = [_filmed([performer], path, (None, None))[1:] for performer in cast]
    own = np.array([cover for cover, _ in alone])
    nearest = np.zeros(own.shape[1:], dtype=np.int64)
    if figures == 2:  # a pixel is whose own film it looks like
        pair = _filmed(cast, path, (None, None))[2].astype(float)
        apart = [np.abs(pair - film).sum(axis=2) for _, film in alone]
        nearest = np.where(own[0] * own[1] > 0.0, apart[1] < apart[0], own[1] > own[0]).astype(int)
    accounts = []
    for k, (stand, seen) in enumerate(zip(stands, said, strict=True)):
        full = float(own[k].sum())
        if full < LEAST_PX:
            continue
        visible = float(shown[nearest == k].sum())
        rows = np.flatnonzero((own[k] > 0.5).any(axis=1))
        low = stand.apply(skin(body, clip.at(0.0))[0])[:, 2].min() / (stand.scale * body.height_m)
        accounts.append(
            Account(
                (seen.visible_px, seen.hidden, seen.height_px, seen.bottom),
                (visible, 1.0 - visible / full, float(np.ptp(rows)) + 1.0, float(low)),
            )
        )
    return accounts


def _filmed(
    cast: list[Performer], path: Trajectory, hiding: tuple[FloatArray | None, ImageArray | None]
) -> tuple[tuple[FigureSeen, ...], FloatArray, ImageArray]:
    """What a film says, how much of each pixel is covered by what it draws, and its dark image."""
    visibility: list[tuple[FigureSeen, ...] | None] = []
    footage = [np.full((240, 320, 3), level, np.uint8) for level in (0, 255)]
    frames = [StampedFrame(0, image, *hiding) for image in footage]
    black, white = render_performers(
        frames, CAMERA, path, cast, look=NO_SHADE, visibility=visibility
    )
    below = to_linear(white / 255.0) - to_linear(black / 255.0)
    assert visibility[0] is not None  # the path covers the frame
    return visibility[0], 1.0 - below.mean(axis=2), black


def main(arguments: list[str] | None = None) -> int:
    """Place figures, and compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.film_account")
    parser.add_argument("--count", type=int, default=60, help="placements (60)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    judged, failed = 0, 0
    for number in range(options.count):
        rng = np.random.default_rng([options.seed, number])
        figures, hidden_by = 1 + number % 2, ("nothing", "wall", "mask")[number // 2 % 3]
        for account in draw_account(rng, figures, hidden_by):
            judged += 1
            failed += bool(account.off)
            if account.off:
                said, counted = (
                    " ".join(f"{value:.3f}" for value in values)
                    for values in (account.said, account.counted)
                )
                print(
                    f"{number}: {figures} figures, hidden by {hidden_by}: "
                    f"{', '.join(account.off)}; said {said}, counted {counted}",
                    flush=True,
                )
    print(f"{failed} of {judged} accounts are wrong")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
