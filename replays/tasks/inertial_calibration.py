"""Camera and IMU calibrated together from a recording of a board: read, calibrated, written.

Written are a manifest of the house, and the two files that Kalibr would write, in its conventions:
``T_cam_imu`` maps the IMU's coordinates to the camera's, ``timeshift_cam_imu`` is added to a
image's stamp to be the IMU's time, readings are ``M (C_gyro_i rate) + bias`` and ``M force +
bias`` (github.com/ethz-asl/kalibr/wiki/Multi-IMU-and-IMU-intrinsic-calibration).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.camera_imu import CameraImuCalibration, calibrate_camera_imu
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.replays.io.readers.opening import read_frames_of
from motorcade.replays.io.readers.readings import read_imu_of
from motorcade.replays.io.recording import FrameSequence
from motorcade.tracking import (
    Board,
    BoardMeasurements,
    CalibrationError,
    Camera,
    measure_board,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.cameras.camera import CameraModel

# Between two poses the IMU tells more than a third would: Kalibr's authors advise 20 Hz, too.
_MOST_HZ = 20.0
_LEAST_IMAGES = 40  # two seconds of them; `synchronise` asks for 20 poses and 2 s


@dataclass(frozen=True, eq=False)
class InertialRun:
    """A calibration of camera and IMU, and what became of the images.

    Fields:
        calibration: of camera and IMU.
        seen: poses over the board that it stands on.
        board: what was looked for.
        searched: how many images were read; `seen.views` of them show the board.
        stated: the IMU's noise as given.
        rate_hz: of the IMU.
        rotation_deg: by how much the images were turned clockwise to be upright.
    """

    calibration: CameraImuCalibration
    seen: BoardMeasurements
    board: Board
    searched: int
    stated: ImuNoise
    rate_hz: float
    rotation_deg: int = 0


def calibrate_recording(
    recording: Path,
    board: Board,
    imu: Path | None = None,
    *,
    camera: Camera | None = None,
    model: CameraModel = "radtan",
    noise: ImuNoise = ADIS16448,
    gravity_m_s2: float | None = None,
    search_s: float = 2.0,
) -> InertialRun:
    """Calibrate camera and IMU from a recording of a board.

    Args:
        recording: a folder of any known layout, a bag or a video; up to 20 of its images a second
            are searched.
        board: what it shows; it must not move.
        imu: EuRoC's CSV, a video with telemetry or a recording; None: that of `recording`.
        camera: known beforehand; None: its intrinsics are found, too.
        model: of the lens that is to be found.
        noise: the IMU's densities and bias walks.
        gravity_m_s2: as for `calibrate_camera_imu`.
        search_s: as for `calibrate_camera_imu`.

    Raises:
        RecordingError: what cannot be read, or no IMU.
        CalibrationError: images that show the board too rarely, or what `calibrate` refuses.
        ValueError: what `calibrate_camera_imu` refuses.
    """
    frames = read_frames_of(recording)
    stream = read_imu_of(recording if imu is None else imu)
    rows = _thinned(frames.time_ns)
    stamps, views, size = _searched(frames, rows, board)
    if len(views) < _LEAST_IMAGES:
        raise CalibrationError(
            f"{board.name}: expected it in {_LEAST_IMAGES} images or more, got it in "
            f"{len(views)} of {len(rows)}"
        )
    seen = measure_board(stamps, views, camera, size=size, model=model)
    calibration = calibrate_camera_imu(
        seen, stream, noise, gravity_m_s2=gravity_m_s2, search_s=search_s
    )
    turned = frames.orientation.degrees if isinstance(frames, VideoFrames | ImageFrames) else 0
    return InertialRun(calibration, seen, board, len(rows), noise, _rate_hz(stream), turned)


def _thinned(time_ns: IntArray) -> IntArray:
    """Rows of images that are a twentieth of a second apart, or as far as they are."""
    if len(time_ns) < 2:
        return np.arange(len(time_ns))
    typical_s = 1e-9 * float(np.median(np.diff(time_ns)))
    return np.arange(0, len(time_ns), max(round(1.0 / (_MOST_HZ * typical_s)), 1))


def _searched(
    frames: FrameSequence, rows: IntArray, board: Board
) -> tuple[IntArray, list[BoardCorners], tuple[int, int]]:
    stamps, views, size = [], [], (0, 0)
    for row in rows.tolist():
        gray = frames[row].gray()
        size = gray.shape[1], gray.shape[0]
        view = board.detect(gray)
        if view is not None and view.spanning:
            stamps.append(int(frames.time_ns[row]))
            views.append(view)
    return np.array(stamps, dtype=np.int64), views, size


def _rate_hz(imu: ImuStream) -> float:
    return 1e9 / float(np.median(np.diff(imu.time_ns)))


def describe_inertial(run: InertialRun) -> dict[str, Any]:
    """What was found and what speaks for it, for JSON and for people."""
    calibration, seen = run.calibration, run.seen
    return {
        "board": run.board.name,
        "images_searched": run.searched,
        "images_with_board": seen.views,
        "images_used": calibration.poses,
        "images_refused": calibration.refused,
        "span_s": calibration.span_s,
        "reprojection_rmse_px": calibration.error_px,
        "corner_sigma_px": calibration.sigma_px,
        "misfit": calibration.misfit,
        "imu_T_camera_wxyz": calibration.imu_T_camera.rotor.as_quaternion().tolist(),
        "imu_T_camera_translation_m": calibration.imu_T_camera.translation_m.tolist(),
        "offset_s": calibration.offset_s,
        "gravity_board_m_s2": calibration.gravity_m_s2.tolist(),
        "gyro_correction": calibration.gyro_correction.tolist(),
        "accel_correction": calibration.accel_correction.tolist(),
        "gyro_bias_rad_s": calibration.gyro_bias_rad_s.tolist(),
        "accel_bias_m_s2": calibration.accel_bias_m_s2.tolist(),
        "gyro_density_rad_s_rthz": calibration.noise.gyro_density_rad_s_rthz,
        "accel_density_m_s2_rthz": calibration.noise.accel_density_m_s2_rthz,
        "parameters": [
            {
                "name": parameter.name,
                "value": parameter.value,
                "sigma": parameter.sigma,
                "unobservable": parameter.unobservable or None,
            }
            for parameter in calibration.parameters
        ],
        "health": calibration.health.as_dict(),
    }


def write_inertial(run: InertialRun, path: Path) -> tuple[Path, Path]:
    """Write a manifest, and Kalibr's two files beside it.

    Args:
        run: the calibration.
        path: of the manifest, ``[camera]`` and ``[imu]``.

    Returns:
        Kalibr's camera chain, ``<stem>-camchain-imucam.yaml``, and its ``<stem>-imu.yaml``.

    Raises:
        OSError: a file that cannot be written.
    """
    chain = path.with_name(f"{path.stem}-camchain-imucam.yaml")
    imu = path.with_name(f"{path.stem}-imu.yaml")
    write_bytes(chain, chain_yaml(run.calibration).encode("ascii"))
    write_bytes(imu, imu_yaml(run.calibration, run.rate_hz).encode("ascii"))
    write_bytes(path, _manifest(run, imu.name).encode())
    return chain, imu


def _manifest(run: InertialRun, noise_file: str) -> str:
    calibration = run.calibration
    seen, span_s = calibration.poses, calibration.span_s
    lines = [f"# {seen} images of {run.board.name}, {span_s:.1f} s beside an IMU"]
    lines += [f"# unobservable by the motion: {one}" for one in calibration.unobservable]
    lines += [
        camera_toml(calibration.camera, run.rotation_deg),
        "[imu]",
        f'noise_file = "{noise_file}"',
        f"clock_offset_s = {calibration.offset_s!r}",
        f"gyro_correction = {_rows(calibration.gyro_correction)}",
        f"accel_correction = {_rows(calibration.accel_correction)}",
        f"imu_T_camera = {_rows(calibration.imu_T_camera.as_matrix())}",
    ]
    return "\n".join(lines) + "\n"


def chain_yaml(camera_imu_calibration: CameraImuCalibration) -> str:
    """Kalibr's ``camchain-imucam.yaml``."""
    camera = camera_imu_calibration.camera
    model = "none" if camera.model == "pinhole" else camera.model
    numbers = [camera.fx, camera.fy, camera.cx, camera.cy]
    return (
        "cam0:\n"
        f"  T_cam_imu: {_rows(camera_imu_calibration.imu_T_camera.inverse().as_matrix())}\n"
        "  cam_overlaps: []\n"
        "  camera_model: pinhole\n"
        f"  distortion_coeffs: {_list(camera.distortion)}\n"
        f"  distortion_model: {model}\n"
        f"  intrinsics: {_list(numbers)}\n"
        f"  resolution: [{camera.width}, {camera.height}]\n"
        "  rostopic: /cam0/image_raw\n"
        f"  timeshift_cam_imu: {_number(camera_imu_calibration.offset_s)}\n"
    )


