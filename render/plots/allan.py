"""Allan deviation over averaging time, with the noise model that was fitted to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from motorcade.render.plots.style import (
    AXIS_COLOURS,
    as_svg,
    house_style,
    label_plainly,
    new_figure,
)

Curve = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]


def plot_allan(curves: Mapping[str, Curve], unit_of: Mapping[str, str]) -> str:
    """`curves` maps a sensor's name to (times (K,) in s, deviation (K, 3), model (K, 3)).

    Measured deviations are dots, the model is a line; `unit_of` gives the sensor's unit. Returns an
    `<svg>` element, a panel a sensor.
    """
    with house_style():
        figure, panels = new_figure(9.0, 3.6, columns=len(curves))
        for axes, (name, (tau_s, deviation, model)) in zip(panels, curves.items(), strict=True):
            for column, (axis, colour) in enumerate(zip("xyz", AXIS_COLOURS, strict=True)):
                axes.plot(tau_s, model[:, column], color=colour, linewidth=1.0)
                axes.plot(tau_s, deviation[:, column], "o", color=colour, markersize=3, label=axis)
            axes.set_xscale("log")
            axes.set_yscale("log")
            label_plainly(axes.xaxis)
            axes.set_title(name)
            axes.set_xlabel("averaging time (s)")
            axes.set_ylabel(f"Allan deviation ({unit_of[name]})")
            axes.legend(loc="best", fontsize=8)
        return as_svg(figure, f"Allan deviation of {' and '.join(curves)}")
