"""Frame sequences made of image files: which files belong to a recording, and reading them.

All are shown as the first says, so that one camera holds for them. What their names say of order
and stamps is read by `names`.

Masks of what moves before the scene, one image a frame, as any model for people leaves them.

White (255) is what moves, black the scene, grey between them a soft edge. Labels are taken too: of
colours every one that is not black, of a cut-out its alpha, and 0 and 1 as 0 and 255.
"""

from __future__ import annotations

import hashlib
import logging
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import cv2
import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.ga.names import one_line
from motorcade.ga.progress import track
from motorcade.replays.io.files import DamagedError, read_bounded, refusal
from motorcade.replays.io.readers.frames import images
from motorcade.replays.io.readers.frames.images import FRAME_LIMIT, image_orientation
from motorcade.replays.io.readers.frames.names import natural, numbered
from motorcade.replays.io.recording import DepthArray, Frame, FrameMasks, ImageArray
from motorcade.tracking.cameras.camera import AS_STORED, ImageOrientation
from motorcade.tracking.masks import COUNTS

if TYPE_CHECKING:
    from motorcade.tracking import Camera
    from motorcade.tracking.depth.cameras import DepthCamera


@dataclass(frozen=True, eq=False)
class ImageFrames:
    """Images in files, one a frame.

    Fields:
        files: ``N`` image files.
        time_ns: ``(N,)`` stamps, strictly increasing.
        size: (width, height) that every image must have, upright; None before the camera is
            known.
        depth_files: depth image of each frame, None where it has none.
        depth_units_per_m: what a metre is in the depth images.
        right_files: right image of each frame, where they are rectified pairs.
        depth_camera: what took the depth images, where they do not lie on the images' pixels
            yet: they are registered as they are read, to `colour_camera`.
        orientation: how all images are shown, as the first says: one for which the camera was held
            otherwise is shown turned, as the same camera saw it.
        shown_size: width and height of the first as shown, where `first_look` found them.
        digests: size in bytes and SHA-256 of files that were read whole, when they were checked.
        masks: of what moves before the scene; None without.
    """

    files: tuple[Path, ...]
    time_ns: IntArray
    size: tuple[int, int] | None = None
    depth_files: tuple[Path | None, ...] = ()
    depth_units_per_m: float = 1000.0
    right_files: tuple[Path, ...] = ()
    depth_camera: DepthCamera | None = None
    colour_camera: Camera | None = None
    orientation: ImageOrientation = AS_STORED
    shown_size: tuple[int, int] | None = None
    digests: Mapping[Path, tuple[int, bytes]] = field(default_factory=dict, repr=False)
    masks: FrameMasks | None = None

    def __post_init__(self) -> None:
        own = np.array(self.time_ns, dtype=np.int64)
        own.setflags(write=False)
        object.__setattr__(self, "time_ns", own)
        if len(own) != len(self.files) or np.any(np.diff(own) <= 0):
            raise ValueError(
                f"time_ns: expected {len(self.files)} increasing stamps, got {len(own)}"
            )

    def __len__(self) -> int:
        return len(self.files)

    def __getitem__(self, index: int) -> Frame:
        index = range(len(self))[index]
        path, name = self.files[index], f"frame {index}"
        read_image = partial(images.read_image, path, name, self.size, self.orientation)
        known = bool(self.depth_files) and self.depth_files[index] is not None
        read_depth = partial(self._registered, index) if known else None
        read_right = None
        if self.right_files:
            read_right = partial(
                images.read_gray, self.right_files[index], name, self.size, self.orientation
            )
        time_ns = int(self.time_ns[index])
        read_mask = None if self.masks is None else self.masks.reader(time_ns)
        return Frame(time_ns, path.name, read_image, read_depth, read_right, read_mask)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def measured_depth(self, index: int) -> DepthArray | None:
        """Read a frame's depth as its sensor measured it, registered to nothing; None without.

        Raises:
            RecordingError: as `Frame.depth_m`.
        """
        path = self.depth_files[index] if self.depth_files else None
        if path is None:
            return None
        units = self.depth_units_per_m
        return images.read_depth(path, f"frame {index}", self._depth_size, units)

    @property
    def _depth_size(self) -> tuple[int, int] | None:
        if self.depth_camera is None:
            return self.size
        return self.depth_camera.camera.width, self.depth_camera.camera.height

    def _registered(self, index: int) -> DepthArray:
        measured = self.measured_depth(index)
        if measured is None:
            raise ValueError(f"frame {index}: expected a depth image, got none")
        if self.depth_camera is None or self.colour_camera is None:
            return measured
        from motorcade.tracking.depth.cameras import register_depth

        return register_depth(measured, self.depth_camera, self.colour_camera)

    def check(self, camera: Camera | None) -> None:
        """Read every file and look at its header, end and size, without decoding.

        Raises:
            RecordingError: the first image that is missing, truncated or of another size.
        """
        for fault in self._read_through(camera)[0].values():
            raise fault

    def intact(self, camera: Camera | None) -> tuple[ImageFrames, tuple[str, ...]]:
        """Leave out what is truncated, corrupt or of another size: a frame, or its depth alone.

        Every file is read once, and what it holds is kept as a digest. Where no camera states a
        size, the commonest one holds: a logo or a preview in the folder is no frame.

        Raises:
            RecordingError: an image is missing, depth has another size, or half of the frames or
                more cannot be used.
        """
        damage, digests = self._read_through(camera)
        if not damage:
            return replace(self, digests=digests), ()
        faults = tuple(str(fault) for fault in damage.values())
        if 2 * len(damage) >= len(self):
            problem = f"{len(damage)} of {len(self)} frames cannot be used, the first: {faults[0]}"
            raise refusal(self.files[0].parent, problem)
        whole = [
            index
            for index, path in enumerate(self.files)
            if path not in damage and not (self.right_files and self.right_files[index] in damage)
        ]
        depth = [None if path in damage else path for path in self.depth_files]
        intact = replace(
            self,
            files=tuple(self.files[index] for index in whole),
            time_ns=self.time_ns[whole],
            depth_files=tuple(depth[index] for index in whole) if depth else (),
            right_files=tuple(self.right_files[index] for index in whole)
            if self.right_files
            else (),
            shown_size=None,
            digests=digests,
        )
        return replace(intact, shown_size=intact.first_size()), faults

    def _read_through(
        self, camera: Camera | None
    ) -> tuple[dict[Path, DamagedError], dict[Path, tuple[int, bytes]]]:
        """What is wrong with each damaged file, and digests of the others; raises other faults."""
        size = self.size if camera is None else (camera.width, camera.height)
        damage: dict[Path, DamagedError] = {}
        sizes: dict[Path, tuple[int, int]] = {}
        digests: dict[Path, tuple[int, bytes]] = {}
        depth = set(self.depth_files)
        held = Counter[ImageOrientation]()
        for path, name in self._all_files("reading images"):
            advice = images.UNALIGNED if path in depth else None
            expected = size
            if path in depth and self.depth_camera is not None:
                expected, advice = self._depth_size, images.ANOTHER_DEPTH_SIZE
            try:
                shown = None if path in depth else self.orientation
                data = images.read_image_bytes(path, name, expected, advice, shown)
            except DamagedError as fault:
                damage[path] = fault
                continue
            if path not in depth:
                held[image_orientation(data)] += 1
                sizes[path] = self.orientation.size(images.image_size(data))
            digests[path] = _digest(data)
        self._check_orientations(held)
        return damage | _of_another_size(sizes), digests

    def _check_orientations(self, held: Counter[ImageOrientation]) -> None:
        """Say how many images were held otherwise; a mirrored one is of no camera of the others."""
        for orientation, count in held.items():
            if orientation.mirrored != self.orientation.mirrored:
                raise refusal(
                    self.files[0].parent,
                    f"expected images that are all mirrored or none, got {count} "
                    f"{_told(orientation)} among others {_told(self.orientation)}",
                    advice="leave them out: one camera holds for all",
                )
            if orientation != self.orientation:
                _LOG.warning(
                    "%s: %d of %d images are %s: they are shown %s as all others, so that one "
                    "camera holds for all",
                    self.files[0].parent,
                    count,
                    held.total(),
                    _told(orientation),
                    _told(self.orientation),
                )

    def content(self) -> Iterator[bytes]:
        """Size and digest of every image; files that were not checked yet are read."""
        yield f"depth units {self.depth_units_per_m!r}".encode()
        if self.depth_camera is not None:
            yield f"depth camera {self.depth_camera!r} {self.colour_camera!r}".encode()
        for path, name in self._all_files("reading images"):
            known = self.digests.get(path)
            length, digest = known or _digest(read_bounded(path, images.FILE_LIMIT, name))
            yield f"{name} {path.suffix} {length}\n".encode()
            yield digest

    def first_size(self) -> tuple[int, int]:
        """Width and height of the first image as shown, for calibrations that leave them out.

        Raises:
            RecordingError: the first image is missing or truncated.
        """
        if self.shown_size is not None:
            return self.shown_size
        data = images.read_image_bytes(self.files[0], "frame 0", None)
        return self.orientation.size(images.image_size(data))

    def first_depth_size(self) -> tuple[int, int]:
        """Width and height of the first depth image; raises as `first_size`."""
        index, path = next(
            (index, path) for index, path in enumerate(self.depth_files) if path is not None
        )
        data = images.read_image_bytes(path, f"depth of frame {index}", None)
        return images.image_size(data)

    def _all_files(self, what: str) -> Iterator[tuple[Path, str]]:
        """Every file and what it is called, telling how far along that is."""
        kinds = (("", self.files), ("depth of ", self.depth_files), ("right of ", self.right_files))
        named = (
            (path, f"{kind}frame {index}")
            for kind, files in kinds
            for index, path in enumerate(files)
            if path is not None
        )
        return track(named, what, sum(len(files) for _, files in kinds))


