"""Readings and positions as apps and devices write them come back, through every command."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Trajectory
from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.readings import read_imu_and_field, read_imu_of, read_readings
from motorcade.replays.io.trajectories import read_trajectory
from tests.end_to_end.loggers import KINDS, G, Motion, draw
from tests.replays.readers.bag_poses import Messages, write_messages

EAST_M = 6378137.0 * np.pi / 180.0
TRACK = [(47.0, 8.5 + 1e-5 * k, 400.0 + k) for k in range(12)]


@pytest.fixture(scope="module")
def motion() -> Motion:
    return draw(np.random.default_rng(20))


@pytest.mark.parametrize("kind", KINDS)
def test_readings_come_back(kind: str, motion: Motion, tmp_path: Path) -> None:
    imu = read_imu_of(KINDS[kind](tmp_path, motion))
    assert len(motion.imu) - 3 <= len(imu) <= len(motion.imu)
    rows = np.rint((imu.time_ns - imu.time_ns[-1]) * 1e-7).astype(int) - 1
    assert np.abs(np.diff(imu.time_ns) - 10_000_000).max() <= 1_000_000
    late = 1 if len(imu) < len(motion.imu) and kind != "two_topics" else 0
    near = [
        np.abs(imu.angular_rate_rad_s - motion.imu.angular_rate_rad_s[rows - shift]).max()
        for shift in (0, late)
    ]
    assert min(near) < 1e-5
    force = motion.imu.specific_force_m_s2
    shift = (0, late)[int(np.argmin(near))]
    assert np.median(np.abs(imu.specific_force_m_s2 - force[rows - shift])) < 0.05


@pytest.mark.parametrize("kind", ["sensor_logger", "phyphox", "androsensor", "physics_toolbox"])
def test_magnetometers_are_read_with_them(kind: str, motion: Motion, tmp_path: Path) -> None:
    path = KINDS[kind](tmp_path, motion)
    readings = read_readings(path)
    assert readings.field is not None
    np.testing.assert_allclose(readings.field[1][5], motion.field[5], atol=1e-5)
    _, field = read_imu_and_field(path, path)
    assert field is not None
    assert np.isfinite(field).all(axis=1).sum() > len(motion.field) - 5


@pytest.mark.parametrize(
    "kind", ["repoimu", "px4", "ardupilot", "sensorlog", "ros_bag", "sensor_logger_zip", "oxts"]
)
def test_every_command_takes_them(kind: str, motion: Motion, tmp_path: Path, capsys) -> None:
    path = KINDS[kind](tmp_path, motion)
    assert main(["orient", str(path), "-o", str(tmp_path / "o.tum")]) == 0
    assert len(read_trajectory(tmp_path / "o.tum")) > 1990
    capsys.readouterr()
    assert main(["inspect", str(path), "--json"]) == 0
    about = json.loads(capsys.readouterr().out)
    words = json.dumps(about)
    assert "orient" in words
    assert f"motorcade inspect {path}" not in words


@pytest.mark.parametrize("name", ["FreeAcc_X", "userAccelerationX", "LINEAR ACCELERATION X (m/s²)"])
def test_accelerations_without_gravity_are_no_force(
    name: str, motion: Motion, tmp_path: Path
) -> None:
    names = [name, name.replace("X", "Y", 1), name.replace("X", "Z", 1)]
    gravity = motion.truth.inverse().apply(np.broadcast_to([0.0, 0.0, G], (len(motion.imu), 3)))
    free = motion.imu.specific_force_m_s2 - gravity
    for with_gravity in (False, True):
        added = ["gravity.x", "gravity.y", "gravity.z"] if with_gravity else []
        rows = [
            ",".join(map(repr, (time_s, *row[:3], *part, *(pull if with_gravity else ()))))
            for time_s, row, part, pull in zip(
                motion.time_s, motion.rows, free.tolist(), gravity.tolist(), strict=True
            )
        ]
        path = tmp_path / "log.csv"
        header = ",".join(["time (s)", "gyro_x", "gyro_y", "gyro_z", *names, *added])
        path.write_text("\n".join([header, *rows]), encoding="utf-8")
        if with_gravity:
            sign = -1.0 if name.startswith("user") else 1.0
            found = sign * read_imu_of(path).specific_force_m_s2
            np.testing.assert_allclose(found, motion.imu.specific_force_m_s2, atol=1e-9)
        else:
            with pytest.raises(RecordingError, match=r"hold gravity, got .*log the whole"):
                read_imu_of(path)


@pytest.mark.parametrize(
    "damage", [b"m/s\xb2", b"m/s\xc3\x82\xc2\xb2", b"m/s\xef\xbf\xbd", b"m/s?"]
)
def test_units_are_known_in_the_wrong_encoding(
    damage: bytes, motion: Motion, tmp_path: Path
) -> None:
    path = KINDS["androsensor"](tmp_path, motion)
    whole = read_readings(path)
    text = path.read_bytes().replace("m/s²".encode(), damage).replace("μT".encode(), b"nT")
    path.write_bytes(text)
    again = read_readings(path)
    np.testing.assert_array_equal(again.imu.specific_force_m_s2, whole.imu.specific_force_m_s2)
    assert whole.field is not None
    assert again.field is not None
    np.testing.assert_allclose(again.field[1], 1e-3 * whole.field[1])


def test_a_packet_counter_needs_its_rate(motion: Motion, tmp_path: Path) -> None:
    path = KINDS["xsens_mtw"](tmp_path, motion)
    path.write_text(path.read_text().replace("// Update Rate: 100.0Hz\n", ""))
    with pytest.raises(RecordingError, match=r"Update Rate: 100 Hz.*got a counter"):
        read_imu_of(path)


def test_forces_without_gravity_are_refused(motion: Motion, tmp_path: Path) -> None:
    folder = KINDS["sensor_logger"](tmp_path, motion)
    (folder / "TotalAcceleration.csv").unlink()
    force = read_imu_of(folder).specific_force_m_s2  # with that of gravity's file
    assert abs(np.median(np.linalg.norm(force, axis=1)) - 9.8) < 0.3
    (folder / "Gravity.csv").unlink()
    with pytest.raises(RecordingError, match="hold gravity"):
        read_imu_of(folder)


def gpx(folder: Path) -> Path:
    points = "".join(
        f'<trkpt lat="{lat}" lon="{lon:.7f}"><ele>{height}</ele>'
        f"<time>2024-05-01T10:00:{second:02}.500Z</time></trkpt>"
        for second, (lat, lon, height) in enumerate(TRACK)
    )
    path = folder / "walk.gpx"
    path.write_text(
        '<?xml version="1.0"?><gpx version="1.1" creator="c" '
        f'xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>{points}</trkseg></trk></gpx>'
    )
    return path


def checked(sentence: str) -> str:
    total = 0
    for letter in sentence.encode():
        total ^= letter
    return f"${sentence}*{total:02X}"


def nmea(folder: Path) -> Path:
    lines = []
    for second, (lat, lon, height) in enumerate(TRACK):
        clock = f"2359{50 + second:02}.50" if second < 10 else f"0000{second - 10:02}.50"
        south, west = f"{int(lat):02}{lat % 1 * 60:08.5f}", f"{int(lon):03}{lon % 1 * 60:08.5f}"
        place = f"{south},N,{west},E"
        day = "010524" if second < 10 else "020524"
        lines.append(checked(f"GPRMC,{clock},A,{place},0.1,0.0,{day},,,A"))
        lines.append(checked(f"GPGGA,{clock},{place},1,08,0.9,{height - 47},M,47.0,M,,"))
    lines[4] = lines[4][:-1] + ("0" if lines[4][-1] != "0" else "1")
    path = folder / "walk.nmea"
    path.write_text("\r\n".join(lines) + "\r\n")
    return path


def nav_sat_fix(folder: Path) -> str:
    messages, sent = Messages(ros1=False), []
    for second, (lat, lon, height) in enumerate(TRACK):
        stamp = (1_714_557_600 + second) * 10**9
        status = messages.make("sensor_msgs/msg/NavSatStatus", status=0, service=1)
        fix = messages.make(
            "sensor_msgs/msg/NavSatFix",
            header=messages.header(stamp, "gps"),
            status=status,
            latitude=lat,
            longitude=lon,
            altitude=height,
            position_covariance=np.zeros(9),
            position_covariance_type=0,
        )
        sent.append(("/fix", stamp + 40_000_000, fix))
    return f"{write_messages(folder, 'mcap', sent)}:/fix"


def check_track(path: Trajectory) -> None:
    assert len(path) == len(TRACK)
    np.testing.assert_array_equal(np.diff(path.time_ns), 10**9)
    places = path.motors.translation_m
    np.testing.assert_allclose(places[0], 0.0, atol=1e-9)
    metres = 1e-5 * EAST_M * np.cos(np.radians(47.0))
    np.testing.assert_allclose(np.diff(places[:, 0]), metres, rtol=3e-3)
    np.testing.assert_allclose(np.diff(places[:, 2]), 1.0, atol=1e-3)


@pytest.mark.parametrize("kind", [gpx, nmea, nav_sat_fix], ids=lambda kind: kind.__name__)
def test_positions_are_paths_in_metres(kind, tmp_path: Path, capsys) -> None:
    name = str(kind(tmp_path))
    check_track(read_trajectory(name))
    assert main(["evaluate", name, name]) == 0
    assert main(["inspect", name.removesuffix(":/fix")]) == 0
    assert "evaluate" in capsys.readouterr().out


def test_gpx_with_declarations_of_its_own_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.gpx"
    path.write_text('<!DOCTYPE g [<!ENTITY a "b">]><gpx version="1.1" creator="&a;"></gpx>')
    with pytest.raises(RecordingError, match="declarations"):
        read_trajectory(path)


def gpx(path: Path, heights: list[float | None]) -> Path:
    """A track of these heights above the sea, None for points without."""
    points = [
        f'<trkpt lat="47.0" lon="{8.5 + 1e-5 * k}"><time>2026-05-01T08:00:{k:02d}Z</time>'
        + ("" if height is None else f"<ele>{height}</ele>")
        + "</trkpt>"
        for k, height in enumerate(heights)
    ]
    head = '<gpx version="1.1" creator="t" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
    path.write_text(f"{head}{''.join(points)}</trkseg></trk></gpx>")
    return path


def test_points_without_a_height_make_no_jump_to_the_sea(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    track = read_trajectory(gpx(tmp_path / "some.gpx", [400.0, 401.0, None, 403.0]))
    assert len(track) == 3
    np.testing.assert_allclose(track.motors.translation_m[:, 2], [0.0, 1.0, 3.0], atol=1e-6)
    assert "1 fixes without a height are left out" in caplog.text
    level = read_trajectory(gpx(tmp_path / "none.gpx", [None] * 4))
    assert len(level) == 4
    assert np.abs(level.motors.translation_m[:, 2]).max() < 1e-3
    assert "no fix has a height: the path is level" in caplog.text


def test_header_stamps_count_before_times_of_arrival(motion: Motion, tmp_path: Path) -> None:
    imu = read_imu_of(KINDS["rostopic"](tmp_path, motion))
    np.testing.assert_array_equal(np.diff(imu.time_ns), np.diff(motion.imu.time_ns))


def test_a_zip_is_what_is_in_it(motion: Motion, tmp_path: Path, capsys) -> None:
    path = tmp_path / "log.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(KINDS["sensorlog"](tmp_path, motion), "2020/sensorlog.csv")
    assert len(read_imu_of(path)) > 1990
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("mav0/cam0/0.png", b"")
    with pytest.raises(RecordingError, match=r"got 'mav0/cam0/0.png'; unpack it \(unzip log.zip\)"):
        read_imu_of(path)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 1
    assert "packed as .zip; unpack it" in capsys.readouterr().err


def test_a_log_of_ardupilot_has_a_field_and_positions(motion: Motion, tmp_path: Path) -> None:
    path = KINDS["ardupilot"](tmp_path, motion)
    readings = read_readings(path)
    assert readings.field is not None
    np.testing.assert_allclose(readings.field[1][1], motion.field[10], atol=0.05 + 1e-9)
    track = read_trajectory(path)
    assert len(track) == len(readings.field[0])
    north_m = track.motors.translation_m[-1, 1]
    assert north_m == pytest.approx(2000e-7 * EAST_M, rel=1e-2)


@pytest.mark.parametrize(
    ("found", "put", "problem"),
    [
        (b"QBffffffIIfBBHH", b"QBffffffIIfBBH?", "types of ArduPilot's"),
        (b"QBffffffIIfBBHH", b"QBffffffIIfBBHB", "as long as its messages"),
        (b"GyrX", b"GxrX", "the column 'GyrX'"),
        (b"IMU\0QBff", b"IMV\0QBff", "ArduPilot's IMU, got none"),
    ],
)
def test_damaged_logs_of_ardupilot_are_refused(
    found: bytes, put: bytes, problem: str, motion: Motion, tmp_path: Path
) -> None:
    path = KINDS["ardupilot"](tmp_path, motion)
    path.write_bytes(path.read_bytes().replace(found, put, 1))
    with pytest.raises(RecordingError, match=problem):
        read_imu_of(path)


def test_a_zip_whose_packing_is_damaged_is_refused(motion: Motion, tmp_path: Path) -> None:
    path = KINDS["sensor_logger_zip"](tmp_path, motion)
    whole = path.read_bytes()
    for at in range(200, len(whole) // 2, len(whole) // 40):
        path.write_bytes(whole[:at] + bytes(64) + whole[at + 64 :])
        with pytest.raises(RecordingError, match="zip"):
            read_imu_of(path)
