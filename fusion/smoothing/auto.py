"""The smoother that a path calls for, and how strong: `method="auto"`.

Each axis of rotation and of translation is smoothed by the spline that predicts its poses best from
their neighbours, under a velocity, an acceleration or a jerk that white noise changes (see
`batch.columns`); poses that none of them explain are told apart (`batch.per_axis`). Three things
more are found out from the path: whether its axes are those of the world or of the body (a camera
knows depth less than width; a vehicle goes where it points); whether errors have heavy tails; and
whether stamps tremble that should be even. Beside the splines stand a constant twist and, where a
body turns fast, a filter of all rotations together (there as well). Where nothing tells noise from
motion the path stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from motorcade.fusion.smoothing.batch.columns import ColumnModel, noise_in_words, told_noise
from motorcade.fusion.smoothing.batch.per_axis import (
    NORMAL_TAILS,
    AxisModels,
    Measured,
    PerAxisPath,
    chosen_models,
    settled,
    smoother,
    tails_of,
)
from motorcade.fusion.smoothing.batch.predicted import in_part, unpredicted
from motorcade.fusion.smoothing.batch.start import (
    PathStart,
    first_path,
    in_better_axes,
    no_worse,
    of_one_turn,
    of_one_twist,
)
from motorcade.fusion.smoothing.checks import FEWEST_POSES, checked_size, in_double, warn_of_coarse
from motorcade.fusion.smoothing.live import LiveSmoother
from motorcade.fusion.smoothing.representations import (
    Representation,
    representation_named,
    restored,
)
from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, checked_number

# Axes of the world, and of the body.
_WORLD, _BODY = "rotor", "motor"
_AXES = 3
# A dual part is half the position times the quaternion, whose error the position's size enlarges.
_MIXED = "dual parts mix positions with rotations"
# A thousandth and a thousand times the time that the path calls for are as good as none and all.
_MOST = 10.0
# Representations whose vectors have a rotation and a translation an axis.
_OF_AXES = ("motor", "similarity", "rotor")


@dataclass(frozen=True)
class SmootherKnobs:
    """What is asked of a smoother that finds out the rest.

    Fields:
        smoothness: 0 smooths as the path calls for; each unit more doubles the time that a pose is
            averaged over, each less halves it; from -10 to 10.
        noise_m, noise_rad: deviation of positions and rotations an axis, where it is known: it is
            then used, not searched for; from 1e-30 to 1e30.
        max_move_m, max_move_rad: no pose is moved, or turned, farther than that from where it was
            measured, though it be wrong; from 1e-30 to 1e30.

    Raises:
        ValueError: a smoothness or a noise out of its range.
        TypeError: what is no number.

    Examples:
        >>> from motorcade.fusion.smoothing.auto import SmootherKnobs
        >>> SmootherKnobs(smoothness=1.0, noise_m=0.005).noise_m
        0.005
    """

    smoothness: float = 0.0
    noise_m: float | None = None
    noise_rad: float | None = None
    max_move_m: float | None = None
    max_move_rad: float | None = None

    def __post_init__(self) -> None:
        if not -_MOST <= checked_number(self.smoothness, "smoothness") <= _MOST:
            raise ValueError(
                f"smoothness: expected {-_MOST:g} to {_MOST:g}, each unit twice as smooth, got "
                f"{self.smoothness}"
            )
        for name in ("noise_m", "noise_rad", "max_move_m", "max_move_rad"):
            size = getattr(self, name)
            if size is not None:
                checked_size(size, name, "metres" if name.endswith("_m") else "radians")

    def known_noise(self, representation: Representation, columns: int) -> FloatArray:
        """Of the columns of a representation ``(columns,)``; NaN where it is to be found out.

        Raises:
            ValueError: a noise of a representation whose vectors are not rotation and translation.
        """
        known = np.full(columns, np.nan)
        sizes = (self.noise_rad, self.noise_m)
        if sizes == (None, None):
            return known
        if representation.name not in _OF_AXES:
            raise ValueError(
                f"noise_m, noise_rad: expected none with {representation.name}, whose components "
                f"have noise of their own; take one of {', '.join(_OF_AXES)}"
            )
        ends = (0, *representation.ends)
        for noise, first, end in zip(sizes, ends[:-1], ends[1:], strict=True):
            known[first:end] = np.nan if noise is None else noise
        return known

    def allowed_share(self, smoothed: Motor, measured: Motor) -> FloatArray:
        """Of the way from measured rotations and positions to smoothed ones ``(N, 2)``."""
        turned = (measured.rotor.inverse() @ smoothed.rotor).angle()
        moved = np.linalg.norm(smoothed.translation_m - measured.translation_m, axis=1)
        limits = [np.inf if most is None else most for most in (self.max_move_rad, self.max_move_m)]
        way = np.maximum(np.column_stack([turned, moved]), 1e-300)
        return np.asarray(np.minimum(1.0, np.array(limits) / way), dtype=np.float64)


@dataclass(frozen=True)
class SmootherChoice:
    """What a path calls for, by what it was told.

    Fields:
        representation: a name of `REPRESENTATIONS`, in whose vectors the axes are.
        models: of each axis: order of the motion, its process noise and the measurement noise, NaN
            where the path does not tell it.
        tails: degrees of freedom of the errors; infinite where they are normal.
        even_stamps: whether the stamps tremble about even ones, which are then taken.
        outliers: share of the poses that are left out, mirrored back or moved back.
        jumps: how often the level jumps; on another path they are looked for anew.
        axes: how many of the models are of rotation, and of rotation and translation.
        knobs: what was asked for.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion.smoothing import choose
        >>> from motorcade.fusion.smoothing.auto import SmootherChoice
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> chosen = choose(noisy)
        >>> isinstance(chosen, SmootherChoice), chosen.representation, chosen.outliers
        (True, 'rotor', 0.0)
        >>> chosen.smooth(noisy)
        Trajectory(world_T_camera, 121 poses, 4.000 s)
    """

    representation: str
    models: tuple[ColumnModel, ...]
    tails: float
    even_stamps: bool
    outliers: float
    jumps: int
    axes: tuple[int, int]
    knobs: SmootherKnobs = field(default_factory=SmootherKnobs)

    @property
    def noise_rad(self) -> float | None:
        """Deviation of a good rotation about an axis, in rad.

        None where the path tells it of no axis, or not of all components of quaternions.
        """
        models = self.models[: self.axes[0]]
        if len(models) == _AXES:
            return told_noise(models)
        if any(one.unobservable for one in models):
            return None
        # Four components have the errors of three half angles, shared as the pose turns.
        squares = sum(one.noise**2 for one in models) / _AXES
        return float(np.sqrt(squares)) / representation_named(self.representation).units[0]

    @property
    def noise_m(self) -> float | None:
        """Deviation of a good position an axis, in m; None where the path tells it of none.

        Dual quaternions do not tell it.
        """
        return None if self._mixed else told_noise(self.models[slice(*self.axes)])

    @property
    def noise_scale(self) -> float | None:
        """Deviation of a good scale; None of rigid poses, or where the path does not tell it."""
        return told_noise(self.models[self.axes[1] :])

    @property
    def unobservable(self) -> str:
        """Why the noise of some axes is not told; empty where it is of all."""
        reasons = [one.unobservable for one in self.models] + [_MIXED if self._mixed else ""]
        return ", ".join(dict.fromkeys(one for one in reasons if one))

    @property
    def _mixed(self) -> bool:
        return self.axes[1] - self.axes[0] != _AXES

    @property
    def raw(self) -> bool:
        """Whether no axis tells its noise, so that good poses are left as they are."""
        return all(one.unobservable for one in self.models)

    @property
    def by_twist(self) -> bool:
        """Whether the path has a constant twist, or rotates at a constant rate."""
        return any(one.stiff for one in self.models)

    @property
    def memory_s(self) -> float:
        """Of the axis whose errors last longest, in which one decays to a third; 0 if none last."""
        return max(one.memory_s for one in self.models)

    def smooth(self, trajectory: Trajectory) -> Trajectory:
        """Smooth a trajectory as was chosen."""
        return smoothed_automatically(trajectory, choice=self).trajectory

    def __str__(self) -> str:
        """The choice in one line."""
        if self.raw:
            return (
                f"poses left as they are ({100.0 * self.outliers:.1f} % outliers): "
                f"{self.unobservable} its noise; a higher rate would, or noise_m and noise_rad "
                "where they are known"
            )
        orders = "/".join(str(one.order) for one in self.models)
        frame = {_WORLD: "axes of the world", _BODY: "axes of the body"}
        parts = [
            f"splines on {self.representation} ({frame.get(self.representation, 'components')})",
            f"order {orders}",
            f"noise {noise_in_words(self.noise_m, self.noise_rad)} an axis",
            f"{100.0 * self.outliers:.1f} % outliers",
        ]
        if self.unobservable:
            parts.append(f"not told of an axis: {self.unobservable}")
        if self.by_twist:
            whole = all(one.stiff for one in self.models[: self.axes[1]])
            parts.append("a constant twist" if whole else "a constant angular rate")
        if self.models[0].joint:
            parts.append("rotations smoothed together")
        if self.jumps:
            parts.append(f"{self.jumps} jump{'s' * (self.jumps > 1)} of level kept")
        if self.tails != NORMAL_TAILS:
            parts.append("heavy tails")
        if self.memory_s > 0.0:
            parts.append(f"errors last for {1e3 * self.memory_s:.0f} ms")
        if self.even_stamps:
            parts.append("stamps taken for even")
        if self.knobs.smoothness:
            parts.append(f"smoothness {self.knobs.smoothness:+g}")
        for name, size in asdict(self.knobs).items():
            if name != "smoothness" and size is not None:
                parts.append(f"{name} given" if name.startswith("noise") else f"{name} {size:g}")
        return "; ".join(parts)


@dataclass(frozen=True, eq=False)
class AutomaticPath:
    """A path smoothed as it calls for.

    Fields:
        trajectory: with the stamps and frames of the measured one.
        choice: what was found out.
        weights: ``(N,)`` about 1 where a measured pose counts fully, 0 where it is called wrong:
            left out, mirrored back or moved back.
        deviations: ``(N, d)`` of the smoothed poses along the representation's axes, for the
            choice's noise; NaN along those whose noise is not told. Motion that is smoothed away
            where more smoothness is asked for is not in them.
        jumps: rows before which the level jumps, as when a map was corrected; these are kept.

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
    jumps: IntArray


