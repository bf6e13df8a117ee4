"""Commands that try methods on many motions: `motorcade compare`, `consistency`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_executor,
    add_seed,
    add_stamps,
    write_json,
)

if TYPE_CHECKING:
    from motorcade.replays.comparison.truth import RecordedMotion


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
    parser.add_argument(
        "--input", type=Path, metavar="FILE", help="an estimated trajectory instead, with --truth"
    )
    parser.add_argument("--truth", type=Path, metavar="FILE", help="its ground truth")
    parser.add_argument(
        "--align",
        choices=("none", "se3", "sim3"),
        default="se3",
        help="of --input with --truth (se3)",
    )
    add_stamps(parser)
    add_executor(parser, "processes")
    parser.add_argument("--quick", action="store_true", help="a small comparison, in seconds")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/compare"),
        metavar="DIR",
        help="for the results (out/compare); a stopped run goes on there",
    )


def compare_smoothers(arguments: argparse.Namespace) -> None:
    """Compare, write the tables and the report, print the findings."""
    from motorcade.fusion.smoothing import METHODS, REPRESENTATION_NAMES
    from motorcade.replays.cli.arguments import check_known
    from motorcade.replays.comparison.plan import DEGRADATIONS, SEEDS, quick, standard
    from motorcade.replays.comparison.run import run_comparison
    from motorcade.replays.comparison.tables import as_text
    from motorcade.replays.engine.executors import check_executor
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
    from motorcade.replays.comparison.truth import RecordedMotion

    trajectories: Sequence[str] = arguments.trajectories
    files = [Path(one) for one in trajectories if not one.isidentifier()]
    names = [one for one in trajectories if one.isidentifier()]
    check_known("--trajectories", names, {*MOTIONS, "all"})
    known = tuple(MOTIONS) if "all" in names else tuple(names)
    recorded = tuple(RecordedMotion.of(one, arguments.rate_hz, arguments.times) for one in files)
    return recorded, (*known, *(one.name for one in recorded))


def _report(out: Path) -> None:
    from motorcade.replays.comparison.report import Results, write_report

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
    parser.add_argument("--duration-s", type=float, metavar="S", help="of each run (120 s)")
    add_executor(parser, "processes")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/consistency"),
        metavar="DIR",
        help="for the results (out/consistency); a stopped run goes on there",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there")


def consistency(arguments: argparse.Namespace) -> None:
    """Run, write the page, print the shares of steps within the bounds."""
    from motorcade.replays.comparison.consistency import (
        ConsistencyPlan,
        as_json,
        as_table,
        run_plan,
        write_page,
    )
    from motorcade.replays.engine.executors import check_executor
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
