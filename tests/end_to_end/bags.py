"""Bags drawn by rosbags' own writer: are poses those of the plain images?

    python -m tests.end_to_end.bags [--bags 30] [--seed N]

Each shows the same board to a swaying camera; encodings of the images, names of their topics and of
others beside them (depth, rectified images with binning and a region), header stamps and cuts are
drawn. Of mosaics, YUV and JPEG the plain images are what OpenCV makes of them by itself, since what
they lost is not the bag's. Prints a line a bag and the largest distance between poses; ends with 1
above 0.1 mm.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.recording import ImageArray
from motorcade.replays.stages.camera.board_poses import board_poses
from tests.bench.view.film import COLUMNS, ROWS, SQUARE_M, _images
from tests.replays.readers.bag_poses import Messages, write_messages

SIZE = 320, 240
COUNT = 20
TOLERANCE_M = 1e-4
START_NS, STEP_NS = 1_700_000_000_123_456_789, 50_000_000
FOCAL, DISTORTION = 0.8 * SIZE[0], (-0.25, 0.08, 0.001, -0.0005)
CAST = np.array([1.0, 0.85, 0.7])
KINDS = ("bag", "folder", "mcap")
ENCODINGS = (
    *("rgb8", "bgr8", "rgba8", "bgra8", "mono8", "mono16", "mono16_12bits", "mono16_big"),
    *("bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg16"),
    *("yuv422", "yuv422_yuy2", "png", "jpeg"),
)
DEPTHS = ("depth raw", "depth float", "compressedDepth")
BESIDE = ("alone", *DEPTHS, "jpeg depth", "rectified", "named")
STAMPS = ("headers", "zero", "equal", "in pairs", "late", "twice")
CUTS = ("whole", "cut")
CX, CY = 0.5 * (SIZE[0] - 1), 0.5 * (SIZE[1] - 1)


@dataclass(frozen=True)
class Drawn:
    """What a bag is like."""

    kind: str
    encoding: str
    beside: str
    stamps: str
    cut: str


def draw(number: int, rng: np.random.Generator) -> Drawn:
    """A bag by its number: every encoding in turn, the rest drawn."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    beside, stamps = (str(rng.choice(words)) for words in (BESIDE, STAMPS))
    encoding = ENCODINGS[number % len(ENCODINGS)]
    one_chunk = kind == "folder" or encoding == "jpeg"  # a database, or less than a chunk
    cut = "whole" if one_chunk else str(rng.choice(CUTS))
    return Drawn(kind, encoding, beside, stamps, cut)


def scene(count: int = COUNT) -> list[ImageArray]:
    """What the camera sees, with a cast that tells red from blue."""
    seen = _images(*SIZE, 3 * count)
    frames = [image for number, image in enumerate(seen) if number % 3 == 0]
    return [np.rint(image * CAST).astype(np.uint8) for image in frames]


