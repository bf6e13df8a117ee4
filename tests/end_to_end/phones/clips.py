"""Writes a case as a phone would: an MP4 with sound, a rotation and its own frame times; the truth.

The truth stands beside it, never where a reader of recordings looks: ``NAME.truth.npz``.
"""

from __future__ import annotations

import struct
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from tests.end_to_end.phones.cases import CASES, Case, path_of, phone_of
from tests.end_to_end.phones.scene import desk, print_on, tag_panels
from tests.end_to_end.phones.sensor import PhoneCamera, Studio

__all__ = ["SECONDS", "anchors_m", "stamps_of", "write_clip"]

SECONDS = 4.0
_RATE_HZ, _TIME_BASE = 30.0, Fraction(1, 90_000)
_SOUND_HZ = 44_100
_CUBE_M = 0.06
"""Tall enough that a wrong focal length shows where it stands."""


def stamps_of(case: Case, seed: int, seconds: float = SECONDS) -> IntArray:
    """Ticks of 1/90000 s at which frames are shown, from 0 on."""
    rng = np.random.default_rng([seed, CASES.index(case), 3])
    count = int(seconds * _RATE_HZ)
    step = np.full(count, 90_000 / _RATE_HZ)
    if case.variable_rate:
        step *= 1.0 + 0.04 * rng.standard_normal(count)
        step *= np.where(rng.uniform(size=count) < 0.06, 2.0, 1.0)  # frames dropped in poor light
    return np.concatenate([[0], np.cumsum(np.rint(step)).astype(np.int64)[:-1]])


def anchors_m(case: Case) -> FloatArray:
    """Corners ``(8, 3)`` of a cube that stands in the middle of what is filmed, world."""
    unit = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [0.0, 1.0]), axis=-1).reshape(-1, 3)
    middle = [0.0, 0.0, 0.0] if case.held == "round" else [0.0, 0.15, 0.0]
    return np.asarray(_CUBE_M * unit + middle, np.float64)


def write_clip(folder: Path, case: Case, seed: int, seconds: float = SECONDS) -> Path:
    """Draw and encode one clip; returns the video's path."""
    rng = np.random.default_rng([seed, CASES.index(case), 4])
    panels = desk(rng, boxes=case.held != "round" or bool(case.shows.tags))
    if case.shows.board is not None:
        panels.append(print_on(case.shows.board, np.array([0.0, 0.0, 0.001]), Rotor.identity()))
    panels += tag_panels(case.shows.family, case.shows.side_m, case.shows.tags)
    phone, path = phone_of(case, seed), path_of(case, seed)
    studio = Studio(panels, phone, path, rng)
    ticks = stamps_of(case, seed, seconds)
    time_s = ticks / 90_000.0
    file = folder / f"{case.name}.mp4"
    turns = {0: 0, 90: 1, 270: -1}[case.rotation]
    images = (np.rot90(studio.frame(float(at)), turns) for at in time_s)
    _encode(file, images, ticks, case)
    if case.rotation:
        _turn(file, case.rotation)
    _write_truth(folder / f"{case.name}.truth.npz", case, phone, seed, time_s)
    return file


def _write_truth(file: Path, case: Case, phone: PhoneCamera, seed: int, time_s: FloatArray) -> None:
    path = path_of(case, seed)
    anchors = anchors_m(case)
    seen = np.stack([phone.project(path, float(at), anchors) for at in time_s])
    np.savez(
        file,
        time_s=time_s,
        world_T_camera=path(time_s).coefficients,
        anchors_m=anchors,
        anchors_px=seen,
        focal_px=np.array([phone.at(float(at)).fx for at in time_s]),
    )


def _encode(file: Path, images: object, ticks: IntArray, case: Case) -> None:
    """H.264 with the frames' own times, and AAC: a rising tone, so that a shift would be heard."""
    with av.open(str(file), "w") as out:
        video = out.add_stream("libx264", rate=30, options={"crf": "19", "preset": "veryfast"})
        video.width, video.height, video.pix_fmt = 1920, 1080, "yuv420p"
        video.time_base = video.codec_context.time_base = _TIME_BASE
        video.codec_context.color_range = 1
        sound = out.add_stream("aac", rate=_SOUND_HZ)
        sound.layout = "mono"
        for tick, image in zip(ticks.tolist(), images, strict=True):  # type: ignore[call-overload]
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="gray")
            frame = frame.reformat(format="yuv420p", dst_color_range="MPEG")
            frame.pts, frame.time_base = tick, _TIME_BASE
            out.mux(video.encode(frame))
        out.mux(video.encode())
        for number, samples in enumerate(_tone(int(ticks[-1]) / 90_000.0)):
            heard = av.AudioFrame.from_ndarray(samples, format="flt", layout="mono")
            heard.sample_rate, heard.pts = _SOUND_HZ, number * samples.shape[1]
            out.mux(sound.encode(heard))
        out.mux(sound.encode())


def _tone(seconds: float) -> list[NDArray[np.float32]]:
    at = np.arange(int(seconds * _SOUND_HZ) // 1024 * 1024) / _SOUND_HZ
    wave = 0.3 * np.sin(2.0 * np.pi * (220.0 + 60.0 * at) * at)
    return [np.asarray(part[None], np.float32) for part in wave.reshape(-1, 1024)]


def _turn(file: Path, rotation: int) -> None:
    """Write a display matrix into the video track's header: clockwise degrees (ISO 14496-12)."""
    data = bytearray(file.read_bytes())
    place = data.find(b"tkhd")
    while place >= 0:
        matrix = place + 4 + 4 + 20 + 16  # version 0: times, id, duration, layer, group, volume
        width, height = struct.unpack_from(">II", data, matrix + 36)
        if width:
            one = 1 << 16
            turned = {
                90: (0, one, 0, -one, 0, 0, height, 0, 1 << 30),
                270: (0, -one, 0, one, 0, 0, 0, width, 1 << 30),
            }[rotation]
            struct.pack_into(">9i", data, matrix, *turned)
        place = data.find(b"tkhd", place + 4)
    file.write_bytes(bytes(data))