def imu_yaml(camera_imu_calibration: CameraImuCalibration, rate_hz: float) -> str:
    """Kalibr's ``imu.yaml`` of its model `scale-misalignment`."""
    lower, turn = camera_imu_calibration.kalibr_gyroscope
    noise = camera_imu_calibration.noise
    return (
        "imu0:\n"
        f"  T_i_b: {_rows(np.eye(4))}\n"
        f"  accelerometer_noise_density: {_number(noise.accel_density_m_s2_rthz)}\n"
        f"  accelerometer_random_walk: {_number(noise.accel_walk_m_s3_rthz)}\n"
        "  accelerometers:\n"
        f"    M: {_rows(camera_imu_calibration.accel_matrix)}\n"
        f"  gyroscope_noise_density: {_number(noise.gyro_density_rad_s_rthz)}\n"
        f"  gyroscope_random_walk: {_number(noise.gyro_walk_rad_s2_rthz)}\n"
        "  gyroscopes:\n"
        f"    A: {_rows(np.zeros((3, 3)))}\n"
        f"    C_gyro_i: {_rows(turn)}\n"
        f"    M: {_rows(lower)}\n"
        "  model: scale-misalignment\n"
        "  rostopic: /imu0\n"
        "  time_offset: 0.0\n"
        f"  update_rate: {rate_hz:.3f}\n"
    )


def _rows(matrix: FloatArray) -> str:
    return f"[{', '.join(_list(row) for row in matrix)}]"


def _list(numbers: Iterable[float]) -> str:
    return f"[{', '.join(map(_number, numbers))}]"


def _number(value: float) -> str:
    """Every digit, as YAML 1.1 knows a number too: it takes 2e-05, without a dot, for text."""
    text = repr(float(value) + 0.0)  # no -0.0
    return text.replace("e", ".0e") if "e" in text and "." not in text else text
