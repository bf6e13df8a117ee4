"""The smoother that a path calls for, and how strong: `method="auto"`.

Each axis of rotation and of translation is smoothed by the spline that predicts its poses best from
their neighbours, under a velocity, an acceleration or a jerk that white noise changes (see
`batch.columns`); poses that none of them explain are told apart (`batch.apart`). Three things more
are found out from the path: whether its axes are those of the world or of the body (a camera knows
depth less than width; a vehicle goes where it points); whether errors have heavy tails; and whether
stamps tremble that should be even. Where nothing tells noise from motion the path stays as it is.

Reading runs of a flat marker's other candidate needs scipy. Where that is missing they are left out
like other wrong poses, with a warning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.smoothing.batch.apart import (
    HEAVY_TAILS,
    NORMAL_TAILS,
    ApartModels,
    ApartPath,
    Measured,
    chosen_models,
    smoothed_apart,
    tails_of,
    weights_of,
)
from motorcade.fusion.smoothing.batch.columns import ColumnModel
from motorcade.fusion.smoothing.batch.noise import FEWEST_POSES
from motorcade.fusion.smoothing.batch.start import PathStart, even_stamps
from motorcade.fusion.smoothing.checks import in_double
from motorcade.fusion.smoothing.representations import (
    REPRESENTATIONS,
    Representation,
    representation_named,
    restored,
)
from motorcade.ga import Trajectory
from motorcade.ga.arrays import FloatArray

# Axes of the world, and of the body.
_WORLD, _BODY = "rotor", "motor"
_FIRST_STEPS, _LAST_STEPS = 3, 5
# By how much the logarithm of poses must be likelier with even stamps for these to be taken.
_LIKELIER = 10.0


@dataclass(frozen=True)
class SmootherChoice:
    """What a path calls for, by what it was told.

    Fields:
        representation: a name of `REPRESENTATIONS`, in whose vectors the axes are.
        models: of each axis: order of the motion, its process noise and the measurement noise.
        tails: degrees of freedom of the errors; infinite where they are normal.
        even_stamps: whether the stamps tremble about even ones, which are then taken.
        outliers: share of the poses that are left out.
        axes: how many of the models are of rotation, and of rotation and translation.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import SmootherChoice, choose
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> chosen = choose(noisy)
        >>> isinstance(chosen, SmootherChoice), chosen.representation, chosen.outliers
        (True, 'rotor', 0.0)
        >>> print(f"{1e3 * chosen.noise_m:.0f} mm")
        10 mm
        >>> chosen.smooth(noisy)
        Trajectory(world_T_camera, 121 poses, 4.000 s)
    """

    representation: str
    models: tuple[ColumnModel, ...]
    tails: float
    even_stamps: bool
    outliers: float
    axes: tuple[int, int]

    @property
    def noise_rad(self) -> float:
        """Deviation of a good rotation about an axis, in rad; half that of quaternions."""
        return _root_mean_square([one.noise for one in self.models[: self.axes[0]]])

    @property
    def noise_m(self) -> float:
        """Deviation of a good position an axis, in m."""
        return _root_mean_square([one.noise for one in self.models[slice(*self.axes)]])

    @property
    def noise_scale(self) -> float | None:
        """Deviation of a good scale; None of rigid poses."""
        left = [one.noise for one in self.models[self.axes[1] :]]
        return _root_mean_square(left) if left else None

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory as was chosen."""
        return smoothed_automatically(trajectory, choice=self).trajectory

    def __str__(self) -> str:
        """The choice in one line."""
        orders = "/".join(str(one.order) for one in self.models)
        frame = {_WORLD: "axes of the world", _BODY: "axes of the body"}
        told = [
            f"splines on {self.representation} ({frame.get(self.representation, 'components')})",
            f"order {orders}",
            f"noise {1e3 * self.noise_m:.3g} mm and {np.rad2deg(self.noise_rad):.3g}° an axis",
            f"{100.0 * self.outliers:.1f} % outliers",
        ]
        if self.tails != NORMAL_TAILS:
            told.append("heavy tails")
        if self.even_stamps:
            told.append("stamps taken for even")
        return "; ".join(told)


@dataclass(frozen=True, eq=False)
class AutomaticPath:
    """A path smoothed as it calls for.

    Fields:
        trajectory: with the stamps and frames of the measured one.
        choice: what was found out.
        weights: ``(N,)`` about 1 where a measured pose counts fully, 0 where it is left out.
        deviations: ``(N, d)`` of the smoothed poses along the representation's axes.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.fusion.smoothing import smoothed_automatically
        >>> found = smoothed_automatically(screw().sampled(30.0, 2.0))
        >>> found.trajectory, found.deviations.shape
        (Trajectory(world_T_camera, 61 poses, 2.000 s), (61, 6))
    """

    trajectory: Trajectory
    choice: SmootherChoice
    weights: FloatArray
    deviations: FloatArray