def first_look(files: Sequence[Path]) -> tuple[tuple[int, int], ImageOrientation]:
    """Width and height of the first of some images as shown, and how that is to be done.

    Raises:
        RecordingError: the image is missing or truncated.
    """
    data = images.read_image_bytes(files[0], "frame 0", None)
    orientation = image_orientation(data)
    return orientation.size(images.image_size(data)), orientation


def _of_another_size(sizes: Mapping[Path, tuple[int, int]]) -> dict[Path, DamagedError]:
    """Images that are not of the commonest size."""
    (usual, count), *others = Counter(sizes.values()).most_common() or [((0, 0), 0)]
    if not others:
        return {}
    as_most = f"expected {usual[0]} x {usual[1]} pixels as {count} of {len(sizes)} images have"
    advice = "keep other images out of the folder"
    faults = {
        path: refusal(path, f"{as_most}, got {size[0]} x {size[1]}", advice=advice)
        for path, size in sizes.items()
        if size != usual
    }
    return {path: DamagedError(str(fault)) for path, fault in faults.items()}


def _told(orientation: ImageOrientation) -> str:
    mirrored = "mirrored and " if orientation.mirrored else ""
    return f"{mirrored}turned clockwise by {orientation.degrees} degrees"


def _digest(data: bytes) -> tuple[int, bytes]:
    return len(data), hashlib.sha256(data).digest()


