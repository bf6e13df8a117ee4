"""Which smoother a path calls for, and how strong: `method="auto"`.

Measurement and process noise are estimated from the path itself (see `batch.noise`). A path without
wrong poses is smoothed by the Rauch-Tung-Striebel smoother under the likelier motion model, one
with wrong poses by the robust batch estimate. So is one whose rotation is so noisy beside its
position that a step's lever arm counts, which the former neglects. Where there is no noise to speak
of the smoother is told so, and leaves the path as it is. Poses that are sparser than 8 Hz do not
resolve what hands and vehicles do, and any model takes such motion for noise; little is smoothed
there.

The robust estimate needs scipy. Where that is missing a Rauch-Tung-Striebel smoother takes its
place, with a warning: it runs on NumPy alone, but gives wrong poses the weight of right ones.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from motorcade.fusion.smoothing.batch.inliers import Sizes
from motorcade.fusion.smoothing.batch.noise import NoiseModel, estimate_noise
from motorcade.fusion.smoothing.batch.robust_map import robust_map
from motorcade.fusion.smoothing.causal import rts_constant_acceleration, rts_constant_velocity
from motorcade.fusion.smoothing.representations import Representation, representation_named
from motorcade.ga import Similarity, Trajectory

log = logging.getLogger("motorcade.smooth")

# Poses farther apart than this do not resolve motion; so much of what the process adds from one to
# the next is then believed to be noise at most.
_UNRESOLVED_S, _SPARSE_SHARE = 0.125, 0.03

_METHODS: dict[str, Callable[..., Trajectory]] = {
    "rts_constant_velocity": rts_constant_velocity,
    "rts_constant_acceleration": rts_constant_acceleration,
    "robust_map": robust_map,
}


@dataclass(frozen=True)
class SmootherChoice:
    """A method with its parameters, and the noise that they were chosen by.

    Fields:
        method: a name of `METHODS`.
        representation: a name of `REPRESENTATIONS`.
        parameters: of the method, in its own units.
        noise: as estimated.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import SmootherChoice, choose
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> chosen = choose(noisy)
        >>> isinstance(chosen, SmootherChoice), chosen.method, chosen.representation
        (True, 'rts_constant_velocity', 'motor')
        >>> chosen.smooth(noisy)
        Trajectory(world_T_camera, 121 poses, 4.000 s)
    """

    method: str
    representation: str
    parameters: dict[str, Any]
    noise: NoiseModel

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory as was chosen."""
        chosen = representation_named(self.representation)
        return _METHODS[self.method](trajectory, chosen, **self.parameters)

    def __str__(self) -> str:
        """The choice in one line."""
        numbers = ", ".join(f"{name} {value:.3g}" for name, value in self.parameters.items())
        share = f"{100.0 * self.noise.outliers:.1f} % outliers"
        return f"{self.method} on {self.representation}: {numbers}; {share}"


def choose(trajectory: Trajectory, representation: str = "motor") -> SmootherChoice:
    """Estimate measurement and process noise, and pick a method and its parameters by them.

    Where the robust estimate is called for and a package that it needs is missing, a warning says
    so, and the likelier motion model is picked.

    Args:
        trajectory: at least 16 poses.
        representation: a name of `REPRESENTATIONS`: what is smoothed.

    Raises:
        ValueError: fewer poses, or an unknown representation.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import choose
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> choose(noisy).method
        'rts_constant_velocity'
    """
    representation_named(representation)
    interval_s = float(np.median(np.diff(trajectory.time_s))) if len(trajectory) > 1 else 0.0
    sparse = interval_s > _UNRESOLVED_S
    noise = estimate_noise(trajectory, representation, order=1 if sparse else None)
    method = "rts_constant_acceleration" if noise.order == 2 else "rts_constant_velocity"
    if (noise.outliers > 0.0 or _levered(trajectory, noise)) and _robust_can_run(method):
        method = "robust_map"
        noise = estimate_noise(trajectory, representation, order=1)
    if sparse:
        noise = _believed(noise, _SPARSE_SHARE * interval_s**1.5)
    rate = "jerk_m_s3" if noise.order == 2 else "acceleration_m_s2"
    angular = "angular_jerk_rad_s3" if noise.order == 2 else "angular_acceleration_rad_s2"
    parameters: dict[str, Any] = {
        rate: noise.translation.acceleration,
        angular: noise.rotation.acceleration,
        "noise_m": noise.translation.noise,
        "noise_rad": noise.rotation.noise,
    }
    if isinstance(trajectory.poses, Similarity):
        growing = "scale_jerk_s3" if noise.order == 2 else "scale_acceleration_s2"
        parameters |= {growing: noise.scale.acceleration, "noise_scale": noise.scale.noise}
    return SmootherChoice(method, representation, parameters, noise)


def _robust_can_run(instead: str) -> bool:
    """Whether `robust_map` has the scipy that it needs; else a warning says what is used."""
    if find_spec("scipy") is not None:
        return True
    log.warning(
        "auto: this path calls for robust_map, which needs the Python package 'scipy' "
        '(pip install "motorcade[pipeline]" brings it); %s instead, which gives wrong '
        "poses the weight of right ones",
        instead,
    )
    return False


def _levered(trajectory: Trajectory, noise: NoiseModel) -> bool:
    """Whether rotation's noise moves the end of a usual step by more than position's noise does."""
    poses = trajectory.poses
    step_m = np.linalg.norm(np.diff(poses.translation_m, axis=0), axis=-1)
    return bool(noise.rotation.noise * float(np.median(step_m)) > noise.translation.noise)


def _believed(noise: NoiseModel, share: float) -> NoiseModel:
    """Noise of no more than a share of the density of the process."""
    rotation, translation, scale = (
        Sizes(min(one.noise, share * one.acceleration), one.acceleration)
        for one in (noise.rotation, noise.translation, noise.scale)
    )
    return replace(noise, rotation=rotation, translation=translation, scale=scale)


def auto(trajectory: Trajectory, representation: Representation) -> Trajectory:
    """Smooth as `choose` says: measurement and process noise are estimated, wrong poses told apart.

    Args:
        trajectory: at least 16 poses.
        representation: what is smoothed.

    Raises:
        ValueError: fewer poses.
    """
    return choose(trajectory, representation.name).smooth(trajectory)
