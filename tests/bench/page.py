"""Writes the page of benchmarks from the figures of a run.

    make bench                                                   measures all, and writes the page
    python -m tests.bench.page build/bench.json > docs/benchmarks.md      writes it once more

The page holds the machine that measured, the main figures beside those of other libraries in the
same run (`headlines`), and every suite's table as the command prints it, with the load of the
machine when it began. It holds no date: the same figures make the same page.
"""

from __future__ import annotations

import inspect
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from math import exp, log
from pathlib import Path
from typing import Any

from tests.bench.demo import FIGURES
from tests.bench.tables import SUITES
from tests.bench.whole.quoted import HEAD

__all__ = ["Headline", "headlines", "machine", "page"]

MACHINE = "machine"
"""The key beside the suites under which the machine stands."""
RUNS = "runs"
"""The key under which stands how long each job took, under what load, and why it found nothing."""
PEERS = (
    *("scipy", "gtsam", "filterpy", "vqf", "pupil-apriltags", "opencv-contrib-python-headless"),
    *("pyrender", "kornia", "mpmath"),
)
"""Packages beside which figures are measured."""
JOINTS = 1000

_HEAD = """# Benchmarks

Written by `make bench` from what it measured in one run. Times are medians; those of other
libraries were taken in the same run, on the same data and cores. Compare ratios: times of two
machines, or of two runs, say little. `make bench SUITE=…` measures a suite at its full size, where
this page holds fewer seeds, rooms or frames.
"""


@dataclass(frozen=True)
class Headline:
    """One job, ours and another's: what was done, both figures, and how many times ours it was."""

    what: str
    ours: str
    other: str
    ratio: float | None
    suite: str

    def row(self) -> str:
        """As a row of a table in Markdown."""
        ratio = "–" if self.ratio is None else f"{float(f'{self.ratio:.2g}'):,g}"
        command = f"`make bench SUITE={self.suite}`"
        return f"| {self.what} | {self.ours} | {self.other} | {ratio} | {command} |"


def machine() -> dict[str, str]:
    """What figures depend on: processor, its cores and SIMD, compiler, Python and NumPy."""
    from motorcade.replays.tasks.doctor import flags, simd

    told = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": names[0] if names else told,
        "cores": str(os.cpu_count()),
        "kernels": simd(flags()),
        "compiler": _compiler(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "beside": ", ".join(_versions()) or "nothing",
    }


def _versions() -> Iterator[str]:
    for name in PEERS:
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            continue


IMAGES = {"stages": ("images/where_time_goes.svg", "Seconds of each stage of the demo, by threads")}
"""By suite: what is drawn of it, beside the page, and what it shows."""


def page(figures: Mapping[str, Any]) -> str:
    """The page, in Markdown, from figures by suite.

    Raises:
        ValueError: a key that is no suite, or no suites at all.
    """
    suites = [name for name in figures if name not in (MACHINE, RUNS)]
    runs: Mapping[str, Mapping[str, Any]] = figures.get(RUNS, {})
    unknown = sorted(set(suites) - set(SUITES))
    if unknown or not suites:
        raise ValueError(
            f"figures: expected suites of {', '.join(SUITES)}, got {unknown or 'none'}"
        )
    parts = [_HEAD, _machine_table(figures.get(MACHINE, {})), *_in_short(figures)]
    for name in SUITES:
        if name in figures:
            parts += [f"## {name}\n", f"{_about(name)}\n", _block(f"make bench SUITE={name}", "sh")]
            parts.append(_block(_table(name, figures[name]), "text"))
            if name in IMAGES:
                parts.append(f"![{IMAGES[name][1]}]({IMAGES[name][0]})\n")
            parts += _of_the_run(name, runs)
    missing = [f"`make bench SUITE={name}`" for name in SUITES if name not in figures]
    if missing:
        parts.append(f"## Not in this run\n\n{', '.join(missing)}.\n")
        parts += _left_out({key: run for key, run in runs.items() if run["suite"] not in figures})
    return "\n".join(parts)