def inside(root: Path, name: str, source: Path, line: int | None = None) -> Path:
    """Join a file name that stands in an untrusted file to the folder it must stay in.

    Raises:
        RecordingError: an absolute name, one with `..`, or no name at all.
    """
    relative = PurePosixPath(name)
    escapes = relative.is_absolute() or ".." in relative.parts or "\\" in name or "\0" in name
    if escapes or not relative.parts:
        raise refusal(
            source,
            f"expected a file name inside {root}, got {one_line(name)}",
            line=line,
        )
    return root / relative


def images_in(root: Path) -> tuple[Path, ...]:
    """Find every image that lies in a folder itself, in natural order.

    Raises:
        RecordingError: nothing found, or a million files or more.
    """
    paths = [path for path in root.iterdir() if path.suffix.lower() in images.SUFFIXES]
    if not paths:
        known = " ".join(images.SUFFIXES)
        raise refusal(root, f"expected images ({known}), got none", advice="say [frames] images")
    if len(paths) > FRAME_LIMIT:
        raise refusal(root, f"expected at most {FRAME_LIMIT} images, got {len(paths)}")
    return tuple(sorted(paths, key=natural))


def image_glob(root: Path, pattern: str) -> tuple[Path, ...]:
    """Find image files by a pattern such as `images/*.jpg`, in natural order.

    Raises:
        RecordingError: nothing found, a million files or more, files that are no images, a
            pattern that is empty or leads outside.
    """
    inside(root, pattern, root)
    if pattern.count("**") > 1:
        raise refusal(root, f"expected at most one ** in the pattern, got {one_line(pattern)}")
    try:
        paths = sorted(root.glob(pattern), key=natural)
    except (ValueError, OSError, re.error) as fault:
        raise refusal(root, f"the pattern {one_line(pattern)} cannot be used: {fault}") from fault
    if not paths:
        advice = "say in [frames] images where they lie in this folder"
        raise refusal(root, f"expected images {one_line(pattern)}, got none", advice=advice)
    if len(paths) > FRAME_LIMIT:
        raise refusal(root, f"expected at most {FRAME_LIMIT} images, got {len(paths)}")
    for path in paths:
        if path.suffix.lower() not in images.SUFFIXES:
            known = " ".join(images.SUFFIXES)
            raise refusal(path, f"expected images ({known})", advice="narrow the pattern")
    return tuple(paths)


_LOG = logging.getLogger("motorcade.replays")
_WHITE_BACKGROUND = 0.6
_NAMED = 3
_FIELD = "[frames] masks"


