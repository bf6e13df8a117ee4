"""What `motorcade trajectory` does to trajectories, in one order whatever the order of options."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from motorcade.fusion.metrics import Align, Plane, alignment_of, associate, cropped
from motorcade.fusion.metrics.poses.association import checked_offset_ns
from motorcade.fusion.metrics.poses.projection import folded, projected
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.stamps import GAP_STEPS, inside_gaps
from motorcade.ga.trajectory_edits import (
    downsampled,
    inverted,
    merged,
    motion_filtered,
    propagated,
    scaled,
    shifted,
)

_LOG = logging.getLogger("motorcade.replays")


@dataclass(frozen=True, eq=False)
class TrajectoryEdits:
    """Edits, in the order in which they are done; without any, trajectories stay as they are.

    Args:
        invert: take the poses for ``child_T_parent``.
        scale: factor of the positions.
        start_s: where the part that is kept begins, in seconds of the trajectory's own clock.
        end_s: where it ends.
        downsample: keep so many poses at most, evenly spaced; of the reference, too.
        motion_filter: keep poses this far apart, (metres of path, degrees); of the reference, too.
        merge: make one trajectory of all, by their stamps.
        offset_s: what is added to the stamps.
        resample_hz: poses at even stamps instead; gaps of more than ten seconds stay.
        max_gap_s: of resampling: leave out what lies between poses that are farther apart. Without
            it the log says how many poses lie in gaps.
        resample_as: poses at this trajectory's stamps instead, where there are poses around them.
        align: how each is brought into the reference's world (`fusion.metrics.alignment_of`).
        n_to_align: of how many pairs, from the first (all).
        max_difference_s: how far apart paired stamps may be.
        interpolate: pair poses with interpolated ones of the longer trajectory.
        paired: keep only the poses that have a partner in the reference, as evo does.
        left: ``left @ pose``: moves the world; of a similarity the scale goes to the positions.
        right: ``pose @ right``: moves the frame that moves.
        propagate: apply `right` to each step rather than to each pose: growing drift.
        plane: project poses to a plane of the world; of the reference, too.

    Examples:
        >>> from motorcade.ga import Motor
        >>> from motorcade.replays.tasks.editing import TrajectoryEdits
        >>> map_T_world = Motor.from_translation([0.0, 0.0, 1.0])
        >>> TrajectoryEdits(left=map_T_world, plane="xy").plane
        'xy'
    """

    invert: bool = False
    scale: float = 1.0
    start_s: float | None = None
    end_s: float | None = None
    downsample: int | None = None
    motion_filter: tuple[float, float] | None = None
    merge: bool = False
    offset_s: float = 0.0
    resample_hz: float | None = None
    resample_as: Trajectory | None = None
    max_gap_s: float | None = None
    align: Align = "none"
    n_to_align: int | None = None
    max_difference_s: float = 0.01
    interpolate: bool = False
    paired: bool = False
    left: Motor | Similarity | None = None
    right: Motor | Similarity | None = None
    propagate: bool = False
    plane: Plane | None = None


def edit_trajectories(
    trajectories: Mapping[str, Trajectory],
    edits: TrajectoryEdits,
    reference: Trajectory | None = None,
) -> tuple[dict[str, Trajectory], Trajectory | None]:
    """Edit named trajectories; gives them and the reference, which is thinned and projected alike.

    Args:
        trajectories: rigid, or similarities, whose positions are taken.
        edits: what is done.
        reference: for `align`, `paired` and the plane.

    Returns:
        The trajectories, one called "merged" where they are merged, and the reference.

    Raises:
        ValueError: edits that need a reference without one, that exclude each other, or that leave
            no pose; the message begins with the trajectory's name.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.replays.tasks.editing import TrajectoryEdits, edit_trajectories
        >>> path = Trajectory(np.arange(9), Motor.identity((9,)))
        >>> found, _ = edit_trajectories({"a": path}, TrajectoryEdits(downsample=3))
        >>> found["a"].time_ns
        array([0, 4, 8])
    """
    _check(edits, reference)
    found = {}
    for name, one in trajectories.items():
        with _named(name):
            found[name] = _thinned(_prepared(one.rigid, edits), edits)
    if edits.merge:
        found = {"merged": _merged(found)}
    true = None if reference is None else _thinned(reference.rigid, edits)
    for name, one in found.items():
        with _named(name):
            found[name] = _placed(name, one, edits, true)
    if true is not None and edits.plane is not None:
        true = _flat("the reference", true, edits.plane)
    return found, true


def _check(edits: TrajectoryEdits, reference: Trajectory | None) -> None:
    if reference is None and (edits.align != "none" or edits.paired):
        asked = "align" if edits.align != "none" else "paired"
        raise ValueError(f"{asked}: expected a reference, got none")
    if edits.resample_hz is not None and edits.resample_as is not None:
        raise ValueError("resample: expected a rate or another's stamps, got both")
    if edits.max_gap_s is not None and edits.resample_hz is None and edits.resample_as is None:
        raise ValueError("max_gap_s: expected resample_hz or resample_as, got neither")
    if edits.propagate and not isinstance(edits.right, Motor):
        raise ValueError("propagate: expected a rigid right transform, got none")
    if edits.interpolate and not edits.paired and edits.align == "none":
        raise ValueError("interpolate: expected align or paired, got neither")
    if edits.n_to_align is not None and edits.align == "none":
        raise ValueError("n_to_align: expected align, got none")


def _prepared(path: Trajectory, edits: TrajectoryEdits) -> Trajectory:
    if edits.invert:
        path = inverted(path)
    if edits.scale != 1.0:
        path = scaled(path, edits.scale)
    if edits.start_s is not None or edits.end_s is not None:
        path = cropped(path, edits.start_s, edits.end_s)
    return path


def _thinned(path: Trajectory, edits: TrajectoryEdits) -> Trajectory:
    if edits.downsample is not None:
        path = downsampled(path, edits.downsample)
    if edits.motion_filter is not None:
        distance_m, angle_deg = edits.motion_filter
        path = motion_filtered(path, distance_m, radians(angle_deg))
    return path


def _merged(found: Mapping[str, Trajectory]) -> Trajectory:
    every = list(found.values())
    first = every[0]
    for name, one in found.items():
        if (one.parent, one.child) != (first.parent, first.child):
            text = "%s: poses %s_T_%s are merged as if they were %s_T_%s"
            _LOG.warning(text, name, one.parent, one.child, first.parent, first.child)
    made = merged([replace(one, parent=first.parent, child=first.child) for one in every])
    lost = sum(map(len, every)) - len(made)
    if lost:
        _LOG.warning("merged: %d poses have the stamp of another; the first of each is kept", lost)
    return made


def _placed(
    name: str, path: Trajectory, edits: TrajectoryEdits, reference: Trajectory | None
) -> Trajectory:
    """Stamps, then the world, then the plane."""
    path = shifted(path, checked_offset_ns(edits.offset_s))
    measured = path
    if edits.resample_hz is not None:
        path = path.at_rate(edits.resample_hz)
    if edits.resample_as is not None:
        path = _resampled(path, edits.resample_as)
    if path is not measured:
        path = _outside_gaps(name, path, measured, edits.max_gap_s)
    if reference is not None and (edits.align != "none" or edits.paired):
        path = _aligned(path, edits, reference)
    path = path.transformed_by(left=edits.left).rigid
    if edits.propagate and isinstance(edits.right, Motor):
        path = propagated(path, edits.right)
    else:
        path = path.transformed_by(right=edits.right).rigid
    return path if edits.plane is None else _flat(name, path, edits.plane)


def _resampled(path: Trajectory, other: Trajectory) -> Trajectory:
    inside = (other.time_ns >= path.time_ns[0]) & (other.time_ns <= path.time_ns[-1])
    if not inside.any():
        raise ValueError(
            f"resample: expected stamps from {path.time_ns[0]} to {path.time_ns[-1]} ns, got those "
            f"from {other.time_ns[0]} to {other.time_ns[-1]} ns"
        )
    return path.resampled(other.time_ns[inside])


def _outside_gaps(
    name: str, path: Trajectory, measured: Trajectory, max_gap_s: float | None
) -> Trajectory:
    """What is not invented in a gap; all, and a word, where nobody says how long one may be."""
    usual_s = float(np.median(np.diff(measured.time_ns))) * 1e-9 if len(measured) > 1 else 1.0
    longest_s = GAP_STEPS * usual_s if max_gap_s is None else max_gap_s
    bad = inside_gaps(path.time_ns, measured.time_ns, longest_s)
    if not np.any(bad):
        return path
    said = f"{name}: {np.count_nonzero(bad)} of {len(path)} poses lie in gaps of more than"
    if max_gap_s is None:
        _LOG.warning(
            "%s %.3g s, where nothing was measured; max_gap_s (--max-gap-s) leaves them out",
            said,
            longest_s,
        )
        return path
    _LOG.warning("%s %g s and are left out", said, longest_s)
    return path[~bad]


def _aligned(path: Trajectory, edits: TrajectoryEdits, reference: Trajectory) -> Trajectory:
    pairs = associate(path, reference, edits.max_difference_s, interpolate=edits.interpolate)
    alignment = alignment_of(pairs, edits.align, edits.n_to_align)
    if not edits.paired:
        return alignment.apply_to(path)
    stamps, first = np.unique(pairs.time_ns, return_index=True)
    poses = alignment.apply(pairs.estimate[first])
    return Trajectory(stamps, poses, path.parent, path.child)


def _flat(name: str, path: Trajectory, plane: Plane) -> Trajectory:
    back = int(np.count_nonzero(folded(path.motors, plane)))
    if back:
        text = "%s: %d of %d poses face backwards in %s, where the angle is folded to within 90°"
        _LOG.warning(text, name, back, len(path), plane)
    return replace(path, poses=projected(path.motors, plane))


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Errors begin with the trajectory's name."""
    try:
        yield
    except ValueError as fault:
        raise ValueError(f"{name}: {fault}") from fault
