"""Lenses as files state them: written by hand here, byte for byte as the formats say."""

import struct
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from motorcade.replays import open_recording
from motorcade.replays.cli.main import main
from motorcade.replays.io.readers.gopro import gopro_camera
from motorcade.replays.pipeline.described.values import stated_lens

KEY = "com.apple.quicktime.camera.focal_length.35mm_equivalent"


def write_clip(path: Path, size: tuple[int, int] = (640, 360), **notes: str) -> Path:
    """Six images of a wall before which nothing moves, with notes as phones write them."""
    drawn = np.random.default_rng(3).integers(0, 255, (size[1] // 8, size[0] // 8), np.uint8)
    wall = cv2.cvtColor(cv2.resize(drawn, size), cv2.COLOR_GRAY2RGB)
    options = {"movflags": "use_metadata_tags"}
    with av.open(str(path), "w", options=options) as out:
        out.metadata.update(notes)
        stream = out.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        for _ in range(6):
            out.mux(stream.encode(av.VideoFrame.from_ndarray(wall, format="rgb24")))
        out.mux(stream.encode())
    return path


def with_user_data(path: Path, *boxes: tuple[bytes, bytes]) -> Path:
    """Append boxes to ``moov/udta``; the film's header stands at the end of the file here."""
    data = path.read_bytes()
    at = data.rindex(b"moov") - 4
    (size,) = struct.unpack_from(">I", data, at)
    assert at + size == len(data)
    inner = b"".join(struct.pack(">I4s", 8 + len(body), kind) + body for kind, body in boxes)
    udta = struct.pack(">I4s", 8 + len(inner), b"udta") + inner
    header = struct.pack(">I4s", size + len(udta), b"moov")
    path.write_bytes(data[:at] + header + data[at + 8 :] + udta)
    return path


def entry(key: bytes, kind: bytes, size: int, body: bytes) -> bytes:
    padded = body + bytes(-len(body) % 4)
    return struct.pack(">4scBH", key, kind, size, len(body) // size) + padded


def settings(*entries: bytes) -> bytes:
    return entry(b"DEVC", b"\0", 1, b"".join(entries))


def test_a_phones_focal_length_gives_the_field_of_view(tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mov", **{KEY: "26.00mm"})
    found = stated_lens(open_recording(clip), (640, 360))
    assert found is not None
    assert found.camera is not None
    # 26 mm on a film of 36 mm by 24 mm: half the diagonal over the focal length is the tangent.
    seen = found.camera.bearings(np.array([[0.0, 0.0], [639.0, 359.0]]))
    angle = np.degrees(np.arccos(seen[0] @ seen[1] / np.prod(np.linalg.norm(seen, axis=-1))))
    assert angle == pytest.approx(2 * np.degrees(np.arctan(0.5 * np.hypot(36, 24) / 26)), abs=0.2)
    assert "26 mm" in found.said


@pytest.mark.parametrize("value", ["", "wide", "0", "26000"])
def test_notes_that_are_no_focal_length_state_nothing(value: str, tmp_path: Path) -> None:
    clip = write_clip(tmp_path / "clip.mov", **{KEY: value})
    assert stated_lens(open_recording(clip), (640, 360)) is None


def test_a_still_states_its_focal_length_in_exif(tmp_path: Path) -> None:
    folder = tmp_path / "stills"
    folder.mkdir()
    first = struct.pack(">HHHII", 1, 34665, 4, 1, 26) + bytes(4)
    second = struct.pack(">HHHIHH", 1, 41989, 3, 1, 52, 0)
    body = b"Exif\0\0MM\0*\0\0\0\x08" + first + second
    for number in range(6):
        _, coded = cv2.imencode(".jpg", np.full((240, 320), 90, np.uint8))
        jpeg = coded.tobytes()
        noted = b"\xff\xd8\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:]
        (folder / f"{number}.jpg").write_bytes(noted)
    found = stated_lens(open_recording(folder), (320, 240))
    assert found is not None
    assert found.camera is not None
    assert found.camera.fx == pytest.approx(52 / np.hypot(36, 24) * 400)


def test_a_gopro_states_model_view_and_readout(tmp_path: Path) -> None:
    told = settings(
        entry(b"MINF", b"c", 1, b"HERO11 Black"),
        entry(b"SROT", b"f", 4, struct.pack(">f", 15.5)),
        entry(b"ZFOV", b"f", 4, struct.pack(">f", 120.0)),
        entry(b"VFOV", b"c", 1, b"W"),
    )
    clip = write_clip(tmp_path / "wide.mp4")
    with_user_data(clip, (b"FIRM", b"H22.01.01.10.00"), (b"GPMF", told))
    found = stated_lens(open_recording(clip), (640, 360))
    assert found is not None
    assert found.camera is not None
    assert found.readout_s == pytest.approx(0.0155)
    assert found.camera.model == "equidistant"
    assert found.camera.fx == pytest.approx(0.5 * np.hypot(640, 360) / np.radians(60.0))
    assert "HERO11 Black" in found.said


@pytest.mark.parametrize(
    ("firmware", "order"), [("HD5.02", "ZXY"), ("HD6.01", "YxZ"), ("FS1.04", "yXZ")]
)
def test_the_model_orders_the_imus_columns(firmware: str, order: str, tmp_path: Path) -> None:
    clip = with_user_data(write_clip(tmp_path / "a.mp4"), (b"FIRM", firmware.encode()))
    found = gopro_camera(clip)
    assert found is not None
    assert found.order == order


def test_damaged_notes_state_nothing_and_other_videos_are_no_gopros(tmp_path: Path) -> None:
    clip = with_user_data(write_clip(tmp_path / "a.mp4"), (b"GPMF", b"DEVC\0\x01\xff\xffMINF"))
    assert gopro_camera(clip) is None
    assert gopro_camera(write_clip(tmp_path / "b.mp4")) is None


def test_what_images_do_not_tell_is_taken_as_the_file_states_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = write_clip(tmp_path / "clip.mov", **{KEY: "26"})
    assert main(["inspect", str(clip)]) == 0
    said = capsys.readouterr()
    line = next(one for one in (said.out + said.err).splitlines() if "26 mm" in one)
    assert "the file's own notes" in line
    assert "not to measure with" in line