def choose(trajectory: Trajectory, representation: str | None = None) -> SmootherChoice:
    """Find out what smoother a path calls for.

    Args:
        trajectory: at least 16 poses.
        representation: a name of `REPRESENTATIONS`: what is smoothed; by default the axes of the
            world or of the body, whichever predict better.

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
        >>> choose(noisy).even_stamps
        False
    """
    return smoothed_automatically(trajectory, representation).choice


def smoothed_automatically(
    trajectory: Trajectory,
    representation: str | None = None,
    choice: SmootherChoice | None = None,
) -> AutomaticPath:
    """Smooth a trajectory as it calls for, and tell what is known of the result; see the module.

    Args:
        trajectory: at least 16 poses.
        representation: as `choose`.
        choice: what was found out already, on this path or another.

    Raises:
        ValueError: fewer poses, or an unknown representation.
    """
    if len(trajectory) < FEWEST_POSES:
        raise ValueError(
            f"trajectory: expected at least {FEWEST_POSES} poses to tell noise from motion, got "
            f"{len(trajectory)}"
        )
    named = representation_named((choice.representation if choice else representation) or _WORLD)
    trajectory = in_double(trajectory)
    start = PathStart.of(trajectory)
    if choice is not None:
        models = ApartModels(choice.models, 0.0)
        measured, path = start.written(named, choice.even_stamps)
        found = smoothed_apart(measured, path, start.weights, models, HEAVY_TAILS, _FIRST_STEPS)
        found = _settled(measured, found, models, choice.tails)
        return _told(trajectory, measured, found, choice)
    even, measured, found = _first(start, named)
    models = chosen_models(measured, found.coordinates, found.weights)
    if representation is None:
        measured, found, models = _in_better_axes(start, measured, found, models, even)
    columns = len(models.columns)
    tails = tails_of(found.squares, found.weights, columns)
    found = _settled(measured, found, models, tails)
    columns_found = tuple(
        replace(model, noise=float(size))
        for model, size in zip(models.columns, found.noise, strict=True)
    )
    outliers = float(np.mean((found.weights == 0.0) | start.mirrored))
    made = SmootherChoice(
        measured.representation.name,
        columns_found,
        tails,
        even,
        outliers,
        measured.representation.ends,
    )
    return _told(trajectory, measured, found, made)


def auto(trajectory: Trajectory, representation: Representation | None) -> Trajectory:
    """Smooth as `choose` says: noise and motion are told from the path, wrong poses left out.

    Args:
        trajectory: at least 16 poses.
        representation: what is smoothed; None takes the axes that predict better.

    Raises:
        ValueError: fewer poses.
    """
    name = None if representation is None else representation.name
    return smoothed_automatically(trajectory, name).trajectory


def _first(start: PathStart, representation: Representation) -> tuple[bool, Measured, ApartPath]:
    """A first path, and whether stamps are taken for even for it."""
    tried = []
    for even in (False, True):
        if even and even_stamps(start.trajectory.time_s) is None:
            continue
        measured, path = start.written(representation, even)
        models = chosen_models(measured, path, start.weights, (2,))
        handicap = _LIKELIER if even else 0.0
        tried.append((models.score - handicap, even, measured, path, models))
    _, even, measured, path, models = max(tried, key=lambda one: one[0])
    found = smoothed_apart(measured, path, start.weights, models, HEAVY_TAILS, _FIRST_STEPS)
    return even, measured, found


def _in_better_axes(
    start: PathStart, measured: Measured, found: ApartPath, models: ApartModels, even: bool
) -> tuple[Measured, ApartPath, ApartModels]:
    """The same in axes of the body, where these predict better."""
    body = REPRESENTATIONS[_BODY]
    smooth = restored(measured.representation, found.coordinates, start.trajectory)
    turned, _ = start.written(body, even)
    path = body.coordinates(smooth.poses)
    others = chosen_models(turned, path, found.weights)
    if others.score <= models.score:
        return measured, found, models
    return turned, replace(found, coordinates=path), others


def _settled(measured: Measured, found: ApartPath, models: ApartModels, tails: float) -> ApartPath:
    weights = weights_of(found.squares, len(models.columns), tails)
    return smoothed_apart(measured, found.coordinates, weights, models, tails, _LAST_STEPS)


def _told(
    trajectory: Trajectory, measured: Measured, found: ApartPath, choice: SmootherChoice
) -> AutomaticPath:
    made = restored(measured.representation, found.coordinates, trajectory)
    return AutomaticPath(made, choice, found.weights, np.sqrt(found.variance))


def _root_mean_square(sizes: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(sizes)))) if sizes else 0.0
