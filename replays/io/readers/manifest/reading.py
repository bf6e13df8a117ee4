"""Manifests: a TOML file that describes any folder of images or a video, or adds to a layout.

With a `[frames]` table the manifest alone says what the recording is. Without one, the folder's
own layout (or the video file) is read first, and every other table replaces or adds its part.
`docs/manifests/every_key.toml` shows all keys. File names are relative to the recording's folder;
a manifest that the user named may also point elsewhere (absolute, or with `..`), one that was found
inside a recording may not.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from os.path import realpath
from pathlib import Path

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.names import one_line
from motorcade.ga.stamps import LONGEST_READOUT_S
from motorcade.replays.io.files import RecordingError, refusal
from motorcade.replays.io.imu import read_imu
from motorcade.replays.io.readers.frames.files import (
    ImageFrames,
    first_look,
    image_glob,
    images_in,
    inside,
    paired_masks,
)
from motorcade.replays.io.readers.frames.held import upright_camera
from motorcade.replays.io.readers.frames.names import stamps_of_names
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.frames.views import ZoomedFrames, frames_between
from motorcade.replays.io.readers.gopro import read_telemetry
from motorcade.replays.io.readers.layouts.detect import find_layout, read_layout
from motorcade.replays.io.readers.manifest.cast import files_of_scene, read_cast
from motorcade.replays.io.readers.manifest.section import (
    CAMERA_KEYS,
    MARKERS_KEYS,
    Section,
    load_toml,
    section_board,
    section_camera,
    section_markers,
    section_rotation,
    setting_from,
)
from motorcade.replays.io.readers.manifest.sensors import (
    IMU_KEYS,
    TRUTH_KEYS,
    read_truth,
    section_imu,
)
from motorcade.replays.io.readers.ros import recording as ros
from motorcade.replays.io.readers.ros.frames import BagFrames
from motorcade.replays.io.readers.tables import UNITS
from motorcade.replays.io.recording import FrameSequence, Recording, with_masks
from motorcade.replays.io.trajectories import read_times
from motorcade.replays.io.transforms import transform
from motorcade.tracking.audit import centre_finding
from motorcade.tracking.boards import Board
from motorcade.tracking.cameras.camera import AS_STORED, MOST_KNOTS, Camera, Zoom, camera_T_turned
from motorcade.tracking.depth.cameras import FINEST, DepthCamera
from motorcade.tracking.slam import MapSnapshot

_LOG = logging.getLogger("motorcade.replays")

LOCAL_NAME = "motorcade.toml"
_TOP = (
    "name",
    "settings",
    "doubts",
    "frames",
    "camera",
    "depth_camera",
    "board",
    "markers",
    "truth",
    "imu",
    "stereo",
    "slam",
)
_SPAN_KEYS = ("start_s", "end_s")
FRAMES_KEYS = (
    *("images", "video", "topic", "rate_hz", "stamps", "stamps_unit", "depth", "depth_units_per_m"),
    *("masks", *_SPAN_KEYS),
)
_FARTHEST_S = 9e9
STEREO_KEYS = ("right", "baseline_m")
DEPTH_CAMERA_KEYS = (*CAMERA_KEYS, "colour_T_depth")


def read(root: Path, manifest: Path, *, may_leave: bool, topic: str | None = None) -> Recording:
    """Read a recording as a manifest describes it.

    Args:
        root: the recording's folder, or its video file.
        manifest: the TOML file.
        may_leave: whether it may name files outside the recording's folder.
        topic: of a bag's images, in place of the one that it may name.

    Raises:
        RecordingError: an unknown key, a wrong type, count or range, a file that is missing; each
            in one line with table and key.
    """
    return _Manifest(root, manifest, may_leave, topic).recording()


class _Manifest:
    """A manifest on its way to a recording."""

    def __init__(self, root: Path, path: Path, may_leave: bool, topic: str | None = None) -> None:
        self.root, self.path, self.may_leave, self.topic = root, path, may_leave, topic
        self.folder = root if root.is_dir() else root.parent
        self.table = load_toml(path)
        self.top = Section(path, "", self.table, _TOP)
        self.stated_T_upright: Motor | None = None  # where the stated camera had to be turned

    def recording(self) -> Recording:
        """Read table by table; later ones may need earlier ones."""
        recording = self._base()
        if "name" in self.top:
            name = self.top.text("name")
            if not name.isprintable():
                raise self.top.fault("name", f"expected letters that show, got {one_line(name)}")
            recording = replace(recording, name=name)
        if "settings" in self.top:
            recording = replace(
                recording, settings=tuple(map(self._setting, self.top.texts("settings")))
            )
        if "doubts" in self.top:
            recording = replace(recording, doubts=tuple(self.top.texts("doubts")))
        recording = self._with_camera(recording)
        if "depth_camera" in self.top:
            recording = self._with_depth_camera(recording)
        if "stereo" in self.top:
            recording = self._with_right(recording)
        if "board" in self.top:
            board, world_T_board, metric = self._board()
            recording = replace(recording, board=board, world_T_board=world_T_board, metric=metric)
        if "markers" in self.top:
            section = self._section("markers", MARKERS_KEYS)
            metric = section.truth("metric", otherwise=True) and recording.metric
            recording = replace(
                recording, markers=section_markers(section, self._file), metric=metric
            )
        if "slam" in self.top:
            section = self._section("slam", SLAM_KEYS)
            recording = replace(recording, slam_map=section_slam(section, self._file))
        if "imu" in self.top:
            recording = self._with_imu(recording)
        if "truth" in self.top:
            section = self._section("truth", TRUTH_KEYS)
            truth = read_truth(section, recording, self._file, self.stated_T_upright)
            recording = replace(recording, truth=truth)
        if "camera" in self.top and "zoom" in self._section("camera", CAMERA_KEYS):
            recording = self._with_zoom(recording)
        if recording.imu is not None and recording.imu_T_camera is None:
            _LOG.warning(
                "%s: its IMU is left aside: give imu_T_camera in [imu] to use it", self.root
            )
            recording = replace(recording, imu=None)
        return recording

    def _section(self, name: str, keys: tuple[str, ...]) -> Section:
        return Section(self.path, name, self.table[name], keys)

    def _setting(self, text: str) -> str:
        """A setting whose file, where it names one, is looked for as those of keys are."""
        setting = setting_from(text, lambda name: self._named(self.top, "settings", name))
        if setting == text or self.may_leave:
            return setting
        name, _, path = setting.partition("=")
        files: Iterable[Path] = ()
        if name == "placed.cast":
            files = read_cast(Path(path)).files()
        elif name == "placed.scene":
            files = files_of_scene(Path(path))
        for file in files:
            if not Path(realpath(file)).is_relative_to(realpath(self.folder)):
                problem = f"expected files inside {self.folder}, got {file}"
                raise self.top.fault("settings", problem)
        return setting

    def _file(self, section: Section, key: str) -> Path:
        """The file that a key names."""
        return self._named(section, key, section.text(key))

    def _named(self, section: Section, key: str, name: str) -> Path:
        if not self.may_leave:
            path = inside(self.folder, name, self.path)
            if not Path(realpath(path)).is_relative_to(realpath(self.folder)):
                problem = f"expected a file inside {self.folder}, got a link out of it"
                raise section.fault(key, problem)
            return path
        return self.folder / name

    def _base(self) -> Recording:
        """What the frames table or the folder's own layout gives."""
        if self.topic is not None:
            return ros.read(self.root, topic=self.topic)
        if "frames" in self.top:
            section = self._section("frames", FRAMES_KEYS)
            if "topic" in section:
                return self._masked(section, self._of_topic(section))
            others = [key for key in FRAMES_KEYS if key in section and key not in _SPAN_KEYS]
            if others == ["masks"] and find_layout(self.root) is not None:
                base = read_layout(self.root, own_truth="truth" not in self.top)
            else:
                frames, name = self._frames(section), self.root.resolve().stem
                telemetry, layout = None, "images"
                if isinstance(frames, VideoFrames):
                    telemetry, layout = read_telemetry(frames.path), "video"
                base = Recording(name, self.root, layout, frames, imu=telemetry)
            base = self._masked(section, base)
            return replace(base, frames=_within(section, base.frames))
        if find_layout(self.root) is None:
            raise self.top.fault(
                "frames",
                f"the table is missing, and {self.root} has no layout of its own",
                'say which images to read: [frames] images = "*.png", rate_hz = 30',
            )
        return read_layout(self.root, own_truth="truth" not in self.top)

    def _of_topic(self, section: Section) -> Recording:
        """What a bag holds, with the images of the topic that the table names."""
        for key in set(FRAMES_KEYS) - {"topic", "masks"}:
            if key in section:
                raise section.fault(key, "not for a bag, which brings its own stamps and depth")
        if not ros.recognise(self.root):
            raise section.fault("topic", f"expected a bag, got {one_line(self.root.name)}")
        return ros.read(self.root, topic=section.text("topic"))

    def _frames(self, section: Section) -> FrameSequence:
        section.only_one("images", "video")
        if "video" in section or ("images" not in section and self.root.is_file()):
            for key in set(FRAMES_KEYS) - {"video", "masks", *_SPAN_KEYS}:
                if key in section:
                    raise section.fault(key, "not for a video, which brings its own stamps")
            return VideoFrames(self._file(section, "video") if "video" in section else self.root)
        if "images" in section:
            files = image_glob(self.folder, section.text("images"))
        else:
            files = images_in(self.folder)
        section.only_one("rate_hz", "stamps")
        if "stamps" in section:
            unit = section.text("stamps_unit", tuple(UNITS)) if "stamps_unit" in section else "s"
            path = self._file(section, "stamps")
            _, time_ns = read_times(path, unit)
            if len(time_ns) != len(files):
                raise refusal(
                    path, f"expected {len(files)} stamps for as many images, got {len(time_ns)}"
                )
        else:
            rate_hz = section.number("rate_hz", 1e-3, 1e5)
            time_ns = stamps_of_names(files, rate_hz)
            counted = round(1e-9 * float(time_ns[-1] - time_ns[0]) * rate_hz) + 1
            if time_ns[0] == 0 and counted > len(files):
                gap = int(np.argmax(np.diff(time_ns) > 1.5e9 / rate_hz))
                _LOG.warning(
                    "%s: of %d images by their numbers %d are not there, the first between %s and "
                    "%s: the stamps leave gaps for them",
                    self.path,
                    counted,
                    counted - len(files),
                    files[gap].name,
                    files[gap + 1].name,
                )
        shown_size, orientation = first_look(files)
        frames = ImageFrames(files, time_ns, orientation=orientation, shown_size=shown_size)
        if "depth" not in section:
            return frames
        if orientation != AS_STORED:
            raise section.fault(
                "depth",
                "expected images that are shown as stored, got turned ones, with which depth "
                "images do not turn",
                "take the orientation out of the images: exiftool -Orientation= FILES",
            )
        depth = image_glob(self.folder, section.text("depth"))
        if len(depth) != len(files):
            raise section.fault("depth", f"expected {len(files)} images, got {len(depth)}")
        units = section.number("depth_units_per_m", 1e-3, 1e6)
        return replace(frames, depth_files=depth, depth_units_per_m=units)

    def _masked(self, section: Section, recording: Recording) -> Recording:
        """Add masks of what moves before the scene, where the table names any."""
        if "masks" not in section:
            return recording
        if section.text("masks") in ("people", "none"):
            return replace(recording, people=section.text("masks"))
        folder, frames = self._file(section, "masks"), recording.frames
        if not isinstance(frames, VideoFrames | ImageFrames | BagFrames) or not folder.is_dir():
            problem = f"expected a folder of masks for images, got {one_line(folder)}"
            raise section.fault("masks", problem)
        names = [path.name for path in frames.files] if isinstance(frames, ImageFrames) else []
        masks = paired_masks(images_in(folder), names, frames.time_ns, _size(frames))
        return replace(recording, frames=with_masks(frames, masks))

    def _with_camera(self, recording: Recording) -> Recording:
        """Replace the camera, and ask the frames for its size; or say how it reads its rows."""
        if "camera" not in self.top:
            return recording
        frames = recording.frames
        section = self._section("camera", CAMERA_KEYS)
        if "readout_s" in section:
            recording = replace(
                recording, readout_s=section.number("readout_s", 0.0, LONGEST_READOUT_S)
            )
            if recording.camera is not None and section.holds_only("readout_s"):
                return recording
        if "focal_sigma" in section:
            recording = replace(recording, focal_sigma=section.number("focal_sigma", 0.0, 1.0))
        if not isinstance(frames, VideoFrames | ImageFrames | BagFrames):
            raise section.fault("", "this recording's camera cannot be replaced")
        stated = "width" in section or "height" in section
        size = None if stated else _size(frames)
        camera, turns = self._upright(section, self._camera(section, size), frames)
        doubt = centre_finding(camera)
        if doubt is not None:
            _LOG.warning("%s: [camera]: %s", self.path, doubt.sentence)
        if turns:
            self.stated_T_upright = camera_T_turned(turns)
        if not isinstance(frames, ImageFrames):
            frames.check(camera)
            return replace(recording, camera=camera)
        registered_to = None if frames.depth_camera is None else camera
        frames = replace(frames, size=(camera.width, camera.height), colour_camera=registered_to)
        return replace(recording, camera=camera, frames=frames)

    def _with_zoom(self, recording: Recording) -> Recording:
        """Bring images of a lens that zooms to the camera's focal length, as they are read."""
        section, camera = self._section("camera", CAMERA_KEYS), recording.camera
        frames = recording.frames
        if "depth_camera" in self.top or "stereo" in self.top or frames[0].read_depth is not None:
            raise section.fault("zoom", "expected images alone, got depth or pairs with them")
        if camera is None or "zoom_s" not in section:
            raise section.fault("zoom_s", "the key is missing", "give the time of each zoom")
        with section.refusing("zoom"):
            zoom_s, ratio = (section.numbers(key, MOST_KNOTS) for key in ("zoom_s", "zoom"))
            zoom = Zoom(np.array(zoom_s), np.array(ratio))
        return replace(recording, frames=ZoomedFrames(frames, zoom, camera))

    def _upright(
        self, section: Section, stated: Camera, frames: VideoFrames | ImageFrames | BagFrames
    ) -> tuple[Camera, int]:
        """The camera of the images as shown, and how far the stated one was turned for it."""
        stored = frames.orientation.size(_size(frames))  # undoes itself
        rotation_deg = section_rotation(section)
        if rotation_deg is None and frames.orientation == AS_STORED:
            return stated, 0  # the images are compared with it when they are read
        with section.refusing(""):
            camera = upright_camera(stated, rotation_deg, stored, frames.orientation)
        if camera.said:
            _LOG.warning("%s: [camera]: %s", self.path, camera.said)
        return camera.camera, camera.quarter_turns

    def _camera(self, section: Section, size: tuple[int, int] | None) -> Camera:
        return section_camera(self.path, section, size, lambda key: self._file(section, key))

    def _with_depth_camera(self, recording: Recording) -> Recording:
        """Say what took the depth images, where they lie on pixels of their own."""
        section = self._section("depth_camera", DEPTH_CAMERA_KEYS)
        frames, colour = recording.frames, recording.camera
        if not isinstance(frames, ImageFrames) or not any(frames.depth_files):
            raise section.fault("", "expected depth images, got none", "say [frames] depth")
        if colour is None:
            raise section.fault("", "expected a [camera] to register depth to, got none")
        stated = "width" in section or "height" in section
        lens = self._camera(section, None if stated else frames.first_depth_size())
        for key in ("fx", "fy"):
            whole, own = getattr(colour, key), getattr(lens, key)
            if whole > FINEST * own:
                expected = f"expected at least a {FINEST}th of the camera's {whole:g} px"
                raise section.fault(key, f"{expected}, got {own:g}")
        pose = transform(section["colour_T_depth"], self.path, "[depth_camera] colour_T_depth")
        taken_by = DepthCamera(lens, pose)
        return replace(
            recording, frames=replace(frames, depth_camera=taken_by, colour_camera=colour)
        )

    def _with_right(self, recording: Recording) -> Recording:
        """Add the right images of rectified pairs."""
        section = self._section("stereo", STEREO_KEYS)
        if not isinstance(recording.frames, ImageFrames):
            raise section.fault("", "expected images in files, got a video or markers alone")
        files = image_glob(self.folder, section.text("right"))
        if len(files) != len(recording.frames):
            problem = f"expected {len(recording.frames)} images, got {len(files)}"
            raise section.fault("right", problem)
        baseline_m = section.number("baseline_m", 1e-3, 1e3)
        if recording.frames.orientation != AS_STORED:
            raise section.fault("right", "expected images that are shown as stored, got turned")
        return replace(
            recording, frames=replace(recording.frames, right_files=files), baseline_m=baseline_m
        )

    def _board(self) -> tuple[Board, Motor, bool]:
        """The board, where it hangs, and whether its size is known."""
        board, table = section_board(self.path, self.table["board"]), self.table["board"]
        if not isinstance(table, Mapping):
            return board, Motor.identity(), True
        metric = Section(self.path, "board", table, tuple(table)).truth("metric", otherwise=True)
        if "world_T_board" not in table:
            return board, Motor.identity(), metric
        pose = transform(table["world_T_board"], self.path, "[board] world_T_board")
        return board, pose, metric

    def _with_imu(self, recording: Recording) -> Recording:
        section = self._section("imu", IMU_KEYS)
        if "file" in section:
            recording = replace(recording, imu=read_imu(self._file(section, "file")))
        if recording.imu is None:
            raise section.fault("file", "the key is missing")
        imu = section_imu(section, self._file)
        recording = replace(recording, imu=imu.on_camera_clock(recording.imu))
        if imu.noise is not None:
            recording = replace(recording, imu_noise=imu.noise)
        if imu.imu_T_camera is not None:
            pose, turn = imu.imu_T_camera, self.stated_T_upright
            recording = replace(recording, imu_T_camera=pose if turn is None else pose @ turn)
        if recording.imu_T_camera is None:
            raise section.fault("imu_T_camera", "the key is missing", "give a 4 by 4 matrix")
        return recording


def _size(frames: VideoFrames | ImageFrames | BagFrames) -> tuple[int, int]:
    """Width and height of the images as shown."""
    return frames.first_size() if isinstance(frames, ImageFrames) else frames.size


def _within(section: Section, frames: FrameSequence) -> FrameSequence:
    """The frames between the times that the table names."""
    if not any(key in section for key in _SPAN_KEYS):
        return frames
    ends = (-_FARTHEST_S, _FARTHEST_S)
    start_s, end_s = (
        section.number(key, *ends) if key in section else end
        for key, end in zip(_SPAN_KEYS, ends, strict=True)
    )
    with section.refusing("start_s"):
        return frames_between(frames, round(1e9 * start_s), round(1e9 * end_s))


SLAM_KEYS = ("map_file",)


def section_slam(section: Section, file: Callable[[Section, str], Path]) -> MapSnapshot:
    """Read the map that a manifest's table names.

    Args:
        section: the table.
        file: the file that a key of the table names.

    Raises:
        RecordingError: naming table and key.
    """
    try:
        return MapSnapshot.load(file(section, "map_file"))
    except RecordingError:
        raise
    except (ValueError, OSError) as fault:
        raise section.fault("map_file", str(fault)) from fault
