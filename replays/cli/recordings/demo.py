"""`motorcade demo`: the whole stage graph on an embedded synthetic recording."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, add_seed, new_command
from motorcade.replays.cli.recordings.run import add_run_options, run_one
from motorcade.replays.engine.progress import log_stages


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        demo,
        name="demo",
        summary="render a synthetic recording and run everything on it",
        example="motorcade demo --out out/demo",
    )
    add_run_options(parser, out=Path("out/demo"))
    add_seed(parser, 0, "the path and the sensors")


def demo(arguments: argparse.Namespace) -> None:
    """Render the recording where it is not there yet, then run it as any other."""
    from motorcade.replays.demo import ensure_demo_recording, settings_beside
    from motorcade.replays.pipeline import Job, require_integrity

    if arguments.strict:
        require_integrity(arguments.until)

    cache = arguments.cache or arguments.out / ".cache"
    start = time.perf_counter()
    recording = ensure_demo_recording(arguments.out / "recording", arguments.seed)
    with log_stages() as lines:
        lines.info("recording: %.1f s", time.perf_counter() - start)
    job = Job(
        recording=recording,
        manifest=None,
        out=arguments.out,
        cache=cache,
        until=arguments.until,
        settings=settings_beside(arguments.settings),
        scene=arguments.scene,
    )
    run_one(job, as_json=arguments.json, strict=arguments.strict)
