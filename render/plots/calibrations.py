"""What calibrations find: Allan deviation and its noise model, corners and their reprojections."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import style

Curve = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]


def plot_allan(curves: Mapping[str, Curve], unit_of: Mapping[str, str]) -> str:
    """`curves` maps a sensor's name to (times (K,) in s, deviation (K, 3), model (K, 3)).

    Measured deviations are dots, the model is a line; `unit_of` gives the sensor's unit. Returns an
    `<svg>` element, a panel a sensor.
    """
    with style.house_style():
        figure, panels = style.new_figure(9.0, 3.6, columns=len(curves))
        for axes, (name, (tau_s, deviation, model)) in zip(panels, curves.items(), strict=True):
            for column, (axis, colour) in enumerate(zip("xyz", style.AXIS_COLOURS, strict=True)):
                axes.plot(tau_s, model[:, column], color=colour, linewidth=1.0)
                axes.plot(tau_s, deviation[:, column], "o", color=colour, markersize=3, label=axis)
            axes.set_xscale("log")
            axes.set_yscale("log")
            style.label_plainly(axes.xaxis)
            axes.set_title(name)
            axes.set_xlabel("averaging time (s)")
            axes.set_ylabel(f"Allan deviation ({unit_of[name]})")
            axes.legend(loc="best", fontsize=8)
        return style.as_svg(figure, f"Allan deviation of {' and '.join(curves)}")


_CELLS = (8, 6)


def plot_coverage(
    size: tuple[int, int],
    corners_px: FloatArray,
    residuals_px: FloatArray,
    left_out_px: FloatArray,
    title: str,
) -> bytes:
    """Draw a PNG image: corners with their residuals, enlarged, and the residuals by themselves.

    Args:
        size: width and height of the camera's image, pixels.
        corners_px: ``(N, 2)`` corners that were used.
        residuals_px: ``(N, 2)`` reprojection minus corner.
        left_out_px: ``(M, 2)`` corners of views that were not used.
        title: stands above.
    """
    import matplotlib as mpl

    lengths = np.linalg.norm(residuals_px, axis=-1)
    usual = max(float(np.percentile(lengths, 95)), 1e-6)
    enlarged = 10 ** np.floor(np.log10(0.04 * size[0] / usual))
    with style.house_style(), mpl.rc_context(_light()):
        figure, (left, right) = style.new_figure(11.0, 4.6, columns=2)
        figure.suptitle(title, x=0.01, ha="left")
        if len(left_out_px):
            left.plot(
                *left_out_px.T, "x", color=style.COLOURS["euler"], markersize=3, label="left out"
            )
        left.quiver(
            *corners_px.T,
            *(residuals_px * enlarged).T,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.0015,
            color=style.COLOURS["dual_quaternion"],
        )
        left.plot(*corners_px.T, ".", color=style.COLOURS["motor"], markersize=2, label="used")
        left.set(
            xlim=(-0.5, size[0] - 0.5),
            ylim=(size[1] - 0.5, -0.5),
            aspect="equal",
            xticks=np.linspace(0, size[0], _CELLS[0] + 1),
            yticks=np.linspace(0, size[1], _CELLS[1] + 1),
            title=f"corners in the image; residuals {enlarged:g} times enlarged",
        )
        left.xaxis.set_major_formatter("{x:.0f}")
        left.yaxis.set_major_formatter("{x:.0f}")
        left.legend(loc="upper left", markerscale=3)
        right.plot(*residuals_px.T, ".", color=style.COLOURS["motor"], markersize=2)
        reach = 1.1 * float(np.abs(residuals_px).max(initial=1e-6))
        right.set(
            xlim=(-reach, reach),
            ylim=(reach, -reach),
            aspect="equal",
            xlabel="column, px",
            ylabel="row, px",
            title="residuals",
        )
        data = io.BytesIO()
        figure.savefig(data, format="png", dpi=110, metadata={"Software": None})
    return data.getvalue()


def _light() -> Any:
    """Matplotlib settings for a white page, in place of colours that a page would set."""
    ink = ("axes.labelcolor", "axes.titlecolor", "legend.labelcolor", "text.color")
    return {
        **dict.fromkeys((*ink, "xtick.color", "ytick.color"), "#222222"),
        **dict.fromkeys(("axes.edgecolor", "grid.color"), "#dddddd"),
        **dict.fromkeys(("axes.facecolor", "figure.facecolor"), "#ffffff"),
    }
