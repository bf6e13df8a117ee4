"""The gimbal's spin, out of a scene file: the same keyframes by Euler angles, quaternions, motors.

`docs/manifests/gimbal_scene.json` holds a figure with two keyframes, both at a pitch of 89.9 deg.
It is played in the synthetic room three times, once for each way to join keyframes; below, how fast
it turns is drawn as it goes.

    python -m docs.making.gimbal_scene OUT.mp4

prints what the three ways cost, and writes the film and a sheet of its frames beside it.
`motorcade run RECORDING --scene SCENE --set placed.interpolation=euler` does the same in one's own
footage.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from docs.making.traces import ErrorTraces, beside
from motorcade.animation import Placement, mannequin
from motorcade.animation.authoring import (
    Scene,
    between_keyframes,
    compare_interpolations,
    read_scene,
)
from motorcade.animation.authoring.parts import Interpolation
from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Rotor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer, render_performers
from motorcade.render.overlay import new_renderer
from motorcade.render.scene import ImageArray
from motorcade.render.video import contact_sheet, write_video
from motorcade.replays.demo.recording import CAMERA
from motorcade.replays.demo.scene import room

__all__ = ["SCENE", "performer", "rates_deg_s", "spins"]

SCENE = Path(__file__).parents[1] / "manifests" / "gimbal_scene.json"
RATE_HZ, STRIP_PX = 30.0, 130
EYE_M, AIM_M = np.array([0.6, -0.32, 0.42]), np.array([0.0, 0.0, 0.2])
WAYS: tuple[Interpolation, ...] = ("euler", "quaternion", "motor")


def performer(scene: Scene, name: str, way: Interpolation, time_ns: np.ndarray) -> Performer:
    """An object of a scene as it goes through its keyframes in one way; a mannequin."""
    part, who = scene.part(name), mannequin()
    size = 1.0 if part.height_m is None else part.height_m / who.height_m
    poses = between_keyframes(part, 1e-9 * time_ns, way)
    sized = poses @ Similarity.from_motor_scale(Motor.identity(), size)
    motion = Trajectory(time_ns, Similarity.normalize(sized.coefficients), "placement", "character")
    return Performer(who, who.clip("idle"), Placement(Motor.identity(), 1.0), motion)


def rates_deg_s(motion: Trajectory) -> FloatArray:
    """How fast it turns (N,) at each stamp, from the one before."""
    turn = (motion.poses.rotor[:-1].inverse() @ motion.poses.rotor[1:]).angle()
    rate = np.minimum(turn, 2.0 * np.pi - turn) / (1e-9 * np.diff(motion.time_ns))
    return np.asarray(np.rad2deg(np.append(rate[:1], rate)))


def spins(scene: Scene, name: str, rate_hz: float = RATE_HZ) -> Iterator[tuple[int, ImageArray]]:
    """Stamps and images of the three ways beside each other.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
        ValueError: an object without keyframes.
    """
    last_s = scene.part(name).keyframes[-1].time_s
    stamps = np.round(np.arange(int(last_s * rate_hz) + 1) * 1e9 / rate_hz).astype(np.int64)
    shown = {way: performer(scene, name, way, stamps) for way in WAYS}
    rates = {way: rates_deg_s(one.motion) for way, one in shown.items() if one.motion is not None}
    size = (CAMERA.width * len(WAYS), STRIP_PX)
    traces = ErrorTraces(1e-9 * stamps, rates, "deg/s", size)
    eye = _eye()
    path = Trajectory(stamps[[0, -1]], Motor.stack([eye, eye]))
    image = _room(eye)
    footage = [(int(stamp), image) for stamp in stamps]
    drawn = [render_performers(footage, CAMERA, path, [one]) for one in shown.values()]
    for stamp, images in zip(stamps.tolist(), zip(*drawn, strict=True), strict=True):
        row = dict(zip(WAYS, images, strict=True))
        yield stamp, beside(row, traces.strip(1e-9 * stamp))


def _eye() -> Motor:
    ahead = AIM_M - EYE_M
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    turn: Rotor = axes_along(right, np.cross(ahead, right))
    return Motor.from_rotor_translation(turn, EYE_M)


def _room(eye: Motor) -> ImageArray:
    with new_renderer("fast", CAMERA.width, CAMERA.height) as renderer:
        renderer.show(room(), None)
        return renderer.render(CAMERA, eye).rgba[..., :3].copy()


def main() -> None:
    """Print the figures and write the film where the first argument says."""
    parser = argparse.ArgumentParser(description="Film keyframes near gimbal lock in three ways.")
    parser.add_argument("out", type=Path, metavar="OUT.mp4")
    parser.add_argument("--scene", type=Path, default=SCENE, help="with keyframes of a mannequin")
    parser.add_argument("--object", default="diver", help="which of its objects")
    given = parser.parse_args()
    scene = read_scene(given.scene)
    for way, found in compare_interpolations(scene.part(given.object)).items():
        print(
            f"{way}: turns {found.turned_over_geodesic:.3f} times the geodesic, at most "
            f"{np.degrees(found.peak_rad_s):.1f} deg/s ({np.degrees(found.mean_rad_s):.1f} in the "
            f"mean), off the screw by {np.degrees(found.off_screw_rad):.1f} deg and "
            f"{1e3 * found.off_screw_m:.1f} mm"
        )
    stamps, frames = zip(*spins(scene, given.object), strict=True)
    write_video(given.out, frames, np.array(stamps))
    chosen = range(0, len(frames), max(1, len(frames) // 12))
    labels = [f"{1e-9 * stamps[k]:.2f} s" for k in chosen]
    sheet = contact_sheet([frames[k] for k in chosen], 3, 640, labels)
    cv2.imwrite(str(given.out.with_suffix(".png")), sheet[..., ::-1])


if __name__ == "__main__":
    main()
