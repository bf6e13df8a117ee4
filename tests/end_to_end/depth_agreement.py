"""How well a path lays depth images on each other: a witness that needs no ground truth.

    python -m tests.end_to_end.depth_agreement FOLDER [FOLDER ...] [--window 200]

All folders together are one recording in 7-Scenes' layout (the parts of a longer one). Visual SLAM
runs as a user runs it, with depth and by one camera alone, over everything and in every window;
of the pairs of frames 30 and 300 apart the median of the point-to-plane distances is printed in
millimetres, beside that of the published poses. A monocular path has the scale that fits the path
with depth. The distances are computed here by numpy alone: raw depth, the published 585 px, normals
by differences of neighbours, pixels of the other frame by rounding.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import Recording

GAPS = (30, 300)
_FOCAL, _CX, _CY = 585.0, 320.0, 240.0
_CUT_M = 0.1
_FEWEST = 2000
_PAIRS_EVERY = 10


class DepthWitness:
    """Depth images of a recording, and what paths make of pairs of them."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._files = files
        self._kept: dict[int, tuple[FloatArray, FloatArray]] = {}

    def apart_mm(self, world_T_depth: FloatArray, gap: int) -> float:
        """Median over pairs of frames so far apart of the median distance, mm; NaN without any."""
        medians = []
        for first in range(0, len(world_T_depth) - gap, _PAIRS_EVERY):
            one, other = world_T_depth[first], world_T_depth[first + gap]
            if np.isnan(one).any() or np.isnan(other).any():
                continue
            apart = self._pair(first, first + gap, np.linalg.inv(one) @ other)
            if len(apart) > _FEWEST:
                medians.append(np.median(apart))
        return 1e3 * float(np.median(medians)) if medians else float("nan")

    def _pair(self, first: int, second: int, first_T_second: FloatArray) -> FloatArray:
        points, normals = self._surface(first)
        seen = self._surface(second)[0][::4, ::4].reshape(-1, 3)
        seen = seen[np.isfinite(seen[:, 0])] @ first_T_second[:3, :3].T + first_T_second[:3, 3]
        seen = seen[seen[:, 2] > 0.1]
        column = np.rint(seen[:, 0] / seen[:, 2] * _FOCAL + _CX).astype(int)
        row = np.rint(seen[:, 1] / seen[:, 2] * _FOCAL + _CY).astype(int)
        inside = (column >= 0) & (column < 640) & (row >= 0) & (row < 480)
        row, column = row[inside], column[inside]
        apart = np.abs(np.sum((seen[inside] - points[row, column]) * normals[row, column], axis=-1))
        found: FloatArray = apart[apart < _CUT_M]
        return found

    def _surface(self, index: int) -> tuple[FloatArray, FloatArray]:
        if index not in self._kept:
            stored = cv2.imread(str(self._files[index]), cv2.IMREAD_UNCHANGED)
            depth = np.where((stored == 0) | (stored == 65535), np.nan, stored / 1000.0)
            row, column = np.mgrid[: depth.shape[0], : depth.shape[1]]
            along = np.stack([(column - _CX) / _FOCAL, (row - _CY) / _FOCAL], axis=-1)
            points = np.concatenate([along * depth[..., None], depth[..., None]], axis=-1)
            right, down = np.full_like(points, np.nan), np.full_like(points, np.nan)
            right[:, 3:-3] = points[:, 6:] - points[:, :-6]
            down[3:-3] = points[6:] - points[:-6]
            normal = np.cross(right, down)
            normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
            jump = np.maximum(np.abs(right[..., 2]), np.abs(down[..., 2])) > 0.03 * depth
            normal[jump] = np.nan
            self._kept[index] = points, normal
        return self._kept[index]


def together(folders: Sequence[Path], into: Path, start: int = 0, stop: int | None = None) -> Path:
    """One recording of the frames of several, by links."""
    into.mkdir(parents=True)
    files = sorted(path for folder in folders for path in folder.glob("frame-*"))
    names = sorted({path.name.partition(".")[0] for path in files})[start:stop]
    for path in files:
        if path.name.partition(".")[0] in names:
            (into / path.name).symlink_to(path.resolve())
    return into


def run_slam(recording: Recording, with_depth: bool) -> Trajectory:
    """The path that the stage gives, its colour camera's."""
    from motorcade.replays.stages.camera.slam_poses import slam_poses
    from motorcade.tracking.slam import VisualSlam

    if with_depth:
        return slam_poses(recording).measurements.trajectory
    if recording.camera is None:
        raise ValueError(f"{recording.name}: expected a camera, got none")
    slam = VisualSlam(recording.camera)
    for frame in recording.frames:
        slam.track(frame.time_ns, frame.gray())
    path = slam.finish().trajectory
    if path is None:
        raise ValueError(f"{recording.name}: expected a path by one camera, got none")
    return path


def scaled(path: Trajectory, metric: Trajectory) -> Trajectory:
    """A monocular path in the metres of another, by the lengths of both."""
    common = np.intersect1d(path.time_ns, metric.time_ns)
    free, known = (
        one.motors_at(common).translation_m - one.motors_at(common[:1]).translation_m
        for one in (path, metric)
    )
    scale = np.sqrt(np.sum(known**2) / np.sum(free**2))
    poses = Motor.from_rotor_translation(path.motors.rotor, scale * path.motors.translation_m)
    return Trajectory(path.time_ns, poses)


def figures(folder: Path, mono: bool) -> dict[str, dict[int, float]]:
    """Of the reference, the path with depth, and the one by one camera: mm by frames apart."""
    recording = open_recording(folder)
    frames = recording.frames
    if not isinstance(frames, ImageFrames) or frames.depth_camera is None:
        raise ValueError(f"{folder}: expected 7-Scenes' layout, got {recording.layout}")
    if recording.truth is None:
        raise ValueError(f"{folder}: expected published poses, got none")
    witness = DepthWitness([path for path in frames.depth_files if path is not None])
    paths = {"published": recording.truth, "with depth": run_slam(recording, True)}
    if mono:
        paths["one camera"] = scaled(run_slam(recording, False), paths["with depth"])
    found = {}
    for name, path in paths.items():
        poses = np.full((len(frames), 4, 4), np.nan)
        known = np.isin(frames.time_ns, path.time_ns)
        world_T_depth = path.motors_at(frames.time_ns[known]) @ frames.depth_camera.colour_T_depth
        poses[known] = world_T_depth.as_matrix()
        found[name] = {gap: witness.apart_mm(poses, gap) for gap in GAPS}
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="How well paths lay depth images on each other.")
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--window", type=int, default=200)
    parser.add_argument("--whole-only", action="store_true", help="no windows")
    given = parser.parse_args(arguments)
    count = len({path.name for one in given.folders for path in one.glob("frame-*.color.*")})
    spans = [(0, count)]
    if not given.whole_only and given.window < count:
        spans += [
            (start, start + given.window)
            for start in range(0, count - given.window + 1, given.window)
        ]
    print(f"{'frames':<12}{'path':<14}" + "".join(f"{gap:>5} apart" for gap in GAPS) + "   (mm)")
    with tempfile.TemporaryDirectory() as scratch:
        for start, stop in spans:
            folder = together(given.folders, Path(scratch) / f"{start}-{stop - 1}", start, stop)
            for name, by_gap in figures(folder, mono=stop - start <= given.window).items():
                cells = "".join(f"{by_gap[gap]:>11.2f}" for gap in GAPS)
                print(f"{start}-{stop - 1:<10}{name:<14}{cells}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
