"""Rigid motions and similarities as versors of geometric algebra: poses, paths, and the algebra.

A pose is named for the frames it connects: ``world_T_camera`` maps camera coordinates to world
coordinates. ``@`` composes from right to left, so that the frames in the middle meet:

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> world_T_camera = Motor.from_euler_translation([0.0, 0.0, np.pi / 2], [1.0, 0.0, 0.0])
    >>> camera_T_imu = Motor.from_translation([0.0, 0.1, 0.0])
    >>> world_T_imu = world_T_camera @ camera_T_imu
    >>> np.round(world_T_imu.apply([0.0, 0.0, 0.0]), 6) + 0.0
    array([0.9, 0. , 0. ])
    >>> np.round(world_T_imu.inverse().apply([0.9, 0.0, 0.0]), 6) + 0.0
    array([0., 0., 0.])

Units are metres, radians and seconds; stamps are integer nanoseconds, quaternions wxyz, Euler
angles intrinsic. Worlds are right-handed with z up; cameras look along z with y down, as OpenCV's.
Small motions are twists in a pose's own frame, rotation vector first: see `Motor.retract`.

Leading dimensions are batch and broadcast: one motor and a million are the same function. Values
are frozen, and what does not fit is refused with its name. Needs no more than NumPy; names
are imported when they are first used.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
