"""`motorcade doctor`: what this machine has and lacks, what each enables, how to get it."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from itertools import groupby

from motorcade.replays.cli.arguments import Subparsers, new_command, print_json


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        doctor,
        name="doctor",
        summary="say what this machine has and lacks: kernels, compiler, OpenGL, video, packages",
        example="motorcade doctor --json",
    )
    parser.add_argument("--json", action="store_true", help="machine-readable")


def doctor(arguments: argparse.Namespace) -> None:
    """Print what was found; RuntimeError where the install itself is broken."""
    from motorcade.replays.doctor import examine

    findings = examine()
    broken = [one for one in findings if one.needed and not one.works]
    if arguments.json:
        print_json({"works": not broken, "findings": [asdict(one) for one in findings]})
    else:
        for group, members in groupby(findings, key=lambda one: one.group):
            print(group)
            for one in members:
                mark = "ok" if one.works else "--"
                print(f"  {mark} {one.name:30} {one.found}")
                if not one.works:
                    print(f"     {'':30} for {one.enables}: {one.remedy}")
    if broken:
        told = "; ".join(f"{one.name}: {one.found}; {one.remedy}" for one in broken)
        raise RuntimeError(f"the install is broken: {told}")
