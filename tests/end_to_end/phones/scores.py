"""What self-calibration makes of a clip, against its truth: focal length and registration.

Registration here: in every frame the camera's pose follows from the print alone, with the camera
that was found; corners of a cube that stands on the print are projected, and compared with where
the exact camera sees them. Of a clip without print only the focal length is scored here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking import (
    Camera,
    Detection,
    SelfCalibration,
    SelfCalibrationError,
    detect_markers,
    self_calibrate_board,
    self_calibrate_motion,
    self_calibrate_tags,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.pose import refine
from motorcade.tracking.self_calibration.bodies import velocities
from tests.end_to_end.phones.cases import Case

__all__ = ["Score", "score", "upright_frames"]

Truth = Mapping[str, NDArray[np.float64]]
Seen = BoardCorners | Sequence[Detection] | None
"""A board, or tags, or nothing."""


@dataclass(frozen=True)
class Score:
    """One clip's figures.

    Fields:
        name: of the clip; bears: whether a camera follows from it.
        focal_error: relative, signed; None where none was given.
        registration_px: root mean square over frames and corners, lines placed by their own times;
            None where there is no print.
        unrolled_px: the same with one pose a frame, as if the shutter did not roll.
        found: what was given; refused: or why not.
    """

    name: str
    bears: bool
    focal_error: float | None = None
    registration_px: float | None = None
    unrolled_px: float | None = None
    found: SelfCalibration | None = None
    refused: str = ""

    @property
    def right(self) -> bool:
        """Whether the clip came out as it must."""
        if not self.bears:
            return self.found is None
        near = self.focal_error is not None and abs(self.focal_error) <= 0.01
        return near and (self.registration_px is None or self.registration_px <= 0.5)

    def line(self) -> str:
        """For people."""
        verdict = "ok  " if self.right else "MISS"
        if self.found is None or self.focal_error is None:
            return f"{verdict} {self.name:24s} refused: {self.refused}"
        placed = "-"
        if self.registration_px is not None:
            placed = f"{self.registration_px:.3f} (one pose a frame {self.unrolled_px:.3f})"
        readout = self.found.readout
        shutter = "-" if readout is None else f"{1e3 * readout.seconds:.1f} ms {readout.axis}"
        return (
            f"{verdict} {self.name:24s} focal {self.focal_error:+7.2%} (sigma "
            f"{self.found.sigma_focal:.2%}) registration {placed} px  rms {self.found.rms_px:.2f} "
            f"px  {self.found.camera.model}  shutter {shutter}  breathing "
            f"{self.found.breathing:.1%}"
        )


def upright_frames(path: Path) -> tuple[list[int], list[NDArray[np.uint8]]]:
    """Stamps in nanoseconds and grey pictures of a clip, as a player turns them."""
    stamps, pictures = [], []
    with av.open(str(path)) as clip:
        for frame in clip.decode(video=0):
            quarter = round(frame.rotation / 90.0)
            picture = np.rot90(frame.to_ndarray(format="gray"), quarter)
            stamps.append(int(frame.pts * frame.time_base * 10**9))
            pictures.append(np.ascontiguousarray(picture))
    return stamps, pictures


def score(path: Path, case: Case) -> Score:
    """Calibrate from a clip, and hold what is found against its truth."""
    truth = np.load(path.with_suffix(".truth.npz"))
    stamps, pictures = upright_frames(path)
    size = pictures[0].shape[1], pictures[0].shape[0]
    try:
        seen: Sequence[Seen] = ()
        if case.shows.board is not None:
            views = [case.shows.board.detect(picture) for picture in pictures]
            found, seen = self_calibrate_board(views, size, stamps), views
        elif case.shows.tags:
            frames = [detect_markers(picture, case.shows.family) for picture in pictures]
            found, seen = self_calibrate_tags(frames, size, stamps), frames
        else:
            found = self_calibrate_motion(pictures, size, stamps)
    except SelfCalibrationError as refusal:
        return Score(case.name, case.bears, refused=str(refusal))
    focal = float(truth["focal_px"].mean())
    error = found.camera.fx / focal - 1.0
    if not seen:
        return Score(case.name, case.bears, error, found=found)
    sighted = _sighted(case, seen)
    placed = [_registration_px(found, sighted, truth, shutter=one) for one in (True, False)]
    return Score(case.name, case.bears, error, placed[0], placed[1], found)


def _sighted(case: Case, seen: Sequence[Seen]) -> list[BoardCorners | None]:
    """What was seen in each frame, as points of the world."""
    board = case.shows.board
    if board is not None:
        low, high = board.points_m.min(axis=0), board.points_m.max(axis=0)
        shift = np.append(-0.5 * (low + high)[:2], 0.001)
        return [
            None
            if not isinstance(one, BoardCorners)
            else BoardCorners(one.ids, one.corners_px, one.points_m + shift)
            for one in seen
        ]
    square = marker_points_m(case.shows.side_m) - 0.5 * case.shows.side_m * np.array([1, -1, 0])
    layout = {tag.marker_id: tag.world_T_tag().apply(square) for tag in case.shows.tags}
    found: list[BoardCorners | None] = []
    for frame in seen:
        sharp = [] if frame is None else [one for one in frame if one.sharp]  # type: ignore[union-attr]
        if not sharp:
            found.append(None)
            continue
        points = np.concatenate([layout[one.marker_id] for one in sharp])
        px = np.concatenate([one.corners_px for one in sharp])
        found.append(BoardCorners(np.arange(len(px)), px, points))
    return found


def _registration_px(
    found: SelfCalibration, views: list[BoardCorners | None], truth: Truth, *, shutter: bool
) -> float:
    """Error of the cube's corners where the print gives each frame's pose.

    Args:
        found: the camera, and its shutter's read-out.
        views: the print's corners by frame, world.
        truth: of the clip.
        shutter: whether lines are placed by their own time, the velocity being that of the poses.
    """
    camera, readout = found.camera, _readout_s(found) if shutter else np.zeros(2)
    shown = [number for number, view in enumerate(views) if view is not None and view.spanning]
    kept = [view for view in views if view is not None and view.spanning]
    near = Motor(truth["world_T_camera"])[shown]
    poses = Motor.stack(
        [refine(one, camera, at).world_T_camera for one, at in zip(kept, near, strict=True)]
    )
    time_s, velocity = truth["time_s"][shown], np.zeros((len(shown), 6))
    for _ in range(2 if readout.any() else 0):
        velocity = velocities(time_s, poses)
        again = []
        for view, pose, twist in zip(kept, poses, velocity, strict=True):
            bent = _rolled_px(camera, pose, twist, view.points_m, readout)
            straight = _rolled_px(camera, pose, twist, view.points_m, np.zeros(2))
            moved = view.at(view.corners_px - bent + straight)
            again.append(refine(moved, camera, pose).world_T_camera)
        poses = Motor.stack(again)
    errors = []
    for number, pose, twist in zip(shown, poses, velocity, strict=True):
        true = truth["anchors_px"][number]
        px = _rolled_px(camera, pose, twist, truth["anchors_m"], readout)
        inside = np.all((true > 0.0) & (true < (camera.width - 1, camera.height - 1)), axis=-1)
        errors.append(np.linalg.norm(px - true, axis=-1)[inside])
    return float(np.sqrt(np.mean(np.square(np.concatenate(errors)))))


def _readout_s(found: SelfCalibration) -> FloatArray:
    """Seconds across and down; zero where no shutter was told."""
    if found.readout is None:
        return np.zeros(2)
    way = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}[found.readout.axis]
    return found.readout.seconds * np.array(way)


def _rolled_px(
    camera: Camera, pose: Motor, twist: FloatArray, points: FloatArray, readout_s: FloatArray
) -> FloatArray:
    """Where points are seen by a camera that moves while its lines are read."""
    still = pose.inverse().apply(points)
    moves = np.cross(still, twist[:3]) - twist[3:]
    px = camera.project(still)
    for _ in range(3):
        late = ((px + 0.5) / (camera.width, camera.height) - 0.5) @ readout_s
        px = camera.project(still + late[:, None] * moves)
    return px
