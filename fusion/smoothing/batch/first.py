"""The first path of `method="auto"`: its jumps, its stamps, and the axes that predict best."""

from __future__ import annotations

from dataclasses import replace

from motorcade.fusion.smoothing.batch.jumps import with_jumps
from motorcade.fusion.smoothing.batch.per_axis import (
    HEAVY_TAILS,
    Measured,
    PerAxisPath,
    chosen_models,
    smoothed_per_axis,
)
from motorcade.fusion.smoothing.batch.start import PathStart, even_stamps
from motorcade.fusion.smoothing.representations import (
    REPRESENTATIONS,
    Representation,
    restored,
)

FIRST_STEPS = 3
_BODY = "motor"
# A changing acceleration tells stamps and axes from each other as well as any order that is chosen.
_FIRST_ORDER = (2,)
# By how much the logarithm of poses must be likelier with even stamps for these to be taken.
_LIKELIER = 10.0


def first_path(
    start: PathStart, representation: Representation
) -> tuple[bool, Measured, PerAxisPath]:
    """A first path with its jumps, and whether stamps are taken for even for it."""
    measured, path = start.written(representation)
    models = chosen_models(measured, path, start.weights, _FIRST_ORDER)
    even, even_s = False, even_stamps(measured.time_s)
    if even_s is not None:
        in_step = replace(measured, time_s=even_s)
        others = chosen_models(in_step, path, start.weights, _FIRST_ORDER)
        even = others.score - _LIKELIER > models.score
        measured, models = (in_step, others) if even else (measured, models)
    measured, models = with_jumps(measured, path, start.weights, models)
    found = smoothed_per_axis(measured, path, start.weights, models, HEAVY_TAILS, FIRST_STEPS)
    return even, measured, found


def in_better_axes(
    start: PathStart, measured: Measured, found: PerAxisPath
) -> tuple[Measured, PerAxisPath]:
    """The same in axes of the body, where these predict better."""
    body = REPRESENTATIONS[_BODY]
    path = body.coordinates(
        restored(measured.representation, found.coordinates, start.trajectory).poses
    )
    turned = replace(start.measured(body, path), time_s=measured.time_s, jumps=measured.jumps)
    world = chosen_models(measured, found.coordinates, found.weights, _FIRST_ORDER)
    if chosen_models(turned, path, found.weights, _FIRST_ORDER).score <= world.score:
        return measured, found
    return turned, replace(found, coordinates=path)
