"""Commands that run and show the stage graph: `motorcade run`, `live`, `demo`, `sweep`, `graph`."""

from __future__ import annotations

import argparse
import json
import os
import sys
import textwrap
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_executor,
    add_file,
    add_flag,
    add_number,
    add_seed,
    add_server,
    chosen,
    listening_of,
    one_line,
    print_json,
    shown,
)

if TYPE_CHECKING:
    from motorcade.replays.live.session import LivePlan
    from motorcade.replays.pipeline.job import Job

STDIN = "/dev/stdin"
MOST_PIPED = 64 << 30
_BEGINS = {".mp4": (4, b"ftyp"), ".mkv": (0, b"\x1aE\xdf\xa3"), ".avi": (0, b"RIFF")}
"""By the suffix of a video's file, where in it which bytes stand."""
UNSMOOTHED = ("measured", "fused")
"""Paths in the table of errors that come before the smoothed ones."""


def add_run(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        run_recordings,
        "run",
        "track, fuse, smooth and augment recordings; leave videos and error reports",
        "motorcade run images/ --manifest camera.toml --out out/run --set fused.gate=0.99",
    )
    add_file(
        parser,
        "recordings",
        "folder, video or bag; of several, each leaves its results in OUT/NAME",
        "RECORDING",
        nargs="+",
    )
    add_file(parser, "--manifest", "TOML description of the recording")
    parser.add_argument(
        "--topic", metavar="T", help="of the images in a bag, as RECORDING:T names it, too"
    )
    parser.add_argument(
        "--board",
        metavar="NAME",
        help="the board in view where nothing describes it, such as checkerboard_9x6 (inner "
        "corners), or as `calibrate` names it: checkerboard_9x6_25mm, Kalibr's target.yaml",
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--shot", type=int, metavar="N", help="run shot N of a clip with cuts (the longest)"
    )
    add_flag(which, "--all-shots", "run every shot, each into OUT/shot-N")
    parser.add_argument(
        "--floor", type=int, metavar="N", help="stand on the N-th of what the report offers"
    )
    add_run_options(parser, out=Path("out"))
    add_executor(parser, "local", "of several recordings: ")


def add_run_options(parser: argparse.ArgumentParser, out: Path) -> None:
    """Options shared with `demo`."""
    add_file(parser, "--out", f"results ({out})", "DIR", default=out)
    parser.add_argument(
        "--until",
        default="report",
        metavar="STAGE",
        help="stop after this stage, of those that `motorcade graph` shows (report)",
    )
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="STAGE.KNOB=VALUE",
        help="change a knob; `motorcade graph --knobs` lists them",
    )
    add_file(parser, "--scene", "set this scene into the footage")
    add_file(parser, "--cache", "stage outputs (OUT/.cache)", "DIR")
    add_flag(parser, "--json", "print the error report as JSON")
    add_strict(parser)


def add_strict(parser: argparse.ArgumentParser) -> None:
    """The option that makes a failure of a doubtful result."""
    add_flag(
        parser,
        "--strict",
        "exit with 1 where a result is doubtful; the results are there all the same",
    )


def _board_name(text: str) -> str:
    """A board's name, of a file that describes it the name of that."""
    from motorcade.replays.io.readers.manifest.section import read_board

    return read_board(text).name if Path(text).suffix in (".toml", ".yaml", ".yml") else text


