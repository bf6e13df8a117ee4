"""Stage `described`: a manifest for a recording of whose camera nothing was told.

`open_described` opens a recording whatever was told of it: what it lacks is found out, written and
read.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from motorcade.fusion.imu import ImuStream
from motorcade.ga.files import off_record
from motorcade.ga.progress import working
from motorcade.replays.engine.graph import Graph, Knobs
from motorcade.replays.engine.stage import GraphError
from motorcade.replays.io.files import read_bounded, write_bytes
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.names import stamps_of_names
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.layouts.detect import LOOSE_IMAGES, RATE_HZ
from motorcade.replays.io.readers.manifest import LOCAL_NAME
from motorcade.replays.io.readers.manifest.section import (
    TOML_LIMIT,
    board_toml,
    camera_toml,
    load_toml,
    markers_toml,
)
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import FrameSequence, Recording
from motorcade.replays.pipeline.described.footage import (
    GOPRO_IMU_R_CAMERA,
    ChosenShot,
    FoundCamera,
    SeenTurns,
    camera_by_motion,
    camera_by_target,
    camera_by_turning,
    camera_by_view,
    camera_of_fixed_place,
    check_axes,
    explained_by_rotation,
    refuse_oblong_pixels,
    seen_turns,
)
from motorcade.replays.pipeline.described.people import with_people
from motorcade.replays.pipeline.described.values import (
    AGREES_SHARE,
    Assumption,
    Description,
    SampledImages,
    StatedLens,
    stated_lens,
)
from motorcade.tracking import (
    SelfCalibrationError,
)
from motorcade.tracking.boards.names import board_in_units
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.checks import GrayImage, check_length
from motorcade.tracking.self_calibration.result import OnlyTurnsError
from motorcade.tracking.shots import CameraMotion
from motorcade.tracking.targets import FoundTarget, find_target, seen_board, seen_markers

log = logging.getLogger("motorcade.graph")

STAGE = "described"


@dataclass(frozen=True, eq=False)
class OpenedRecording:
    """A recording, and what of it was not told.

    Fields:
        recording: complete as far as its files and images bear it.
        manifest: the text that repeats this, None where nothing was lacking.
        assumed: what stands in it without having been told.
        seconds: what finding that out took, now or when it was done.
    """

    recording: Recording
    manifest: str | None = None
    assumed: tuple[Assumption, ...] = ()
    seconds: float = 0.0


def description_graph() -> Graph:
    """The one stage that comes before the others: from a recording to what it lacks.

    >>> from motorcade.replays.pipeline.described.describing import description_graph
    >>> sorted(description_graph().stages["described"].knobs)
    ['board', 'fov_deg', 'rate_hz', 'shot', 'size_m', 'target']
    """
    return Graph([described], {"recording": Recording})


def parted(settings: Iterable[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Settings of this stage, and those of all others.

    >>> from motorcade.replays.pipeline.described.describing import parted
    >>> parted(["described.size_m=0.03", "tracked.by=slam"])
    (('described.size_m=0.03',), ('tracked.by=slam',))
    """
    words = tuple(settings)
    own = tuple(one for one in words if one.strip().startswith(f"{STAGE}."))
    return own, tuple(one for one in words if one not in own)


def open_described(
    recording: Recording, manifest: Path | None, cache: Path, knobs: Knobs
) -> OpenedRecording:
    """Complete a recording; where neither its files nor a manifest name a camera, find that out.

    Args:
        recording: as it was opened.
        manifest: by which it was opened, if any was named.
        cache: keeps what was found out.
        knobs: of the stage `described`.

    Raises:
        RecordingError: as `open_recording`.
        StageError: images that tell too little; the message says what to do.
        GraphError: knobs for a recording that lacks nothing.
    """
    path = getattr(recording.frames, "named", recording.root)  # a bag's topic with it
    stated = _given(recording.root, manifest)
    names_camera = stated is not None and "camera" in load_toml(stated)
    if names_camera or not lacks_description(recording):
        if knobs.get(STAGE):
            knob = next(iter(knobs[STAGE]))
            problem = f"{STAGE}.{knob}: {path} names its camera, so nothing is looked for"
            raise GraphError(f"{problem}; say it in a manifest instead")
        return OpenedRecording(recording)
    with off_record():
        recording = with_people(recording.intact(), cache)
    run = description_graph().run(STAGE, {"recording": recording}, cache, knobs)
    description: Description = run.outputs[STAGE]
    for assumption in description.assumed:
        log.info("assumed %s", assumption)
    before = "" if stated is None else read_bounded(stated, TOML_LIMIT).decode()
    text = description.manifest(before)
    place = cache / f"manifest-{hashlib.sha256(text.encode()).hexdigest()[:16]}.toml"
    write_bytes(place, text.encode())
    seconds = run.records[0].seconds
    return OpenedRecording(open_recording(path, place), text, description.assumed, seconds)


