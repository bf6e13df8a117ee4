"""`motorcade fuse --positions`: satellite positions of three formats hold a path that drifts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, simulate_imu
from motorcade.fusion.measurements import GeodeticOrigin
from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.cli import main
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory

START = datetime(2026, 5, 1, 23, 59, 30, tzinfo=UTC)
ORIGIN = GeodeticOrigin(47.3769, 8.5417, 408.0)
SIGMA_M, RATE_HZ, SPAN_S = 0.6, 5.0, 60.0
ANTENNA = np.array([0.1, 0.0, 0.3])


@dataclass(frozen=True)
class Flight:
    """A flight of a minute, its poses that drift, and its fixes: seconds, degrees and metres."""

    folder: Path
    truth: Trajectory
    drifted: Trajectory
    time_s: FloatArray
    places: FloatArray


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Flight:
    folder, rng = tmp_path_factory.mktemp("flight"), np.random.default_rng(38)
    start_ns = int(START.timestamp()) * 10**9
    slow = MOTIONS["walk_and_look"].sampled(200.0, SPAN_S, start_ns=start_ns, child="imu")
    time_s = 1e-9 * (slow.time_ns - start_ns)
    wide = np.stack([12.0 * np.sin(0.21 * time_s), 9.0 * np.sin(0.33 * time_s), 0.0 * time_s], -1)
    poses = Motor.from_translation(wide) @ slow.motors
    whole = Trajectory(slow.time_ns, poses, "world", "imu")
    write_imu(simulate_imu(whole, 200.0, ADIS16448, rng).stream, folder / "imu.csv")
    truth = whole[::10]
    share = np.linspace(0.0, 1.0, len(truth))[:, None]
    turns = Rotor.from_rotation_vector(share * np.array([0.0, 0.0, np.radians(7.0)]))
    walk = np.cumsum(0.01 * rng.standard_normal((len(truth), 3)), axis=0)
    drift = Motor.from_rotor_translation(turns, walk + share * [1.5, -1.0, 0.5])
    drifted = Trajectory(truth.time_ns, drift @ truth.motors, "world", "imu")
    write_trajectory(drifted, folder / "poses.tum")
    fixes = whole[:: round(200.0 / RATE_HZ)]
    local = fixes.motors.apply(ANTENNA) + SIGMA_M * rng.standard_normal((len(fixes), 3))
    heading = Rotor.from_rotation_vector([0.0, 0.0, 2.0])  # the poses' world knows no north
    latitude, longitude, height = ORIGIN.geodetic(heading.apply(local))
    places = np.stack([latitude, longitude, height], axis=-1)
    return Flight(folder, truth, drifted, 1e-9 * (fixes.time_ns - start_ns), places)


def _moments(flight: Flight) -> list[datetime]:
    return [START + timedelta(seconds=round(second, 3)) for second in flight.time_s.tolist()]


def gpx(flight: Flight) -> str:
    points = "".join(
        f'<trkpt lat="{lat:.9f}" lon="{lon:.9f}"><ele>{height:.3f}</ele>'
        f"<time>{moment.strftime('%Y-%m-%dT%H:%M:%S.%f')[:-3]}Z</time></trkpt>"
        for moment, (lat, lon, height) in zip(_moments(flight), flight.places, strict=True)
    )
    path = flight.folder / "flight.gpx"
    head = '<gpx version="1.1" creator="t" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
    path.write_text(f"{head}{points}</trkseg></trk></gpx>")
    return str(path)


def nmea(flight: Flight) -> str:
    lines = []
    for moment, (lat, lon, height) in zip(_moments(flight), flight.places, strict=True):
        clock = moment.strftime("%H%M%S.%f")[:-4]
        place = f"{int(lat):02}{lat % 1 * 60:010.7f},N,{int(lon):03}{lon % 1 * 60:010.7f},E"
        for body in (
            f"GPRMC,{clock},A,{place},0.1,0.0,{moment:%d%m%y},,,A",
            f"GPGGA,{clock},{place},1,08,0.9,{height - 47.0:.3f},M,47.0,M,,",
        ):
            total = 0
            for letter in body.encode():
                total ^= letter
            lines.append(f"${body}*{total:02X}")
    path = flight.folder / "flight.nmea"
    path.write_text("\r\n".join(lines) + "\r\n")
    return str(path)


KINDS: list[Callable[[Flight], str]] = [gpx, nmea]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_positions_take_the_drift_out_of_a_path(
    kind: Callable[[Flight], str], flight: Flight
) -> None:
    out = flight.folder / f"{kind.__name__}.tum"
    asked = ["fuse", flight.folder / "poses.tum", flight.folder / "imu.csv", "-o", out]
    asked += ["--positions", kind(flight), "--positions-sigma-m", SIGMA_M, "--antenna-m", *ANTENNA]
    assert main([str(word) for word in asked]) == 0
    before = evaluate(flight.drifted, flight.truth, align="se3")
    after = evaluate(read_trajectory(out), flight.truth, align="se3")
    assert after.ape_m.rmse < 0.5 * before.ape_m.rmse
    assert after.rotation_deg.rmse < before.rotation_deg.rmse


def test_positions_of_another_time_are_refused(flight: Flight, capsys) -> None:
    later = flight.folder / "later.tum"
    late = replace(flight.truth, time_ns=flight.truth.time_ns + 10**12)
    write_trajectory(late, later)
    asked = ["fuse", flight.folder / "poses.tum", flight.folder / "imu.csv", "-o", later]
    assert main([str(word) for word in [*asked, "--positions", later]]) == 1
    assert "positions: expected 4 or more" in capsys.readouterr().err


def test_positions_of_another_path_are_refused(flight: Flight, capsys) -> None:
    """A mirrored path is one that no heading explains."""
    moved = flight.truth.motors.translation_m * [-1.0, 1.0, 1.0]
    other = flight.folder / "other.tum"
    write_trajectory(Trajectory(flight.truth.time_ns, Motor.from_translation(moved)), other)
    poses, imu = (str(flight.folder / name) for name in ("poses.tum", "imu.csv"))
    out = str(flight.folder / "none.tum")
    assert main(["fuse", poses, imu, "-o", out, "--positions", str(other)]) == 1
    assert "expected them along the poses' path" in capsys.readouterr().err
