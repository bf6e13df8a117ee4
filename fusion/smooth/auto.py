"""Which smoother a path calls for, and how strong: `method="auto"`.

Noise and liveliness are estimated from the path itself (see `batch.noise`). A path without wrong
poses is smoothed by the Rauch-Tung-Striebel smoother under the likelier motion model, one with
wrong poses by the robust batch estimate. Where there is no noise to speak of the smoother is told
so, and leaves the path as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from motorcade.fusion.smooth.batch.noise import NoiseModel, estimate_noise
from motorcade.fusion.smooth.batch.robust_map import robust_map
from motorcade.fusion.smooth.causal import rts_constant_acceleration, rts_constant_velocity
from motorcade.fusion.smooth.representations import Representation, representation_named
from motorcade.ga import Similarity, Trajectory

__all__ = ["Choice", "auto", "choose"]

_METHODS: dict[str, Callable[..., Trajectory]] = {
    "rts_constant_velocity": rts_constant_velocity,
    "rts_constant_acceleration": rts_constant_acceleration,
    "robust_map": robust_map,
}


@dataclass(frozen=True)
class Choice:
    """A method with its parameters, and the noise that they were chosen by.

    Fields:
        method: a name of `METHODS`.
        representation: a name of `REPRESENTATIONS`.
        parameters: of the method, in its own units.
        noise: as estimated.
    """

    method: str
    representation: str
    parameters: dict[str, float]
    noise: NoiseModel

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory as was chosen.

        Raises:
            ModuleNotFoundError: a package that the method needs is missing.
        """
        chosen = representation_named(self.representation)
        return _METHODS[self.method](trajectory, chosen, **self.parameters)

    def __str__(self) -> str:
        """The choice in one line."""
        numbers = ", ".join(f"{name} {value:.3g}" for name, value in self.parameters.items())
        share = f"{100.0 * self.noise.outliers:.1f} % outliers"
        return f"{self.method} on {self.representation}: {numbers}; {share}"


def choose(trajectory: Trajectory, representation: str = "motor") -> Choice:
    """Estimate noise and liveliness of a trajectory, and pick method and parameters by them.

    Args:
        trajectory: at least 16 poses.
        representation: a name of `REPRESENTATIONS`: what is smoothed.

    Raises:
        ValueError: fewer poses, or an unknown representation.
    """
    representation_named(representation)
    noise = estimate_noise(trajectory, representation)
    method = "rts_constant_acceleration" if noise.order == 2 else "rts_constant_velocity"
    if noise.outliers > 0.0:
        method = "robust_map"
        noise = estimate_noise(trajectory, representation, order=1)
    rate = "jerk_m_s3" if noise.order == 2 else "acceleration_m_s2"
    angular = "angular_jerk_rad_s3" if noise.order == 2 else "angular_acceleration_rad_s2"
    parameters = {
        rate: noise.translation.acceleration,
        angular: noise.rotation.acceleration,
        "noise_m": noise.translation.noise,
        "noise_rad": noise.rotation.noise,
    }
    if isinstance(trajectory.poses, Similarity):
        growing = "scale_jerk_s3" if noise.order == 2 else "scale_acceleration_s2"
        parameters |= {growing: noise.scale.acceleration, "noise_scale": noise.scale.noise}
    return Choice(method, representation, parameters, noise)


def auto(trajectory: Trajectory, representation: Representation) -> Trajectory:
    """Smooth as `choose` says: noise and liveliness are estimated, wrong poses told apart.

    Args:
        trajectory: at least 16 poses.
        representation: what is smoothed.

    Raises:
        ValueError: fewer poses.
        ModuleNotFoundError: wrong poses were found, and scipy or CasADi is missing.
    """
    return choose(trajectory, representation.name).smooth(trajectory)
