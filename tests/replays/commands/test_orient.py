"""`orient`: files in, orientation out, and what it says of results that cannot be relied on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.orientation import (
    OrientationModel,
    estimate_orientation,
    orientation_doubts,
)
from motorcade.ga import Rotor
from motorcade.replays.cli import main
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.imu import write_imu
from motorcade.replays.io.readers.readings import at_samples, read_broad
from motorcade.replays.io.trajectories import read_trajectory

FIELD_UT = np.array([0.0, 17.0, -42.0])


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


class Walk:
    """Twenty seconds of a motion, its IMU and its magnetometer."""

    def __init__(self, name: str = "walk_and_look") -> None:
        rng = np.random.default_rng(0)
        path = ContinuousPath.along(MOTIONS[name], 20.0)
        simulated = simulate_imu(path, 100.0, ADIS16448, rng)
        self.imu: ImuStream = simulated.stream
        self.truth: Rotor = simulated.path.poses.rotor
        read = self.truth.inverse().apply(np.broadcast_to(FIELD_UT, (len(self.imu), 3)))
        self.field = read + rng.normal(0.0, 0.5, read.shape)

    def heading_error_deg(self, found: Rotor) -> float:
        error = (found @ self.truth.inverse()).as_quaternion()[-1]
        return float(np.degrees(2.0 * np.arctan(error[3] / error[0])))


@pytest.fixture(scope="module")
def walk() -> Walk:
    return Walk()


@pytest.fixture
def imu_file(walk: Walk, tmp_path: Path) -> Path:
    write_imu(walk.imu, tmp_path / "imu.csv")
    return tmp_path / "imu.csv"


def write_field(path: Path, time_ns: np.ndarray, field: np.ndarray) -> Path:
    rows = zip(time_ns.tolist(), field.tolist(), strict=True)
    path.write_text("".join(f"{t},{x!r},{y!r},{z!r}\n" for t, (x, y, z) in rows))
    return path


def test_a_trajectory_is_what_the_library_gives(walk: Walk, imu_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "orientation.tum"
    for option, smooth in (((), True), (("--online",), False)):
        assert run("orient", imu_file, "-o", out, *option) == 0
        written = read_trajectory(out)
        found = estimate_orientation(walk.imu, smooth=smooth)
        assert np.array_equal(written.time_ns, walk.imu.time_ns)
        turned = (written.poses.rotor @ found.world_R_imu.inverse()).as_rotation_vector()
        np.testing.assert_allclose(turned, 0.0, atol=1e-9)


def test_a_magnetometer_of_its_own_rate_finds_north(
    walk: Walk, imu_file: Path, tmp_path: Path
) -> None:
    """At 25 Hz, with stamps between the IMU's."""
    file = write_field(tmp_path / "mag.csv", walk.imu.time_ns[::4] - 3_000_000, walk.field[::4])
    out, table, summary = (tmp_path / name for name in ("o.tum", "deviations.csv", "o.json"))
    options = ["--deviations", table, "--json", summary, "--readings", "instant"]
    assert run("orient", imu_file, "--magnetometer", file, "-o", out, *options) == 0
    assert abs(walk.heading_error_deg(read_trajectory(out).poses.rotor)) < 3.0
    told = json.loads(summary.read_text())
    assert told["doubts"] == []
    assert told["heading_deviation_deg"] < 5.0
    rows = np.loadtxt(table, delimiter=",")
    assert rows.shape == (len(walk.imu), 8)
    assert np.degrees(np.median(rows[:, 2])) == pytest.approx(told["heading_deviation_deg"])


def test_a_magnetometer_may_stand_in_the_imus_own_file(walk: Walk, tmp_path: Path) -> None:
    both, plain = tmp_path / "nine.csv", tmp_path / "six.csv"
    write_imu(walk.imu, plain)
    header, *lines = plain.read_text().splitlines()
    nine = [
        f"{a},{b[0]!r},{b[1]!r},{b[2]!r}" for a, b in zip(lines, walk.field.tolist(), strict=True)
    ]
    both.write_text("\n".join([header + ",mx,my,mz", *nine, ""]))
    out = tmp_path / "o.tum"
    assert run("orient", both, "--magnetometer", "-o", out) == 0
    assert abs(walk.heading_error_deg(read_trajectory(out).poses.rotor)) < 3.0


def test_readings_go_to_the_first_sample_that_is_not_before_them() -> None:
    imu, stamps = np.array([10, 20, 30, 40]), np.array([5, 10, 21, 29, 41])
    made = at_samples(imu, stamps, np.arange(15.0).reshape(5, 3))
    np.testing.assert_array_equal(made[:, 0], [3.0, np.nan, 9.0, np.nan])


def with_force(walk: Walk, force: np.ndarray) -> ImuStream:
    return ImuStream(walk.imu.time_ns, walk.imu.angular_rate_rad_s, force)


