"""Smoothing in one line: every method on every representation, by name.

A method is a function of a trajectory, a representation and keyword parameters in physical units;
`METHODS` lists them. The docstring of each function, or of the filter that it runs, says what its
parameters mean, where it breaks down and whose it is.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from motorcade.fusion.smoothing.auto import auto
from motorcade.fusion.smoothing.batch import robust_map, spline
from motorcade.fusion.smoothing.causal import (
    constant_acceleration,
    constant_velocity,
    double_exponential,
    exponential,
    one_euro,
    rts_constant_acceleration,
    rts_constant_velocity,
)
from motorcade.fusion.smoothing.representations import representation_named
from motorcade.fusion.smoothing.window import gaussian, local_polynomial, savitzky_golay
from motorcade.ga import Trajectory

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


def smooth(
    trajectory: Trajectory,
    method: str = "auto",
    representation: str = "motor",
    **parameters: Any,
) -> Trajectory:
    """Smooth a trajectory; the result has the same stamps and frames.

    Args:
        trajectory: at any sampling, even or not.
        method: a name of `METHODS`.
        representation: a name of `REPRESENTATIONS`: what the poses are averaged as.
        parameters: of the method, in physical units; see its own docstring.

    Raises:
        ValueError: an unknown method, representation or parameter (the message lists those there
            are), a parameter out of its range, or fewer poses than the method needs.

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
    """
    function = method_named(method)
    known = method_parameters(method)
    for name in parameters:
        if name not in known:
            raise ValueError(
                f"parameters: expected of {method} {', '.join(known) or 'none'}, got {name!r}"
            )
    return function(trajectory, representation_named(representation), **parameters)


def method_named(name: str) -> Method:
    """The function of that name.

    Raises:
        ValueError: a name that is not in `METHODS`; the message lists those that are.
    """
    if name not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, got {name!r}")
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
