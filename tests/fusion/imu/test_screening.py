"""Streams in other units, saturated or with gaps are found out; sound ones pass in silence."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import (
    ADIS16448,
    ContinuousPath,
    ImuFaults,
    ImuStream,
    screen_imu,
    simulate_imu,
)
from motorcade.fusion.imu.screening import saturated_axes
from motorcade.fusion.imu.stream import STANDARD_GRAVITY_M_S2
from motorcade.fusion.motions import MOTIONS
from motorcade.ga import Motor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import read_imu, write_imu

RIGID = [name for name, motion in MOTIONS.items() if motion.versor is Motor]


def ridden(name: str, faults: ImuFaults | None = None, duration_s: float = 20.0) -> ImuStream:
    path = ContinuousPath.along(MOTIONS[name], duration_s)
    rng = np.random.default_rng(3)
    return simulate_imu(path, 200.0, ADIS16448, rng, faults=faults or ImuFaults()).stream


def in_units(stream: ImuStream, rate: float, force: float) -> ImuStream:
    return ImuStream(
        stream.time_ns, rate * stream.angular_rate_rad_s, force * stream.specific_force_m_s2
    )


@pytest.mark.parametrize("name", RIGID)
def test_sound_streams_pass_in_silence(name):
    assert screen_imu(ridden(name)) == ()


@pytest.mark.parametrize("file", ["imu/V102_imu.txt", "replays/euroc_V1_01/mav0/imu0/data.csv"])
def test_recordings_pass_in_silence(data_dir, file, caplog):
    with caplog.at_level(logging.WARNING):
        read_imu(data_dir / file)
    assert not caplog.records


def test_two_seconds_say_nothing_of_the_unit_of_the_rate():
    """Gravity turns 57 times too slowly, but too few tenths of a second show it."""
    degrees = in_units(ridden("tumble"), 180.0 / np.pi, 1.0)
    with pytest.raises(ValueError, match="angular_rate_rad_s: expected radians a second"):
        screen_imu(degrees)
    short = slice(0, 500)
    assert (
        screen_imu(
            ImuStream(
                degrees.time_ns[short],
                degrees.angular_rate_rad_s[short],
                degrees.specific_force_m_s2[short],
            )
        )
        == ()
    )


@pytest.mark.parametrize(
    ("factor", "unit"), [(1 / 9.80665, "in g;"), (1e3 / 9.80665, "milli-g"), (1 / 0.3048, "ft/s²")]
)
@pytest.mark.parametrize("name", ["stop_and_go", "screw"])
def test_force_in_other_units_is_refused_at_rest(name, factor, unit):
    with pytest.raises(ValueError, match=rf"specific_force_m_s2: expected about 9.81 at.*{unit}"):
        screen_imu(in_units(ridden(name), 1.0, factor))


@pytest.mark.parametrize(
    "name", ["gimbal_hover", "tumble", "gimbal_crossing", "antipodal_crossing"]
)
@pytest.mark.parametrize("force", [1.0, 1.02])
def test_degrees_are_refused_where_gravity_turns(name, force):
    with pytest.raises(ValueError, match="angular_rate_rad_s: expected radians a second"):
        screen_imu(in_units(ridden(name), float(np.rad2deg(1.0)), force))


def test_another_gravity_is_told():
    (told,) = screen_imu(in_units(ridden("stop_and_go"), 1.0, 0.8))
    assert told.startswith("the accelerometer reads 7.8")


def test_saturation_is_told_of_the_axis_that_has_it():
    whole = ridden("gimbal_crossing")
    peak = float(np.max(np.abs(whole.angular_rate_rad_s)))
    limited = ridden("gimbal_crossing", ImuFaults(gyro_range_rad_s=0.8 * peak))
    told = screen_imu(limited)
    assert len(told) == 2
    assert all(
        f"angular rate y reads exactly {sign}{0.8 * peak:.6g}" in line
        for sign, line in zip(("", "-"), told, strict=True)
    )
    coarse = ImuFaults(gyro_step_rad_s=7e-4, accel_step_m_s2=8e-3)
    assert screen_imu(ridden("stop_and_go", coarse)) == ()


@pytest.mark.parametrize("step", [1e-6, 1e-3])
def test_peaks_that_are_cut_off_are_told_from_smooth_ones(rng, step):
    """As many readings lie just below the limit of a slow motion as are cut off by it."""
    turns = 2.7 * np.sin(2.0 * np.pi * 0.3 * 5e-3 * np.arange(8000))
    turns = step * np.round((turns + rng.normal(0.0, 2e-3, 8000)) / step)
    rate = np.column_stack([turns, np.clip(turns, -2.65, 2.65), rng.normal(0.0, 1.0, 8000)])
    force = rng.normal(np.array([0.0, 0.0, STANDARD_GRAVITY_M_S2]), 0.02, (8000, 3))
    told = saturated_axes(ImuStream(5_000_000 * np.arange(8000), rate, force))
    assert [line.split(" reads")[0] for line in told] == ["angular rate y"] * 2


def test_gaps_are_counted():
    stream = ridden("handheld")
    kept = np.r_[0:1000, 1001:2000, 2400:4001]
    with_gap = ImuStream(
        stream.time_ns[kept], stream.angular_rate_rad_s[kept], stream.specific_force_m_s2[kept]
    )
    (told,) = screen_imu(with_gap)
    assert told == "2 gaps in the samples, the longest of 2.0050 s after 9995000000 ns"


def test_readers_refuse_and_tell(tmp_path: Path, caplog):
    file = tmp_path / "imu.csv"
    write_imu(in_units(ridden("stop_and_go"), 1.0, 1 / 9.80665), file)
    with pytest.raises(RecordingError, match=rf"^{file}: .*gravity in g; multiply by 9.80665$"):
        read_imu(file)
    write_imu(ridden("handheld", ImuFaults(dropped_share=0.01)), file)
    with caplog.at_level(logging.WARNING):
        read_imu(file)
    assert "gaps in the samples, the longest of 0.0" in caplog.text
