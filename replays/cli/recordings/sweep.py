"""`motorcade sweep`: recordings times knobs times seeds, one table, one report."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, add_executor, new_command, print_json
from motorcade.replays.cli.recordings.run import add_strict

DESCRIPTION = """\
Run every combination of recordings, knobs and seeds; leave one table and a comparative report.
What is finished is not run again. Paths in CONFIG.toml are relative to it:

  recordings = ["flights/*", {path = "board.mp4", manifest = "board.toml"}]
  seeds = [0, 1, 2]                   # left out: one run with the knobs' own seeds
  until = "errors"                    # or any later stage, as with `motorcade run --until`

  [knobs]                             # `motorcade graph --knobs` lists them
  tracked.by = "simulated"   # the same in every run
  fused.gate = [0.99, 0.9999]         # each in turn"""


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        sweep_recordings,
        name="sweep",
        summary="run every combination of recordings, knobs and seeds; leave one table and a "
        "comparative report; what is finished is not run again",
        example="motorcade sweep sweep.toml --out out/sweep --executor tcp://scheduler:8786",
    )
    parser.description = DESCRIPTION
    parser.add_argument("config", type=Path, metavar="CONFIG.toml")
    parser.add_argument(
        "--out", type=Path, default=Path("out/sweep"), metavar="DIR", help="results (out/sweep)"
    )
    add_executor(parser, "processes")
    parser.add_argument("--json", action="store_true", help="print the table as JSON")
    add_strict(parser)


def sweep_recordings(arguments: argparse.Namespace) -> None:
    """Read the file, run what is missing, say where the results lie; failures end with status 1."""
    from motorcade.replays.engine.executors import check_executor
    from motorcade.replays.pipeline import pipeline_graph, require_integrity
    from motorcade.replays.sweep import read_sweep, run_sweep

    plan = read_sweep(arguments.config, pipeline_graph())
    if arguments.strict:
        require_integrity(plan.until)
    summary = run_sweep(plan, arguments.out, check_executor(arguments.executor))
    if summary.left:
        done = len(plan) - summary.left
        where = f"results in {', '.join(map(str, summary.files))}" if done else "no table yet"
        told = f"stopped; {done} of {len(plan)} runs are done, {where}"
        raise KeyboardInterrupt(f"{told}; the same command does the rest")
    if arguments.json:
        print_json({"rows": [dict(row) for row in summary.rows]})
    else:
        print(f"{summary.done} runs done, {summary.done_before} were done before")
        if summary.doubtful:
            print(f"{summary.doubtful} of them are DOUBTFUL; the table says why")
        print("results in " + ", ".join(map(str, summary.files)))
    if summary.failed:
        told = f"{summary.failed} of {len(plan)} runs failed; the table says why"
        raise RuntimeError(told + (", the others are done" if summary.failed < len(plan) else ""))
    if arguments.strict and summary.doubtful:
        told = f"{summary.doubtful} of {len(plan)} results are doubtful; the table says why"
        raise RuntimeError(told)
