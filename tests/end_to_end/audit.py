"""Contradictions planted in recordings at hand: is each found, and named?

    python -m tests.end_to_end.audit

What a user gets wrong is planted in what a recording says of itself: focal lengths, depth, its
extrinsics and scale, boards, distortion, left and right, the IMU's extrinsics, axes, units and
clock. A line each: what was planted, the finding's name that must contradict it, what was found.
Then the same recordings as they are, of which nothing may be doubted.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from motorcade.ga import Motor
from motorcade.replays.readers.frames.files import PictureFrames
from motorcade.replays.readers.opening import open_recording
from motorcade.replays.recording import Frame, Recording
from motorcade.replays.stages.camera.board_audit import audited_board
from motorcade.replays.stages.camera.sensor_audit import audited_depth, audited_pair
from motorcade.tracking import AuditFinding, Checkerboard, track_board
from motorcade.tracking.depth import DepthCamera
from tests.fusion.health.cases import FAULTS, flown
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import scenario

Findings = tuple[AuditFinding, ...]
MANIFESTS = Path(__file__).parents[2] / "docs" / "manifests"
_BOARD_FRAMES = 60


@dataclass(frozen=True)
class Planted:
    """One contradiction: where, what, and the name of the finding that must tell it."""

    recording: str
    what: str
    expected: str
    findings: Callable[[], Findings]


def kitchens(data: Path) -> Iterator[Planted]:
    """Depth and colour of 7-Scenes."""
    changes: dict[str, tuple[str, Callable[[PictureFrames], PictureFrames]]] = {
        "colour's focal length 5 % too long": ("depth_on_colour", _colour_zoomed(1.05)),
        "colour's focal length 5 % too short": ("depth_on_colour", _colour_zoomed(0.95)),
        "depth's focal length that of colour": ("depth_on_colour", _depth_zoomed(525.0 / 585.0)),
        "depth 10 px to the right": ("depth_on_colour", _shifted),
        "depth camera's extrinsics inverted": ("depth_on_colour", _inverted),
        "depth 5 % too large": ("depth_scale", _scaled(1.0 / 1.05)),
        "depth in units of 1/5000 m": ("depth_scale", _scaled(5.0)),
    }
    for name in ("7scenes_redkitchen", "7scenes_redkitchen_200"):
        for what, (expected, change) in changes.items():
            yield Planted(name, what, expected, _depth_of(data / "replays" / name, change))
        yield Planted(name, "", "", _depth_of(data / "replays" / name, lambda one: one))


def boards(data: Path) -> Iterator[Planted]:
    """A checkerboard and the camera that looks at it."""
    name = "vamr_board"
    root = data / "replays" / name
    changes: dict[str, tuple[str, Callable[[Recording], Recording]]] = {
        "focal length 5 % too long": ("camera_on_board", _zoomed(1.05)),
        "focal length 5 % too short": ("camera_on_board", _zoomed(0.95)),
        "distortion of the other sign": ("camera_on_board", _bent),
        "board of 8 x 6 corners": ("board_corners", _board_of(8, 6)),
        "board of 7 x 5 corners": ("board_corners", _board_of(7, 5)),
        "": ("", lambda one: one),
    }
    for what, (expected, change) in changes.items():
        yield Planted(name, what, expected, _board_findings(root, change))


def pairs(scratch: Path) -> Iterator[Planted]:
    """Left and right of a drawn pair."""
    write_recording(scratch, scenario("handheld", frames=30), name="drawn pair")
    recording = open_recording(scratch)

    class Swapped:
        """Right pictures for left ones."""

        def __len__(self) -> int:
            return len(recording.frames)

        def __getitem__(self, index: int) -> Frame:
            one = recording.frames[index]
            if one.read_right is None:
                raise ValueError("expected a right picture, got none")
            return replace(one, read_image=one.read_right, read_right=one.gray)

    swapped = replace(recording, frames=Swapped())  # type: ignore[arg-type]
    yield Planted(
        "drawn pair", "left for right", "left_and_right", lambda: (audited_pair(swapped),)
    )
    yield Planted("drawn pair", "", "", lambda: (audited_pair(recording),))


def flights(data: Path) -> Iterator[Planted]:
    """An IMU beside camera poses: the health verdict, which a run's integrity tells."""
    chosen = ("extrinsics transposed", "extrinsics off by 20°", "x and y swapped", "deg/s")
    for what in (*chosen, "half a second late", ""):
        expected = FAULTS[what][1] if what else ""
        yield Planted("V1_02", what, expected, lambda what=what: _health(data, what))  # type: ignore[misc]


