"""Stage `turning_poses`: attitudes of a camera that stands, or only turns about its lens.

Nothing tells lengths then. The world has the camera above its origin, at the height at which eyes
and hands are, and the first image's up is its z.
"""

from __future__ import annotations

import time

import numpy as np

from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.progress import track
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import camera_of, require_images
from motorcade.replays.stages.values.camera_poses import HELD_HEIGHT, CameraPoses, SightedPoints
from motorcade.tracking import PoseMeasurements, TrackingError
from motorcade.tracking.shots.rotation import track_rotation

_WORLD_T_FIRST = Motor.from_rotor_translation(
    Rotor.from_matrix([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), [0.0, 0.0, HELD_HEIGHT]
)
_SIGMA_PX, _SIGMA_PLACE = 0.5, 1e-4
_FAR = 10.0
_TRACKED_SHARE, _MOST_SLIP_PX = 0.5, 3.0


def turning_poses(recording: Recording, *, held: bool = False) -> CameraPoses:
    """Track the attitude of a camera that stays at its place.

    With `held` it stands, and what moves in the images moves by itself, however much it is.

    Raises:
        NotOffered: no camera known, or no images.
        TrackingError: images whose corners no rotation explains.
    """
    camera = camera_of(recording)
    require_images(recording)
    start, frames = time.perf_counter(), recording.frames
    images = (frame.gray() for frame in track(frames, "following the camera", len(frames)))
    turned = track_rotation(images, camera, held=held)
    share, slip = len(turned.known) / len(frames), float(np.median(turned.slip_px))
    if share < _TRACKED_SHARE or slip > _MOST_SLIP_PX * max(1.0, camera.width / 960.0):
        raise TrackingError(
            f"{recording.name}: a rotation about the lens explains {100 * share:.0f} % of the "
            f"frames, to {slip:.1f} px: the camera moves, or hardly anything can be tracked"
        )
    motors = _WORLD_T_FIRST @ Motor.from_rotor_translation(
        Rotor.from_matrix(turned.first_R_camera), np.zeros((len(turned.known), 3))
    )
    path = Trajectory(frames.time_ns[turned.known], motors, "world", "camera")
    sigma = np.repeat((_SIGMA_PX / camera.fx, _SIGMA_PLACE), 3)
    covariance = np.broadcast_to(np.diag(sigma**2), (len(path), 6, 6))
    stamps, frame = np.unique(frames.time_ns[turned.frame], return_inverse=True)
    points = _WORLD_T_FIRST.apply(_FAR * turned.ray)
    rests = bool(np.ptp(turned.first_R_camera, axis=0).max() == 0.0)
    return CameraPoses(
        PoseMeasurements(path, covariance),
        frames.time_ns,
        np.full(len(path), np.nan),
        "turning",
        f"the camera {'stands' if rests else 'only turns'}: attitudes by corners, no lengths",
        metric=False,
        sighted=SightedPoints(camera, stamps, frame, points, turned.px) if len(frame) else None,
        seconds=time.perf_counter() - start,
    )
