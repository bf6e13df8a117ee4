"""Draws the two images of the README from a run of the demo.

    make demo
    python docs/making/demo_images.py out/demo

writes `docs/images/demo.webp`, which plays the footage beside its video, and
`docs/images/gimbal_lock.svg`, rotation errors over time; it prints what they show as figures.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from motorcade.fusion.metrics import associate, evaluate, rotation_rad
from motorcade.ga.versors.euler_angles import euler_from_matrix
from motorcade.render import read_frames
from motorcade.render.plots import plot_series, standing_alone
from motorcade.render.plots.style import ON_PAGES
from motorcade.render.video import contact_sheet
from motorcade.replays import open_recording
from motorcade.replays.io.trajectories import read_trajectory

IMAGES = Path(__file__).resolve().parents[1] / "images"
SHOWN = ("euler", "euler_unwrapped", "quaternion", "motor")
LOCK_DEG = 89.0
LEGEND_PX = 26
WIDTH_PX, EVERY = 400, 3


def draw(out: Path) -> None:
    """Write both images from what a run left in `out`."""
    play(out)
    (truth,) = out.rglob("truth.tum")
    true = read_trajectory(truth)
    series = {}
    for name in SHOWN:
        path = read_trajectory(out / "trajectories" / f"smoothed_{name}.tum")
        pairs = associate(path, true)
        error = np.rad2deg(rotation_rad(pairs.estimate, pairs.reference))
        series[name] = ((pairs.time_ns - pairs.time_ns[0]) * 1e-9, error)
        found = evaluate(path, true).as_dict()
        print(
            f"{name:16}{found['rotation_rmse_deg']:9.3f} deg"
            f"{found['angular_jitter_rad_s2']:11.2f} rad/s²"
        )
    svg = plot_series(series, "rotation error", "degrees", log_scale=True, width_in=10.0)
    (IMAGES / "gimbal_lock.svg").write_text(with_legend(standing_alone(svg)), encoding="utf-8")
    pitch = np.rad2deg(np.abs(euler_from_matrix(true.motors.rotor.as_matrix())[:, 1]))
    near = pitch > LOCK_DEG
    print(
        f"{np.count_nonzero(near[1:] & ~near[:-1])} times within {90 - LOCK_DEG:g} deg of the lock"
    )


def play(out: Path) -> None:
    """Write the footage and the film beside each other, every third frame at its own pace."""
    film = [image for _, image in read_frames(out / "overlay.mp4")]
    footage = [frame.image() for frame in open_recording(out / "recording").frames]
    sides = [
        Image.fromarray(contact_sheet([before, after], 2, WIDTH_PX))
        for before, after in list(zip(footage, film, strict=True))[::EVERY]
    ]
    sides[0].save(
        IMAGES / "demo.webp",
        save_all=True,
        append_images=sides[1:],
        duration=round(EVERY * 1000 / 30),
        loop=0,
        quality=55,
        method=6,
    )


def with_legend(svg: str) -> str:
    """The plot with its lines named in a row above it."""
    box = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)
    if box is None:
        raise ValueError("svg: expected a viewBox that begins at 0 0")
    width, height = float(box[1]), float(box[2])
    style = re.search(r"<style>.*?</style>", svg, re.DOTALL)
    names = [
        f'<text x="{0.25 * width + 0.18 * width * k:g}" y="17" fill="{ON_PAGES[name]}" '
        f'font-family="sans-serif" font-size="12">{name}</text>'
        for k, name in enumerate(SHOWN)
    ]
    begin, end = svg.index("<svg "), svg.index(">", svg.index("<svg "))
    head, body = svg[begin:end], svg[end:]
    head = re.sub(r' (?:x|y|width|height)="[^"]*"', "", head)
    place = f'<svg y="{LEGEND_PX}" width="{width:g}" height="{height:g}" '
    inner = place + head.removeprefix("<svg ") + body
    whole = height + LEGEND_PX
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {whole:g}">'
        f"{style[0] if style else ''}"
        f'<rect width="{width:g}" height="{whole:g}" fill="var(--page)"/>'
        f"{''.join(names)}{inner}</svg>\n"
    )


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
