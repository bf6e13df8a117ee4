"""Kinds of clips that people bring: other files, other images, and what is no clip at all.

Each is made of one of the twelve clips, half as large and shorter, so that its truth still holds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from motorcade.ga.arrays import FloatArray, IntArray
from tests.end_to_end.phones.kinds import covers, damages
from tests.end_to_end.phones.kinds.coding import Coded, Image

__all__ = ["KINDS", "Kind"]

Edit = Callable[[Image, int], Image]
"""An image, full size, and its number in the clip, to what is filmed instead."""
_X265 = {"crf": "19", "preset": "ultrafast", "x265-params": "log-level=none"}
_X264 = {"crf": "19", "preset": "veryfast"}
_VP9 = {"crf": "24", "b": "0", "cpu-used": "8", "deadline": "realtime"}
_AV1 = {"crf": "24", "preset": "12"}


@dataclass(frozen=True)
class Kind:
    """One kind.

    Fields:
        name: of its file.
        of: the clip that it is made of.
        must: "right": come out as the clip must; "refused": be refused with `why` in the line;
            "filmed": get a film as from a fixed place, doubted with `why`;
            "told": be right, or be refused or called doubtful with `why` in what is said.
        why: a regular expression.
        coded: how the file is written.
        edit: of the images.
        crop: left, top, width and height, before all is made half as large; None: all.
        mirrored: whether left is right.
        woven: whether every second row is of the next frame, as where fields make up frames.
        scale: of the images' sides.
        rows: which frames, by the count of those there are.
        speed: how many times as fast they are shown.
        damage: done to the file at last.
        even: whether frames follow one another evenly, whatever was between them.
    """

    name: str
    of: str = "checker"
    must: str = "right"
    why: str = ""
    coded: Coded = field(default_factory=Coded)
    edit: Edit | None = None
    crop: tuple[int, int, int, int] | None = None
    mirrored: bool = False
    woven: bool = False
    scale: tuple[float, float] = (0.5, 0.5)
    rows: Callable[[int], IntArray] = lambda count: np.arange(min(count, 84))
    speed: float = 1.0
    damage: Callable[[Path], None] | None = None
    even: bool = False


def _every(count: int) -> IntArray:
    return np.arange(count)


def _first(number: int) -> Callable[[int], IntArray]:
    return lambda count: np.arange(number)


def _still(count: int) -> IntArray:
    return np.full(84, count // 2)


def _doubled(count: int) -> IntArray:
    return np.repeat(np.arange(min(count, 84)), 2)


def _jumping(count: int) -> IntArray:
    return np.concatenate([np.arange(40), np.arange(count - 40, count)])


def _zooming(image: Image, number: int) -> Image:
    """Digital zoom while filming: by 30 % in three seconds, about the middle."""
    height, width = image.shape[:2]
    zoom = 1.0 + 0.3 * number / 84.0
    middle = 0.5 * (np.array([width, height]) - 1.0)
    shown = np.column_stack([np.eye(2) * zoom, (1.0 - zoom) * middle])
    return np.asarray(cv2.warpAffine(image, shown, (width, height)), np.uint8)


def _dark(image: Image, number: int) -> Image:
    """A tenth of the light: few levels are left, and the sensor's noise beside them."""
    noise = np.random.default_rng(number).normal(0.0, 1.5, image.shape[:2])
    return np.clip(16.0 + 0.09 * image + noise[..., None], 0, 255).astype(np.uint8)


