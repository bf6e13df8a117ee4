"""`make bench SUITE=smoothers`: `auto` beside other libraries' smoothers, and our own tuned best.

Four groups: recorded flights under sixteen kinds of noise; a further flight and synthetic motions
under the same, 10 s of each; a slow robot at 1 to 8 Hz, likewise; and estimates that others made,
judged from step to step. Peers run on the same poses, those called tuned with what is best for the
ground truth of each single cell (`tests.bench.smoothing.peers.tuned`). Regret is what `auto` leaves
more than the best of all methods of this library, itself among them
(`tests.bench.smoothing.peers.own_best`).

    python -m tests.bench.smoothing.smoothers --on V1_03 --noise white --way auto --way gtsam
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from tests.bench.data import data_folder
from tests.bench.smoothing.cells import (
    FURTHER,
    JUDGED,
    NOISES,
    OUTLIERS,
    SLOW,
    Cell,
    cell,
    errors,
    left,
    motion,
)
from tests.bench.smoothing.estimates import ESTIMATES, IN_STEP, estimates
from tests.bench.smoothing.peers.own_best import OwnBest, own_best
from tests.bench.smoothing.peers.tuned import PEERS, Case

__all__ = ["bench_smoothers", "smoothers_table"]

OWN = "own best, tuned"
FLIGHTS_GROUP, FURTHER_GROUP, ESTIMATES_GROUP = "flights", "further motions", "estimates"
SLOW_GROUP = "slow paths"
_FURTHER_S = 10.0
_COLUMNS = ("e2", "s4", "plain", "outliers", "worse", "µs a pose")
_HEAD = f"{'way':24s}" + "".join(f"{name:>10s}" for name in _COLUMNS)
# A way loses where another leaves more than this share less.
_CLEARLY = 0.02


def bench_smoothers(
    on: Sequence[str] = (),
    noises: Sequence[str] = (),
    ways: Sequence[str] = (),
    folder: Path | None = None,
    seed: int = 0,
) -> dict[str, Any]:
    """What each way leaves of error (e2), and of error and jitter (s4), on every cell at hand.

    Args:
        on: motions and estimates by name or its beginning; all unless some are named.
        noises: the same of noises.
        ways: the same of peers and `OWN`.
        folder: of the recordings.
        seed: of the cells' noise.
    """
    data = data_folder() if folder is None else folder
    wanted = [way for way in (*PEERS, OWN) if _named(way, ways)]
    rows = [*_cell_rows(data, on, noises, wanted, seed), *_estimate_rows(data, on, noises, wanted)]
    return {"rows": rows}


def _named(name: str, chosen: Sequence[str]) -> bool:
    return not chosen or any(name.startswith(one) for one in chosen)


def _cell_rows(
    data: Path, on: Sequence[str], noises: Sequence[str], ways: Sequence[str], seed: int
) -> Iterator[dict[str, Any]]:
    groups = (
        (FLIGHTS_GROUP, JUDGED, None),
        (FURTHER_GROUP, FURTHER, _FURTHER_S),
        (SLOW_GROUP, SLOW, None),
    )
    for group, names, duration_s in groups:
        for name in (name for name in names if _named(name, on)):
            true = motion(name, data, *(() if duration_s is None else (duration_s,)))
            for noise in NOISES if true is not None else ():
                if true is None or not _named(noise, noises):
                    continue
                one = cell(name, noise, true, seed)
                case = _case_of_cell(one)
                for way in ways:
                    path, told = _smoothed(way, case)
                    found = left(path, one)
                    yield (
                        {"group": group, "on": name, "noise": noise}
                        | told
                        | {
                            "e2": found.e2,
                            "s4": found.s4,
                            "rotation": found.shares[1],
                            "position": found.shares[0],
                            "added_deg": found.added_deg,
                        }
                    )


def _case_of_cell(one: Cell) -> Case:
    wrong = errors(one.raw, one.true)
    rad, metres = (1.4826 * float(np.median(np.abs(part))) for part in wrong)

    def both(path: Trajectory) -> tuple[float, float]:
        turn, shift = (float(np.sqrt(np.mean(part**2))) for part in errors(path, one.true))
        return turn, shift

    return Case(one.raw, both, (max(rad, 1e-6), max(metres, 1e-6)), one.noise in OUTLIERS)


def _estimate_rows(
    data: Path, on: Sequence[str], noises: Sequence[str], ways: Sequence[str]
) -> Iterator[dict[str, Any]]:
    if noises or not any(_named(name, on) for name in ESTIMATES):
        return
    made: dict[tuple[str, str], tuple[Trajectory, dict[str, Any]]] = {}
    for one in estimates(data):
        if not _named(one.name, on):
            continue
        raw = one.steps(one.raw)
        case = Case(one.raw, one.steps, (raw[0] / np.sqrt(6.0), raw[1] / np.sqrt(6.0)), False)
        for way in ways:
            # In step the same paths are judged, not tuned anew.
            key = (one.name.removesuffix(IN_STEP), way)
            if key not in made:
                made[key] = _smoothed(way, case)
            path, told = made[key]
            found = one.steps(path)
            rotation, position = found[0] / raw[0], found[1] / raw[1]
            yield (
                {"group": ESTIMATES_GROUP, "on": one.name, "noise": ""}
                | told
                | {
                    "e2": 0.5 * (rotation + position),
                    "s4": float("nan"),
                    "rotation": rotation,
                    "position": position,
                    "rotation_deg": float(np.rad2deg(found[0])),
                    "position_mm": 1e3 * found[1],
                }
            )


def _smoothed(way: str, case: Case) -> tuple[Trajectory, dict[str, Any]]:
    start = process_time()
    if way == OWN:
        best: OwnBest = own_best(case)
        path, setting = best.path or case.raw, best.setting
    else:
        path, setting = PEERS[way](case), ""
    us = 1e6 * (process_time() - start) / len(case.raw)
    return path, {"way": way, "setting": setting, "us_a_pose": us}


def smoothers_table(figures: Mapping[str, Any]) -> str:
    """Each group's means, the regret, and where `auto` loses."""
    rows = figures["rows"]
    if not rows:
        return "smoothers: neither a recording nor a motion of that name"
    lines = _regret([row for row in rows if row["group"] != ESTIMATES_GROUP])
    for group in dict.fromkeys(row["group"] for row in rows):
        own = [row for row in rows if row["group"] == group]
        # An estimate that is judged twice counts once, by its stamps as they come.
        counted = [row for row in own if not row["on"].endswith(IN_STEP)]
        lines += [*_means(group, counted), *_regret(counted), ""]
        lines += _estimates(own) if group == ESTIMATES_GROUP else []
        lines += _losses(own)
    return "\n".join(lines)


