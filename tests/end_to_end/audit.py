"""Contradictions planted in recordings at hand: is each found, and named?

    python -m tests.end_to_end.audit

What a user gets wrong is planted in what a recording says of itself: focal lengths, depth, its
extrinsics and scale, boards, distortion, left and right, the IMU's extrinsics, axes, units and
clock, sizes of markers, odometry's extrinsics and the cameras of a rig. A line each: what was
planted, the finding's name that must contradict it, what was found.
Then the same recordings as they are, of which nothing may be doubted.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from motorcade.ga import Motor, Rotor
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.tagslam.recording import TagSlamRecording
from motorcade.replays.io.readers.tagslam.recording import read_corners as read_tagslam
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.board_audit import audited_board
from motorcade.replays.stages.camera.offered import camera_of, sampled_images
from motorcade.replays.stages.camera.sensor_audit import audited_depth, audited_pair
from motorcade.tracking import AuditFinding, Checkerboard, track_board
from motorcade.tracking.depth import DepthCamera
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.scenes import FixedMarker, MarkerBody, map_scene
from motorcade.tracking.targets.stated import compare_layout
from tests.fusion.health.cases import FAULTS, flown
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import scenario

Findings = tuple[AuditFinding, ...]
MANIFESTS = Path(__file__).parents[2] / "docs" / "manifests"
_BOARD_FRAMES = 60
_TAG_FRAMES = 600


@dataclass(frozen=True)
class Planted:
    """One contradiction: where, what, and the name of the finding that must tell it."""

    recording: str
    what: str
    expected: str
    findings: Callable[[], Findings]


def kitchens(data: Path) -> Iterator[Planted]:
    """Depth and colour of 7-Scenes."""
    changes: dict[str, tuple[str, Callable[[ImageFrames], ImageFrames]]] = {
        "colour's focal length 5 % too long": ("depth_on_colour", colour_zoomed(1.05)),
        "colour's focal length 5 % too short": ("depth_on_colour", colour_zoomed(0.95)),
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

    frames = recording.frames
    if not isinstance(frames, ImageFrames):
        raise ValueError(f"{scratch}: expected image files")
    swapped = replace(
        recording, frames=replace(frames, files=frames.right_files, right_files=frames.files)
    )
    yield Planted("drawn pair", "left for right", "left_and_right", lambda: audited_pair(swapped))
    yield Planted("drawn pair", "", "", lambda: audited_pair(recording))
    camera = camera_of(recording)
    bent = replace(
        recording, camera=replace(camera, model="radtan", distortion=(-0.2, 0.05, 0.0, 0.0))
    )
    yield Planted("drawn pair", "distortion stated", "distortion", lambda: audited_pair(bent))


def flights(data: Path) -> Iterator[Planted]:
    """An IMU beside camera poses: the health verdict, which a run's integrity tells."""
    chosen = ("extrinsics transposed", "extrinsics off by 20°", "x and y swapped", "deg/s")
    for what in (*chosen, "half a second late", ""):
        expected = FAULTS[what][1] if what else ""
        yield Planted("V1_02", what, expected, partial(_health, data, what))


def tags(data: Path) -> Iterator[Planted]:
    """Markers that cameras on a body saw, and what is stated of them."""
    changes: dict[str, tuple[str, str, Callable[[TagSlamRecording], TagSlamRecording]]] = {
        "marker stated a quarter too large": ("test_23", "marker_sizes", _larger_marker),
        "odometry's pose on its body inverted": (
            "test_21",
            "odometry_extrinsics",
            _inverted_odometry,
        ),
        "cameras of the rig swapped": ("test_11", "stated_poses", _swapped_cameras),
    }
    for what, (name, expected, change) in changes.items():
        yield Planted(name, what, expected, partial(_scene_of, data, name, change))
    for name in ("test_11", "test_21", "test_23"):
        yield Planted(name, "", "", partial(_scene_of, data, name, lambda one: one))


def _scene_of(
    data: Path, name: str, change: Callable[[TagSlamRecording], TagSlamRecording]
) -> Findings:
    given = change(read_tagslam(data / "tags" / "tagslam" / name))
    streams = {camera: _first_frames(stream) for camera, stream in given.streams.items()}
    return map_scene(streams, given.scene).audit


def _first_frames(stream: CornerStream) -> CornerStream:
    """Up to half a minute, which is enough to tell."""
    kept = stream.frame < _TAG_FRAMES
    return CornerStream(
        stream.camera,
        stream.time_ns[:_TAG_FRAMES],
        stream.frame[kept],
        stream.marker_ids[kept],
        stream.corners_px[kept],
    )