def _of_the_run(suite: str, runs: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """How long a suite took, under what load, and which of its parts found nothing."""
    own = {name: run for name, run in runs.items() if run["suite"] == suite}
    if not own:
        return []
    seconds = sum(run["seconds"] for run in own.values())
    load = max(run["load"] for run in own.values())
    told = f"Measured in {seconds:.0f} s; the machine's load was at most {load:.1f}.\n"
    return [told, *_left_out(own)]


def _left_out(runs: Mapping[str, Mapping[str, Any]]) -> list[str]:
    told = [f"{name}: {run['left_out']}" for name, run in runs.items() if "left_out" in run]
    return [f"Left out: {'; '.join(told)}.\n"] if told else []


def headlines(figures: Mapping[str, Any]) -> Iterator[Headline]:
    """The main figures of those suites that were measured and had another library beside them."""
    for name, found in _HEADLINES.items():
        if name in figures:
            yield from found(figures[name])


def _blend(found: Mapping[str, Any]) -> Iterator[Headline]:
    ns = {(row["method"], row["scalar"], row["joints"]): row["ns"] for row in found["rows"]}
    for ours, way in (("motor linear", "nlerp"), ("motor screw", "slerp")):
        for scalar in ("float32", "float64"):
            mine = ns.get((ours, scalar, JOINTS))
            fairest = (f"quaternion {way} + mix in arrays", f"GLM {way} + mix")
            other = next((name for name in fairest if (name, scalar, JOINTS) in ns), None)
            if mine is not None and other is not None:
                theirs = ns[other, scalar, JOINTS]
                yield Headline(
                    f"two poses blended, {ours}, {scalar}, {JOINTS} joints",
                    f"{mine:.1f} ns a joint",
                    f"{theirs:.1f} ({other})",
                    theirs / mine,
                    "blend",
                )


def _smooth(found: Mapping[str, Any]) -> Iterator[Headline]:
    ours: dict[str, float] = {}
    for row in found["rows"]:
        if row["job"] not in ours:
            ours[row["job"]] = row["seconds"]
        else:
            mine = ours[row["job"]]
            yield Headline(
                row["job"],
                _seconds(mine),
                f"{_seconds(row['seconds'])} ({row['way']})",
                row["over_ours"],
                "smooth",
            )


def _markers(found: Mapping[str, Any]) -> Iterator[Headline]:
    for row in found.get("markers", {}).get("rows", ()):
        counts, ms = row["found"], row["ms_an_image"]
        for other in [way for way in counts if way != "motorcade"]:
            yield Headline(
                f"markers in {row['count']} images of `{row['images']}`",
                f"{counts['motorcade']} found, {ms['motorcade']:.0f} ms",
                f"{counts[other]} found, {ms[other]:.0f} ms ({other})",
                ms[other] / ms["motorcade"],
                "tracking",
            )


def _flights(found: Mapping[str, Any]) -> Iterator[Headline]:
    rows = {(row["flight"], row["by"]): row for row in found.get("flights", {}).get("rows", ())}
    for (flight, by), row in rows.items():
        other = rows.get((flight, "gtsam's graph"))
        if by == "filter" and other is not None:
            mine, theirs = (1e3 * one["outside_mean_rmse_m"] for one in (row, other))
            yield Headline(
                f"{flight}, camera poses and IMU fused, position",
                f"{mine:.2f} mm",
                f"{theirs:.2f} mm (gtsam's graph)",
                theirs / mine,
                "fusion",
            )


def _render(found: Mapping[str, Any]) -> Iterator[Headline]:
    by_size: dict[int, dict[str, float]] = {}
    for row in found["rows"]:
        by_size.setdefault(row["triangles"], {})[row["drawn_by"]] = row["cpu_ms"]
    for triangles, spent in by_size.items():
        mine, theirs = spent.get("fast renderer"), spent.get("pyrender alone")
        if mine is not None and theirs is not None:
            yield Headline(
                f"a frame of {triangles:,} triangles with shadow, time of the processor",
                f"{mine:.0f} ms",
                f"{theirs:.0f} ms (pyrender)",
                theirs / mine,
                "render",
            )


def _smoothers(found: Mapping[str, Any]) -> Iterator[Headline]:
    """By geometric means over the flights; ways that ground truth tuned are among the others."""
    shares: dict[str, list[float]] = {}
    for row in found["rows"]:
        if row["group"] == "flights":
            shares.setdefault(row["way"], []).append(row["s4"])
    left = {way: exp(sum(map(log, of)) / len(of)) for way, of in shares.items()}
    others = {way: share for way, share in left.items() if way != "auto"}
    if "auto" in left and others:
        best = min(others, key=lambda way: others[way])
        yield Headline(
            "residual error and jitter on recorded flights that `smooth` leaves, told nothing",
            f"{100 * left['auto']:.1f} %",
            f"{100 * others[best]:.1f} % ({best})",
            others[best] / left["auto"],
            "smoothers",
        )


def _demo(found: Mapping[str, Any]) -> Iterator[Headline]:
    rows = {row["representation"]: row for row in found["rows"]}

    def told(name: str) -> str:
        row = rows[name]
        turn, jitter = (float(f"{row[key]:.3g}") for key in FIGURES)
        return f"{turn:g}°, {jitter:,g} rad/s²"

    for other, named in (("euler_unwrapped", "unwrapped"), ("euler", "plain")):
        yield Headline(
            f"rotation error and jitter of the demo's path on motors; on {named} Euler angles",
            told("motor"),
            told(other),
            rows[other]["rotation_rmse_deg"] / rows["motor"]["rotation_rmse_deg"],
            "demo",
        )


def _accuracy(found: Mapping[str, Any]) -> Iterator[Headline]:
    for scalar, errors in found["hard"].items():
        worst = max(errors, key=lambda kernel: errors[kernel])
        told = f"largest error of all kernels where formulas fail, {scalar} (`{worst}`)"
        yield Headline(told, f"{errors[worst]:.1e}", "50 digits (mpmath)", None, "accuracy")
    for scalar, errors in found["fresh"].items():
        worst = max(errors, key=lambda kernel: errors[kernel][1])
        told = f"largest error on a million fresh motors, {scalar} (`{worst}`)"
        ours = f"{errors[worst][1]:.1f} roundings times the condition"
        yield Headline(told, ours, "80 bits (numpy)", None, "accuracy")


_HEADLINES: Mapping[str, Callable[[Any], Iterator[Headline]]] = {
    "demo": _demo,
    "smoothers": _smoothers,
    "blend": _blend,
    "smooth": _smooth,
    "tracking": _markers,
    "fusion": _flights,
    "render": _render,
    "accuracy": _accuracy,
}


def _in_short(figures: Mapping[str, Any]) -> list[str]:
    rows = [one.row() for one in headlines(figures)]
    head = [HEAD, "|---|---|---|---|---|"]
    return ["## In short\n", "\n".join([*head, *rows]) + "\n"] if rows else []


def _machine_table(told: Mapping[str, str]) -> str:
    rows = [f"| {name} | {value} |" for name, value in told.items()]
    return "\n".join(["| machine | |", "|---|---|", *(rows or ["| not told | |"])]) + "\n"


def _table(name: str, found: Any) -> str:
    module, _, table = SUITES[name]
    return str(getattr(import_module(f"tests.bench.{module}"), table)(found))


def _about(name: str) -> str:
    """What the suite says of itself, but for its name in front and commands below."""
    module, _, _ = SUITES[name]
    told = inspect.getdoc(import_module(f"tests.bench.{module}")) or ""
    lines = [line for line in told.splitlines() if not line.startswith("    ")]
    text = "\n".join(lines).strip().removeprefix(f"`make bench SUITE={name}`: ")
    return text[0].upper() + text[1:]


def _block(text: str, language: str) -> str:
    return f"```{language}\n{text.strip(chr(10))}\n```\n"


def _seconds(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds > 1e-3 else f"{1e6 * seconds:.3g} µs"


def _compiler() -> str:
    try:
        told = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "none"
    return told.stdout.splitlines()[0]


def main() -> None:
    """Print the page."""
    if len(sys.argv) != 2:
        raise SystemExit("usage: python -m tests.bench.page BENCH.json")
    try:
        print(page(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))), end="")
    except (OSError, ValueError) as fault:
        raise SystemExit(f"{sys.argv[1]}: {fault}") from fault


if __name__ == "__main__":
    main()
