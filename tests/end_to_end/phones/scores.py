"""What `motorcade run CLIP` makes of a clip of which nothing is told, against its truth.

The command runs as a user runs it, in a process of its own, to the film. Then: the focal length of
the manifest that it wrote; registration along the path that the film is drawn by; and of the film
itself size, orientation, frame times, colours and sound.

Registration here: a cube is placed once, with one size, where it fits best, as a person would place
something in the scene; in every frame its corners are projected by the camera and the pose that
were found, one pose a frame, and compared with where the exact camera sees them. As in the film,
that pose is the one that shows the cube where the rolling shutter of the manifest does.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from motorcade.fusion.metrics import align, associate
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.tracking import Camera
from motorcade.tracking.rolling import as_read
from tests.end_to_end.phones.cases import Case
from tests.end_to_end.phones.films import faults_of_film, read_video

__all__ = ["Score", "run_command", "score", "scored"]

Truth = Mapping[str, NDArray[np.float64]]
FOCAL_SHARE, REGISTRATION_PX, COVERED_SHARE = 0.01, 0.5, 0.9


@dataclass(frozen=True)
class Score:
    """One clip's figures.

    Fields:
        name: of the clip; bears: whether a path with metres or units follows from it.
        seconds: that the command took.
        refused: the line with which it was refused, "" where it was not.
        focal_error: relative, signed.
        registration_px: root mean square over frames and corners.
        covered: share of the frames that have a pose.
        faults: of the film.
        camera: what was said of it.
    """

    name: str
    bears: bool
    seconds: float
    refused: str = ""
    focal_error: float = np.inf
    registration_px: float = np.inf
    covered: float = 0.0
    faults: tuple[str, ...] = ()
    camera: str = ""

    @property
    def right(self) -> bool:
        """Whether the clip came out as it must; without a path to compare, by its film alone."""
        if not self.bears:
            return bool(self.refused) or not self.faults
        kept = self.covered >= COVERED_SHARE and not self.faults and not self.refused
        return (
            kept
            and abs(self.focal_error) <= FOCAL_SHARE
            and self.registration_px <= REGISTRATION_PX
        )

    def line(self) -> str:
        """A row of a table."""
        verdict = "yes" if self.right else "NO"
        if self.refused:
            return (
                f"| {self.name} | {verdict} | refused: {self.refused} | | | | {self.seconds:.0f} |"
            )
        kept = "; ".join(self.faults) or "kept"
        return (
            f"| {self.name} | {verdict} | {self.focal_error:+.2%} | {self.registration_px:.2f} | "
            f"{self.covered:.0%} | {kept} | {self.seconds:.0f} |"
        )


def run_command(clip: Path, out: Path, until: str) -> tuple[int, str]:
    """Run it; returns its exit status and the last line that it printed to standard error."""
    command = [str(Path(sys.executable).with_name("motorcade")), "run", str(clip)]
    ran = subprocess.run(
        [*command, "--out", str(out), "--until", until], capture_output=True, text=True, check=False
    )
    lines = [one for one in ran.stderr.splitlines() if one.strip()]
    return ran.returncode, lines[-1] if lines else ""


def score(clip: Path, case: Case, out: Path, until: str = "overlay") -> Score:
    """Run the command on a clip, and hold what it leaves against the truth.

    Args:
        clip: the video; its truth lies beside it.
        case: what it shows.
        out: for the run's results.
        until: the last stage; without a film, nothing of it is compared.
    """
    start = time.perf_counter()
    status, last = run_command(clip, out, until)
    seconds = time.perf_counter() - start
    if status:
        return Score(case.name, case.bears, seconds, refused=f"({status}) {last}")
    if not case.bears:
        return Score(case.name, case.bears, seconds, faults=film_faults(clip, out, until))
    return scored(clip, case, out, until, seconds)


def scored(clip: Path, case: Case, out: Path, until: str, seconds: float) -> Score:
    """What a run left, held against the truth that lies beside its clip."""
    truth = np.load(clip.with_suffix(".truth.npz"))
    log = json.loads((out / "run.json").read_text())
    table = tomllib.loads((out / "manifest.toml").read_text())["camera"]
    camera = Camera(
        *(table[key] for key in ("width", "height", "fx", "fy", "cx", "cy")),
        table.get("model", "pinhole"),
        tuple(table.get("distortion", ())),
    )
    path = read_trajectory(_drawn(out))
    run = {0: (0.0, 1.0), 90: (-1.0, 0.0), 270: (1.0, 0.0)}[case.rotation]
    shutter_s = table.get("readout_s", 0.0) * np.array(run)
    registration, covered = registration_px(path, camera, truth, shutter_s)
    faults = film_faults(clip, out, until)
    focal = float(truth["focal_px"].mean())
    said = next(one for one in log["assumed"] if one.startswith("camera:"))
    error = camera.fx / focal - 1.0
    return Score(case.name, case.bears, seconds, "", error, registration, covered, faults, said)


def film_faults(clip: Path, out: Path, until: str) -> tuple[str, ...]:
    """What is wrong with a run's film against its clip: no film, other frames, stamps or sound."""
    film = out / "overlay.mp4"
    if not film.exists():
        return ("no film",) if until == "overlay" else ()
    return tuple(faults_of_film(read_video(clip), read_video(film)))