def _given(path: Path, manifest: Path | None) -> Path | None:
    """The manifest that was named, or lies in the recording."""
    if manifest is not None:
        return manifest
    local = path / LOCAL_NAME
    return local if local.exists() else None


def summary(opened: OpenedRecording) -> dict[str, Any]:
    """What was assumed, for machines; empty where nothing was."""
    return {} if opened.manifest is None else {"assumed": [str(one) for one in opened.assumed]}


_ENOUGH_SHARE = 0.4
"""Of the images: a target seen in fewer is no good to track by."""
_BY_SLAM = "visual SLAM, whose lengths have a unit only where an IMU tells it"
_BY_TURNING = 0.1
"""Relative deviation of a focal length that turning alone tells."""


def lacks_description(recording: Recording) -> bool:
    """Whether a recording has images, and neither a camera nor a truth to go by."""
    unknown = recording.camera is None and recording.truth is None
    return unknown and not isinstance(recording.frames, CornerFrames)


def described(
    recording: Recording,
    *,
    target: Literal["auto", "none"] = "auto",
    board: str | None = None,
    size_m: float | None = None,
    fov_deg: float | None = None,
    rate_hz: float = RATE_HZ,
    shot: int = 0,
) -> Description:
    """Find out what a recording does not tell, and write it as a manifest.

    Boards and markers are looked for in images spread over it, unless the recording names some or
    `target=none` says that there are none. Without `size_m`, the side of a square or of a marker's
    black square in metres, lengths are counted in those. The camera is found by them, or by the
    motion where there are none; `board` names the board in view, as `boards.board_named` does, or
    `checkerboard_8x6` without the size of its squares; `fov_deg` says instead how wide the images
    see along their longer side. `rate_hz` is that of images without times. Of a
    recording with cuts its longest shot is taken, or number `shot`, counted from 1.

    Raises:
        ValueError: a size that is not above zero, a shot that is not there, or images from which
            no camera follows.
    """
    if size_m is not None:
        check_length(size_m, "described.size_m")
    if fov_deg is not None and not 1.0 <= fov_deg <= 170.0:
        raise ValueError(f"described.fov_deg: expected 1 to 170 degrees, got {fov_deg:g}")
    if shot < 0:
        raise ValueError(f"described.shot: expected a number from 1 on, or 0, got {shot}")
    chosen = ChosenShot(recording, shot, lenient=fov_deg is not None)
    describing, sample = _Describing(chosen.recording, chosen.shot.motion), chosen.sample
    refuse_oblong_pixels(chosen.recording)
    describing.frames(rate_hz, chosen, recording.frames)
    with working("looking for boards and markers"):
        known = _told(recording, sample.spread)
        named = None if board is None else _named(recording, board, sample.spread)
        target_seen = known or named or (None if target == "none" else find_target(sample.spread))
    with working("finding the camera"):
        camera = describing.camera(sample, target_seen, fov_deg)
    if known is None:
        unit_m = None if board is None else board_in_units(board)[1]
        source = f"its name, {board}" if board else "counting in images spread over the recording"
        describing.target(named or camera.target, unit_m if size_m is None else size_m, source)
    describing.telemetry(camera.camera)
    describing.up(camera.target)
    return describing.description()


def _told(recording: Recording, images: tuple[GrayImage, ...]) -> FoundTarget | None:
    """The board or markers that the recording names; None where it names none."""
    if recording.board is not None:
        return seen_board(recording.board, images)
    return seen_markers(recording.markers.family, images) if recording.markers else None