def run_recordings(arguments: argparse.Namespace) -> None:
    """Run one recording here, or several by the executor asked for."""
    from motorcade.replays.engine.jobs import check_executor, outcomes
    from motorcade.replays.pipeline.job import Job, require_integrity, shot_job, shot_jobs

    check_executor(arguments.executor)
    if arguments.strict:
        require_integrity(arguments.until)
    named = [_kept(path, arguments.out) for path in arguments.recordings]
    recordings = [_with_topic(path, arguments.topic) for path in named]
    _refuse_equal_names(recordings)
    board = () if arguments.board is None else (f"described.board={_board_name(arguments.board)}",)
    floor = () if arguments.floor is None else (f"placed.floor={arguments.floor}",)
    jobs = [
        Job(
            recording=path,
            manifest=arguments.manifest,
            out=arguments.out / _name(path) if len(recordings) > 1 else arguments.out,
            cache=arguments.cache,
            until=arguments.until,
            settings=(*board, *arguments.settings, *floor),
            scene=arguments.scene,
        )
        for path in recordings
    ]
    if arguments.shot is not None:
        jobs = [shot_job(job, arguments.shot, job.out) for job in jobs]
    if arguments.all_shots:
        jobs = [shot for job in jobs for shot in shot_jobs(job)]
    if len(jobs) == 1:
        run_one(jobs[0], as_json=arguments.json, strict=arguments.strict)
        return
    done: dict[str, dict[str, Any]] = {}
    run_job_here = partial(_run_one_of_several, quiet=arguments.quiet)
    for job, outcome in outcomes(run_job_here, jobs, arguments.executor):
        if isinstance(outcome, BaseException):
            print(f"motorcade: {job.recording}: {one_line(outcome)}", file=sys.stderr)
            continue
        name = f"{job.recording}, {job.out.name}" if arguments.all_shots else str(job.recording)
        done[name] = outcome
        if not arguments.json:
            print(f"{name}:")
            print_summary(outcome, job.out, as_json=False)
    if arguments.json:
        print(json.dumps(done, indent=2))
    if len(done) < len(jobs):
        failed = len(jobs) - len(done)
        raise RuntimeError(f"{failed} of {len(jobs)} recordings failed; the others are done")
    doubtful = [name for name, summary in done.items() if doubts(summary)]
    if arguments.strict and doubtful:
        raise RuntimeError(
            f"{len(doubtful)} of {len(jobs)} results are doubtful: {', '.join(doubtful)}"
        )


def run_one(job: Job, *, as_json: bool, strict: bool) -> None:
    """Run a recording here; print a line per stage, then its figures, then one line on the result.

    Raises RuntimeError: a doubtful result, where that is asked to be strict.
    """
    from motorcade.ga.progress import log_stages
    from motorcade.replays.pipeline.job import run_job

    with log_stages() as lines:
        summary = run_job(job)
        print_summary(summary, job.out, as_json=as_json)
        lines.info(result(summary, job.out))
    if strict and doubts(summary):
        raise RuntimeError(f"{job.recording}: the result is doubtful, see above")


def _run_one_of_several(job: Job, *, quiet: bool) -> dict[str, Any]:
    """Run a recording, here or in another process; its log lines begin with its name."""
    from motorcade.ga.progress import log_stages, show_progress
    from motorcade.replays.pipeline.job import run_job

    show_progress(not quiet)
    with log_stages(_name(job.recording)) as lines:
        summary = run_job(job)
        lines.info(result(summary, job.out))
    return summary


def _kept(recording: Path, out: Path) -> Path:
    """A recording that comes through `/dev/stdin` as a file beside its results.

    Raises ValueError: what comes is no video that is known by its first bytes, or has no end.
    """
    if str(recording) != STDIN:
        return recording
    from motorcade.ga.unfinished import unfinished

    with recording.open("rb") as source:
        head = source.read(16)
        known = (end for end, (at, what) in _BEGINS.items() if head[at:].startswith(what))
        suffix = next(known, None)
        if suffix is None:
            raise ValueError(
                f"{recording}: expected a video (mp4, mov, mkv, webm, avi), got something else; "
                "recordings of other kinds are read from files and folders"
            )
        out.mkdir(parents=True, exist_ok=True)
        left = MOST_PIPED
        with unfinished(out) as place:
            part = place / "recording"
            with part.open("wb") as file:
                while head:
                    file.write(head)
                    left -= len(head)
                    if left < 0:
                        raise ValueError(f"{recording}: expected at most {MOST_PIPED} bytes")
                    head = source.read(1 << 20)
            return part.replace(out / f"recording{suffix}")