def _drawn(out: Path) -> Path:
    """The path along which things are drawn into the film."""
    smoothed = out / "trajectories" / "smoothed_motor.tum"
    return smoothed if smoothed.exists() else out / "trajectories" / "camera_poses_motor.tum"


def registration_px(
    path: Trajectory, camera: Camera, truth: Truth, shutter_s: NDArray[np.float64]
) -> tuple[float, float]:
    """Error of the cube's corners, and the share of the frames that have a pose."""
    true_ns = np.rint(1e9 * truth["time_s"]).astype(np.int64)
    rows = np.abs(true_ns[:, None] - path.time_ns).argmin(axis=1)
    near = np.abs(true_ns - path.time_ns[rows]) < 2_000_000
    if np.count_nonzero(near) < 3:
        return np.inf, float(near.mean())
    rows, seen = rows[near], truth["anchors_px"][near]
    numbers = _start(path.motors[rows], Motor(truth["world_T_camera"])[near])
    for _ in range(2):
        placed = _placed(numbers, truth)
        drawn = as_read(path, camera, placed, shutter_s) if shutter_s.any() else path
        numbers, error = _fitted(numbers, drawn.motors[rows], camera, truth, seen)
    return error, float(near.mean())


def _placed(numbers: NDArray[np.float64], truth: Truth) -> NDArray[np.float64]:
    """The cube's corners where rotation vector, shift and log scale ``(7,)`` put them."""
    turn = Rotor.from_rotation_vector(numbers[:3])
    placed: NDArray[np.float64] = np.exp(numbers[6]) * turn.apply(truth["anchors_m"])
    return placed + numbers[3:6]


def _fitted(
    start: NDArray[np.float64],
    poses: Motor,
    camera: Camera,
    truth: Truth,
    seen: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Where the cube fits best, and its root mean square error."""
    inside = np.all((seen > 0.0) & (seen < (camera.width - 1, camera.height - 1)), axis=-1)
    to_camera = poses.inverse()[:, None]

    def off(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        px = camera.project(to_camera.apply(_placed(numbers, truth)), allow_nan=True)
        return np.nan_to_num((px - seen)[inside], nan=1e3).ravel()

    best = least_squares(off, start, x_scale="jac")
    return best.x, float(np.sqrt(2.0 * np.mean(best.fun**2)))


def _start(found: Motor, true: Motor) -> NDArray[np.float64]:
    """Rotation vector, shift and log scale ``(7,)`` from the true world to the one found."""
    time_ns = np.arange(int(true.shape[0]))
    paths = [Trajectory(time_ns, one, "world", "camera") for one in (true, found)]
    fitted = align(associate(*paths), with_scale=True)
    turn = fitted.rotor.as_rotation_vector()
    return np.concatenate([turn, fitted.translation_m, [np.log(fitted.scale)]])
