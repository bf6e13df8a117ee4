"""Quaternions, dual quaternions and Euler angles: array functions, and poses made of them.

Quaternions are ``(*, 4)``, w first, Hamilton's; dual quaternions ``(*, 8)``, the real part first;
angles are in radians, translations in metres, batch in front. ``nearest_…`` and ``interpolate_…``
say how each is made continuous and led from one pose to the next. Conversions of Euler angles are
those of `motorcade.ga.versors.euler_angles`.

`QuaternionPose`, `DualQuaternion` and `EulerPose` are frozen poses with the verbs of the versors,
so that one test or comparison runs on all. None of it is built on the versors, whose witness it is.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