def _with_topic(recording: Path, topic: str | None) -> Path:
    """A bag with the topic of its images, as its name says it."""
    return recording if topic is None else Path(f"{recording}:{topic}")


def _name(recording: Path) -> str:
    """The name of what a path leads to; links in a circle are told of when it is opened."""
    from motorcade.replays.io.readers.opening import recording_and_topic

    return Path(os.path.realpath(recording_and_topic(recording)[0])).name


def _refuse_equal_names(recordings: list[Path]) -> None:
    """Several recordings write into folders of their names, which must differ."""
    names = [_name(path) for path in recordings]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(
                f"run: {names.count(name)} recordings are called {name!r} and would write into "
                "one folder; run them one at a time, each with its own --out"
            )


def print_summary(summary: Mapping[str, Any], out: Path, *, as_json: bool) -> None:
    """The table of errors, or the whole report as JSON, and where the results lie."""
    from motorcade.replays.pipeline.report.summary import as_table

    if as_json:
        print(json.dumps(summary, indent=2), flush=True)
        return
    if "errors" in summary:
        print(as_table(summary))
    print(f"results in {out}", flush=True)


def doubts(summary: Mapping[str, Any]) -> list[str]:
    """Why a run's result is doubtful; empty where it is not, or where nothing was checked."""
    return list(summary.get("integrity", {}).get("doubts", ()))


def result(summary: Mapping[str, Any], out: Path) -> str:
    """What came of a run in one line.

    Whether it is doubtful and why, what the film shows, the poses, their distance from the ground
    truth, what a stage made worse, what is not sure, where to look.
    """
    from motorcade.replays.pipeline.report.summary import shown_value

    doubtful = "; ".join(doubts(summary))
    if doubtful:
        doubtful = f"{summary['integrity']['verdict'].upper()}: {doubtful}; "
        if summary["integrity"]["drawn"] == "measured":
            doubtful += "the character stands along the measured path; "
    worse = "".join(f"; {text}" for text in summary.get("stage_comparison", {}).get("worse", ()))
    if summary.get("doubts"):
        worse += f"; not sure: {', '.join(summary['doubts'])}"
    poses = summary.get("camera_poses")
    if poses is None:
        return f"{doubtful}done as far as {summary['until']}{worse}; look into {out}"
    film = f"{summary['overlay']['in_words']}; " if summary.get("overlay") else ""
    film += f"{summary['people']}; " if " " in summary.get("people", "") else ""
    text = (
        f"{doubtful}{film}{poses['measured']} of {poses['frames']} frames have a pose "
        f"({poses['origin']})"
    )
    smoothed = next(row for path, row in summary["errors"].items() if path not in UNSMOOTHED)
    off_m, off_deg = smoothed.get("ape_rmse_m"), smoothed.get("rotation_rmse_deg")
    if off_m is not None:
        off = f"{shown_value('ape_rmse_m', off_m)} mm, {shown_value('rotation_rmse_deg', off_deg)}°"
        text += f", smoothed {off} from the ground truth (RMSE)"
    return f"{text}{worse}; open {out / 'report.html'}"


def add_demo(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        demo,
        "demo",
        "render a synthetic recording and run everything on it",
        "motorcade demo --out out/demo",
    )
    add_run_options(parser, out=Path("out/demo"))
    add_seed(parser, 0, "the path and the sensors")


def demo(arguments: argparse.Namespace) -> None:
    """Render the recording where it is not there yet, then run it as any other."""
    from motorcade.replays.demo.recording import ensure_demo_recording, settings_beside
    from motorcade.replays.pipeline.job import Job, require_integrity

    if arguments.strict:
        require_integrity(arguments.until)

    cache = arguments.cache or arguments.out / ".cache"
    start = time.perf_counter()
    recording = ensure_demo_recording(arguments.out / "recording", arguments.seed)
    from motorcade.ga.progress import log_stages

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


