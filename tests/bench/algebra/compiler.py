"""What the optimiser makes of scripts: their operations, and the time of compiling them.

Each script is compiled from its text in fresh processes, after imports and another script; the
median counts. Beside the scripts of ``docs/scripts`` there is trilateration ("GPS"), Gaalop's own
example: three spheres meet in a pair of points.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from typing import Any

__all__ = ["GPS", "bench_compiler", "compiler_table"]

SCRIPTS = Path(__file__).resolve().parents[3] / "docs" / "scripts"
PROCESSES = 5
GPS = """
a = VecN3(ax, ay, az); b = VecN3(bx, by, bz); c = VecN3(cx, cy, cz);
spheres = (a - 0.5*r*r*einf)^(b - 0.5*s*s*einf)^(c - 0.5*t*t*einf);
pair = *spheres;
length = sqrt(abs(spheres . spheres));
one = (pair + length)/(einf . pair);
other = (pair - length)/(einf . pair);
?here = -one/(one . einf);
?there = -other/(other . einf);
"""
_CODE = """
import json, sys, time
import casadi
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.passes.stats import count_operations
from motorcade.ga.script import parse

compile_script(parse("?y = a*e1*b;", "first"), "first")
text = sys.stdin.read()
start = time.perf_counter()
program = compile_script(parse(text, "script"), "script")
spent = time.perf_counter() - start
counts = count_operations(program.tape)
print(json.dumps([1e3 * spent, counts.multiplications, counts.additions, counts.divisions]))
"""


def bench_compiler() -> list[dict[str, Any]]:
    """Operations and milliseconds of each script."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in sorted(SCRIPTS.glob("*.clu"))}
    return [_compiled(name, text) for name, text in {**texts, "gps": GPS}.items()]


def compiler_table(found: list[Mapping[str, Any]]) -> str:
    """The scripts as lines of text."""
    lines = [f"{'script':<28}{'mul':>7}{'add':>7}{'div':>7}{'ms':>10}"]
    for row in found:
        counts = "".join(f"{row[key]:>7}" for key in ("mul", "add", "div"))
        lines.append(f"{row['script']:<28}{counts}{row['ms']:>10.1f}")
    return "\n".join(lines) + "\n"


def _compiled(name: str, text: str) -> dict[str, Any]:
    rows = [
        json.loads(
            subprocess.run(
                [sys.executable, "-c", _CODE],
                input=text,
                capture_output=True,
                text=True,
                check=True,
            ).stdout
        )
        for _ in range(PROCESSES)
    ]
    _, mul, add, div = rows[0]
    spent = median(row[0] for row in rows)
    return {"script": name, "mul": mul, "add": add, "div": div, "ms": spent}