def _larger_marker(one: TagSlamRecording) -> TagSlamRecording:
    """The marker that is seen most often beside others."""
    stream = next(iter(one.streams.values()))
    beside = np.bincount(stream.frame)[stream.frame] > 1
    wrong = int(np.argmax(np.bincount(stream.marker_ids[beside & (stream.frame < _TAG_FRAMES)])))

    def changed(body: MarkerBody, row: int) -> MarkerBody:
        if one.scene.body_of(wrong) != row:
            return body
        stated = body.markers.get(wrong) or FixedMarker(one.side_m[wrong])
        larger = replace(stated, side_m=1.25 * stated.side_m)
        return replace(body, markers={**body.markers, wrong: larger})

    bodies = tuple(changed(body, row) for row, body in enumerate(one.scene.bodies))
    return replace(one, scene=replace(one.scene, bodies=bodies))


def _inverted_odometry(one: TagSlamRecording) -> TagSlamRecording:
    """Stated half a turn from the body a pose is its own inverse, so it is turned by 120° first."""
    other = Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.deg2rad(120.0) / np.sqrt(3.0) * np.ones(3)), np.zeros(3)
    )

    def changed(body: MarkerBody) -> MarkerBody:
        if body.odometry is None:
            return body
        path = body.odometry.trajectory.transformed_by(right=other)
        body_T_odometry = body.odometry.body_T_odometry @ other
        wrong = replace(body.odometry, trajectory=path, body_T_odometry=body_T_odometry.inverse())
        return replace(body, odometry=wrong)

    bodies = tuple(map(changed, one.scene.bodies))
    return replace(one, scene=replace(one.scene, bodies=bodies))


def _swapped_cameras(one: TagSlamRecording) -> TagSlamRecording:
    first, second, *others = one.scene.cameras.values()
    swapped = dict(zip(one.scene.cameras, (second, first, *others), strict=True))
    return replace(one, scene=replace(one.scene, cameras=swapped))


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


def _depth_of(root: Path, change: Callable[[ImageFrames], ImageFrames]) -> Callable[[], Findings]:
    return lambda: audited_depth(changed_kitchen(root, change))[1]


def changed_kitchen(root: Path, change: Callable[[ImageFrames], ImageFrames]) -> Recording:
    """A recording of 7-Scenes of which something else is stated."""
    recording = open_recording(root)
    frames = recording.frames
    if not isinstance(frames, ImageFrames):
        raise ValueError(f"{root}: expected image files")
    changed = change(frames)
    return replace(recording, frames=changed, camera=changed.colour_camera)


def _sensor(frames: ImageFrames) -> DepthCamera:
    if frames.depth_camera is None:
        raise ValueError("frames: expected a depth camera, got none")
    return frames.depth_camera


def colour_zoomed(factor: float) -> Callable[[ImageFrames], ImageFrames]:
    def change(frames: ImageFrames) -> ImageFrames:
        camera = frames.colour_camera
        if camera is None:
            raise ValueError("frames: expected a colour camera, got none")
        longer = replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)
        return replace(frames, colour_camera=longer)

    return change


def _depth_zoomed(factor: float) -> Callable[[ImageFrames], ImageFrames]:
    def change(frames: ImageFrames) -> ImageFrames:
        camera = _sensor(frames).camera
        other = replace(camera, fx=factor * camera.fx, fy=factor * camera.fy)
        sensor = DepthCamera(other, _sensor(frames).colour_T_depth)
        return replace(frames, depth_camera=sensor)

    return change


def _shifted(frames: ImageFrames) -> ImageFrames:
    camera = _sensor(frames).camera
    sensor = DepthCamera(replace(camera, cx=camera.cx - 10.0), _sensor(frames).colour_T_depth)
    return replace(frames, depth_camera=sensor)


def _inverted(frames: ImageFrames) -> ImageFrames:
    colour_T_depth: Motor = _sensor(frames).colour_T_depth.inverse()
    return replace(frames, depth_camera=DepthCamera(_sensor(frames).camera, colour_T_depth))


def _scaled(factor: float) -> Callable[[ImageFrames], ImageFrames]:
    return lambda one: replace(one, depth_units_per_m=factor * one.depth_units_per_m)


def _board_findings(root: Path, change: Callable[[Recording], Recording]) -> Callable[[], Findings]:
    def findings() -> Findings:
        recording = change(open_recording(root, MANIFESTS / "vamr_board.toml"))
        if recording.camera is None or recording.board is None:
            raise ValueError(f"{root}: expected a camera and a board")
        images = [
            (recording.frames[number].time_ns, recording.frames[number].gray())
            for number in range(0, len(recording.frames), len(recording.frames) // _BOARD_FRAMES)
        ]
        tracked = track_board(images, recording.camera, recording.board)
        layout = compare_layout(recording.board, sampled_images(recording), recording.camera)
        of_camera, *_ = audited_board(recording, recording.board, tracked, 0.0)
        return of_camera if layout is None else (layout, *of_camera)

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
        for planted in (
            kitchens(data),
            boards(data),
            pairs(Path(scratch)),
            flights(data),
            tags(data),
        ):
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
