"""Telemetry in GoPro's videos: values, axes and stamps as made, and as a camera wrote them."""

import itertools
import struct
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorcade.render import write_video
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.readers import gopro
from motorcade.replays.io.readers.opening import open_recording
from motorcade.replays.io.readers.readings import read_imu_of

HERE = Path("made-up.mp4")
TURNED = np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]])
"""How a camera's axes are ordered on a GoPro's IMU, all of them backwards."""


def entry(key: str, kind: str, size: int, body: bytes) -> bytes:
    """One item, with the padding that follows it."""
    head = key.encode() + struct.pack(">BBH", ord(kind) if kind else 0, size, len(body) // size)
    return head + body + bytes(-len(body) % 4)


def sensor(key: str, values: np.ndarray, scale: int, unit: bytes, *extra: bytes) -> bytes:
    body = b"".join(
        [
            entry("STNM", "c", 1, b"named"),
            entry("SIUN", "c", len(unit), unit),
            entry("SCAL", "s", 2, struct.pack(">h", scale)),
            *extra,
            entry(key, "s", 6, np.rint(scale * values).astype(">i2").tobytes()),
        ]
    )
    return entry("STRM", "", 1, body)


def packet(force: np.ndarray, rate: np.ndarray, *extra: bytes) -> bytes:
    streams = sensor("ACCL", force, 418, b"m/s\xb2", *extra)
    return entry("DEVC", "", 1, streams + sensor("GYRO", rate, 3755, b"rad/s", *extra))


def test_axes_and_scales(rng: np.random.Generator) -> None:
    force, rate = rng.uniform(-20, 20, (5, 3)), rng.uniform(-4, 4, (9, 3))
    found = gopro._sensors(packet(force, rate), HERE)
    np.testing.assert_allclose(found[b"ACCL"], force[:, [1, 2, 0]], atol=0.6 / 418)
    np.testing.assert_allclose(found[b"GYRO"], rate[:, [1, 2, 0]], atol=0.6 / 3755)
    turned = gopro._sensors(packet(force, rate, entry("ORIN", "c", 1, b"YxZ")), HERE)
    expected = np.stack([-force[:, 1], force[:, 0], force[:, 2]], axis=1)
    np.testing.assert_allclose(turned[b"ACCL"], expected, atol=0.6 / 418)


def made_stream(
    monkeypatch: pytest.MonkeyPatch, counts: list[int], jitter_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Stamps and force along x of telemetry whose force tells the time, the gyroscope's double."""
    at, parts = 0, []
    for second, count in enumerate(counts):
        t = np.arange(at, at + count) / 200.0
        force = np.stack([0 * t, t, 0 * t], axis=1)
        wander = jitter_s * (-1) ** second
        parts.append((second + wander, 1.0, packet(force, np.repeat(force, 2, axis=0) * 0)))
        at += count
    monkeypatch.setattr(gopro, "_packets", lambda path: iter(parts))
    stream = gopro.read_telemetry(HERE)
    assert stream is not None
    assert stream.rate_hz == pytest.approx(400.0, rel=2e-3)
    return stream.time_ns, stream.specific_force_m_s2[:, 0]


def test_steady_rates_outlast_packets_that_come_late(monkeypatch: pytest.MonkeyPatch) -> None:
    time_ns, told_s = made_stream(monkeypatch, [200, 200, 200, 200, 200, 57], 0.004)
    np.testing.assert_allclose(1e-9 * time_ns, told_s, atol=0.005)
    np.testing.assert_allclose(np.diff(time_ns), np.diff(time_ns)[0], rtol=1e-3)


def test_lost_samples_are_told_and_bounded_by_their_packet(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    counts = [200, 200, 120, 200, 200]
    t = np.cumsum([0, *counts])[:-1] / 200
    assert abs(t[-1] - 4.0) > 0.1
    time_ns, _ = made_stream(monkeypatch, counts, 0.0)
    assert "telemetry lost samples" in caplog.text
    assert time_ns[0] == 0
    assert 4.9e9 < time_ns[-1] < 5e9


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (packet(np.ones((3, 3)), np.ones((3, 3)))[:-5], "expected .* bytes of"),
        (entry("DEVC", "", 1, sensor("ACCL", np.ones((2, 3)), 9, b"g")), "got b'g'"),
        (entry("DEVC", "", 1, sensor("GYRO", np.ones((2, 3)), 0, b"rad/s")), "not 0"),
        (packet(np.ones((2, 3)), np.ones((2, 3)), entry("ORIN", "c", 1, b"XXZ")), "order of x"),
    ],
)
def test_what_does_not_fit_is_refused(data: bytes, told: str) -> None:
    with pytest.raises(RecordingError, match=told):
        gopro._sensors(data, HERE)


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 400), st.binary(min_size=1, max_size=6), st.integers(0, 500))
def test_damaged_bytes_are_read_or_refused(at: int, noise: bytes, end: int) -> None:
    data = bytearray(packet(np.ones((8, 3)), np.ones((8, 3))))
    data[at : at + len(noise)] = noise
    try:
        found = gopro._sensors(bytes(data[:end]), HERE)
    except RecordingError:
        return
    assert all(np.all(np.isfinite(values)) for values in found.values())


