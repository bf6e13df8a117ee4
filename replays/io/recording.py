"""A recording of one camera, whatever its layout: frames, IMU, calibration and ground truth.

Conventions: stamps in integer nanoseconds, OpenCV camera axes, poses named `world_T_camera`,
images uint8 in RGB order or grey as the file has them, upright (turned as EXIF or a video's display
matrix says; the camera is that of the upright images), depth in metres with NaN where the sensor
saw nothing (stored 0 or 65535).
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.files import off_record
from motorcade.ga.names import printable
from motorcade.ga.stamps import LONGEST_READOUT_S
from motorcade.replays.io.files import refusal
from motorcade.tracking.checks import check_length
from motorcade.tracking.markers.families import check_family
from motorcade.tracking.markers.marker_map import MarkerMap

if TYPE_CHECKING:
    from motorcade.fusion.imu.noise import ImuNoise
    from motorcade.fusion.imu.stream import ImuStream
    from motorcade.tracking.boards import Board
    from motorcade.tracking.cameras.camera import Camera
    from motorcade.tracking.slam import MapSnapshot


@dataclass(frozen=True, eq=False)
class LooseMarkers:
    """Markers of one family and size.

    Args:
        family: one of `tracking.FAMILIES`.
        side_m: side of the black squares, metres.
        marker_map: where they stand, if that is known; the world is then the map's.

    Raises:
        ValueError: an unknown family, or a side that is not above zero.
    """

    family: str
    side_m: float
    marker_map: MarkerMap | None = None

    def __post_init__(self) -> None:
        check_family(self.family)
        check_length(self.side_m, "LooseMarkers.side_m")

    def content(self) -> bytes:
        """Everything that a result can depend on."""
        facts = f"{self.family} {self.side_m!r}".encode()
        if self.marker_map is None:
            return facts
        known = self.marker_map
        arrays = (
            known.marker_ids,
            known.side_m,
            known.world_R_marker.coefficients,
            known.origin_m,
        )
        return facts + b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)


ImageArray = NDArray[np.uint8]
DepthArray = NDArray[np.float32]


@dataclass(frozen=True)
class Frame:
    """One image of a recording; nothing is read before it is asked for.

    What is read then stays off the record of files: a recording's digest covers its images.

    Fields:
        time_ns: stamp.
        name: file name, or "frame 12" of a video; opens error messages.
        read_image, read_depth, read_right, read_mask: what `image`, `depth_m`, `right` and `mask`
            call.
        taken: the frame as it was taken, where `image` shows it in another focal length.
        zoom: that with which it was taken, over the one of `image`.

    >>> import numpy as np
    >>> from motorcade.replays import Frame
    >>> frame = Frame(50_000_000, "0.png", lambda: np.full((48, 64), 128, np.uint8))
    >>> frame.gray().shape, frame.depth_m() is None
    ((48, 64), True)
    """

    time_ns: int
    name: str
    read_image: Callable[[], ImageArray] = field(repr=False)
    read_depth: Callable[[], DepthArray] | None = field(default=None, repr=False)
    read_right: Callable[[], ImageArray] | None = field(default=None, repr=False)
    read_mask: Callable[[], ImageArray] | None = field(default=None, repr=False)
    taken: Frame | None = field(default=None, repr=False)
    zoom: float = 1.0

    def image(self) -> ImageArray:
        """Read the image: uint8 ``(height, width, 3)`` RGB, or ``(height, width)`` if it is grey.

        Raises:
            RecordingError: missing, truncated, corrupt, or not of the camera's size.
        """
        with off_record():
            return self.read_image()

    def gray(self) -> ImageArray:
        """Read the image as luma (ITU-R BT.601), uint8 ``(height, width)``; raises as `image`.

        What a mask says to move is filled smoothly from around, so that nothing is tracked on it.
        """
        import cv2

        image = self.still().image()
        if image.ndim == 2:
            return image
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), dtype=np.uint8)

    def depth_m(self) -> DepthArray | None:
        """Read the depth, metres ``(height, width)``, NaN where unknown; None without depth."""
        with off_record():
            return None if self.read_depth is None else self.read_depth()

    def mask(self) -> ImageArray | None:
        """Read what moves before the scene, 0 to 255 ``(height, width)``; None without masks."""
        with off_record():
            return None if self.read_mask is None else self.read_mask()

    def still(self) -> Frame:
        """The frame without what a mask says to move: filled from around, its depth unknown."""
        mask, read_depth = self.mask(), self.read_depth
        if mask is None:
            return self
        from motorcade.tracking.masks import fill_masked

        still = replace(self, read_image=lambda: fill_masked(self.read_image(), mask))
        if read_depth is not None:
            unknown = np.where(mask > 0, np.float32(np.nan), np.float32(0.0))
            still = replace(still, read_depth=lambda: read_depth() + unknown)
        return replace(still, read_mask=None)

    def right(self) -> ImageArray | None:
        """Read the right image of a rectified pair, grey ``(height, width)``; None without."""
        with off_record():
            return None if self.read_right is None else self.read_right()


class FrameMasks(Protocol):
    """Masks of what moves before the scene, by the frames' stamps."""

    def reader(self, time_ns: int) -> Callable[[], ImageArray] | None:
        """What reads the mask of the frame with a stamp; None where there is none."""
        ...

    def check(self) -> None:
        """Look at every mask; raises RecordingError for one that does not fit."""
        ...

    def content(self) -> Iterator[bytes]:
        """All that they hold, in blocks and a stable order, for a digest."""
        ...


