"""`motorcade evaluate`: errors of estimated trajectories against a reference."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast, get_args

from motorcade.replays.cli.arguments import (
    Commands,
    add_stamps,
    check_known,
    chosen,
    shown,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.fusion.metrics import Delta, Evaluation, Matched, Relation
    from motorcade.ga import Trajectory


Figures = Mapping[str, float | int | str | None]

_FIRST = frozenset(
    {
        "align",
        "pairs",
        "scale",
        "ape_rmse_m",
        "ape_max_m",
        "rotation_rmse_deg",
        "rotation_max_deg",
        "rpe_delta",
        "rpe_delta_unit",
        "rpe_pairs",
        "rpe_trans_rmse_m",
        "rpe_rot_rmse_deg",
        "drift_translation_percent",
        "drift_rotation_deg_100m",
        "linear_jitter_m_s2",
        "angular_jitter_rad_s2",
        "lag_ms",
        "angular_rate_lag_ms",
    }
)
"""Figures that are printed, where there are any, if not all are asked for."""


def add_evaluate(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        evaluate_files,
        "evaluate",
        "absolute and relative pose error, jitter, lag and artifacts against a reference",
        "motorcade evaluate estimate.tum truth.tum --align se3 --json errors.json\n"
        "  motorcade evaluate orb.txt vins.txt truth.tum --align sim3 --delta 5 --delta-unit m",
    )
    parser.add_argument(
        "estimates", type=Path, nargs="+", metavar="EST", help="TUM, EuRoC or KITTI files"
    )
    parser.add_argument("reference", type=Path, metavar="REF", help="the same: the ground truth")
    add_stamps(parser)
    _add_pairs_to(parser)
    _add_alignment_to(parser)
    _add_relative_to(parser)
    parser.add_argument(
        "--energy-above-hz",
        type=float,
        default=5.0,
        help="cut-off of the spectral energy (5 Hz, or a quarter of a slow rate)",
    )
    parser.add_argument(
        "--all", action="store_true", help="print every figure, not only those that matter most"
    )
    parser.add_argument(
        "--json",
        type=Path,
        metavar="FILE",
        help="write all results there; of several estimates by their names",
    )
    parser.add_argument(
        "--errors", type=Path, metavar="FILE", help="write the errors of every pair there, as CSV"
    )
    parser.add_argument(
        "--plot",
        type=Path,
        metavar="FILE.svg",
        help="draw errors over time, and maps of the estimates coloured by their position error",
    )


def _add_pairs_to(parser: argparse.ArgumentParser) -> None:
    pairs = parser.add_argument_group("pairs of poses")
    pairs.add_argument(
        "--max-difference-s",
        type=float,
        default=0.01,
        help="stamps farther apart are not paired (0.01 s)",
    )
    pairs.add_argument(
        "--offset-s",
        type=float,
        default=0.0,
        help="add this to the estimates' stamps to have the reference's clock (0)",
    )
    pairs.add_argument("--start-s", type=float, help="leave out the reference before this stamp")
    pairs.add_argument("--end-s", type=float, help="leave out the reference after this stamp")
    pairs.add_argument(
        "--interpolate",
        action="store_true",
        help="take the trajectory with more poses at the stamps of the other one",
    )
    pairs.add_argument(
        "--max-gap-s",
        type=float,
        metavar="S",
        help="of --interpolate: leave out what lies in longer gaps (none is left out)",
    )
    pairs.add_argument(
        "--rows",
        type=int,
        metavar="FROM",
        help="of KITTI files: the reference's row (from 0) of the estimates' first pose",
    )


def _add_alignment_to(parser: argparse.ArgumentParser) -> None:
    alignment = parser.add_argument_group("alignment")
    alignment.add_argument(
        "--align",
        choices=("none", "se3", "sim3", "yaw", "scale", "origin", "scaled_origin"),
        default="none",
        help="fit the estimate to the reference first: rigidly, with scale, by heading and place "
        "(where gravity tells both up), by scale alone, or by the first pose, as it is or scaled "
        "(none)",
    )
    alignment.add_argument(
        "--n-to-align", type=int, metavar="N", help="fit the first N pairs only (all)"
    )
    alignment.add_argument(
        "--project", choices=("xy", "xz", "yz"), help="project both to a plane after alignment"
    )


def _add_relative_to(parser: argparse.ArgumentParser) -> None:
    relative = parser.add_argument_group("errors")
    relative.add_argument(
        "--relations",
        metavar="NAMES",
        help="evo's pose relations to report beside, or all: full, trans_part, rot_part, "
        "angle_deg, angle_rad, point_distance, point_distance_error_ratio",
    )
    relative.add_argument(
        "--delta", type=float, default=1.0, metavar="D", help="of the relative pose error (1)"
    )
    relative.add_argument(
        "--delta-unit", choices=("frames", "m", "deg", "rad"), default="frames", help="(frames)"
    )
    relative.add_argument(
        "--all-pairs",
        action="store_true",
        help="from every pose on, rather than each from where the one before ended",
    )
    relative.add_argument(
        "--delta-tolerance",
        type=float,
        default=0.1,
        metavar="SHARE",
        help="of all pairs: by what share of the delta they may miss it (0.1)",
    )
    relative.add_argument(
        "--pairs-from",
        choices=("reference", "estimate"),
        default="reference",
        help="whose metres and degrees are counted (reference; evo's default is the estimate)",
    )
    relative.add_argument(
        "--rpe-length-m",
        type=float,
        default=1.0,
        help="length of path for the relative error by length (1 m)",
    )
    relative.add_argument(
        "--drift",
        metavar="LENGTHS",
        help="KITTI's drift over these lengths in metres: 5,10,20, or kitti for 100,200,…,800",
    )


def evaluate_files(arguments: argparse.Namespace) -> None:
    """Read all, evaluate, print a table."""
    from motorcade.replays.io.files import write_bytes
    from motorcade.replays.io.trajectories import check_rows, read_trajectory

    if arguments.plot is not None and arguments.plot.suffix != ".svg":
        raise ValueError(f"--plot: expected a name ending in .svg, got {arguments.plot}")
    stamps = {"rate_hz": arguments.rate_hz, "times": arguments.times}
    reference = read_trajectory(arguments.reference, **stamps)
    matched: dict[str, Matched] = {}
    for name, path in zip(_names(arguments.estimates), arguments.estimates, strict=True):
        estimate = read_trajectory(path, **stamps, first_row=arguments.rows)
        if arguments.rows is None:
            check_rows({path: estimate, arguments.reference: reference})
        matched[name] = _matched(arguments, estimate, reference)
    delta = _delta(arguments)
    evaluations = {name: _evaluated(one, delta, arguments) for name, one in matched.items()}
    figures = {name: one.as_dict() for name, one in evaluations.items()}
    for line in _table(figures, None if arguments.all else _printed(evaluations)):
        print(line)
    (only, *more) = figures.values()
    write_json(arguments.json, figures if more else only)
    if arguments.errors is not None:
        from motorcade.replays.tasks.evaluation import error_rows

        write_bytes(arguments.errors, "\n".join([*error_rows(matched), ""]).encode())
    if arguments.plot is not None:
        from motorcade.replays.tasks.evaluation import error_image

        write_bytes(arguments.plot, error_image(matched, delta, arguments.project).encode())


def _matched(arguments: argparse.Namespace, estimate: Trajectory, reference: Trajectory) -> Matched:
    from motorcade.fusion.metrics import match

    return match(
        estimate,
        reference,
        arguments.align,
        plane=arguments.project,
        **chosen(
            arguments,
            *("max_difference_s", "offset_s", "start_s", "end_s", "interpolate", "max_gap_s"),
            "n_to_align",
        ),
    )


def _delta(arguments: argparse.Namespace) -> Delta:
    from motorcade.fusion.metrics import Delta

    return Delta(
        arguments.delta,
        arguments.delta_unit,
        arguments.all_pairs,
        arguments.delta_tolerance,
        arguments.pairs_from,
    )


def _evaluated(matched: Matched, delta: Delta, arguments: argparse.Namespace) -> Evaluation:
    from motorcade.fusion.metrics import evaluate_matched

    return evaluate_matched(
        matched,
        arguments.rpe_length_m,
        arguments.energy_above_hz,
        delta=delta,
        relations=_relations(arguments.relations),
        drift_lengths_m=_lengths_m(arguments.drift),
    )


def _relations(names: str | None) -> tuple[Relation, ...]:
    from motorcade.fusion.metrics import Relation

    known = get_args(Relation)
    if names is None or names == "all":
        return known if names else ()
    wanted = tuple(name.strip() for name in names.split(","))
    check_known("--relations", wanted, known)
    return cast("tuple[Relation, ...]", wanted)


def _lengths_m(text: str | None) -> tuple[float, ...]:
    from motorcade.fusion.metrics import KITTI_LENGTHS_M

    if text is None or text == "kitti":
        return KITTI_LENGTHS_M if text else ()
    try:
        return tuple(float(length) for length in text.split(","))
    except ValueError:
        raise ValueError(
            f"--drift: expected kitti, or lengths in metres as 5,10,20, got {text!r}"
        ) from None


def _names(paths: Sequence[Path]) -> list[str]:
    """Short names for estimates: those of the files, or the whole paths where these are alike."""
    short = [path.stem for path in paths]
    names = short if len(set(short)) == len(short) else [str(path) for path in paths]
    if len(set(names)) < len(names):
        raise ValueError(f"EST: expected each file once, got {', '.join(names)}")
    return names


def _printed(evaluations: Mapping[str, Evaluation]) -> frozenset[str]:
    asked = {
        f"{error}_{statistic}{unit}"
        for evaluation in evaluations.values()
        for error, unit, _ in evaluation.relations
        for statistic in ("rmse", "max")
    }
    return _FIRST | asked


def _table(figures: Mapping[str, Figures], printed: frozenset[str] | None) -> Iterator[str]:
    """A row a figure, a column an estimate; those that no estimate has only where all are asked."""
    keys = dict.fromkeys(key for one in figures.values() for key in one)
    rows = {key: [one.get(key) for one in figures.values()] for key in keys}
    if printed is not None:
        rows = {
            key: row
            for key, row in rows.items()
            if key in printed and any(value is not None for value in row)
        }
    key_width = max(30, *map(len, rows))
    if len(figures) == 1:
        for key, (value,) in rows.items():
            yield f"{key:>{key_width}}  {shown(value)}"
        return
    widths = [max(15, len(name)) for name in figures]
    lines: list[tuple[str, Sequence[float | str | None]]] = [("", list(figures)), *rows.items()]
    for key, cells in lines:
        aligned = (f"{shown(cell):>{w}}" for cell, w in zip(cells, widths, strict=True))
        yield "  ".join([f"{key:>{key_width}}", *aligned])