_MOV, _MKV, _WEBM = Coded(".mov"), Coded(".mkv", sound="libopus"), Coded(".webm")
KINDS = (
    # Files: the same images, coded otherwise.
    Kind("hevc", coded=Coded(codec="libx265", options=_X265, tag="hvc1")),
    Kind(
        "hevc_10_bit_hlg_pcm",
        coded=Coded(
            ".mov", "libx265", "yuv420p10le", _X265, "hvc1", 0, (9, 9, 18, 1), sound="pcm_s16le"
        ),
    ),
    Kind("h264_10_bit", coded=Coded(pixels="yuv420p10le")),
    Kind("half_turn", coded=Coded(turned_deg=180)),
    Kind(
        "tall_hevc_mov",
        "checker_tall_rolling",
        coded=Coded(".mov", "libx265", "yuv420p", _X265, "hvc1", 90, sound="pcm_s16le"),
    ),
    Kind("mkv_opus", coded=_MKV),
    Kind(
        "webm_vp9",
        "loose",
        coded=Coded(".webm", "libvpx-vp9", options=_VP9, sound="libopus"),
    ),
    Kind("mp4_av1", "loose", coded=Coded(codec="libsvtav1", options=_AV1)),
    Kind("full_range_601", coded=Coded(pixels="yuvj420p", colours=(6, 6, 6, 2))),
    Kind("pq_2020", coded=Coded(pixels="yuv420p10le", colours=(9, 9, 16, 1))),
    Kind(
        "odd_size",
        coded=Coded(".webm", "libvpx-vp9", options=_VP9, sound="libopus"),
        crop=(4, 2, 1910, 1074),
    ),
    Kind("flagged_interlaced", coded=Coded(options=_X264 | {"x264-params": "fake-interlaced=1"})),
    Kind(
        "fields",
        must="told",
        why="interlaced",
        coded=Coded(options=_X264 | {"x264-params": "tff=1"}),
        woven=True,
    ),
    Kind("edit_list", "loose", coded=Coded(skipped=20)),
    Kind(
        "amr_3gp",
        must="told",
        why="sound of .* is left out",
        coded=Coded(".3gp", sound="libopencore_amrnb", sound_hz=8000),
    ),
    Kind("transport_stream", coded=Coded(".mts")),
    Kind("no_sound", coded=Coded(sound="")),
    Kind(
        "motion_jpeg_avi", coded=Coded(".avi", "mjpeg", "yuvj420p", {"q": "3"}, sound="pcm_s16le")
    ),
    # Times.
    Kind("hz_60", "loose", rows=_every, speed=2.0),
    Kind("hz_120", rows=_every, speed=4.0),
    Kind("every_frame_twice", rows=_doubled, speed=2.0, even=True),
    Kind("jump_cut", rows=_jumping, even=True),
    Kind("three_frames", must="filmed", why="how wide it sees", rows=_first(3)),
    Kind("one_frame", must="filmed", why="how wide it sees", rows=_first(1)),
    Kind("no_motion", must="filmed", why="focal length is known to", rows=_still, even=True),
    Kind("no_motion_room", "room", must="filmed", why="how wide it sees", rows=_still, even=True),
    # Images.
    Kind(
        "one_tag", "loose", must="told", why="focal length is known to", edit=covers.all_but_tag(3)
    ),
    Kind(
        "third_hidden_checker",
        must="told",
        why="focal length is known to|fit to|motion alone",
        edit=covers.third("checker"),
    ),
    Kind(
        "third_hidden_grid",
        "grid_tall_long",
        edit=covers.third("grid_tall_long"),
        coded=Coded(turned_deg=90),
    ),
    Kind("third_hidden_charuco", "charuco_wide", edit=covers.third("charuco_wide")),
    Kind("left_third_black", edit=covers.left_third),
    Kind("zoomed_off_centre", "loose", crop=(560, 60, 1280, 720), scale=(0.75, 0.75)),
    Kind("zooming", must="told", why="focal length changes|zoom", edit=_zooming),
    Kind("letterboxed", edit=covers.letterboxed),
    Kind("dark", edit=_dark),
    Kind("mirrored_checker", mirrored=True),
    Kind("mirrored_charuco", "charuco_wide", must="told", why="mirror", mirrored=True),
    Kind("mirrored_tags", "loose", must="told", why="mirror", mirrored=True),
    Kind(
        "wide_pixels",
        must="told",
        why="square",
        coded=Coded(pixel_aspect=Fraction(4, 3)),
        scale=(0.375, 0.5),
    ),
    # Damage, and what is no clip.
    Kind("cut_mp4", must="refused", why="truncated|not complete", damage=damages.halved),
    Kind(
        "cut_faststart",
        must="told",
        why="truncated",
        coded=Coded(muxing={"movflags": "faststart"}),
        damage=damages.halved,
    ),
    Kind("cut_mkv", must="told", why="truncated", coded=_MKV, damage=damages.halved),
    Kind(
        "cut_webm",
        must="told",
        why="truncated",
        damage=damages.halved,
        coded=Coded(".webm", "libvpx-vp9", options=_VP9, sound="libopus"),
    ),
    Kind("empty_file", must="refused", why="empty", damage=damages.emptied),
    Kind(
        "no_images",
        must="refused",
        why="no (images|video)|video stream",
        damage=damages.without_images,
    ),
    Kind("sound_alone", must="refused", why="video stream", damage=damages.sound_alone),
    Kind("text_named_mp4", must="refused", why="read as a video", damage=damages.text),
    Kind(
        "moving_gif",
        must="refused",
        why="ffmpeg -i moving_gif.gif",
        coded=Coded(".gif", "gif", "rgb8", {}, sound=""),
        rows=_first(20),
    ),
    Kind("photograph", must="refused", why="image", coded=Coded(".jpg", ""), damage=damages.image),
)


def times(time_s: FloatArray, rows: IntArray, kind: Kind) -> FloatArray:
    """When the chosen frames are shown, from the first that is not skipped on."""
    if kind.even:
        return np.arange(len(rows)) / 30.0 / kind.speed
    shown = time_s[rows] / kind.speed
    return np.asarray(shown - shown[kind.coded.skipped], np.float64)