def test_a_cameras_own_telemetry(data_dir: Path) -> None:
    path = data_dir / "replays" / "gopro" / "karma.mp4"
    recording = open_recording(path)
    imu = recording.imu
    assert imu is not None
    # What the camera itself counted: TSMP of the last packet, samples since the start.
    last = list(gopro._packets(path))[-1][2]
    totals = {}
    for device in gopro.items(last, path):
        for stream in gopro.items(device.body, path):
            if not stream.kind:
                told = {item.key: item for item in gopro.items(stream.body, path)}
                totals |= dict.fromkeys(told.keys() & {b"ACCL", b"GYRO"}, told[b"TSMP"].body)
    (gyro,) = struct.unpack(">L", totals[b"GYRO"])
    (accel,) = struct.unpack(">L", totals[b"ACCL"])
    assert gyro - 10 <= len(imu) <= gyro
    assert imu.rate_hz == pytest.approx(397.2, abs=0.5)
    assert accel / gyro == pytest.approx(198 / 397, abs=0.002)
    # It flies level: the force is gravity's, along z, and the camera hardly turns.
    force = imu.specific_force_m_s2
    assert np.linalg.norm(force.mean(axis=0)) == pytest.approx(9.8, abs=0.2)
    assert force.mean(axis=0)[2] > 9.5
    assert np.abs(imu.angular_rate_rad_s.mean(axis=0)).max() < 0.1
    frames = recording.frames.time_ns
    assert abs(imu.time_ns[0] - frames[0]) < 3e7
    assert abs(imu.time_ns[-1] - frames[-1]) < 1e8


