"""Plain C of ours, one call at a time, beside GLM, Eigen, klein, libvsr and Gaalop's C: one run.

    python -m tests.bench.algebra.plain_c
    python -m tests.bench.algebra.plain_c --peers FOLDER    # with glm/, eigen/, klein/, versor/ …
    python -m tests.bench.algebra.plain_c --without rows    # a pass of ours left out

Each row is a script, written by the target ``c`` in both precisions and compiled into the same
program as its peers, with the same flags; times are the processor's, the least of many, and ours is
measured before and after the others. A peer is measured whose headers the compiler finds: those of
libglm-dev and libeigen3-dev, or checkouts in the folder given by ``--peers``; the others are named.
``gaalop/float32.c`` and ``gaalop/float64.c`` there hold ``gaalop_compose`` and ``gaalop_plane``.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from motorcade.ga.codegen.precision import DOUBLE, SINGLE
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import c
from motorcade.ga.script import parse

SOURCE = Path(__file__).with_name("rows.cpp")
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-ffp-contract=fast", "-std=c++17", "-w")
_BLADES = ("", "*e2^e3", "*e3^e1", "*e1^e2", "*e1^einf", "*e2^einf", "*e3^einf", "*e1^e2^e3^einf")
INCLUDES = ("glm", "eigen", "klein/public", "versor/include", "gaalop")
PEERS = ("GLM", "Eigen", "klein", "libvsr", "Gaalop")


def _motor(name: str) -> str:
    terms = " + ".join(f"{name}{k}{blade}" for k, blade in enumerate(_BLADES))
    return f"{name} = {terms};\n"


_LINE = " + ".join(f"b{k}{blade}" for k, blade in enumerate(_BLADES[1:7]))
_TWIST = " + ".join(f"a{k}{blade}" for k, blade in enumerate(_BLADES[1:7]))
SCRIPTS = {
    "compose": _motor("a") + _motor("b") + "?r = a*b;",
    "inverse": _motor("a") + "?r = ~a;",
    "point": _motor("a") + "p = createPoint(b0, b1, b2); ?r = a*p*~a;\n//#pragma output r e1 e2 e3",
    "plane": _motor("a") + "?r = a*(b0*e1 + b1*e2 + b2*e3 + b3*einf)*~a;",
    "line": _motor("a") + f"?r = a*({_LINE})*~a;",
    "join": _motor("a")
    + "p = createPoint(b0, b1, b2); q = createPoint(b3, b4, b5); ?r = a*(*(p^q^einf))*~a;",
    "logarithm": _motor("a") + "?r = log(a);",
    "exponential": f"?r = exp({_TWIST});",
    "interpolate": _motor("a") + _motor("b") + "?r = a*exp(w*log(~a*b));",
    "blend": _motor("a") + _motor("b") + "?r = versor(a + w*(b - a));",
}


@contextmanager
def _left_out(passes: list[str]) -> Iterator[None]:
    """Without the passes of the target that are named."""
    if "rows" not in passes:
        yield
        return
    with patch.object(c, "with_unlike_rows", lambda tape: tape):
        yield


def kernels_of(precision: str, passes: list[str]) -> str:
    """The functions of all rows."""
    real = SINGLE if precision == "float32" else DOUBLE
    with _left_out(passes):
        return "\n".join(
            c.write(compile_script(parse(text), name), real)[f"{name}.c"]
            for name, text in SCRIPTS.items()
        )


def measured(precision: str, peers: Path | None, passes: list[str]) -> list[tuple[str, str, float]]:
    """Row, who, and nanoseconds a call."""
    with tempfile.TemporaryDirectory() as folder:
        kernels, program = Path(folder) / "kernels.c", Path(folder) / "rows"
        kernels.write_text(kernels_of(precision, passes), encoding="utf-8")
        single = precision == "float32"
        options = [f"-DREAL={'float' if single else 'double'}", f'-DKERNELS="{kernels}"']
        options += ["-DSINGLE"] if single else ["-DVSR_PRECISION_DOUBLE"]
        if peers is not None:
            options += [f"-I{peers / name}" for name in INCLUDES if (peers / name).is_dir()]
            gaalop = peers / "gaalop" / f"{precision}.c"
            options += [f'-DGAALOP="{gaalop}"'] if gaalop.exists() else []
        subprocess.run(["c++", *FLAGS, *options, str(SOURCE), "-o", str(program)], check=True)
        done = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    return [(row, who, float(ns)) for row, who, ns in json.loads(done.stdout)]


def table(figures: list[tuple[str, str, float]]) -> list[str]:
    """A line a row: ours, then each peer with how much of its time ours takes."""
    own: dict[str, float] = {}
    for row, who, ns in figures:
        if who.startswith("ours"):
            own[row] = min(ns, own.get(row, ns))
    lines = []
    for row, ns in own.items():
        others = [(who, peer) for name, who, peer in figures if name == row and "ours" not in who]
        said = "; ".join(f"{who} {peer:.2f} ({ns / peer:.2f})" for who, peer in others)
        lines.append(f"{row:<34}{ns:>8.2f}  {said}")
    return lines


def main(arguments: list[str] | None = None) -> None:
    """Print a table a precision."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.algebra.plain_c",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--peers", type=Path, metavar="FOLDER", help="checkouts of peers")
    parser.add_argument("--without", nargs="*", default=[], choices=["rows"], help="passes of ours")
    options = parser.parse_args(arguments)
    print(f"ns a call, ours and (ours / peer); {' '.join(FLAGS)}")
    for precision in ("float32", "float64"):
        figures = measured(precision, options.peers, options.without)
        print(f"\n{precision}", *table(figures), sep="\n")
        there = " ".join(who for _, who, _ in figures)
        print("left out:", ", ".join(peer for peer in PEERS if peer not in there) or "nothing")


if __name__ == "__main__":
    main()
