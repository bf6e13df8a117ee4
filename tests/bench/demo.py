"""The demo, from its first image to its report: how long, and what each representation leaves.

Rotation error and angular jitter are those of the smoothed paths against the exact ground truth,
by one smoother; in seven seconds the camera comes near the gimbal lock of Euler angles six times.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

__all__ = ["bench_demo", "demo_table"]

SHOWN = ("motor", "quaternion", "euler_unwrapped", "euler")
FIGURES = ("rotation_rmse_deg", "angular_jitter_rad_s2")
_RUN = "import sys; from motorcade.replays.cli import main; sys.exit(main())"


def bench_demo(until: str = "report") -> dict[str, Any]:
    """Seconds from the command to its report, and the figures of `SHOWN`.

    Raises:
        RuntimeError: the demo failed.
    """
    with tempfile.TemporaryDirectory() as out:
        start = perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", _RUN, "demo", "-q", "--json", "--until", until, "--out", out],
            capture_output=True,
            text=True,
            check=False,
        )
        seconds = perf_counter() - start
        if done.returncode:
            raise RuntimeError(f"demo: {' '.join(done.stderr.split())[-300:]}")
        figures = json.loads(done.stdout)["errors"]
        film = (Path(out) / "overlay.mp4").is_file()
    rows = [{"representation": name, **{k: figures[name][k] for k in FIGURES}} for name in SHOWN]
    return {"seconds": seconds, "film": film, "rows": rows}


def demo_table(found: Mapping[str, Any]) -> str:
    """A row a representation, and the time."""
    lines = [f"{'smoothed on':<20}{'rotation error':>16}{'angular jitter':>20}"]
    for row in found["rows"]:
        turn, jitter = (row[name] for name in FIGURES)
        lines.append(f"{row['representation']:<20}{turn:>14.3f} °{jitter:>13,.2f} rad/s²")
    what = "with its film" if found["film"] else "without a film, as no OpenGL is here"
    return "\n".join([*lines, f"from the command to the report {what}: {found['seconds']:.0f} s"])
