"""`python -m tests.end_to_end.found_people [--images DIR]`: are people masked who are in view?

Dressed human rigs do what their clips hold, at three distances, drawn into recordings without
people; the exact mask is where they are drawn over white and over black alike. A row a rig, motion
and distance: images with a mask, and its intersection over union with the exact one, in the median
and at the worst tenth. Then a row for each recording as it is, where nothing may be masked. Ends
with 1 where the median is below 0.9, or nobody is masked; for misses there is no bound.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.animation import place_on_plane
from motorcade.animation.formats import read_character
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.render import render_overlay
from motorcade.replays.io.trajectories import even_stamps
from motorcade.replays.pipeline.described.people import BlazePose, weights_folder
from motorcade.tracking import Camera
from motorcade.tracking.masks import refine_mask
from motorcade.tracking.people import find_people, overlap
from tests.bench.data import data_folder

Image = NDArray[np.uint8]
DATA = data_folder()
SIZE, COUNT, RATE_HZ, EYE_M, HEIGHT_M, LEAST = (640, 360), 30, 15.0, 1.5, 1.75, 0.9
RIGS = ("makehuman/mh_male_ge53_135k_dressed.glb", "makehuman/mh_male_ge53_27k.glb")
MOTIONS, AWAY_M = ("cmu_01_01_playground", "cmu_jumping_jacks"), (2.5, 4.0, 7.0)
CLIPS = ("hall_still.mp4", "park_walk.mp4", "room_bed.mp4", "kitchen_smooth.mp4", "board_desk.avi")


def footage(name: str, count: int = COUNT) -> list[Image]:
    """The first images (h, w, 3) RGB of a clip."""
    video, images = cv2.VideoCapture(str(DATA / "clips" / name)), []
    while len(images) < count:
        read, image = video.read()
        if not read:
            break
        images.append(cv2.cvtColor(cv2.resize(image, SIZE), cv2.COLOR_BGR2RGB))
    return images


def films(rig: str, motion: str, away_m: float, scene: list[Image]) -> Iterator[list[Image]]:
    """Somebody before a scene, before white, and before black."""
    body = read_character(DATA / "rigs" / rig)
    camera = Camera(*SIZE, 560.0, 560.0, 0.5 * (SIZE[0] - 1), 0.5 * (SIZE[1] - 1))
    turn = Rotor.from_matrix([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    pose = Motor.from_rotor_translation(turn, np.array([0.0, 0.0, EYE_M]))
    time_ns = even_stamps(len(scene), RATE_HZ)
    path = Trajectory(time_ns, Motor.concatenate([pose.reshape(1)] * len(scene)), "world", "camera")
    place = place_on_plane(body, np.array([away_m, 0.0]), np.pi, height_m=HEIGHT_M)
    for images in (scene, [np.full_like(scene[0], 255)] * len(scene), [0 * scene[0]] * len(scene)):
        frames = ((int(at), image, None, None) for at, image in zip(time_ns, images, strict=True))
        yield list(render_overlay(frames, camera, path, body, body.clip(motion), place))


def main(arguments: list[str] | None = None) -> int:
    """Draw people, find them, and compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.found_people")
    parser.add_argument("--images", type=Path, help="a folder for an image of each film")
    options, folder, beyond = parser.parse_args(arguments), weights_folder(), False
    if folder is None:
        print("the nets that find people are not installed: motorcade doctor")
        return 0
    nets = BlazePose(folder)
    for rig in RIGS:
        for row, (motion, away_m) in enumerate((m, a) for m in MOTIONS for a in AWAY_M):
            shown, white, black = films(rig, motion, away_m, footage(CLIPS[row % 3]))
            exact = [
                np.uint8(255) * (bright.max(axis=2).astype(int) - dark.max(axis=2) < 128)
                for bright, dark in zip(white, black, strict=True)
            ]
            found = [
                None if mask is None else refine_mask(cv2.resize(mask, SIZE), image)
                for mask, image in zip(
                    find_people(shown, nets.detect, nets.segment), shown, strict=True
                )
            ]
            some = [
                overlap(mask, own)
                for mask, own in zip(found, exact, strict=True)
                if mask is not None
            ]
            median, low = np.quantile(some or [0.0], [0.5, 0.1])
            beyond |= bool(some) and median < LEAST
            told = (
                f"{len(some)} of {len(shown)} masked, overlap {median:.3f}, worst tenth {low:.3f}"
            )
            print(f"{Path(rig).stem} {motion} {away_m} m: {told}", flush=True)
            if options.images is not None and found[15] is not None:
                options.images.mkdir(parents=True, exist_ok=True)
                seen = np.hstack(
                    [shown[15][..., ::-1], np.dstack([found[15], exact[15], 0 * exact[15]])]
                )
                cv2.imwrite(str(options.images / f"{Path(rig).stem}_{motion}_{away_m}.png"), seen)
    for name in CLIPS:
        scene = footage(name, 10**6)
        masked = sum(mask is not None for mask in find_people(scene, nets.detect, nets.segment))
        beyond |= masked > 0
        print(f"{name}: {masked} of {len(scene)} masked, and nobody is there", flush=True)
    return int(beyond)


if __name__ == "__main__":
    sys.exit(main())
