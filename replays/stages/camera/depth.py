"""A recording's depth as its sensor measured it, and SLAM's map refined by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from motorcade.ga import Motor
from motorcade.replays.io.readers.frames.files import ImageFrames
from motorcade.replays.io.recording import DepthArray, Recording
from motorcade.replays.stages.camera.offered import camera_of
from motorcade.tracking.depth.cameras import DepthCamera
from motorcade.tracking.depth.refine import refine_by_depth
from motorcade.tracking.slam.geometry import seen_through

if TYPE_CHECKING:
    from motorcade.tracking.slam import SlamResult

MeasuredDepth = Callable[[int], DepthArray | None]
"""The depth of a frame by its number, None without."""


def measured_depth(recording: Recording) -> tuple[DepthCamera, MeasuredDepth]:
    """The pinhole that took the depth images, and their undistorted pixels.

    Depth that was recorded on colour's pixels counts as taken by the colour camera.
    """
    frames = recording.frames
    if isinstance(frames, ImageFrames) and frames.depth_camera is not None:
        lens, colour_T_depth = frames.depth_camera.camera, frames.depth_camera.colour_T_depth
        read: MeasuredDepth = frames.measured_depth
    else:
        lens, colour_T_depth = camera_of(recording), Motor.identity()

        def read(index: int) -> DepthArray | None:
            return frames[index].still().depth_m()

    def undistorted(index: int) -> DepthArray | None:
        depth_m = read(index)
        return None if depth_m is None else lens.undistort_depth(depth_m)

    return DepthCamera(lens.undistorted(), colour_T_depth), undistorted


def refined_by_depth(recording: Recording, result: SlamResult) -> SlamResult | None:
    """SLAM's path and map, refined by depth; None without a path, or as `refine_by_depth` says."""
    if result.trajectory is None:
        return None
    taken_by, depth_m = measured_depth(recording)
    index = {stamp: row for row, stamp in enumerate(recording.frames.time_ns.tolist())}
    refined = refine_by_depth(
        result.map,
        result.trajectory,
        seen_through(camera_of(recording)),
        taken_by,
        lambda time_ns: depth_m(index[time_ns]),
    )
    if refined is None:
        return None
    return replace(result, trajectory=refined.trajectory, map=refined.map)