def _means(group: str, rows: list[dict[str, Any]]) -> list[str]:
    ways = list(dict.fromkeys(row["way"] for row in rows))
    count = len({(row["on"], row["noise"]) for row in rows})
    lines = [f"{group}, {count} cells: geometric means of what is left", _HEAD]
    for way in ways:
        own = [row for row in rows if row["way"] == way]
        wild = [row["e2"] for row in own if row["noise"] in OUTLIERS]
        plain = [row["e2"] for row in own if row["noise"] not in OUTLIERS]
        e2, s4 = (_mean([row[key] for row in own]) for key in ("e2", "s4"))
        us = float(np.mean([row["us_a_pose"] for row in own]))
        worse = sum(row["e2"] > 1.0005 for row in own)
        lines.append(
            f"{way:24s}{e2:10.3f}{s4:10.3f}{_mean(plain):10.3f}{_mean(wild):10.3f}"
            f"{worse:10d}{us:10.0f}"
        )
    return lines


def _regret(rows: list[dict[str, Any]]) -> list[str]:
    """What `auto` leaves more than the best of this library's methods."""
    shares = []
    for cells in _by_cell(rows):
        if {"auto", OWN} <= cells.keys():
            least = min(cells["auto"]["e2"], cells[OWN]["e2"])
            shares.append((cells["auto"]["e2"] / least - 1.0, cells["auto"]))
    if not shares:
        return []
    worst, where = max(shares, key=lambda one: one[0])
    mean = float(np.mean([share for share, _ in shares]))
    return [
        f"regret of auto to the library's own best: {100 * mean:.1f} % mean, "
        f"{100 * worst:.1f} % worst ({where['on']}, {where['noise']})"
    ]


def _estimates(rows: list[dict[str, Any]]) -> list[str]:
    lines = [f"{'':32s}{'way':24s}{'rotation':>10s}{'':>8s}{'position':>11s}"]
    for row in rows:
        lines.append(
            f"{row['on']:32s}{row['way']:24s}{row['rotation_deg']:9.4f}°{row['rotation']:8.3f}"
            f"{row['position_mm']:8.2f} mm{row['position']:7.3f}"
        )
    return [*lines, ""]


def _losses(rows: list[dict[str, Any]]) -> list[str]:
    """Cells where a peer, or a tuned method of ours, leaves clearly less than `auto`."""
    lines = []
    for cells in _by_cell(rows):
        if "auto" not in cells or len(cells) < 2:
            continue
        ours = cells["auto"]
        best = min(cells.values(), key=lambda row: float(row["e2"]))
        if best["e2"] < (1.0 - _CLEARLY) * ours["e2"]:
            told = f" ({best['setting']})" if best["setting"] else ""
            lines.append(
                f"  {ours['on'] + ', ' + ours['noise']:42s}{ours['e2']:7.3f}{best['e2']:8.3f}  "
                f"{best['way']}{told}"
            )
    head = f"  {'where auto leaves over 2 % more than another':42s}{'auto':>7s}{'best':>8s}"
    return [head, *lines, ""] if lines else []


def _by_cell(rows: list[dict[str, Any]]) -> Iterator[dict[str, dict[str, Any]]]:
    found: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for row in rows:
        found.setdefault((row["on"], row["noise"]), {})[row["way"]] = row
    yield from found.values()


def _mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values)))) if values else float("nan")


def main() -> None:
    """Run what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    for option, what in (("on", "motions or estimates"), ("noise", "noises"), ("way", "ways")):
        parser.add_argument(
            f"--{option}", action="append", default=[], help=f"{what} whose name begins so (all)"
        )
    parser.add_argument("--seed", type=int, default=0, help="of the noise (0)")
    given = parser.parse_args()
    figures = bench_smoothers(given.on, given.noise, given.way, seed=given.seed)
    print(smoothers_table(figures))


if __name__ == "__main__":
    main()
