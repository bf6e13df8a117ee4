"""Commands that judge: `motorcade evaluate`, `compare`, `consistency`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, get_args

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_executor,
    add_file,
    add_flag,
    add_number,
    add_seed,
    add_stamps,
    check_known,
    chosen,
    shown,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.fusion.metrics import Delta, Matched, Relation
    from motorcade.fusion.metrics.evaluation import Evaluation
    from motorcade.ga import Trajectory
    from motorcade.replays.comparison.evaluator import RecordedMotion


def add_compare(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        compare_smoothers,
        "compare",
        "compare smoothers and representations of poses, with intervals",
        "motorcade compare --trajectories gimbal_crossing handheld --seeds 5 --out out/c",
    )
    names = "names; all without"
    parser.add_argument(
        "--trajectories",
        nargs="+",
        default=[],
        metavar="NAME",
        help="names of motions, files of true paths, or all for every name; all without",
    )
    parser.add_argument(
        "--noise",
        "--degradations",
        dest="degradations",
        nargs="+",
        default=[],
        metavar="NAME",
        help=names,
    )
    parser.add_argument("--methods", nargs="+", default=[], metavar="NAME", help=names)
    parser.add_argument("--representations", nargs="+", default=[], metavar="NAME", help=names)
    parser.add_argument("--seeds", type=int, metavar="N", help="test seeds (6)")
    add_file(parser, "--input", "an estimated trajectory instead, with --truth")
    add_file(parser, "--truth", "its ground truth")
    add_choice(parser, "--align", ("none", "se3", "sim3"), "of --input with --truth (se3)", "se3")
    add_stamps(parser)
    add_executor(parser, "processes")
    add_flag(parser, "--quick", "a small comparison, in seconds")
    add_file(
        parser,
        "--out",
        "for the results (out/compare); a stopped run goes on there",
        "DIR",
        default=Path("out/compare"),
    )


def compare_smoothers(arguments: argparse.Namespace) -> None:
    """Compare, write the tables and the report, print the findings."""
    from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES
    from motorcade.replays.cli.arguments import check_known
    from motorcade.replays.comparison.plan import DEGRADATIONS, SEEDS, quick, standard
    from motorcade.replays.comparison.run import run_comparison
    from motorcade.replays.comparison.tables import as_text
    from motorcade.replays.engine.jobs import check_executor
    from motorcade.replays.pipeline.results import require_writable

    if (arguments.input is None) != (arguments.truth is None):
        raise ValueError("compare: expected --input and --truth together, got one of them")
    check_known("--noise", arguments.degradations, DEGRADATIONS)
    check_known("--methods", arguments.methods, METHODS)
    check_known("--representations", arguments.representations, REPRESENTATION_NAMES)
    check_executor(arguments.executor)
    if arguments.seeds is not None and arguments.seeds < 1:
        raise ValueError(f"--seeds: expected 1 or more, got {arguments.seeds}")
    recorded, motions = _motions(arguments)
    require_writable(arguments.out)
    if arguments.input is not None:
        print(as_text(_recorded(arguments)))
        _report(arguments.out)
        return
    chosen = {
        "motions": motions,
        "degradations": tuple(arguments.degradations),
        "methods": tuple(arguments.methods),
        "representations": tuple(arguments.representations),
    }
    if arguments.quick:
        options: dict[str, Any] = {name: value for name, value in chosen.items() if value}
        if arguments.seeds is not None:
            options["test_seeds"] = tuple(range(100, 100 + arguments.seeds))
        plan = replace(quick(), recorded=recorded, **options)
    else:
        plan = standard(
            SEEDS if arguments.seeds is None else arguments.seeds, **chosen, recorded=recorded
        )
    print(as_text(run_comparison(plan, arguments.out, arguments.executor)))
    _report(arguments.out)


def _motions(
    arguments: argparse.Namespace,
) -> tuple[tuple[RecordedMotion, ...], tuple[str, ...]]:
    """Those of the words that are files, and the names of all motions."""
    from motorcade.fusion.motions import MOTIONS
    from motorcade.replays.cli.arguments import check_known
    from motorcade.replays.comparison.evaluator import RecordedMotion

    trajectories: Sequence[str] = arguments.trajectories
    files = [Path(one) for one in trajectories if not one.isidentifier()]
    names = [one for one in trajectories if one.isidentifier()]
    check_known("--trajectories", names, {*MOTIONS, "all"})
    known = tuple(MOTIONS) if "all" in names else tuple(names)
    recorded = tuple(RecordedMotion.of(one, arguments.rate_hz, arguments.times) for one in files)
    return recorded, (*known, *(one.name for one in recorded))


def _report(out: Path) -> None:
    from motorcade.replays.comparison.report.page import write_report
    from motorcade.replays.comparison.report.results import Results

    print(f"report: {write_report(Results.read(out), out)}; tables beside it")


def _recorded(arguments: argparse.Namespace) -> dict[str, object]:
    from motorcade.replays.comparison.run import compare_recorded
    from motorcade.replays.io.trajectories import read_trajectory

    for name in ("trajectories", "degradations", "seeds", "quick"):
        if getattr(arguments, name):
            raise ValueError(f"--{name}: expected without --input, whose data it does not change")
    estimate, truth = (
        read_trajectory(path, rate_hz=arguments.rate_hz, times=arguments.times)
        for path in (arguments.input, arguments.truth)
    )
    return compare_recorded(
        estimate,
        truth,
        arguments.out,
        arguments.input.stem,
        arguments.methods,
        arguments.representations,
        arguments.align,
        arguments.executor,
    )


def add_consistency(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        consistency,
        "consistency",
        "NEES and NIS of the filter over simulated runs, beside quaternions and Euler angles",
        "motorcade consistency --motions gimbal_crossing --runs 100 --out out/consistency",
    )
    parser.add_argument(
        "--motions",
        nargs="+",
        metavar="NAME",
        help="rigid ones (gimbal_crossing, handheld, walk_and_look)",
    )
    parser.add_argument(
        "--filters", metavar="NAMES", help="motor, quaternion, euler, euler_exact (the first three)"
    )
    parser.add_argument("--runs", type=int, metavar="N", help="of each motion (100)")
    add_seed(parser, None, "the first run")
    add_number(parser, "--duration-s", "of each run (120 s)", metavar="S")
    add_executor(parser, "processes")
    add_file(
        parser,
        "--out",
        "for the results (out/consistency); a stopped run goes on there",
        "DIR",
        default=Path("out/consistency"),
    )
    add_file(parser, "--json", "write the figures there")


def consistency(arguments: argparse.Namespace) -> None:
    """Run, write the page, print the shares of steps within the bounds."""
    from motorcade.replays.comparison.consistency import (
        ConsistencyPlan,
        as_json,
        as_table,
        run_plan,
        write_page,
    )
    from motorcade.replays.engine.jobs import check_executor
    from motorcade.replays.pipeline.results import require_writable

    names = ("motions", "filters", "runs", "seed", "duration_s")
    options = {name: getattr(arguments, name) for name in names}
    if options["filters"] is not None:
        options["filters"] = tuple(name.strip() for name in options["filters"].split(","))
    if options["motions"] is not None:
        options["motions"] = tuple(options["motions"])
    plan = ConsistencyPlan(**{name: value for name, value in options.items() if value is not None})
    check_executor(arguments.executor)
    require_writable(arguments.out)
    verdicts = run_plan(plan, arguments.out, arguments.executor)
    figures = as_json(plan, verdicts)
    print(as_table(figures))
    print(f"page: {write_page(plan, verdicts, arguments.out)}")
    write_json(arguments.json, figures)


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
    add_file(parser, "estimates", "TUM, EuRoC or KITTI files", "EST", nargs="+")
    add_file(parser, "reference", "the same: the ground truth", "REF")
    add_stamps(parser)
    _add_pairs_to(parser)
    _add_alignment_to(parser)
    _add_relative_to(parser)
    add_number(
        parser,
        "--energy-above-hz",
        "cut-off of the spectral energy (5 Hz, or a quarter of a slow rate)",
        5.0,
    )
    add_flag(parser, "--all", "print every figure, not only those that matter most")
    add_file(parser, "--json", "write all results there; of several estimates by their names")
    add_file(parser, "--errors", "write the errors of every pair there, as CSV")
    add_file(
        parser,
        "--plot",
        "draw errors over time, and maps of the estimates coloured by their position error",
        "FILE.svg",
    )


def _add_pairs_to(parser: argparse.ArgumentParser) -> None:
    pairs = parser.add_argument_group("pairs of poses")
    add_number(pairs, "--max-difference-s", "stamps farther apart are not paired (0.01 s)", 0.01)
    add_number(
        pairs,
        "--offset-s",
        "add this to the estimates' stamps to have the reference's clock (0)",
        0.0,
    )
    add_number(pairs, "--start-s", "leave out the reference before this stamp")
    add_number(pairs, "--end-s", "leave out the reference after this stamp")
    add_flag(
        pairs, "--interpolate", "take the trajectory with more poses at the stamps of the other one"
    )
    add_number(
        pairs,
        "--max-gap-s",
        "of --interpolate: leave out what lies in longer gaps (none is left out)",
        metavar="S",
    )
    pairs.add_argument(
        "--rows",
        type=int,
        metavar="FROM",
        help="of KITTI files: the reference's row (from 0) of the estimates' first pose",
    )


def _add_alignment_to(parser: argparse.ArgumentParser) -> None:
    alignment = parser.add_argument_group("alignment")
    add_choice(
        alignment,
        "--align",
        ("none", "se3", "sim3", "yaw", "scale", "origin", "scaled_origin"),
        "fit the estimate to the reference first: rigidly, with scale, by heading and place "
        "(where gravity tells both up), by scale alone, or by the first pose, as it is or scaled "
        "(none)",
        "none",
    )
    alignment.add_argument(
        "--n-to-align", type=int, metavar="N", help="fit the first N pairs only (all)"
    )
    add_choice(
        alignment, "--project", ("xy", "xz", "yz"), "project both to a plane after alignment"
    )


def _add_relative_to(parser: argparse.ArgumentParser) -> None:
    relative = parser.add_argument_group("errors")
    relative.add_argument(
        "--relations",
        metavar="NAMES",
        help="evo's pose relations to report beside, or all: full, trans_part, rot_part, "
        "angle_deg, angle_rad, point_distance, point_distance_error_ratio",
    )
    add_number(relative, "--delta", "of the relative pose error (1)", 1.0, metavar="D")
    add_choice(relative, "--delta-unit", ("frames", "m", "deg", "rad"), "(frames)", "frames")
    add_flag(
        relative,
        "--all-pairs",
        "from every pose on, rather than each from where the one before ended",
    )
    add_number(
        relative,
        "--delta-tolerance",
        "of all pairs: by what share of the delta they may miss it (0.1)",
        0.1,
        metavar="SHARE",
    )
    add_choice(
        relative,
        "--pairs-from",
        ("reference", "estimate"),
        "whose metres and degrees are counted (reference; evo's default is the estimate)",
        "reference",
    )
    add_number(
        relative, "--rpe-length-m", "length of path for the relative error by length (1 m)", 1.0
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
        from motorcade.replays.tasks.editing import error_rows

        write_bytes(arguments.errors, "\n".join([*error_rows(matched), ""]).encode())
    if arguments.plot is not None:
        from motorcade.replays.tasks.editing import error_image

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
    from motorcade.fusion.metrics.evaluation import evaluate_matched

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
