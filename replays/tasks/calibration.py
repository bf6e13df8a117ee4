"""Cameras calibrated from images of a board, and together with an IMU from a recording of it.

With an IMU a manifest is written, and the two files that Kalibr would write, in its conventions:
``T_cam_imu`` maps the IMU's coordinates to the camera's, ``timeshift_cam_imu`` is added to a
image's stamp to be the IMU's time, readings are ``M (C_gyro_i rate) + bias`` and ``M force +
bias`` (github.com/ethz-asl/kalibr/wiki/Multi-IMU-and-IMU-intrinsic-calibration).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.fusion.camera_imu import CameraImuCalibration, calibrate_camera_imu
from motorcade.fusion.imu import ADIS16448, ImuNoise, ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.replays.io.files import RecordingError, refusal, write_bytes
from motorcade.replays.io.readers.frames.files import ImageFrames, images_in
from motorcade.replays.io.readers.frames.images import (
    SUFFIXES,
    decode_gray,
    image_orientation,
    read_image_bytes,
)
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.replays.io.readers.opening import read_frames_of
from motorcade.replays.io.readers.readings import read_imu_of
from motorcade.replays.io.recording import Frame, FrameSequence, ImageArray
from motorcade.tracking import (
    Board,
    BoardMeasurements,
    Calibration,
    CalibrationError,
    Camera,
    measure_board,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.cameras.calibrate import (
    LensTrial,
    better_lens,
    choose_lens,
    spread_views,
    try_lenses,
)
from motorcade.tracking.cameras.camera import AS_STORED, CameraModel, ImageOrientation

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


# Frames of a video that are searched, and views that are fitted: more hardly change the result.
_MOST_FRAMES = 300
_MOST_VIEWS = 60

_Read = tuple[str, Callable[[tuple[int, int] | None], tuple[ImageArray, ImageOrientation]]]


@dataclass(frozen=True, eq=False)
class CalibrationRun:
    """A calibration, and what became of every image.

    Fields:
        board: what was looked for.
        names: of the images of `views`.
        views: the fitted views and those that were left out of the fit.
        searched: how many images were read.
        with_board: how many of them show the board.
        unreadable: one line for each image that could not be read.
        orientation: how the images are stored, where all say the same.
        trials: every lens model, judged by held-out views.
        doubt: which lens model predicts held-out views better than the one asked for; empty where
            none does.
    """

    calibration: Calibration
    board: Board
    names: tuple[str, ...]
    views: tuple[BoardCorners, ...]
    searched: int
    with_board: int
    unreadable: tuple[str, ...]
    orientation: ImageOrientation
    trials: tuple[LensTrial, ...]
    doubt: str


def calibrate_images(
    paths: Sequence[Path],
    board: Board,
    model: CameraModel | None = None,
) -> CalibrationRun:
    """Calibrate the camera that took images of a board.

    Args:
        paths: image files, folders of them, or video files; all of one size.
        board: what they show.
        model: "pinhole", "radtan" or "equidistant"; None: the simplest that predicts held-out views
            as well as the best.

    Returns:
        the run; images that cannot be read, or are of another size than the first, are listed.

    Raises:
        CalibrationError: too few images show the board, or what `tracking.calibrate` refuses.
        RecordingError: a path that does not exist, a folder without images, a video that cannot
            be read.
    """
    for path in paths:
        if not path.exists():
            raise refusal(path, "the file is missing")
    size: tuple[int, int] | None = None
    views_of: list[tuple[str, BoardCorners]] = []
    held: set[ImageOrientation] = set()
    unreadable: list[str] = []
    searched = 0
    for name, read in _images(paths):
        try:
            gray, orientation = read(size)
        except RecordingError as fault:
            unreadable.append(str(fault))
            continue
        size = gray.shape[1], gray.shape[0]
        held.add(orientation)
        searched += 1
        view = board.detect(gray)
        if view is not None and view.spanning:
            views_of.append((name, view))
    if size is None or not views_of:
        first = f"; first: {unreadable[0]}" if unreadable else ""
        raise CalibrationError(
            f"{board.name}: expected it in some images, got it in none of {searched} that could "
            f"be read, {len(unreadable)} could not{first}"
        )
    spread = spread_views([view for _, view in views_of], _MOST_VIEWS)
    views = tuple(views_of[index][1] for index in spread)
    trials = try_lenses(views, size)
    chosen = choose_lens(trials)
    if model is not None:
        chosen = next(trial for trial in trials if trial.model == model)
    if chosen.calibration is None:
        raise CalibrationError(chosen.fault)
    better = better_lens(trials, chosen)
    return CalibrationRun(
        calibration=chosen.calibration,
        board=board,
        names=tuple(views_of[index][0] for index in spread),
        views=views,
        searched=searched,
        with_board=len(views_of),
        unreadable=tuple(unreadable),
        orientation=held.pop() if len(held) == 1 else AS_STORED,
        trials=trials,
        doubt="" if better is None else _doubt(chosen, better),
    )


def _doubt(chosen: LensTrial, better: LensTrial) -> str:
    return (
        f"{better.model} predicts held-out views to {better.typical_px:.2f} px, {chosen.model} to "
        f"{chosen.typical_px:.2f}: say --model {better.model}, or leave it out"
    )


def _images(paths: Sequence[Path]) -> Iterator[_Read]:
    for path in paths:
        if path.is_dir():
            yield from map(_image, images_in(path))
        elif path.suffix.lower() in SUFFIXES:
            yield _image(path)
        else:
            yield from _video(path)


def _image(path: Path) -> _Read:
    def read(size: tuple[int, int] | None) -> tuple[ImageArray, ImageOrientation]:
        data = read_image_bytes(path, None, size)
        return decode_gray(path, data, None), image_orientation(data)

    return str(path), read


def _video(path: Path) -> Iterator[_Read]:
    from motorcade.replays.io.readers.frames.video import VideoFrames

    def reader(
        frame: Frame,
    ) -> Callable[[tuple[int, int] | None], tuple[ImageArray, ImageOrientation]]:
        return lambda _: (frame.gray(), frames.orientation)

    frames, _ = VideoFrames(path).intact(None)
    count = min(len(frames), _MOST_FRAMES)
    for index in np.unique(np.linspace(0, len(frames) - 1, count).astype(int)):
        yield f"{path}, frame {index}", reader(frames[int(index)])


def describe_calibration(run: CalibrationRun) -> dict[str, Any]:
    """The camera and what speaks for it, for JSON and for people."""
    calibration = run.calibration
    camera = calibration.camera
    errors = calibration.view_error_px[calibration.used]
    return {
        "board": run.board.name,
        "camera": {
            "model": camera.model,
            "width_px": camera.width,
            "height_px": camera.height,
            "fx_px": camera.fx,
            "fy_px": camera.fy,
            "cx_px": camera.cx,
            "cy_px": camera.cy,
            "distortion": list(camera.distortion),
        },
        "standard_deviation": {
            **dict(
                zip(("fx_px", "fy_px", "cx_px", "cy_px"), calibration.deviation[:4], strict=True)
            ),
            "distortion": calibration.deviation[4:].tolist(),
        },
        "held_out_px": {trial.model: _finite(trial.typical_px) for trial in run.trials},
        "doubt": run.doubt or None,
        "reprojection_rmse_px": calibration.rmse_px,
        "worst_view_rmse_px": float(errors.max()),
        "images_searched": run.searched,
        "images_with_board": run.with_board,
        "views_used": int(calibration.used.sum()),
        "views_left_out": int((~calibration.used).sum()),
        "coverage": calibration.coverage(run.views),
        "largest_turn_deg": calibration.turn_deg,
        "unreadable": list(run.unreadable),
        "views": [
            {"image": name, "corners": len(view), "used": bool(used), "rmse_px": _finite(error)}
            for name, view, used, error in zip(
                run.names, run.views, calibration.used, calibration.view_error_px, strict=True
            )
        ],
    }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def write_calibration(run: CalibrationRun, path: Path) -> Path:
    """Write the camera as TOML (usable as a manifest), and the coverage image beside it.

    Returns:
        where the image lies: `path` with ``_coverage.png`` for its suffix.

    Raises:
        OSError: a file that cannot be written.
    """
    from motorcade.render.plots import plot_coverage

    calibration = run.calibration
    camera = calibration.camera
    said = (
        f"# {int(calibration.used.sum())} views of {run.board.name}, "
        f"{calibration.rmse_px:.4f} px RMS;\n"
        "# standard deviations of fx fy cx cy and distortion: "
        f"{' '.join(f'{one:.2g}' for one in calibration.deviation)}\n"
    )
    write_bytes(path, (said + camera_toml(camera, run.orientation.degrees)).encode())
    image = path.with_name(f"{path.stem}_coverage.png")
    coverage = calibration.coverage(run.views)
    title = f"{path.stem}: {calibration.rmse_px:.3f} px RMS, {coverage:.0%} of the cells"
    data = plot_coverage(
        (camera.width, camera.height),
        _corners(run, used=True),
        calibration.residuals_px,
        _corners(run, used=False),
        title,
    )
    write_bytes(image, data)
    return image


def _corners(run: CalibrationRun, *, used: bool) -> FloatArray:
    rows = zip(run.views, run.calibration.used, strict=True)
    return np.concatenate([np.empty((0, 2)), *(one.corners_px for one, is_ in rows if is_ == used)])
