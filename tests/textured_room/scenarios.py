"""What can happen to a camera in the textured room, by name: the cases that tracking must survive.

============ =====================================================================================
name         what happens
============ =====================================================================================
``handheld`` sway on the spot, everything in order
``loop``     one and a half times around the block: the start is out of view for most of the way;
             beyond the block the light goes down to an eighth and comes back, so that what is
             tracked there drifts by centimetres, which coming back to the start can tell
``long``     30 s of handheld; written with an IMU it serves visual-inertial estimators
``gap``      as long, with a hand over the lenses for one second in the middle
``turning``  pure rotation about the lens: nothing can be triangulated
``covered``  as handheld, with a hand over the lenses for 30 frames in the middle
``blank``    as handheld, in a room without texture
``blurred``  as handheld, exposed for 25 ms, with four times the noise
============ =====================================================================================
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from motorcade.ga import Trajectory
from motorcade.replays.io.trajectories import even_stamps
from tests.textured_room.paths import LOOP_S, Path, handheld, loop, turning
from tests.textured_room.renderer import Renderer, Sensor, View
from tests.textured_room.scene import furnished_room

__all__ = ["RATE_HZ", "SCENARIOS", "Scenario", "scenario"]

RATE_HZ = 30.0
_DEPTH_NOISE_PX = 0.15


@dataclass(frozen=True)
class Scenario:
    """A path, a sensor, and what happens on the way.

    Fields:
        path: poses by time; the first frame is at 0 s.
        frames: how many, at `RATE_HZ`.
        sensor: what looks.
        exposure_s: how long each image is exposed, its stamp in the middle; 0 for no blur.
        covered: first frame in which nothing is seen, and the first after it.
        darkened: first frame in which the light goes down, and the first after it is back;
            least_light: what is left of it in the middle of them. The noise stays.
        textured: whether the room has texture.
        seed: of the textures and of the noise.

    Raises:
        ValueError: fewer than two frames, a negative exposure, or frames covered that run
            backwards, or no light at all.
    """

    path: Path
    frames: int
    sensor: Sensor = field(default_factory=lambda: Sensor(depth_noise_px=_DEPTH_NOISE_PX))
    exposure_s: float = 0.0
    covered: tuple[int, int] = (0, 0)
    darkened: tuple[int, int] = (0, 0)
    least_light: float = 1.0
    textured: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        if self.frames < 2:
            raise ValueError(f"Scenario.frames: expected 2 or more, got {self.frames}")
        if not (np.isfinite(self.exposure_s) and self.exposure_s >= 0.0):
            raise ValueError(f"Scenario.exposure_s: expected 0 or more, got {self.exposure_s}")
        for name in ("covered", "darkened"):
            first, after = getattr(self, name)
            if not 0 <= first <= after:
                raise ValueError(f"Scenario.{name}: expected first <= after, got {(first, after)}")
        if not 0.0 < self.least_light <= 1.0:
            raise ValueError(
                f"Scenario.least_light: expected above 0 and up to 1, got {self.least_light}"
            )

    def truth(self) -> Trajectory:
        """The exact poses of all frames."""
        time_ns = even_stamps(self.frames, RATE_HZ)
        return Trajectory(time_ns, self.path(time_ns * 1e-9))

    def views(self) -> Iterator[View]:
        """Draw all frames, in order; the same seed gives the same images.

        A frame's noise depends on its number alone, not on how many there are.
        """
        renderer = self.renderer()
        for number, time_ns in enumerate(even_stamps(self.frames, RATE_HZ)):
            rng = np.random.default_rng([self.seed, 1, number])
            if self.covered[0] <= number < self.covered[1]:
                yield View.covered(self.sensor, rng)
                continue
            exposed = self.path(self._exposed_s(time_ns * 1e-9))
            yield renderer.view(exposed, rng, light=self.light(number))

    def light(self, number: int) -> float:
        """How bright a frame is; 1 in full light."""
        first, after = self.darkened
        if not first <= number < after:
            return 1.0
        depth = np.sqrt(np.sin(np.pi * (number - first) / (after - first)))
        return float(self.least_light**depth)

    def renderer(self) -> Renderer:
        """The room of this seed, and the sensor that looks at it."""
        rng = np.random.default_rng([self.seed, 0])
        return Renderer(furnished_room(rng, textured=self.textured), self.sensor)

    def _exposed_s(self, middle_s: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Times that one image averages."""
        if self.exposure_s == 0.0:
            return np.array(middle_s)
        count = self.sensor.exposures
        parts = (np.arange(count) - 0.5 * (count - 1)) / count
        return np.asarray(middle_s + self.exposure_s * parts)


_NOISY = Sensor(depth_noise_px=2.0 * _DEPTH_NOISE_PX, noise=4.0, exposures=5)
SCENARIOS: dict[str, Scenario] = {
    "handheld": Scenario(handheld, 200),
    "loop": Scenario(
        loop, round(1.5 * LOOP_S * RATE_HZ), darkened=(120, 270), least_light=0.12,
    ),
    "long": Scenario(handheld, 900),
    "gap": Scenario(handheld, 900, covered=(450, 480)),
    "turning": Scenario(turning, 150),
    "covered": Scenario(handheld, 200, covered=(85, 115)),
    "blank": Scenario(handheld, 60, textured=False),
    "blurred": Scenario(handheld, 200, sensor=_NOISY, exposure_s=0.025),
}  # fmt: skip


def scenario(name: str, *, seed: int = 0, frames: int | None = None) -> Scenario:
    """A scenario by its name, with other textures and noise, or shorter.

    Raises:
        ValueError: no such name, or fewer than two frames.
    """
    if name not in SCENARIOS:
        raise ValueError(f"scenario: expected one of {', '.join(SCENARIOS)}, got {name!r}")
    found = SCENARIOS[name]
    return replace(found, seed=seed, frames=found.frames if frames is None else frames)
