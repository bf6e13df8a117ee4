"""TUM-VI: EuRoC's folders with Kalibr's calibration, 16-bit images and truth of the IMU."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from motorcade.replays.io.files import RecordingError
from motorcade.replays.io.readers.opening import open_recording

CHAIN = """
cam0:
  T_cam_imu: {}
  camera_model: pinhole
  distortion_model: equidistant
  distortion_coeffs: [0.003, 0.0007, -0.002, 0.0002]
  intrinsics: [19.0, 19.1, 11.9, 7.8]
  resolution: [24, 16]
"""
NOISE = """
accelerometer_noise_density: 0.0028
accelerometer_random_walk: 0.00086
gyroscope_noise_density: 0.00016
gyroscope_random_walk: 0.000022
rostopic: /imu0
update_rate: 200.0
"""


@pytest.fixture
def tum_vi(make: Callable[[str], Any]) -> tuple[Any, Motor]:
    """EuRoC's made-up sequence put the way of TUM-VI."""
    made = make("euroc")
    mav = made.root / "mav0"
    for sensor in ("cam0", "imu0"):
        (mav / sensor / "sensor.yaml").unlink()
    (mav / "mocap0").mkdir()
    truth = mav / "state_groundtruth_estimate0"
    rows = [",".join(row.split(",")[:8]) for row in (truth / "data.csv").read_text().splitlines()]
    (mav / "mocap0" / "data.csv").write_text("\n".join(rows))
    shutil.rmtree(truth)
    camera_T_imu = Motor.random(np.random.default_rng(2))
    (made.root / "dso").mkdir()
    (made.root / "dso" / "camchain.yaml").write_text(
        CHAIN.format(camera_T_imu.as_matrix().tolist())
    )
    (made.root / "dso" / "imu_config.yaml").write_text(NOISE)
    for image in (mav / "cam0" / "data").iterdir():
        grey = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE)
        assert cv2.imwrite(str(image), grey.astype(np.uint16) * 256)
    return made, camera_T_imu


def test_it_is_read_whole(tum_vi: tuple[Any, Motor]) -> None:
    made, camera_T_imu = tum_vi
    recording = open_recording(made.root)
    recording.check()
    assert recording.camera is not None
    assert recording.imu_noise is not None
    assert recording.truth is not None
    assert recording.camera.model == "equidistant"
    assert recording.imu_noise.gyro_density_rad_s_rthz == 0.00016
    expected = made.poses @ camera_T_imu.inverse()
    np.testing.assert_allclose(recording.truth.motors.as_matrix(), expected.as_matrix(), atol=1e-9)
    np.testing.assert_array_equal(recording.truth.time_ns, made.time_ns)
    assert recording.frames[0].image().dtype == np.uint8


def test_sixteen_bits_become_the_eight_that_they_were_made_from(
    tum_vi: tuple[Any, Motor], make: Callable[..., Any]
) -> None:
    eight = open_recording(make("euroc", "eight").root)
    sixteen = open_recording(tum_vi[0].root)
    for a, b in zip(eight.frames, sixteen.frames, strict=True):
        np.testing.assert_array_equal(a.image(), b.image())


def test_without_any_calibration_both_ways_are_named(tum_vi: tuple[Any, Motor]) -> None:
    root: Path = tum_vi[0].root
    (root / "dso" / "camchain.yaml").unlink()
    with pytest.raises(RecordingError, match=r"sensor.yaml.*or dso/camchain.yaml"):
        open_recording(root)


def test_the_chains_time_shift_puts_imu_and_truth_on_the_cameras_clock(
    tum_vi: tuple[Any, Motor],
) -> None:
    root: Path = tum_vi[0].root
    chain, before = root / "dso" / "camchain.yaml", open_recording(root)
    chain.write_text(chain.read_text() + "  timeshift_cam_imu: 0.25\n")
    after = open_recording(root)
    for name in ("imu", "truth"):
        one, other = getattr(before, name), getattr(after, name)
        np.testing.assert_array_equal(one.time_ns - 250_000_000, other.time_ns)
    np.testing.assert_array_equal(before.frames.time_ns, after.frames.time_ns)
    chain.write_text(chain.read_text().replace("0.25", "soon"))
    with pytest.raises(RecordingError, match="timeshift_cam_imu: expected seconds"):
        open_recording(root)