def test_what_cannot_be_relied_on_is_said(walk: Walk) -> None:
    rate, force = walk.imu.angular_rate_rad_s, walk.imu.specific_force_m_s2
    up = estimate_orientation(walk.imu).world_R_imu.inverse().apply([0.0, 0.0, 9.81])
    for imu, part in [
        (with_force(walk, force / 9.80665), "which is gravity in g; multiply by 9.80665"),
        (with_force(walk, force - up), "without gravity"),
        (with_force(walk, 0.165 * force), "expected 9.81"),
        (ImuStream(walk.imu.time_ns, -2.0 * rate, force), "its axes or signs"),
        (ImuStream(walk.imu.time_ns, np.degrees(rate), force), "in degrees a second"),
    ]:
        doubts = orientation_doubts(imu, estimate_orientation(imu))
        assert any(part in doubt for doubt in doubts), (part, doubts)
    nothing = estimate_orientation(walk.imu, magnetic_field=np.zeros_like(walk.field))
    (doubt,) = orientation_doubts(walk.imu, nothing, with_magnetometer=True)
    assert "heading is known to ±180° only" in doubt


def test_clean_readings_raise_no_doubt(walk: Walk) -> None:
    for field in (None, walk.field):
        found = estimate_orientation(walk.imu, OrientationModel(), magnetic_field=field)
        assert orientation_doubts(walk.imu, found, with_magnetometer=field is not None) == ()


def test_strict_fails_where_the_result_is_doubtful(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A magnetometer whose axes are not the gyroscope's."""
    turning, imu_file = Walk("gimbal_crossing"), tmp_path / "imu.csv"
    write_imu(turning.imu, imu_file)
    file = write_field(tmp_path / "mag.csv", turning.imu.time_ns, turning.field[:, [1, 2, 0]])
    arguments = ["orient", imu_file, "--magnetometer", file, "-o", tmp_path / "o.tum"]
    assert run(*arguments) == 0
    assert "doubtful: the magnetic field is disturbed" in capsys.readouterr().err
    assert run(*arguments, "--strict") == 1
    assert (tmp_path / "o.tum").exists()


def test_a_field_of_another_time_is_refused(
    walk: Walk, imu_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_field(tmp_path / "mag.csv", walk.imu.time_ns + 10**12, walk.field)
    assert run("orient", imu_file, "--magnetometer", file, "-o", tmp_path / "o.tum") == 1
    assert "expected readings within the time of the IMU, got none" in capsys.readouterr().err


def trial(path: Path, **changes: object) -> Path:
    """A trial of BROAD of 200 samples, with data sets of one's own."""
    h5py = pytest.importorskip("h5py")
    rows = {
        "imu_gyr": np.zeros((200, 3)),
        "imu_acc": np.tile([0.0, 0.0, 9.81], (200, 1)),
        "imu_mag": np.tile(FIELD_UT, (200, 1)),
        **changes,
    }
    with h5py.File(path, "w") as file:
        file.attrs["sampling_rate"] = 285.7
        for name, values in rows.items():
            if values is not None:
                file[name] = values
    return path


def test_a_trial_of_broad_is_read(tmp_path: Path) -> None:
    file = trial(tmp_path / "trial.hdf5")
    imu, field = read_broad(file)
    assert imu.rate_hz == pytest.approx(285.7)
    np.testing.assert_array_equal(field[0], FIELD_UT)
    out = tmp_path / "o.tum"
    assert run("orient", file, "--magnetometer", "-o", out) == 0
    np.testing.assert_allclose(
        read_trajectory(out).poses.rotor.as_rotation_vector(), 0.0, atol=1e-6
    )


def test_trials_that_are_none_are_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    file = tmp_path / "trial.hdf5"
    elsewhere = trial(tmp_path / "elsewhere.hdf5")
    for changes, message in [
        ({"imu_acc": None}, "imu_acc: expected a data set of BROAD's in this file, got none"),
        ({"imu_mag": h5py.ExternalLink(str(elsewhere), "imu_mag")}, "imu_mag: expected a data set"),
        (
            {"imu_gyr": np.zeros((200, 4))},
            r"imu_gyr: expected numbers of shape \(N, 3\), got float",
        ),
        ({"imu_gyr": np.zeros((100, 3))}, "expected as many rows of imu_gyr"),
        ({"imu_gyr": np.full((200, 3), np.nan)}, "angular_rate_rad_s"),
        ({"imu_gyr": np.array([b"a"] * 200)}, "imu_gyr: expected numbers"),
    ]:
        with pytest.raises(RecordingError, match=message):
            read_broad(trial(file, **changes))
    file.write_bytes(b"no HDF5")
    with pytest.raises(RecordingError, match="expected an HDF5 file, got something else"):
        read_broad(file)
    with h5py.File(file, "w") as made:
        for name in ("imu_gyr", "imu_acc", "imu_mag"):
            made.create_dataset(name, (200, 3), "f8", chunks=(2**24, 3), maxshape=(None, 3))
        made.attrs["sampling_rate"] = 100.0
    with pytest.raises(RecordingError, match="imu_gyr: expected chunks of at most"):
        read_broad(file)