def stored(image: ImageArray, encoding: str) -> tuple[str, NDArray[Any], bool]:
    """The name of an encoding in a message, its pixels, and whether its bytes are big-endian."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    if encoding.startswith("mono16"):
        wide = grey.astype(np.uint16)
        wide = wide << 4 if encoding.endswith("12bits") else wide * 256 + 37
        big = encoding.endswith("big")
        return "mono16", wide.astype(">u2" if big else "<u2"), big
    if encoding.startswith("bayer"):
        order = encoding[6:10]
        mosaic = np.empty(image.shape[:2], np.uint8)
        for place, letter in enumerate(order):
            rows, columns = slice(place // 2, None, 2), slice(place % 2, None, 2)
            mosaic[rows, columns] = image[rows, columns, "rgb".index(letter)]
        wide = encoding.endswith("16")
        return encoding, mosaic.astype("<u2") * 257 if wide else mosaic, False
    if encoding.startswith("yuv422"):
        code = cv2.COLOR_RGB2YUV_UYVY if encoding == "yuv422" else cv2.COLOR_RGB2YUV_YUY2
        return encoding, cv2.cvtColor(image, code), False
    changed = {
        "mono8": grey,
        "bgr8": image[..., ::-1],
        "rgba8": np.dstack([image, np.full(image.shape[:2], 255, np.uint8)]),
        "bgra8": np.dstack([image[..., ::-1], np.full(image.shape[:2], 255, np.uint8)]),
    }
    return encoding, changed.get(encoding, image), False


_CV_BRIDGE = {"rggb": "BG", "bggr": "RG", "gbrg": "GR", "grbg": "GB"}
"""How OpenCV calls mosaics, by their second row from the second pixel on."""


def as_plain(image: ImageArray, encoding: str) -> ImageArray:
    """What is left of an image in an encoding, in RGB."""
    if encoding == "jpeg":
        data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])[1]
        return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1], np.uint8)
    if encoding.startswith("bayer"):
        mosaic = stored(image, f"{encoding[:10]}8")[1]
        code = getattr(cv2, f"COLOR_Bayer{_CV_BRIDGE[encoding[6:10]]}2RGB")
        return np.asarray(cv2.cvtColor(mosaic, code), np.uint8)
    if encoding.startswith("yuv"):
        code = cv2.COLOR_YUV2RGB_UYVY if encoding == "yuv422" else cv2.COLOR_YUV2RGB_YUYV
        return np.asarray(cv2.cvtColor(stored(image, encoding)[1], code), np.uint8)
    return image


class Bag:
    """Messages of a bag on their way: topic, time of receipt, message."""

    def __init__(self, drawn: Drawn, rng: np.random.Generator) -> None:
        self.drawn, self.rng = drawn, rng
        self.messages = Messages(ros1=drawn.kind == "bag")
        self.sent: list[tuple[str, int, Any]] = []

    def header_ns(self, index: int) -> int:
        """A stamp as the draw has it."""
        stamp = START_NS + STEP_NS * index
        return {
            "zero": 0,
            "equal": START_NS,
            "in pairs": START_NS + STEP_NS * (index // 2 * 2),
        }.get(self.drawn.stamps, stamp)

    def raw(self, index: int, encoding: str, pixels: NDArray[Any], big: bool, frame: str) -> Any:
        height, width = pixels.shape[:2]
        data = np.frombuffer(np.ascontiguousarray(pixels).tobytes(), np.uint8)
        return self.messages.make(
            "sensor_msgs/msg/Image",
            header=self.messages.header(self.header_ns(index), frame),
            height=height,
            width=width,
            encoding=encoding,
            is_bigendian=int(big),
            step=data.size // height,
            data=data,
        )

    def packed(self, index: int, form: str, data: NDArray[np.uint8], frame: str) -> Any:
        return self.messages.make(
            "sensor_msgs/msg/CompressedImage",
            header=self.messages.header(self.header_ns(index), frame),
            format=form,
            data=data.ravel(),
        )

    def info(self, index: int, frame: str, rectified: bool) -> Any:
        """A sensor of twice the pixels, of which a region is shown, binned by two."""
        k = [2 * FOCAL, 0, 2 * CX + 0.5 + 40, 0, 2 * FOCAL, 2 * CY + 0.5 + 20, 0, 0, 1]
        p = [*k[:3], 0, *k[3:6], 0, *k[6:], 0]
        other = [1.3 * value for value in k[:6]] + [0.0, 0.0, 1.0]
        letters = str.upper if self.messages.ros1 else str.lower
        values = {
            "k": other if rectified else k,
            "d": (*DISTORTION, 0.0) if rectified else (),
            "r": np.eye(3).ravel(),
            "p": p,
        }
        return self.messages.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.messages.header(self.header_ns(index), frame),
            height=2 * SIZE[1] + 20,
            width=2 * SIZE[0] + 40,
            distortion_model="plumb_bob",
            binning_x=2,
            binning_y=2,
            roi=self.messages.make(
                "sensor_msgs/msg/RegionOfInterest",
                x_offset=40,
                y_offset=20,
                height=2 * SIZE[1],
                width=2 * SIZE[0],
                do_rectify=False,
            ),
            **{letters(key): np.asarray(value, np.float64) for key, value in values.items()},
        )

    def send(self, topic: str, index: int, message: Any) -> None:
        received = START_NS + STEP_NS * index + int(self.rng.integers(1_000_000, 3_000_000))
        self.sent.append((topic, received, message))

    def fill(self, frames: list[ImageArray]) -> str:
        """All messages; returns the topic of the images."""
        place = "/camera/color"
        image = "image_rect_color" if self.drawn.beside == "rectified" else "image_raw"
        topic = f"{place}/{image}"
        if self.drawn.encoding in ("png", "jpeg"):
            topic += "/compressed"
        for index, frame in enumerate(frames):
            self.send(f"{place}/camera_info", index, self.info(index, "cam", "rect" in image))
            self.send(topic, index, self.image(index, frame))
            self.beside(index, frame)
        self.disturb(topic)
        return topic

    def image(self, index: int, frame: ImageArray) -> Any:
        if self.drawn.encoding == "png":
            data = cv2.imencode(".png", frame[..., ::-1])[1]
            return self.packed(index, "rgb8; png compressed bgr8", data, "cam")
        if self.drawn.encoding == "jpeg":
            data = cv2.imencode(".jpg", frame[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])[1]
            return self.packed(index, "rgb8; jpeg compressed bgr8", data, "cam")
        encoding, pixels, big = stored(frame, self.drawn.encoding)
        return self.raw(index, encoding, pixels, big, "cam")

    def beside(self, index: int, frame: ImageArray) -> None:
        """Other topics of images, whose names come first."""
        depth_mm = np.full(frame.shape[:2], 750, np.uint16)
        aligned, what = "/camera/aligned_depth_to_color/image_raw", self.drawn.beside
        if what == "depth raw":
            self.send(aligned, index, self.raw(index, "16UC1", depth_mm, False, "cam"))
        elif what == "depth float":
            metres = np.float32(1e-3) * depth_mm
            self.send(aligned, index, self.raw(index, "32FC1", metres, False, "cam"))
        elif what == "compressedDepth":
            head = np.zeros(12, np.uint8)
            data = np.concatenate([head, cv2.imencode(".png", depth_mm)[1].ravel()])
            form = "16UC1; compressedDepth png"
            self.send(f"{aligned}/compressedDepth", index, self.packed(index, form, data, "cam"))
        elif what == "jpeg depth":
            data = cv2.imencode(".jpg", (depth_mm // 8).astype(np.uint8))[1]
            form = "16UC1; jpeg compressed "
            self.send(f"{aligned}/compressed", index, self.packed(index, form, data, "cam"))
        elif what == "named":
            turned = np.ascontiguousarray(frame[::-1])
            self.send("/a/image_raw", index, self.raw(index, "rgb8", turned, False, "a"))

    def disturb(self, topic: str) -> None:
        """Messages that come twice, or late."""
        rows = [row for row, (name, _, _) in enumerate(self.sent) if name == topic]
        if self.drawn.stamps == "twice":
            name, received, message = self.sent[rows[3]]
            self.sent.append((name, received + 500_000, message))
        if self.drawn.stamps == "late":
            name, _, message = self.sent[rows[4]]
            self.sent[rows[4]] = (name, self.sent[rows[5]][1] + 200_000, message)
        self.sent.sort(key=lambda entry: entry[1])


def write(folder: Path, drawn: Drawn, frames: list[ImageArray], rng: np.random.Generator) -> Path:
    """Write a bag; returns what a user would name."""
    bag = Bag(drawn, rng)
    topic = bag.fill(frames)
    path = write_messages(folder, drawn.kind, bag.sent)
    if drawn.cut == "cut":
        data = path.read_bytes()
        path.write_bytes(data[: int(len(data) * rng.uniform(0.7, 0.98))])
    return Path(f"{path}:{topic}") if drawn.beside == "named" else path


def plain_poses(folder: Path, frames: list[ImageArray]) -> Any:
    """Poses of the same images in a folder, a row a frame."""
    folder.mkdir(parents=True, exist_ok=True)
    for index, frame in enumerate(frames):
        cv2.imwrite(str(folder / f"{index:02}.png"), frame[..., ::-1])
    manifest = folder / "motorcade.toml"
    camera = f"width = {SIZE[0]}\nheight = {SIZE[1]}\nfx = {FOCAL}\nfy = {FOCAL}\n"
    camera += f"cx = {CX}\ncy = {CY}\n"
    manifest.write_text(
        f'[frames]\nimages = "*.png"\nrate_hz = 20.0\n[camera]\n{camera}{board_table()}'
    )
    return board_poses(open_recording(folder)).measurements.trajectory.motors


def board_table() -> str:
    """The board, as a manifest names it."""
    size = f"columns = {COLUMNS}\nrows = {ROWS}\nsquare_m = {SQUARE_M}\n"
    return f'[board]\ntype = "checkerboard"\n{size}'


def distance_m(folder: Path, drawn: Drawn, frames: list[ImageArray], rng: Any) -> float:
    """The largest distance between poses of a bag and of its plain images.

    Raises:
        ValueError: fewer images than the bag holds.
    """
    manifest = folder / "board.toml"
    manifest.write_text(board_table())
    recording = open_recording(write(folder, drawn, frames, rng), manifest)
    count = len(recording.frames)
    if drawn.cut == "whole" and count != len(frames):
        raise ValueError(f"expected {len(frames)} images, got {count}")
    depth = recording.frames[1].depth_m()
    wants_depth = drawn.beside in DEPTHS
    if wants_depth and (depth is None or abs(float(np.nanmedian(depth)) - 0.75) > 1e-6):
        raise ValueError("expected depth of 0.75 m beside the images")
    plain = plain_poses(folder / "plain", [as_plain(frame, drawn.encoding) for frame in frames])
    path = board_poses(recording).measurements.trajectory
    if len(path) < 0.5 * len(frames):
        raise ValueError(f"expected poses, got {len(path)}")
    rows = np.rint((path.time_ns - START_NS) / STEP_NS).astype(int)
    apart = path.motors.translation_m - plain.translation_m[rows]
    return float(np.linalg.norm(apart, axis=1).max())


def main() -> int:
    """Draw, read, compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.bags", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--bags", type=int, default=30)
    parser.add_argument("--seed", type=int, default=7)
    asked = parser.parse_args()
    rng, frames, worst = np.random.default_rng(asked.seed), scene(), 0.0
    with tempfile.TemporaryDirectory() as place:
        for number in range(asked.bags):
            folder = Path(place) / f"{number}"
            folder.mkdir()
            drawn = draw(number, rng)
            try:
                apart = distance_m(folder, drawn, frames, rng)
            except ValueError as fault:
                apart = np.inf
                print(fault)
            worst = max(worst, apart)
            print(f"{number:3} {drawn}: {1e3 * apart:.4f} mm")
    print(f"largest distance: {1e3 * worst:.4f} mm, of {asked.bags} bags")
    return int(worst > TOLERANCE_M)


if __name__ == "__main__":
    sys.exit(main())