class FrameSequence(Protocol):
    """Images in the order of their stamps, read one at a time."""

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(N,)``, strictly increasing, read-only."""
        ...

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> Frame: ...

    def __iter__(self) -> Iterator[Frame]: ...

    def check(self, camera: Camera | None) -> None:
        """Look at every image without decoding where that is possible.

        Raises:
            RecordingError: an image is missing, truncated or not of the camera's size.
        """
        ...

    def intact(self, camera: Camera | None) -> tuple[FrameSequence, tuple[str, ...]]:
        """Give the sequence without damaged images, and what is said of each left out.

        What is read whole on the way is digested, so that `content` need not read it again.

        Raises:
            RecordingError: an image that is missing or of another size, or too much damage.
        """
        ...

    def content(self) -> Iterator[bytes]:
        """Give all that the images depend on, in blocks and a stable order, for a digest."""
        ...


@dataclass(frozen=True, eq=False)
class Odometry:
    """A path that drifts but is smooth, recorded beside the images.

    Fields:
        trajectory: poses of what it tracks, in a world of its own.
        odometry_T_camera: where the camera sits on that.
    """

    trajectory: Trajectory
    odometry_T_camera: Motor


@dataclass(frozen=True, eq=False)
class Recording:
    """What was recorded, with what is known about it. None where the recording lacks something.

    Fields:
        name: for people; the folder's name unless a manifest says otherwise. Letters that do not
            show, or turn the order of others about, are question marks.
        root: the folder, or the video file.
        layout: "euroc", "seven_scenes", "tum_rgbd", "kitti", "tagslam", "ros", "images",
            "images", "video" or "synthetic".
        frames: the images.
        camera: intrinsics, of the upright images' size.
        focal_sigma: relative standard deviation of the camera's focal length where it was found in
            these images; 0 where somebody stated the camera.
        readout_s: from the first row of an image, as it is stored, to the last, whose middle row
            is read at the stamp (rolling shutter); 0 for a global one. See `shutter_s`.
        baseline_m: how far to its right the camera of the frames' right images stands.
        imu, imu_noise: angular rate and specific force; noise densities and bias walks.
        imu_T_camera: where the camera sits on the IMU (camera coordinates to IMU coordinates).
        odometry: a recorded odometry's path, None without.
        board: a board in view, and where it stands in the world (identity: it is the world).
        markers: markers in view that are no board.
        metric: False where nobody knows how large board or markers are: their lengths are then
            ratios, and so are those of poses that they give.
        slam_map: a saved map of the place, which visual SLAM goes on in.
        truth: world_T_camera. Its stamps need not be the frames' own, nor cover all of them.
        settings: knobs of the pipeline that suit this recording, each "stage.knob=value".
        people: "auto", "people" or "none", as `[frames] masks` says; of found ones, a clause.
        damaged: what is said of each image that was left out because it is damaged.
        doubts: what of all this is not sure, a clause each; what a run closes with.

    Raises:
        RecordingError: no frames, or a pose that is not a single one.

    >>> import numpy as np
    >>> from pathlib import Path
    >>> from motorcade.ga import Motor, Trajectory
    >>> from motorcade.replays import Recording
    >>> from motorcade.replays.io.readers.frames.files import ImageFrames
    >>> time_ns = np.array([0, 50_000_000])
    >>> frames = ImageFrames((Path("0.png"), Path("1.png")), time_ns)  # read when they are used
    >>> world_T_camera = Motor.from_translation([[0.0, 0.0, 1.5], [0.1, 0.0, 1.5]])
    >>> truth = Trajectory(time_ns, world_T_camera, "world", "camera")
    >>> recording = Recording("by hand", Path(), "images", frames, truth=truth)
    >>> recording.duration_s, recording.imu is None
    (0.05, True)
    """

    name: str
    root: Path
    layout: str
    frames: FrameSequence
    camera: Camera | None = None
    imu: ImuStream | None = None
    imu_noise: ImuNoise | None = None
    imu_T_camera: Motor | None = None
    board: Board | None = None
    world_T_board: Motor = field(default_factory=Motor.identity)
    markers: LooseMarkers | None = None
    slam_map: MapSnapshot | None = None
    truth: Trajectory | None = None
    settings: tuple[str, ...] = ()
    damaged: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    baseline_m: float | None = None
    odometry: Odometry | None = None
    readout_s: float = 0.0
    metric: bool = True
    focal_sigma: float = 0.0
    people: str = "auto"

    def __post_init__(self) -> None:
        if len(self.frames) == 0:
            raise refusal(self.root, "expected at least one frame, got none")
        object.__setattr__(self, "name", printable(self.name))
        if self.baseline_m is not None and not 0.0 < self.baseline_m < np.inf:
            problem = f"expected metres above 0, got {self.baseline_m}"
            raise refusal(self.root, problem, field="baseline_m")
        if not 0.0 <= self.readout_s <= LONGEST_READOUT_S:
            problem = f"expected seconds from 0 to {LONGEST_READOUT_S:g}, got {self.readout_s}"
            raise refusal(self.root, problem, field="readout_s")
        if not 0.0 <= self.focal_sigma < np.inf:
            problem = f"expected a share of 0 or more, got {self.focal_sigma}"
            raise refusal(self.root, problem, field="focal_sigma")
        for name in ("imu_T_camera", "world_T_board"):
            motor = getattr(self, name)
            if motor is not None and motor.shape != ():
                raise refusal(self.root, f"expected one motor, got {motor.shape}", field=name)

    @property
    def masks(self) -> FrameMasks | None:
        """Masks of what moves before the scene, by the frames' stamps; None without."""
        return getattr(getattr(self.frames, "taken", self.frames), "masks", None)

    @property
    def rows_run(self) -> IntArray:
        """Which way ``(2,)``, right and down, stored rows follow one another in upright images.

        Of a phone held upright they are columns.
        """
        orientation = getattr(self.frames, "orientation", None)
        down = np.array([0, 1]) if orientation is None else orientation.matrix[:, 1]
        return np.asarray(down, np.int64)

    @property
    def shutter_s(self) -> FloatArray:
        """`readout_s` across upright images ``(2,)``: from left to right, from top to bottom."""
        return self.readout_s * self.rows_run.astype(np.float64)

    @property
    def duration_s(self) -> float:
        """Seconds from the first frame's stamp to the last one's."""
        time_ns = self.frames.time_ns
        return float(time_ns[-1] - time_ns[0]) * 1e-9

    @property
    def summary(self) -> str:
        """What it holds, in one line."""
        frames = self.frames
        size = getattr(frames, "size", None)
        text = f"{self.name}: {len(frames)} images"
        if size is not None:
            text += f" of {size[0]} x {size[1]}"
        if self.duration_s > 0.0:
            text += f" in {self.duration_s:.1f} s"
        known: dict[str, object] = {
            "a camera": self.camera,
            "a board": self.board,
            "markers": self.markers,
            "an IMU": self.imu,
            "odometry": self.odometry,
            "ground truth": self.truth,
        }
        named = ", ".join(name for name, value in known.items() if value is not None)
        return f"{text}, with {named}" if named else f"{text}, of which nothing else is told"

    def check(self) -> None:
        """Check every image (existence, size, end markers) and that the streams overlap.

        Raises:
            RecordingError: the first fault found.
        """
        self.frames.check(self.camera)
        self._check_overlap()
        if self.masks is not None:
            self.masks.check()

    def intact(self) -> Recording:
        """Check everything, but leave damaged images out and name them in `damaged`.

        The images of the recording that this gives need not be read again for its digest.

        Raises:
            RecordingError: a fault that leaving out single images does not mend.
        """
        frames, faults = self.frames.intact(self.camera)
        self._check_overlap()
        if self.masks is not None:
            self.masks.check()
            frames = with_masks(frames, self.masks)
        return replace(self, frames=frames, damaged=(*self.damaged, *faults))

    def _check_overlap(self) -> None:
        if self.imu is None:
            return
        frames, imu = self.frames.time_ns, self.imu.time_ns
        if imu[-1] < frames[0] or imu[0] > frames[-1]:
            raise refusal(
                self.root,
                f"expected IMU and frames to overlap in time, got IMU {imu[0]} to {imu[-1]} ns "
                f"and frames {frames[0]} to {frames[-1]} ns",
                advice="are both stamped by the same clock and in the unit stated?",
            )

    def digest(self) -> str:
        """SHA-256 (hex) of everything that a result can depend on.

        Covers the bytes of the images, which are read unless `intact` has done so, the values of
        all the rest (so a comment in a calibration file changes nothing), and the name, since
        reports show it; not the place.
        """
        digest = hashlib.sha256(b"motorcade recording 2\n")
        for label, value in self._facts():
            digest.update(f"{label} {len(value)}\n".encode())
            digest.update(value)
        for block in self.frames.content():
            digest.update(block)
        return digest.hexdigest()

    def _facts(self) -> Iterator[tuple[str, bytes | memoryview]]:
        for label in ("name", "layout", "camera", "board", "imu_noise"):
            yield label, repr(getattr(self, label)).encode()
        for label in ("imu_T_camera", "world_T_board"):
            motor = getattr(self, label)
            yield label, b"" if motor is None else _bytes(motor.coefficients)
        yield "markers", b"" if self.markers is None else self.markers.content()
        if self.slam_map is not None:
            for name in (one.name for one in fields(self.slam_map)):
                value = getattr(self.slam_map, name)
                array = value.coefficients if isinstance(value, Motor) else np.asarray(value)
                yield f"slam map {name}", _bytes(array)
        yield "damaged", repr(self.damaged).encode()
        if self.doubts:
            yield "doubts", repr(self.doubts).encode()
        if self.baseline_m is not None:
            yield "baseline", repr(self.baseline_m).encode()
        if not self.metric:
            yield "metric", b"false"
        yield "frame stamps", _bytes(self.frames.time_ns)
        if self.masks is not None:
            yield "masks", b"".join(self.masks.content())
        if self.readout_s:
            yield "readout", repr(self.readout_s).encode()
        if self.focal_sigma:
            yield "focal sigma", repr(self.focal_sigma).encode()
        if self.imu is not None:
            yield "imu stamps", _bytes(self.imu.time_ns)
            yield "angular rate", _bytes(self.imu.angular_rate_rad_s)
            yield "specific force", _bytes(self.imu.specific_force_m_s2)
        if self.odometry is not None:
            path = self.odometry.trajectory
            yield "odometry extrinsics", _bytes(self.odometry.odometry_T_camera.coefficients)
            yield "odometry stamps", _bytes(path.time_ns)
            yield "odometry poses", _bytes(path.poses.coefficients)
        if self.truth is not None:
            yield "truth frames", f"{self.truth.parent} {self.truth.child}".encode()
            yield "truth stamps", _bytes(self.truth.time_ns)
            yield "truth poses", _bytes(self.truth.poses.coefficients)


def _bytes(array: NDArray[Any]) -> memoryview:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data


def with_masks(frames: FrameSequence, masks: FrameMasks) -> FrameSequence:
    """A copy of frames, with masks."""
    masked, taken = copy(frames), getattr(frames, "taken", None)  # by a lens that zooms
    name, value = ("masks", masks) if taken is None else ("taken", with_masks(taken, masks))
    object.__setattr__(masked, name, value)
    return masked


class DecodedFrames(ABC):
    """A sequence of frames by their number; `_time_ns` holds their stamps."""

    _time_ns: IntArray
    masks: FrameMasks | None = None

    @property
    def time_ns(self) -> IntArray:
        """Stamps ``(N,)``, strictly increasing, read-only."""
        return self._time_ns

    def __len__(self) -> int:
        return len(self._time_ns)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        time_ns = int(self._time_ns[index])
        read_mask = None if self.masks is None else self.masks.reader(time_ns)
        read_image = partial(self._image, index)
        return Frame(time_ns, f"frame {index}", read_image, read_mask=read_mask)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    @abstractmethod
    def _image(self, index: int) -> ImageArray:
        """The image of a frame."""