SWEEP = """\
Run every combination of recordings, knobs and seeds; leave one table and a comparative report.
What is finished is not run again. Paths in CONFIG.toml are relative to it:

  recordings = ["flights/*", {path = "board.mp4", manifest = "board.toml"}]
  seeds = [0, 1, 2]                   # left out: one run with the knobs' own seeds
  until = "errors"                    # or any later stage, as with `motorcade run --until`

  [knobs]                             # `motorcade graph --knobs` lists them
  tracked.by = "simulated"   # the same in every run
  fused.gate = [0.99, 0.9999]         # each in turn"""


def add_sweep(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        sweep_recordings,
        "sweep",
        "run every combination of recordings, knobs and seeds; leave one table and a "
        "comparative report; what is finished is not run again",
        "motorcade sweep sweep.toml --out out/sweep --executor tcp://scheduler:8786",
    )
    parser.description = SWEEP
    parser.add_argument("config", type=Path, metavar="CONFIG.toml")
    add_file(parser, "--out", "results (out/sweep)", "DIR", default=Path("out/sweep"))
    add_executor(parser, "processes")
    add_flag(parser, "--json", "print the table as JSON")
    add_strict(parser)


def sweep_recordings(arguments: argparse.Namespace) -> None:
    """Read the file, run what is missing, say where the results lie; failures end with status 1."""
    from motorcade.replays.comparison.sweep import read_sweep, run_sweep
    from motorcade.replays.engine.jobs import check_executor
    from motorcade.replays.pipeline.job import pipeline_graph, require_integrity

    plan = read_sweep(arguments.config, pipeline_graph())
    if arguments.strict:
        require_integrity(plan.until)
    summary = run_sweep(plan, arguments.out, check_executor(arguments.executor))
    if summary.left:
        done = len(plan) - summary.left
        where = f"results in {', '.join(map(str, summary.files))}" if done else "no table yet"
        text = f"stopped; {done} of {len(plan)} runs are done, {where}"
        raise KeyboardInterrupt(f"{text}; the same command does the rest")
    if arguments.json:
        print_json({"rows": [dict(row) for row in summary.rows]})
    else:
        print(f"{summary.done} runs done, {summary.done_before} were done before")
        if summary.doubtful:
            print(f"{summary.doubtful} of them are DOUBTFUL; the table says why")
        print("results in " + ", ".join(map(str, summary.files)))
    if summary.failed:
        text = f"{summary.failed} of {len(plan)} runs failed; the table says why"
        raise RuntimeError(text + (", the others are done" if summary.failed < len(plan) else ""))
    if arguments.strict and summary.doubtful:
        text = f"{summary.doubtful} of {len(plan)} results are doubtful; the table says why"
        raise RuntimeError(text)


WIDTH = 92


def add_graph(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        draw_graph,
        "graph",
        "draw the stage graph",
        "motorcade graph --svg graph.svg",
    )
    add_file(parser, "--svg", "write an image instead")
    add_flag(
        parser,
        "--knobs",
        "tell every stage's knobs instead: default, values (units end the name), meaning",
    )


def draw_graph(arguments: argparse.Namespace) -> None:
    """Print or write the drawing."""
    from motorcade.replays.engine.graph import described_knobs, draw_mermaid, draw_svg
    from motorcade.replays.io.files import write_bytes
    from motorcade.replays.pipeline.described.describing import description_graph
    from motorcade.replays.pipeline.job import pipeline_graph

    graph = pipeline_graph()
    if arguments.svg is not None:
        write_bytes(arguments.svg, draw_svg(graph).encode())
    elif arguments.knobs:
        for stage in (*description_graph().stages.values(), *graph.stages.values()):
            for knob in described_knobs(stage):
                print(f"{stage.name}.{knob.name}={knob.default}  ({knob.values})")
                print(textwrap.indent(textwrap.fill(knob.meaning, WIDTH), " " * 4))
    else:
        print(draw_mermaid(graph), end="")


