"""`motorcade consistency`: whether the filter's errors are as large as it says, over many runs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, add_executor, add_seed, new_command


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        consistency,
        name="consistency",
        summary="NEES and NIS of the filter over simulated runs, beside quaternions and Euler "
        "angles",
        example="motorcade consistency --motions gimbal_crossing --runs 100 --out out/consistency",
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
    from motorcade.replays.consistency.page import write_page
    from motorcade.replays.consistency.run import ConsistencyPlan, as_json, as_table, run_plan
    from motorcade.replays.engine.executors import check_executor
    from motorcade.replays.files.atomic import write_bytes
    from motorcade.replays.results import require_writable

    names = ("motions", "filters", "runs", "seed", "duration_s")
    given = {name: getattr(arguments, name) for name in names}
    if given["filters"] is not None:
        given["filters"] = tuple(name.strip() for name in given["filters"].split(","))
    if given["motions"] is not None:
        given["motions"] = tuple(given["motions"])
    plan = ConsistencyPlan(**{name: value for name, value in given.items() if value is not None})
    check_executor(arguments.executor)
    require_writable(arguments.out)
    verdicts = run_plan(plan, arguments.out, arguments.executor)
    figures = as_json(plan, verdicts)
    print(as_table(figures))
    print(f"page: {write_page(plan, verdicts, arguments.out)}")
    if arguments.json is not None:
        write_bytes(arguments.json, (json.dumps(figures, indent=2) + "\n").encode())