def choose(
    trajectory: Trajectory,
    representation: str | None = None,
    **knobs: float | None,
) -> SmootherChoice:
    """Find out what smoother a path calls for.

    Args:
        trajectory: at least 16 poses.
        representation: a name of `REPRESENTATIONS`: what is smoothed; by default the axes of the
            world or of the body, whichever predict better.
        knobs: of `SmootherKnobs`.

    Raises:
        ValueError: fewer poses, an unknown representation, or a knob out of its range.

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
    return smoothed_automatically(trajectory, representation, None, **knobs).choice


def smoothed_automatically(
    trajectory: Trajectory,
    representation: str | None = None,
    choice: SmootherChoice | None = None,
    **knobs: float | None,
) -> AutomaticPath:
    """Smooth a trajectory as it calls for, and tell what is known of the result; see the module.

    Args:
        trajectory: at least 16 poses.
        representation: as `choose`.
        choice: what was found out already, on this path or another, with knobs of its own.
        knobs: of `SmootherKnobs`.

    Raises:
        ValueError: fewer poses, an unknown representation, a knob out of its range or beside a
            choice.
    """
    if len(trajectory) < FEWEST_POSES:
        raise ValueError(
            f"trajectory: expected at least {FEWEST_POSES} poses to tell noise from motion, got "
            f"{len(trajectory)}"
        )
    asked = SmootherKnobs(**knobs)  # type: ignore[arg-type]
    if choice is not None and asked != SmootherKnobs():
        raise ValueError(f"choice: expected none beside knobs, got {choice} and {asked}")
    trajectory = in_double(trajectory)
    starts = PathStart.of(trajectory)
    if choice is None:
        choice, start, measured, smoothed = _chosen(starts, representation, asked)
    else:
        named = representation_named(choice.representation)
        models = AxisModels(tuple(replace(one, stiff=False) for one in choice.models), 0.0)
        start, _, measured, smoothed = first_path(starts, named, models, choice.even_stamps)
        smoothed = settled(measured, smoothed, models, choice.tails)
        if choice.by_twist:
            state = (start, measured, smoothed, models, choice.tails)
            measured, smoothed, models = of_one_twist(*state, any_axes=False)
        choice = replace(choice, models=models.columns)
    if choice.knobs.smoothness != 0.0:
        smoothed = smoother(
            measured, smoothed, choice.models, choice.tails, choice.knobs.smoothness
        )
    return _finished(start, trajectory, measured, smoothed, choice)


def auto(
    trajectory: Trajectory,
    representation: Representation | None,
    *,
    smoothness: float = 0.0,
    noise_m: float | None = None,
    noise_rad: float | None = None,
    max_move_m: float | None = None,
    max_move_rad: float | None = None,
    lag_s: float | None = None,
) -> Trajectory:
    """Smooth as `choose` says: noise and motion are told from the path, wrong poses left out.

    Args:
        trajectory: at least 16 poses.
        representation: what is smoothed; None takes the axes that predict better.
        smoothness: 0 smooths as the path calls for; each unit more doubles the time that a pose is
            averaged over, each less halves it.
        noise_m: deviation of positions an axis, where it is known: it is used, not searched for.
        noise_rad: of rotations an axis, likewise.
        max_move_m: no position is moved farther than that, though it be wrong; None: as found.
        max_move_rad: no rotation is turned farther, likewise.
        lag_s: None: every pose knows the whole path. Otherwise it knows what was measured up to so
            many seconds later, and `LiveSmoother` gives it.

    Raises:
        ValueError: fewer poses, a knob out of its range, noise of a representation without axes, or
            a lag beside other knobs or another representation than rotors.
    """
    name = None if representation is None else representation.name
    knobs = SmootherKnobs(smoothness, noise_m, noise_rad, max_move_m, max_move_rad)
    if lag_s is None:
        return smoothed_automatically(trajectory, name, **asdict(knobs)).trajectory
    if knobs != SmootherKnobs():
        raise ValueError(
            "lag_s: expected none beside other knobs: a path that is smoothed as it comes is "
            "weighed anew at every pose"
        )
    if name not in (None, _WORLD):
        raise ValueError(f"lag_s: expected {_WORLD} or no representation beside it, got {name}")
    return LiveSmoother(lag_s).smooth(trajectory)


def _chosen(
    starts: Sequence[PathStart], representation: str | None, knobs: SmootherKnobs
) -> tuple[SmootherChoice, PathStart, Measured, PerAxisPath]:
    """What a path calls for, where it starts then, and the path smoothed so."""
    named = representation_named(representation or _WORLD, starts[0].trajectory.poses)
    start, even, measured, smoothed = first_path(starts, named)
    known = knobs.known_noise(measured.representation, smoothed.noise.size)
    taken = measured, smoothed
    if representation is None:
        taken = in_better_axes(start, measured, smoothed)
    models = chosen_models(taken[0], taken[1].coordinates, smoothed.weights, known=known)
    if taken[0] is not measured and models.unobservable > 0:
        world = chosen_models(measured, smoothed.coordinates, smoothed.weights, known=known)
        # What is left as measured is not predicted better.
        if world.unobservable < models.unobservable:
            taken, models = (measured, smoothed), world
    measured, smoothed = taken
    warn_of_coarse(float(np.median(np.diff(measured.time_s))))
    tails = tails_of(smoothed.squares, smoothed.weights, len(models.columns))
    smoothed = settled(measured, smoothed, models, tails)
    free = representation is None
    measured, smoothed, models = of_one_twist(start, measured, smoothed, models, tails, free)
    measured, smoothed, models = of_one_turn(start, measured, smoothed, models, tails)
    smoothed, models = no_worse(start, measured, smoothed, models, tails, known)
    noise = np.where(np.isnan(known), smoothed.noise, known)
    choice = SmootherChoice(
        measured.representation.name,
        tuple(
            replace(model, noise=float("nan") if model.unobservable else float(size))
            for model, size in zip(models.columns, noise, strict=True)
        ),
        tails,
        even,
        float(np.mean((smoothed.weights == 0.0) | start.mirrored)),
        len(measured.jumps),
        measured.representation.ends,
        knobs,
    )
    return choice, start, measured, smoothed


def _finished(
    start: PathStart,
    trajectory: Trajectory,
    measured: Measured,
    smoothed: PerAxisPath,
    choice: SmootherChoice,
) -> AutomaticPath:
    path = restored(measured.representation, smoothed.coordinates, trajectory)
    models = AxisModels(choice.models, 0.0)
    stay = unpredicted(start.trajectory, measured, smoothed, models, choice.tails)
    if choice.raw and choice.knobs.smoothness == 0.0:
        stay |= smoothed.weights[:, None] > 0.0
    path = in_part(path, start.trajectory, np.where(stay, 0.0, 1.0))
    share = choice.knobs.allowed_share(path.poses.rigid, trajectory.poses.rigid)
    path, stay = in_part(path, trajectory, share), stay | (share < 1.0)
    deviations = np.sqrt(smoothed.spread) * [one.noise for one in choice.models]
    parts = np.searchsorted(choice.axes, np.arange(deviations.shape[1]), "right")
    deviations[np.column_stack([stay, np.all(stay, axis=1)])[:, parts]] = np.nan
    weights = np.where(start.mirrored, 0.0, smoothed.weights)
    return AutomaticPath(path, choice, weights, deviations, measured.jumps)
