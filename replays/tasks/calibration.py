"""Calibration from image files or a video: views gathered, camera and coverage written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.errors import RecordingError, refusal
from motorcade.replays.io.files import write_bytes
from motorcade.replays.io.readers.frames.exif import image_orientation
from motorcade.replays.io.readers.frames.files import images_in
from motorcade.replays.io.readers.frames.images import SUFFIXES, decode_gray, read_image_bytes
from motorcade.replays.io.readers.manifest.section import camera_toml
from motorcade.replays.io.recording import Frame, ImageArray
from motorcade.tracking import Board, Calibration, CalibrationError
from motorcade.tracking.boards.corners import BoardCorners
from motorcade.tracking.cameras.calibrate import (
    LensTrial,
    better_lens,
    choose_lens,
    spread_views,
    try_lenses,
)
from motorcade.tracking.cameras.camera import AS_STORED, CameraModel, ImageOrientation

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
