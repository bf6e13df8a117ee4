"""What a recording holds, in a few lines: frames, rates, gaps, calibration, streams, truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from motorcade.ga import IntArray
from motorcade.replays.recording import Recording

GAP_FACTOR = 2.5
"""A step between stamps this many times the median step counts as a gap."""


def describe(recording: Recording) -> dict[str, Any]:
    """Contents of a recording as JSON-ready values whose keys carry units."""
    about: dict[str, Any] = {"name": recording.name}
    about |= _stream("frames", recording.frames.time_ns)
    camera = recording.camera
    if camera is not None:
        about["image_size_px"] = [camera.width, camera.height]
        about["camera_model"] = camera.model
        about["focal_px"] = [camera.fx, camera.fy]
        about["principal_point_px"] = [camera.cx, camera.cy]
        about["distortion"] = list(camera.distortion)
    if recording.board is not None:
        about["board"] = recording.board.name
        about["board_size_m"] = list(recording.board.size_m)
    if recording.imu is not None:
        about |= _stream("imu", recording.imu.time_ns)
    if recording.imu_noise is not None:
        about["imu_noise"] = str(recording.imu_noise)
    if recording.truth is not None:
        about |= _stream("truth", recording.truth.time_ns)
        steps = np.diff(recording.truth.poses.translation_m, axis=0)
        about["truth_path_m"] = float(np.linalg.norm(steps, axis=1).sum())
    return about


def _stream(name: str, time_ns: IntArray) -> dict[str, Any]:
    """Count, span, rate and gaps of a stamped stream."""
    about: dict[str, Any] = {f"{name}_count": len(time_ns)}
    if len(time_ns) < 2:
        return about
    steps_s = np.diff(time_ns) * 1e-9
    usual = float(np.median(steps_s))
    about[f"{name}_duration_s"] = float(steps_s.sum())
    about[f"{name}_rate_hz"] = 1.0 / usual
    about[f"{name}_gaps"] = int(np.count_nonzero(steps_s > GAP_FACTOR * usual))
    about[f"{name}_longest_gap_s"] = float(steps_s.max())
    return about
