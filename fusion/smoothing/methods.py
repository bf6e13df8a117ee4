"""Smoothing in one line: every method on every representation, by name.

A method is a function of a trajectory, a representation and keyword parameters in physical units;
`METHODS` lists them. The docstring of each function, or of the filter that it runs, says what its
parameters mean, where it breaks down and whose it is.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from typing import Any, Literal, overload

from motorcade.fusion.smoothing.auto import auto
from motorcade.fusion.smoothing.batch.robust_map import robust_map
from motorcade.fusion.smoothing.batch.spline import spline
from motorcade.fusion.smoothing.causal import (
    constant_acceleration,
    constant_velocity,
    double_exponential,
    exponential,
    one_euro,
    rts_constant_acceleration,
    rts_constant_velocity,
)
from motorcade.fusion.smoothing.given import each_path, with_trajectories
from motorcade.fusion.smoothing.representations import Representation, representation_named
from motorcade.fusion.smoothing.results import SmoothingResult, smoothed_in_full
from motorcade.fusion.smoothing.window import gaussian, local_polynomial, savitzky_golay
from motorcade.ga import Trajectory
from motorcade.ga.names import did_you_mean

Method = Callable[..., Trajectory]

METHODS: dict[str, Method] = {
    "auto": auto,
    "exponential": exponential,
    "double_exponential": double_exponential,
    "one_euro": one_euro,
    "constant_velocity": constant_velocity,
    "constant_acceleration": constant_acceleration,
    "rts_constant_velocity": rts_constant_velocity,
    "rts_constant_acceleration": rts_constant_acceleration,
    "gaussian": gaussian,
    "savitzky_golay": savitzky_golay,
    "local_polynomial": local_polynomial,
    "spline": spline,
    "robust_map": robust_map,
}
"""Every method by name; each is called as ``method(trajectory, representation, **parameters)``."""


@overload
def smooth(
    trajectory: Trajectory,
    method: str = ...,
    representation: str | None = ...,
    *,
    time_s: None = ...,
    full: Literal[False] = ...,
    **parameters: Any,
) -> Trajectory: ...
@overload
def smooth(
    trajectory: Trajectory,
    method: str = ...,
    representation: str | None = ...,
    *,
    time_s: None = ...,
    full: Literal[True],
    **parameters: Any,
) -> SmoothingResult: ...
@overload
def smooth(
    trajectory: Any,
    method: str = ...,
    representation: str | None = ...,
    *,
    time_s: Any = ...,
    full: bool = ...,
    **parameters: Any,
) -> Any: ...
def smooth(
    trajectory: Any,
    method: str = "auto",
    representation: str | None = None,
    *,
    time_s: Any = None,
    full: bool = False,
    **parameters: Any,
) -> Any:
    """Smooth poses; the result comes as they did, with the same stamps and frames.

    Args:
        trajectory: at any sampling, even or not: a Trajectory, an array ``(N, 7)`` of
            x, y, z, qx, qy, qz, qw or ``(N, 4, 4)``, scipy's Rotation or RigidTransform, a pandas
            DataFrame, evo's PoseTrajectory3D, a torch tensor, gtsam's poses; several at once as a
            dict or a stack. See `motorcade.fusion.smoothing.given`.
        method: a name of `METHODS`.
        representation: a name of `REPRESENTATION_NAMES`: what the poses are averaged as; by default
            motors, of "auto" what predicts better.
        time_s: ``(N,)`` seconds or datetimes, for poses that come without stamps.
        full: give a `SmoothingResult` instead, which holds the smoothed poses, covariances, rates,
            weights, what "auto" chose, and the curve that resamples them; of several bodies a dict
            or a list of them.
        parameters: of the method, in physical units; see its own docstring.

    Raises:
        ValueError: an unknown method, representation or parameter (the message lists those there
            are), a parameter out of its range, fewer poses than the method needs, or stamps that
            are missing or do not fit.
        TypeError: poses of a kind that is not known, or a parameter that is not of its kind.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> from motorcade.fusion.motions.degradations import Gaussian
        >>> from motorcade.fusion import evaluate, smooth
        >>> rng = np.random.default_rng(0)
        >>> true = handheld(rng).sampled(rate_hz=30.0, duration_s=4.0)  # world_T_camera
        >>> noisy = Gaussian(sigma_m=0.01, sigma_rad=0.02).apply(true, rng)
        >>> for path in (noisy, smooth(noisy, "rts_constant_velocity", acceleration_m_s2=2.0)):
        ...     print(f"{1e3 * evaluate(path, true).ape_m.rmse:.1f} mm")
        17.5 mm
        11.9 mm
        >>> rows = np.column_stack([noisy.motors.translation_m, np.tile([0, 0, 0, 1.0], (121, 1))])
        >>> smooth(rows, time_s=noisy.time_s).shape  # an array in, an array out
        (121, 7)
    """
    function = method_named(method)
    known = method_parameters(method)
    for name in parameters:
        if name not in known:
            raise ValueError(
                f"parameters: expected of {method} {', '.join(known) or 'none'}, got {name!r}; "
                + did_you_mean(name, known)
            )

    def averaged_as(path: Trajectory) -> Representation | None:
        if representation is None and function is auto:
            return None
        return representation_named(representation or "motor", path.poses)

    if full:
        return each_path(
            trajectory,
            time_s,
            lambda poses: smoothed_in_full(
                poses, method, averaged_as(poses.trajectory), function, known | parameters
            ),
        )
    return with_trajectories(
        trajectory, time_s, lambda path: function(path, averaged_as(path), **parameters)
    )


def method_named(name: str) -> Method:
    """The function of that name.

    Raises:
        ValueError: a name that is not in `METHODS`; the message lists those that are.
        TypeError: no name.
    """
    if not isinstance(name, str):
        raise TypeError(f"method: expected a name of METHODS, got {type(name).__name__}")
    if name not in METHODS:
        near = did_you_mean(name, METHODS)
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, got {name!r}; {near}")
    return METHODS[name]


def method_parameters(name: str) -> dict[str, Any]:
    """Parameters of a method with their defaults, in the order of its signature.

    Examples:
        >>> from motorcade.fusion.smoothing import method_parameters
        >>> method_parameters("gaussian")
        {'sigma_s': 0.1, 'truncate': 4.0, 'order': 1}
    """
    signature = inspect.signature(method_named(name))
    return {
        parameter.name: parameter.default
        for parameter in signature.parameters.values()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    }


def parsed_parameters(
    name: str, settings: Iterable[str], called: str = "parameters"
) -> dict[str, Any]:
    """``["sigma_s=0.1", ...]`` as parameters of a method, each read as its default is written.

    Args:
        name: of the method.
        settings: name=value each.
        called: what messages call the settings.

    Raises:
        ValueError: an unknown method or parameter, or a value of the wrong kind.

    Examples:
        >>> from motorcade.fusion.smoothing.methods import parsed_parameters
        >>> parsed_parameters("gaussian", ["sigma_s=0.2", "order=0"])
        {'sigma_s': 0.2, 'order': 0}
    """
    known, parameters = method_parameters(name), dict[str, Any]()
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or key not in known:
            raise ValueError(
                f"{called}: expected name=value, names of {name}: {', '.join(known)}; got "
                f"{setting!r}; {did_you_mean(key, known)}"
            )
        kind = float if known[key] is None else type(known[key])
        try:
            parameters[key] = kind(text)
        except ValueError:
            raise ValueError(f"{called} {key}: expected {kind.__name__}, got {text!r}") from None
    return parameters
