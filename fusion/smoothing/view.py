"""A steadier view of footage: turned camera by camera, so that one place moves evenly in it.

What is drawn cannot be steadier than the footage that it stands on: where a hand shakes the camera
by a pixel, what shakes less slides by the rest. So the view is steadied, not the pose: the camera
stays where it was and is only turned, which moves the whole image, near and far alike, by a
homography that needs no depth. It is turned so that a place of the world is seen where a smoothed
path would see it; what the drawn place needs is smoothed, not the camera's path as such.
(Rotation-only stabilisation, as in A. Karpenko and others, "Digital video stabilization and rolling
shutter correction using gyroscopes", 2011, about a known place.)
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.fusion.smoothing.methods import smooth
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray, checked_floats

LIVE: tuple[str, dict[str, Any]] = "double_exponential", {"cutoff_hz": 3.0, "trend_cutoff_hz": 1.5}
"""Below 3 Hz lies what a hand means to do, above it what it trembles."""
OFFLINE: tuple[str, dict[str, Any]] = "local_polynomial", {"window_s": 0.4, "order": 2}
"""Passes the same motion, from both sides."""


def steady_view(path: Trajectory, about_m: ArrayLike, *, live: bool = False) -> Trajectory:
    """The cameras of a path, each turned on the spot so that a place moves evenly in the images.

    Args:
        path: `world_T_camera`, as measured: what registers.
        about_m: (3,) the place, world, before all cameras.
        live: whether only the past may be looked at.

    Returns:
        The same stamps and places with other attitudes. To see the footage so, image k is warped
        by `turned_homography` of the two attitudes.

    Raises:
        ValueError: fewer than three poses, or a place at or behind a camera.

    >>> import numpy as np
    >>> from motorcade.fusion.smoothing.view import steady_view
    >>> from motorcade.ga import Motor, Trajectory
    >>> rng = np.random.default_rng(0)
    >>> shaken = Motor.exp(np.pad(rng.normal(0.0, 0.002, (60, 3)), ((0, 0), (0, 3))))
    >>> path = Trajectory(33_000_000 * np.arange(60), shaken)
    >>> view = steady_view(path, [0, 0, 2.0])
    >>> np.allclose(view.motors.translation_m, path.motors.translation_m)
    True
    >>> def spread(cameras):
    ...     return cameras.inverse().apply([0, 0, 2.0])[:, 0].std()
    >>> bool(spread(view.motors) < 0.7 * spread(path.motors))
    True
    """
    place = checked_floats(about_m, "steady_view(about_m)", (3,))
    if len(path) < 3:
        raise ValueError(f"steady_view(path): expected three poses or more, got {len(path)}")
    method, settings = LIVE if live else OFFLINE
    even = smooth(path, method, "motor", **settings)
    seen, wanted = (one.inverse().apply(place) for one in (path.motors, even.motors))
    if np.min(seen[:, 2]) <= 0.0 or np.min(wanted[:, 2]) <= 0.0:
        raise ValueError(f"steady_view(about_m): expected a place before all cameras, got {place}")
    # Seen from where the camera is, in the even path's attitude; then turned to where it should be.
    turned = even.motors.rotor.inverse().apply(place - path.motors.translation_m)
    correction = _between(wanted, turned)
    rotors = even.motors.rotor @ correction
    motors = Motor.from_rotor_translation(rotors, path.motors.translation_m)
    return Trajectory(path.time_ns, motors, path.parent, path.child)


def turned_homography(camera_matrix: FloatArray, taken: Rotor, shown: Rotor) -> FloatArray:
    """(*, 3, 3) from pixels of an image taken to those of it shown from another attitude.

    Args:
        camera_matrix: (3, 3) of a camera without distortion.
        taken: attitude `world_T_camera` (*) that the image was taken in.
        shown: (*) that it is to be seen in.
    """
    turn = (shown.inverse() @ taken).as_matrix()
    return np.asarray(camera_matrix @ turn @ np.linalg.inv(camera_matrix))


def _between(start: FloatArray, end: FloatArray) -> Rotor:
    """The least rotors (N,) that turn directions (N, 3) `start` to `end`."""
    a = start / np.linalg.norm(start, axis=-1, keepdims=True)
    b = end / np.linalg.norm(end, axis=-1, keepdims=True)
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine, np.sum(a * b, axis=-1, keepdims=True))
    return Rotor.from_rotation_vector(axis / np.maximum(sine, 1e-15) * angle)