@dataclass(frozen=True, eq=False)
class MaskFiles:
    """A mask for each of some frames, found by the frame's stamp.

    Fields:
        files: `N` image files.
        time_ns: ``(N,)`` stamps of the frames that they belong to.
        size: width and height that each must have: the frames', as shown.
    """

    files: tuple[Path, ...]
    time_ns: IntArray
    size: tuple[int, int]

    def reader(self, time_ns: int) -> Callable[[], ImageArray] | None:
        """What reads the mask of the frame with a stamp; None where there is none."""
        row = int(np.searchsorted(self.time_ns, time_ns))
        if row == len(self.time_ns) or self.time_ns[row] != time_ns:
            return None
        return partial(read_mask, self.files[row], self.size)

    def check(self) -> None:
        """Read every file and look at its header, end and size; say where masks seem inverted.

        Raises:
            RecordingError: the first that is missing, truncated or of another size.
        """
        for _ in self.content():
            pass
        some = self.files[:: 1 + len(self.files) // 8]
        share = float(np.mean([read_mask(path, self.size) >= COUNTS for path in some]))
        if share > _WHITE_BACKGROUND:
            _LOG.warning(
                "%s: masks cover %.0f %% of the images: white must be what moves; invert them if "
                "it is the background",
                self.files[0].parent,
                100.0 * share,
            )

    def content(self) -> Iterator[bytes]:
        """The stamps, and a digest of every file; raises as `check`."""
        yield self.time_ns.tobytes()
        for path in self.files:
            yield hashlib.sha256(_read(path, self.size)).digest()


def _read(path: Path, size: tuple[int, int]) -> bytes:
    advice = f"make masks of the images as they are shown, {size[0]} x {size[1]}"
    return images.read_image_bytes(path, _FIELD, size, advice)


def read_mask(path: Path, size: tuple[int, int]) -> ImageArray:
    """Decode a mask: uint8 ``(height, width)``, 255 for what moves.

    Raises RecordingError: missing, truncated, another size, or nothing that can be decoded.
    """
    stored = cv2.imdecode(np.frombuffer(_read(path, size), np.uint8), cv2.IMREAD_UNCHANGED)
    if stored is None or stored.shape[1::-1] != size:
        raise refusal(path, "the mask cannot be decoded", field=_FIELD, advice="write it as PNG")
    if stored.ndim == 3 and stored.shape[2] == 4 and stored[..., 3].min() < 255:
        stored = stored[..., 3]
    elif stored.ndim == 3:
        highest, lowest = stored[..., :3].max(axis=2), stored[..., :3].min(axis=2)
        labels = np.where(highest >= COUNTS, 255, 0)
        stored = highest if np.array_equal(highest, lowest) else labels
    if stored.dtype == np.uint16 and stored.max() > 1:
        stored = stored >> 8
    return np.asarray(stored * 255 if stored.max() == 1 else stored, dtype=np.uint8)


def paired_masks(
    files: Sequence[Path], names: Sequence[str], time_ns: IntArray, size: tuple[int, int]
) -> MaskFiles:
    """Give each frame its mask: by name where masks are called as the images are, else by order.

    Args:
        files: of masks, in natural order.
        names: of the frames' image files; empty where they are in one file.
        time_ns: ``(N,)`` stamps of the frames.
        size: of the frames as shown.

    Raises:
        RecordingError: a frame without a mask, or masks of which one is missing (by name or
            number), or more or fewer than frames.
    """
    folder, stems = files[0].parent, {Path(name).stem: row for row, name in enumerate(names)}
    rows = {name: row for row, name in enumerate(names)} | stems
    own = {rows[path.stem]: path for path in files if path.stem in rows}
    missing: list[str] = []
    if 2 * len(own) > len(files):
        missing = [name for row, name in enumerate(names) if row not in own]
        files = [own[row] for row in sorted(own)]
    else:
        steps = np.diff(np.array(numbered(files) or range(len(files))))
        jumps = np.flatnonzero(steps != np.median(steps)) if len(steps) else np.zeros(0, np.int64)
        missing = [f"what follows {files[row].name}" for row in jumps.tolist()]
    if missing or len(files) != len(time_ns):
        listed = f"; missing: {', '.join(missing[:_NAMED])}" if missing else ""
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        raise refusal(
            folder,
            f"expected {len(time_ns)} masks, one for each frame, got {len(files)}{listed}{more}",
            field=_FIELD,
            advice="call them as the images are called; a frame in which nothing moves needs a "
            "black one",
        )
    return MaskFiles(tuple(files), time_ns, size)