DESCRIPTION = """\
Track a camera while it films, and put a figure where one taps, in a page of the browser.

Without SOURCE the camera is the browser's own: this machine's, or with --lan a phone's, by https.
SOURCE is a device (/dev/video0), an address (rtsp://...), "-" for a video that comes through the
standard input, or a recording, which is played at its own pace.

Without --camera the camera is found from the board within seconds: move round it, and tilt it.
Frames a second, latency and registration are measured while it runs, and shown.
--record keeps the session as a recording that `motorcade run` replays."""


def add_live(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        live,
        "live",
        "track a camera while it films, with a figure on its images, in the browser",
        "motorcade live --board checkerboard_9x6_25mm --lan\n"
        "  motorcade live /dev/video0 --board board.yaml --no-page",
    )
    parser.description = DESCRIPTION
    parser.add_argument("source", nargs="?", metavar="SOURCE", help="else the browser's camera")
    target = parser.add_mutually_exclusive_group()
    target.add_argument("--board", metavar="NAME", help="in view: checkerboard_9x6_25mm, or a file")
    target.add_argument("--markers", metavar="FAMILY", help="the marker that is seen first")
    target.add_argument("--slam", action="store_true", help="neither: map the place (--camera)")
    add_number(parser, "--size-m", "side of --markers, metres", metavar="S")
    add_file(parser, "--camera", "as `motorcade calibrate` writes it")
    add_file(parser, "--manifest", "of a recording as SOURCE")
    parser.add_argument("--character", default="mannequin", metavar="FILE", help="the figure")
    add_number(parser, "--height-m", "of the figure", metavar="H")
    add_file(parser, "--record", "keep the session there", "DIR")
    add_flag(parser, "--no-page", "track SOURCE, and print figures")
    add_flag(parser, "--json", "print them as JSON (--no-page)")
    add_server(parser)


def live(arguments: argparse.Namespace) -> None:
    """Serve the page until it is stopped; or track a source to its end."""
    plan = _plan(arguments)
    if not arguments.no_page:
        _serve(plan, arguments)
        return
    from motorcade.replays.live.session import track_without_page

    session, frames = plan.open()
    if frames is None:
        raise ValueError("--no-page: expected a SOURCE, since only a page has a browser's camera")
    try:
        figures = track_without_page(session, frames)
    finally:
        session.close()
    if arguments.json:
        print_json(figures)
        return
    for key, value in figures.items():
        text = " ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else value
        print(f"{key:>22}  {shown(text)}")


def _plan(arguments: argparse.Namespace) -> LivePlan:
    """What the options ask for."""
    from motorcade.replays.io.readers.manifest.section import read_board, read_camera
    from motorcade.replays.live.session import LivePlan
    from motorcade.replays.live.tracker import FirstMarker, Target

    target: Target | None = None
    if arguments.slam:
        target = "slam"
    elif arguments.board is not None:
        target = read_board(arguments.board)
    elif arguments.markers is not None:
        if arguments.size_m is None:
            raise ValueError("--markers: expected --size-m S with it, the side of a marker, metres")
        target = FirstMarker(arguments.markers, arguments.size_m)
    camera = None if arguments.camera is None else read_camera(arguments.camera)
    stated = chosen(arguments, "source", "manifest", "character", "height_m", "record")
    return LivePlan(target=target, camera=camera, **stated)


def _serve(plan: LivePlan, arguments: argparse.Namespace) -> None:
    try:
        from motorcade.replays.live.app import serve_live
    except ModuleNotFoundError as missing:
        raise RuntimeError(
            f"a page needs the Python package {missing.name}, which is not installed; "
            'pip install "motorcade[studio]" brings it, or track without one by --no-page'
        ) from missing
    serve_live(plan, listening_of(arguments), open_browser=not arguments.no_open)