def _health(data: Path, what: str) -> Findings:
    from motorcade.fusion.health import check_health

    one = flown("V1_02", data)
    given = FAULTS[what][0](one, one) if what else one
    found = check_health(
        given.poses.trajectory, given.imu, given.imu_T_camera, gravity_m_s2=given.gravity_m_s2
    )
    return tuple(
        AuditFinding(fault.fault, "contradicted", None, "", found.summary)
        for fault in found.findings
    )


def _depth_of(
    root: Path, change: Callable[[PictureFrames], PictureFrames]
) -> Callable[[], Findings]:
    def findings() -> Findings:
        recording = open_recording(root)
        frames = recording.frames
        if not isinstance(frames, PictureFrames):
            raise ValueError(f"{root}: expected picture files")
        changed = change(frames)
        return audited_depth(replace(recording, frames=changed, camera=changed.colour_camera))[1]

    return findings


def _sensor(frames: PictureFrames) -> DepthCamera:
    if frames.depth_camera is None:
        raise ValueError("frames: expected a depth camera, got none")
    return frames.depth_camera


def _colour_zoomed(factor: float) -> Callable[[PictureFrames], PictureFrames]:
    def change(frames: PictureFrames) -> PictureFrames:
        camera = frames.colour_camera
        if camera is None:
            raise ValueError("frames: expected a colour camera, got none")
        longer = replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)
        return replace(frames, colour_camera=longer)

    return change


def _depth_zoomed(factor: float) -> Callable[[PictureFrames], PictureFrames]:
    def change(frames: PictureFrames) -> PictureFrames:
        camera = _sensor(frames).camera
        other = replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)
        sensor = DepthCamera(other, _sensor(frames).colour_T_depth)
        return replace(frames, depth_camera=sensor)

    return change


def _shifted(frames: PictureFrames) -> PictureFrames:
    camera = _sensor(frames).camera
    sensor = DepthCamera(replace(camera, cx=camera.cx - 10.0), _sensor(frames).colour_T_depth)
    return replace(frames, depth_camera=sensor)


def _inverted(frames: PictureFrames) -> PictureFrames:
    colour_T_depth: Motor = _sensor(frames).colour_T_depth.inverse()
    return replace(frames, depth_camera=DepthCamera(_sensor(frames).camera, colour_T_depth))


def _scaled(factor: float) -> Callable[[PictureFrames], PictureFrames]:
    return lambda one: replace(one, depth_units_per_m=factor * one.depth_units_per_m)


def _board_findings(root: Path, change: Callable[[Recording], Recording]) -> Callable[[], Findings]:
    def findings() -> Findings:
        recording = change(open_recording(root, MANIFESTS / "vamr_board.toml"))
        if recording.camera is None or recording.board is None:
            raise ValueError(f"{root}: expected a camera and a board")
        pictures = [
            (recording.frames[number].time_ns, recording.frames[number].gray())
            for number in range(0, len(recording.frames), len(recording.frames) // _BOARD_FRAMES)
        ]
        tracked = track_board(pictures, recording.camera, recording.board)
        return audited_board(recording, recording.board, tracked)

    return findings


def _zoomed(factor: float) -> Callable[[Recording], Recording]:
    def change(one: Recording) -> Recording:
        if one.camera is None:
            raise ValueError("recording: expected a camera, got none")
        camera = replace(one.camera, fx=factor * one.camera.fx, fy=factor * one.camera.fy)
        return replace(one, camera=camera)

    return change


def _bent(one: Recording) -> Recording:
    if one.camera is None:
        raise ValueError("recording: expected a camera, got none")
    other = tuple(-value for value in one.camera.distortion)
    return replace(one, camera=replace(one.camera, distortion=other))


def _board_of(columns: int, rows: int) -> Callable[[Recording], Recording]:
    return lambda one: replace(one, board=Checkerboard(columns, rows, 0.04))


def judged(one: Planted) -> tuple[bool, str]:
    """Whether what was planted was named, and what was found; of clean ones, that nothing was."""
    found = one.findings()
    doubted = [finding for finding in found if not finding.passed]
    named = any(
        finding.name == one.expected and finding.verdict == "contradicted" for finding in doubted
    )
    told = "; ".join(finding.sentence for finding in (doubted or found)) or "nothing is wrong"
    return (named if one.expected else not doubted), told


def main() -> int:
    """Print a line each; 1 where one was missed, or a clean recording doubted."""
    data = Path(os.environ.get("MOTORCADE_DATA") or "../shared/data")
    missed = 0
    with tempfile.TemporaryDirectory() as scratch:
        for planted in (kitchens(data), boards(data), pairs(Path(scratch)), flights(data)):
            for one in planted:
                right, told = judged(one)
                missed += not right
                mark = "found " if right else "MISSED"
                if not one.what:
                    mark = "clean " if right else "FALSE "
                print(f"{mark} {one.recording}: {one.what or 'as it is'}: {told}", flush=True)
    print(f"{missed} missed or false")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
