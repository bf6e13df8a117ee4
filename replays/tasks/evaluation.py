"""Errors of evaluated trajectories pair by pair: as rows of a table, and as an image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from motorcade.fusion.metrics import (
    Delta,
    Matched,
    NotObservableError,
    Plane,
    absolute_errors,
    relative_errors,
)
from motorcade.ga.arrays import FloatArray
from motorcade.render.plots import ErrorsAlong, plot_errors_along, standing_alone

_HEADER = "estimate,time_ns,distance_m,position_error_m,rotation_error_deg"


def error_rows(matched: Mapping[str, Matched]) -> Iterator[str]:
    """Lines of a CSV file: a header, then a line a pair of each estimate.

    `distance_m` is how far the ground truth has gone since the first pair; stamps are by its clock.

    Examples:
        >>> from motorcade.fusion.metrics import match
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.replays.tasks.evaluation import error_rows
        >>> path = screw().sampled(10.0, 1.0)
        >>> header, first, *rest = error_rows({"slam": match(path, path)})
        >>> header.split(",")[:2], first.split(",")[:3], len(rest)
        (['estimate', 'time_ns'], ['slam', '0', '0.0'], 10)
    """
    yield _HEADER
    for name, match in matched.items():
        ours, true = match.pairs.estimate, match.pairs.reference
        steps = np.linalg.norm(np.diff(true.translation_m, axis=0), axis=-1)
        columns = (
            match.pairs.time_ns,
            np.concatenate([[0.0], np.cumsum(steps)]),
            absolute_errors(ours, true, "trans_part"),
            absolute_errors(ours, true, "angle_deg"),
        )
        for row in zip(*(column.tolist() for column in columns), strict=True):
            yield (
                f'"{name}",{",".join(map(repr, row))}'
                if "," in name
                else ",".join([name, *map(repr, row)])
            )


def error_image(matched: Mapping[str, Matched], delta: Delta, plane: Plane | None = None) -> str:
    """Errors over time and along the way, as an SVG file.

    Args:
        matched: estimates by their names, beside one ground truth.
        delta: what relative errors are over.
        plane: of the maps; where it is None, the one in which the ground truth goes farthest.

    Examples:
        >>> from motorcade.fusion.metrics import Delta, match
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.replays.tasks.evaluation import error_image
        >>> path = screw().sampled(10.0, 1.0)
        >>> error_image({"slam": match(path, path)}, Delta()).startswith("<svg")
        True
    """
    start_ns = min(int(one.pairs.time_ns[0]) for one in matched.values())
    along = {name: _along(one, delta, start_ns) for name, one in matched.items()}
    longest = max((one.reference for one in matched.values()), key=len)
    relative = "1 frame" if delta.value == 1 and delta.unit == "frames" else str(delta)
    return standing_alone(
        plot_errors_along(along, longest.motors.translation_m, relative, plane or "")
    )


def _along(matched: Matched, delta: Delta, start_ns: int) -> ErrorsAlong:
    ours, true = matched.pairs.estimate, matched.pairs.reference
    time_s: FloatArray = np.asarray((matched.pairs.time_ns - start_ns) * 1e-9, dtype=np.float64)
    try:
        _, last = delta.ends(ours, true)
        (relative_m,) = relative_errors(ours, true, delta, ("trans_part",))
    except NotObservableError:  # too short a path: the panel stays empty, as the figure is None
        last, relative_m = np.zeros(0, dtype=np.int64), np.zeros(0)
    in_time = np.argsort(last, kind="stable")
    return ErrorsAlong(
        time_s=time_s,
        path_m=ours.translation_m,
        position_m=absolute_errors(ours, true, "trans_part"),
        rotation_deg=absolute_errors(ours, true, "angle_deg"),
        relative_time_s=time_s[last[in_time]],
        relative_m=relative_m[in_time],
    )