def _named(recording: Recording, name: str, images: tuple[GrayImage, ...]) -> FoundTarget:
    """Where the board of a name is seen.

    Raises:
        ValueError: no name of a board, one beside a manifest's, or a board that is not seen.
    """
    board, _ = board_in_units(name)
    if recording.board is not None or recording.markers is not None:
        problem = "expected no board's name beside a manifest's [board] or [markers]"
        raise ValueError(f"{recording.name}: described.board: {problem}, got {name}; say it once")
    named = seen_board(board, images)
    if len(named.images) >= _ENOUGH_SHARE * named.searched:
        return named
    counted = find_target(images)
    seen = f"{name} is in {len(named.images)} of {named.searched} images"
    other = "" if counted is None else f"; they show {counted.summary}"
    if not named.images:
        raise ValueError(
            f"{recording.name}: described.board: expected a board that is in view, but {seen}"
            f"{other}; leave --board out, or name the one in view"
        )
    return replace(named, doubt=f"{seen}{other}")


class _Describing:
    """A manifest on its way, and what was assumed so far."""

    def __init__(self, recording: Recording, motion: CameraMotion) -> None:
        self.recording, self.motion = recording, motion
        self._span = ""
        self.assumed: list[Assumption] = []
        self.doubts: list[str] = []
        self._tables: list[str] = []
        self._settings: list[str] = []
        self._seen_turns: SeenTurns | None = None
        self.stated: StatedLens | None = None

    def description(self) -> Description:
        """All of it."""
        tables = "\n".join(self._tables)
        lists = tuple(self._settings), tuple(self.assumed), tuple(self.doubts)
        return Description(tables, *lists, self._span)

    def frames(self, rate_hz: float, chosen: ChosenShot, all_frames: FrameSequence) -> None:
        """Which images are the frames, and how fast they follow one another."""
        self._span = chosen.span_toml(1e-9 * all_frames.time_ns)
        if not chosen.shots.whole:
            source = "comparing each image with those before it"
            self._assume("shots", chosen.said, source, "--shot 2")
        frames, root = all_frames, self.recording.root
        if self.recording.layout != LOOSE_IMAGES or not isinstance(frames, ImageFrames):
            return
        folder = frames.files[0].parent.relative_to(root)
        lines = ["[frames]"] if folder.parts == () else ["[frames]", f'images = "{folder}/*.*"']
        self._tables.append("\n".join([*lines, f"rate_hz = {rate_hz!r}"]) + "\n")
        time_ns = stamps_of_names(frames.files, rate_hz)
        self._tables[-1] += chosen.span_toml(1e-9 * time_ns)
        self._span = ""
        said = f"{len(frames)} images in the order of their names, {rate_hz:g} a second"
        source = "images that hold no times"
        if time_ns[0] > 0:
            said, source = f"{len(frames)} images, times in seconds since 1970", "their names"
        self._assume("times", said, source, "described.rate_hz=30")

    def camera(
        self,
        sample: SampledImages,
        target: FoundTarget | None,
        fov_deg: float | None,
    ) -> FoundCamera:
        """The camera: told by its view, or found."""
        size = sample.size
        self.stated = stated_lens(self.recording, size)
        if fov_deg is not None:
            said = f"a lens without distortion that sees {fov_deg:g} degrees"
            camera_of_footage = FoundCamera(
                camera_by_view(size, fov_deg), said, "what was told", target
            )
        elif target is not None:
            try:
                camera_of_footage = self._checked(
                    camera_by_target(target, sample, self.recording.frames)
                )
            except ValueError as why:
                if len(target.images) < _ENOUGH_SHARE * target.searched:
                    problem = (
                        f"{self.recording.name}: {target.summary}, do not tell its camera: {why}"
                    )
                    camera_of_footage = replace(
                        self._camera_of_motion(size, problem), target=target
                    )
                else:
                    camera_of_footage = self._as_stated(target, size, why)
        else:
            problem = f"{self.recording.name}: no camera known, no board or markers in its images"
            camera_of_footage = self._camera_of_motion(size, problem)
        if target is None:
            self._tracked_without_target()
        self.doubts += camera_of_footage.doubts
        said = "; ".join((camera_of_footage.said, *camera_of_footage.doubts))
        self._assume("camera", said, camera_of_footage.source, "described.fov_deg=65")
        # A sensor reads the rows that it stores, from the first on.
        readout_s, source = (
            float(np.dot(camera_of_footage.shutter_s, self.recording.rows_run)),
            camera_of_footage.source,
        )
        if readout_s <= 0.0 and self.stated is not None:
            readout_s, source = self.stated.readout_s, self.stated.said
        readout = ""
        if readout_s > 0.0:
            readout = f"readout_s = {readout_s!r}\n"
            said = f"{1e3 * readout_s:.1f} ms from an image's first row to its last"
            self._assume("rolling shutter", said, source, "readout_s under [camera]")
        if camera_of_footage.sigma:
            readout += f"focal_sigma = {camera_of_footage.sigma!r}\n"
        if (zoom := camera_of_footage.zoom) is not None:
            for key, values in (("zoom_s", zoom.time_s), ("zoom", zoom.ratio)):
                readout += f"{key} = {values.round(6).tolist()}\n"
        self._tables.append(camera_toml(camera_of_footage.camera, self._turned_deg()) + readout)
        return camera_of_footage

    def _turned_deg(self) -> int:
        """By how much the images are turned to be shown: the camera is of those shown."""
        frames = self.recording.frames
        if not isinstance(frames, VideoFrames | ImageFrames):
            return 0
        return frames.orientation.degrees

    def _camera_of_motion(self, size: tuple[int, int], problem: str) -> FoundCamera:
        """The camera by the turns that a gyroscope counted, or by how the scene moves.

        `problem` says why no target tells it.

        Raises:
            ValueError: neither tells it.
        """
        imu = self.recording.imu
        turned = None if imu is None else camera_by_turning(self._turns(imu), size)
        if turned is None:
            if self._stays:
                return camera_of_fixed_place(self.motion, size, self.stated)
            try:
                return self._checked(camera_by_motion(self.recording.frames, size))
            except OnlyTurnsError as why:
                self.motion = CameraMotion("turns", 0.0, why.focal, _BY_TURNING)
                return camera_of_fixed_place(self.motion, size, self.stated)
            except SelfCalibrationError as why:
                if explained_by_rotation(self.recording, size):
                    self.motion = CameraMotion("turns")
                    return camera_of_fixed_place(self.motion, size, self.stated)
                if self.stated is not None and self.stated.camera is not None:
                    doubt = f"the images do not tell it ({why})"
                    fixed_camera = camera_of_fixed_place(self.motion, size, self.stated)
                    return replace(fixed_camera, doubts=(doubt,))
                problem += f", in which {self.motion}, and no path follows: {why}"
                raise ValueError(problem) from why
        said = f"pinhole, focal length {turned.camera.fx:.0f} px ± {100.0 * turned.sigma:.2g} %, "
        said += f"over {turned.pairs} pairs of frames"
        doubts = ("how the lens bends is not known",)
        source = "the turns that the gyroscope counted"
        return self._checked(
            FoundCamera(turned.camera, said, source, None, doubts=doubts, sigma=turned.sigma)
        )

    @property
    def _stays(self) -> bool:
        """Whether the camera stays at its place, so that there is no path to be found."""
        return self.motion.kind in ("stands", "turns")

    def _tracked_without_target(self) -> None:
        """How the poses are found where no print is in view."""
        if self.motion.kind == "zooms":
            self.doubts.append("the lens zooms, which is taken for a camera that moves")
        if self._stays:
            self._settings.append("tracked.by=turning")
        if self.motion.kind == "stands":
            self._settings.append("turning_poses.held=true")

    def _as_stated(
        self, target: FoundTarget, size: tuple[int, int], why: ValueError
    ) -> FoundCamera:
        """The lens that the file states, or a usual one, where the target does not tell it."""
        stated = self.stated
        if stated is None or stated.camera is None:
            camera_found = camera_of_fixed_place(CameraMotion("unknown"), size, None)
            doubts = (*camera_found.doubts, f"{target.summary}, do not tell it: {why}")
            return replace(camera_found, target=target, doubts=doubts)
        doubts = (f"good to look at, not to measure with: the images do not tell it ({why})",)
        return FoundCamera(
            stated.camera, stated.said, "the file's own notes", target, doubts=doubts
        )

    def _checked(self, found_camera: FoundCamera) -> FoundCamera:
        """A camera that was found, doubted where the file states quite another."""
        stated = self.stated
        if stated is None or stated.camera is None:
            return found_camera
        if abs(found_camera.camera.fx / stated.camera.fx - 1.0) <= AGREES_SHARE:
            return found_camera
        doubt = f"the file says otherwise: {stated.said}"
        return replace(found_camera, doubts=(*found_camera.doubts, doubt))

    def _turns(self, imu: ImuStream) -> SeenTurns:
        if self._seen_turns is None:
            self._seen_turns = seen_turns(self.recording.frames, imu)
        return self._seen_turns

    def target(self, target: FoundTarget | None, size_m: float | None, source: str) -> None:
        """The board or the markers, and their size."""
        if target is None:
            how = _BY_SLAM
            if self._stays:
                how = f"attitudes alone, without lengths, since {self.motion}"
            source, override = "neither board nor markers in the images", "tracked.by=slam"
            self._assume("tracking", how, source, override)
            return
        if target.doubt:
            self.doubts.append(target.doubt)
        self._assume("target", target.summary, source, "described.target=none")
        length = 1.0 if size_m is None else size_m
        table = _target_toml(target, length)
        self._tables.append(table if size_m is not None else f"{table}metric = false\n")
        if len(target.images) < _ENOUGH_SHARE * target.searched:
            self._settings.append("tracked.by=slam")
            seen = f"a target in only {len(target.images)} of {target.searched} images"
            self._assume("tracking", _BY_SLAM, seen, "tracked.by=auto")
            return
        if size_m is None:
            said = f"unknown, so lengths are counted in {target.unit}s"
            self._assume("size", said, "no ruler in the images", "described.size_m=0.03")
        by = "tracked.by=slam"
        self._assume("tracking", f"by the {_word(target)}", "the target in view", by)

    def telemetry(self, camera: Camera) -> None:
        """How the camera sits on the IMU of a GoPro's telemetry, if the images do not deny it."""
        imu = self.recording.imu
        if imu is None or self.recording.imu_T_camera is not None:
            return
        checked = check_axes(self._turns(imu), camera, GOPRO_IMU_R_CAMERA)
        if checked.verdict == "contradict":
            said = "left aside: the images turn otherwise than GoPro's axes say"
            self._assume(
                "imu", said, f"a likeness of {checked.likeness:.2f}", "[imu] in a manifest"
            )
            return
        pose = np.eye(4)
        pose[:3, :3] = GOPRO_IMU_R_CAMERA
        rows = ",\n".join(f"    {row}" for row in pose.tolist())
        self._tables.append(f"[imu]\nimu_T_camera = [\n{rows},\n]\n")
        agree = {
            "agree": f"the images agree, likeness {checked.likeness:.2f}",
            "do not tell": "the images do not tell",
        }[checked.verdict]
        source = f"GoPro's axes; {agree}"
        said = "the telemetry's, the lens looking along its -y, upright along z"
        self._assume("imu", said, source, "[imu] imu_T_camera in a manifest")

    def up(self, target: FoundTarget | None) -> None:
        """Against what a character stands upright."""
        if target is not None and "tracked.by=slam" not in self._settings:
            face = "a marker's" if target.board is None else "the board's"
            said, source = f"out of {face} printed face", "the target in view"
            self._assume("up", said, source, "placed.on=plane")
        elif any(one.startswith("[imu]") for one in self._tables):
            self._assume("up", "against gravity", "the telemetry", "placed.on=floor")
        else:
            said = "weighed from how the camera was held, surfaces and lines that it saw"
            if target is None and self._stays:
                said = "the first image's own"
            self._assume("up", said, "nothing that measured gravity", "placed.on=floor")

    def _assume(self, what: str, said: str, source: str, override: str) -> None:
        option = override if " " in override else f"--set {override}"
        self.assumed.append(Assumption(what, said, source, option))


def _word(target: FoundTarget) -> str:
    return "markers" if target.board is None else "board"


def _target_toml(target: FoundTarget, length: float) -> str:
    """The table of a target whose square or marker has this side."""
    board = target.board
    if board is not None:
        return board_toml(board.resized(length))
    return markers_toml(str(target.family), length)