def test_telemetry_is_used_only_where_the_camera_sits_on_it(
    data_dir: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = data_dir / "replays" / "gopro" / "karma.mp4"
    manifest = tmp_path / "gopro.toml"
    manifest.write_text("[camera]\nfx = 420.0\nfy = 420.0\ncx = 426.5\ncy = 239.5\n")
    assert open_recording(path, manifest).imu is None
    assert "give imu_T_camera" in caplog.text
    placed = "[imu]\nimu_T_camera = [[-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], "
    placed += "[0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]\n"
    manifest.write_text(manifest.read_text() + placed)
    bare = open_recording(path, manifest).imu
    assert bare is not None
    # The same where the manifest names the video: used with extrinsics, told of without.
    manifest.write_text('[frames]\nvideo = "karma.mp4"\n' + manifest.read_text())
    named = open_recording(path.parent, manifest).imu
    assert named is not None
    np.testing.assert_array_equal(named.specific_force_m_s2, bare.specific_force_m_s2)
    caplog.clear()
    manifest.write_text(manifest.read_text().removesuffix(placed))
    assert open_recording(path.parent, manifest).imu is None
    assert "give imu_T_camera" in caplog.text


def test_the_gyroscopes_z_turns_with_the_images_upward_axis(data_dir: Path) -> None:
    """Images shift sideways as the camera turns: a witness of the tutorial's extrinsics."""
    recording = open_recording(data_dir / "replays" / "gopro" / "karma.mp4")
    frames, imu = recording.frames, recording.imu
    assert imu is not None
    stamps = frames.time_ns[::4]
    images = [cv2.cvtColor(frames[k].image(), cv2.COLOR_RGB2GRAY) for k in range(0, len(frames), 4)]
    shifts = []
    for before, after in itertools.pairwise(images):
        found = cv2.goodFeaturesToTrack(before, 200, 0.01, 10)
        moved, seen, _ = cv2.calcOpticalFlowPyrLK(before, after, found, None)
        shifts.append(np.median((moved - found)[seen.ravel() > 0, 0, 0]))
    steps_s = np.gradient(1e-9 * (imu.time_ns - stamps[0]))
    angle = np.interp(stamps, imu.time_ns, np.cumsum(imu.angular_rate_rad_s[:, 2] * steps_s))
    # A turn to the left, positive about an axis that points up, moves what is seen to the right.
    assert np.corrcoef(shifts, np.diff(angle))[0, 1] > 0.97


def test_sync_takes_a_video_a_recording_or_a_file(data_dir: Path, tmp_path: Path) -> None:
    path = data_dir / "replays" / "gopro" / "karma.mp4"
    own = gopro.read_telemetry(path)
    assert own is not None
    write_imu(own, tmp_path / "imu.csv")
    write_video(tmp_path / "plain.mp4", [np.zeros((48, 64, 3), np.uint8)], np.zeros(1, np.int64))
    (tmp_path / "motorcade.toml").write_text(
        '[frames]\nvideo = "plain.mp4"\n[imu]\nfile = "imu.csv"\n'
        "imu_T_camera = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], "
        "[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]\n"
    )
    for source in (path, tmp_path, tmp_path / "imu.csv"):
        stream = read_imu_of(source)
        np.testing.assert_array_equal(stream.time_ns, own.time_ns)
        np.testing.assert_allclose(
            stream.specific_force_m_s2, own.specific_force_m_s2, rtol=1e-3, atol=1e-3
        )
    with pytest.raises(RecordingError, match=r"plain\.mp4.*expected accelerometer and gyroscope"):
        read_imu_of(tmp_path / "plain.mp4")


def test_telemetry_of_android_is_read(rng: np.random.Generator, tmp_path: Path) -> None:
    """A packet a sample, each of one type (CAMM); bytes of other packets are left alone."""
    rate, force = rng.normal(0.0, 1.0, (60, 3)), rng.normal(0.0, 0.1, (60, 3)) - [0.0, 9.81, 0.0]
    path = tmp_path / "phone.mp4"
    with av.open(str(path), "w") as container:
        video = container.add_stream("mpeg4", rate=30)
        video.width, video.height, video.pix_fmt = 64, 48, "yuv420p"
        track = container.add_data_stream("bin_data")
        for number in range(60):
            image = av.VideoFrame.from_ndarray(np.full((48, 64, 3), number, np.uint8), "rgb24")
            container.mux(video.encode(image))
            for kind, values in ((0, rate), (2, rate), (3, force)):
                body = struct.pack("<HH3f", 0, kind, *values[number])
                packet = av.Packet(body)
                packet.stream, packet.time_base = track, Fraction(1, 1000)
                packet.pts = packet.dts = 10 * number + kind
                container.mux(packet)
        container.mux(video.encode())
    imu = read_imu_of(path)
    assert 58 <= len(imu) <= 60
    np.testing.assert_array_equal(np.diff(imu.time_ns), 10_000_000)
    first = np.argmin(np.abs(rate[:3] + imu.angular_rate_rad_s[0] @ TURNED).sum(axis=1))
    found = -imu.angular_rate_rad_s @ TURNED
    np.testing.assert_allclose(found, rate[first : first + len(imu)], atol=1e-6)
    assert np.median(imu.specific_force_m_s2[:, 2]) == pytest.approx(9.81, abs=0.1)
