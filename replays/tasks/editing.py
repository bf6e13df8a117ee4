"""What `motorcade trajectory` does to trajectories, in one order whatever the order of options.

Which trajectories a command line names (files, and what is read of bags), what one is at a glance,
and where edited ones are written: one file, or a folder of files by their own names.

Errors of evaluated trajectories pair by pair: as rows of a table, and as an image.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.fusion.metrics import (
    Align,
    Delta,
    Matched,
    NotObservableError,
    Plane,
    absolute_errors,
    alignment_of,
    associate,
    cropped,
    relative_errors,
)
from motorcade.fusion.metrics.poses.alignment import checked_offset_ns, folded, projected
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.ga.stamps import GAP_STEPS, inside_gaps, near_steps
from motorcade.ga.trajectory_edits import (
    downsampled,
    inverted,
    merged,
    motion_filtered,
    propagated,
    scaled,
    shifted,
)
from motorcade.replays.io.trajectories import TrajectoryFormat, split_bag_name, write_trajectory

if TYPE_CHECKING:
    from motorcade.render.plots import ErrorsAlong

_HEADER = "estimate,time_ns,distance_m,position_error_m,rotation_error_deg"


def error_rows(matched: Mapping[str, Matched]) -> Iterator[str]:
    """Lines of a CSV file: a header, then a line a pair of each estimate.

    `distance_m` is how far the ground truth has gone since the first pair; stamps are by its clock.

    Examples:
        >>> from motorcade.fusion.metrics import match
        >>> from motorcade.fusion.motions import screw
        >>> from motorcade.replays.tasks.editing import error_rows
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
        >>> from motorcade.replays.tasks.editing import error_image
        >>> path = screw().sampled(10.0, 1.0)
        >>> error_image({"slam": match(path, path)}, Delta()).startswith("<svg")
        True
    """
    # Not at the top: paths are edited and smoothed where nothing is drawn.
    from motorcade.render.plots import plot_errors_along, standing_alone

    start_ns = min(int(one.pairs.time_ns[0]) for one in matched.values())
    along = {name: _along(one, delta, start_ns) for name, one in matched.items()}
    longest = max((one.reference for one in matched.values()), key=len)
    relative = "1 frame" if delta.value == 1 and delta.unit == "frames" else str(delta)
    return standing_alone(
        plot_errors_along(along, longest.motors.translation_m, relative, plane or "")
    )


def _along(matched: Matched, delta: Delta, start_ns: int) -> ErrorsAlong:
    from motorcade.render.plots import ErrorsAlong

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


def trajectory_figures(trajectory: Trajectory) -> dict[str, Any]:
    """Figures of one trajectory, ready for JSON; of similarities, those of the rigid part.

    The two frames (poses are ``parent_T_child``), stamps, length and turning from pose to pose,
    first and last position, least and largest coordinates; and of the steps from pose to pose,
    where there are any, time, speed, turning, and `gaps`: those of more than three median ones.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Trajectory
        >>> from motorcade.replays.tasks.editing import trajectory_figures
        >>> path = Trajectory(10**9 * np.arange(2), Motor.from_translation([[0, 0, 0], [3, 4, 0]]))
        >>> figures = trajectory_figures(path)
        >>> figures["path_length_m"], figures["speed_mean_m_s"]
        (5.0, 5.0)
    """
    path = trajectory.rigid
    place, steps_ns = path.motors.translation_m, np.diff(path.time_ns)
    far = np.linalg.norm(np.diff(place, axis=0), axis=1)
    turned = np.rad2deg((path.motors.rotor[:-1].inverse() @ path.motors.rotor[1:]).angle())
    step_s = steps_ns * 1e-9
    return {
        "parent": path.parent,
        "child": path.child,
        "poses": len(path),
        "start_ns": int(path.time_ns[0]),
        "end_ns": int(path.time_ns[-1]),
        "duration_s": path.duration_s,
        "path_length_m": float(far.sum()),
        "turned_deg": float(turned.sum()),
        "first_m": place[0].tolist(),
        "last_m": place[-1].tolist(),
        "lowest_m": place.min(axis=0).tolist(),
        "highest_m": place.max(axis=0).tolist(),
        **_spread("step_{}_s", step_s),
        "gaps": int(np.count_nonzero(~near_steps(steps_ns))) if steps_ns.size else 0,
        **_spread("speed_{}_m_s", far / step_s),
        "turning_max_deg_s": float((turned / step_s).max()) if steps_ns.size else None,
    }


def _spread(key: str, values: FloatArray) -> dict[str, float | None]:
    """Least, mean and largest value; None of none."""
    names = ("min", "mean", "max")
    return {
        key.format(name): float(getattr(values, name)()) if values.size else None for name in names
    }


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
    edited = {}
    for name, trajectory in trajectories.items():
        with _named(name):
            edited[name] = _thinned(_prepared(trajectory.rigid, edits), edits)
    if edits.merge:
        edited = {"merged": _merged(edited)}
    true = None if reference is None else _thinned(reference.rigid, edits)
    for name, thinned in edited.items():
        with _named(name):
            edited[name] = _placed(name, thinned, edits, true)
    if true is not None and edits.plane is not None:
        true = _flat("the reference", true, edits.plane)
    return edited, true


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


def _merged(trajectories: Mapping[str, Trajectory]) -> Trajectory:
    every = list(trajectories.values())
    first = every[0]
    for name, path in trajectories.items():
        if (path.parent, path.child) != (first.parent, first.child):
            text = "%s: poses %s_T_%s are merged as if they were %s_T_%s"
            _LOG.warning(text, name, path.parent, path.child, first.parent, first.child)
    joined = merged([replace(one, parent=first.parent, child=first.child) for one in every])
    lost = sum(map(len, every)) - len(joined)
    if lost:
        _LOG.warning("merged: %d poses have the stamp of another; the first of each is kept", lost)
    return joined


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


def trajectory_names(
    inputs: Sequence[Path], topics: Sequence[str] = (), *, every_topic: bool = False
) -> list[str]:
    """The names of trajectories of files and bags, as `read_trajectory` takes them.

    Args:
        inputs: files; bags, alone or with what is read of them.
        topics: what is read of each bag that stands alone: topics of poses, or two frames.
        every_topic: read every topic of poses of these.

    Raises:
        RecordingError: a bag that cannot be read.
        ValueError: a trajectory that is named twice, topics without a bag that stands alone, or a
            bag without a topic of poses where every one of them is asked for.

    >>> trajectory_names([Path("run.tum"), Path("flight.bag")], ["/odom", "map/base"])
    ['run.tum', 'flight.bag:/odom', 'flight.bag:map/base']
    """
    bags = [split_bag_name(one) for one in inputs]
    alone = [one is not None and not one[1] for one in bags]
    if topics and not any(alone):
        raise ValueError(f"--topic {topics[0]}: expected a bag without a topic among the inputs")
    names: list[str] = []
    for name, is_alone in zip(inputs, alone, strict=True):
        read = list(_of_bag(name, topics, every_topic)) if is_alone else [str(name)]
        for read_name in read:
            if read_name in names:
                raise ValueError(f"{read_name}: expected each trajectory once, got it twice")
            names.append(read_name)
    return names


def refuse_inputs(names: Iterable[str], files: Iterable[Path]) -> None:
    """Refuse to write over what is read: measured poses cannot be had again.

    Args:
        names: what is read, as `trajectory_names` gives it.
        files: what is written.

    Raises:
        ValueError: a file among both, by whatever path or link.
    """
    bags = ((name, split_bag_name(name)) for name in names)
    read = [Path(name) if bag is None else bag[0] for name, bag in bags]
    for file in files:
        if file.is_file() and any(one.is_file() and one.samefile(file) for one in read):
            raise ValueError(
                f"--output {file}: this is one of the inputs; expected another file or folder"
            )


def _of_bag(bag: Path, topics: Sequence[str], every_topic: bool) -> Iterator[str]:
    """What is read of a bag that stands alone; itself where nothing says what."""
    if topics:
        yield from (f"{bag}:{topic}" for topic in topics)
    elif every_topic:
        from motorcade.replays.io.readers.ros.trajectories import list_bag_trajectories

        listed = list_bag_trajectories(bag).topics
        if not listed:
            raise ValueError(f"{bag}: expected topics of poses, got none")
        yield from (f"{bag}:{topic}" for topic in listed)
    else:
        yield str(bag)


def stem_of(name: str) -> str:
    """What a trajectory's file is called: a file's stem, or what was read of a bag.

    >>> stem_of("runs/estimate.tum"), stem_of("flight.mcap:/tf:map.base_link")
    ('estimate', 'tf_map.base_link')
    """
    named = split_bag_name(name)
    if named is None or not named[1]:
        return Path(name).stem
    return named[1].strip("/").replace(":", "_").replace("/", "_")


def output_files(formats: Mapping[str, TrajectoryFormat | None], output: Path) -> dict[str, Path]:
    """The file of each trajectory: `output` for one, or files in the folder `output`.

    Args:
        formats: of the files in a folder, by the trajectories' names.
        output: a file, or a folder: one that is there, or a name without an ending.

    Raises:
        ValueError: several for one file, no format for a folder, or two of one name.
    """
    known = all(fmt is not None for fmt in formats.values())
    if not (output.is_dir() or (not output.suffix and known)):
        if len(formats) > 1:
            raise ValueError(
                f"{output}: expected a folder for {len(formats)} trajectories, with --format; or "
                "--merge to make one of them"
            )
        return dict.fromkeys(formats, output)
    if not known:
        raise ValueError(f"{output}: expected --format for the files of a folder")
    files = {
        name: output / (stem_of(name) + (".csv" if fmt == "euroc" else f".{fmt}"))
        for name, fmt in formats.items()
    }
    for name, path in files.items():
        others = [one for one, other in files.items() if other == path and one != name]
        if others:
            raise ValueError(f"{path}: expected one trajectory, got {name} and {others[0]}")
    return files


def write_trajectories(
    trajectories: Mapping[str, Trajectory],
    files: Mapping[str, Path],
    formats: Mapping[str, TrajectoryFormat | None],
) -> None:
    """Write each to its file, each whole or not at all.

    Raises OSError: a file or its folder cannot be written.
    """
    for name, path in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_trajectory(trajectories[name], path, formats[name])
