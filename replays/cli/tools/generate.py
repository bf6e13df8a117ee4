"""`motorcade generate`: code from a CLUScript."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from motorcade.replays.cli.arguments import Subparsers, new_command

TARGET_NAMES = (
    *("c", "c-batch", "numpy", "glsl", "casadi", "torch"),
    *("cpp", "rust", "javascript", "wgsl", "julia", "latex"),
)


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        generate_code,
        name="generate",
        summary="write a CLUScript as C, NumPy, GLSL, Rust, JavaScript, … or LaTeX",
        example="motorcade generate blend.clu --target numpy -o blend.py",
    )
    parser.add_argument("script", type=Path, metavar="SCRIPT", help="its name names the function")
    parser.add_argument("--target", choices=TARGET_NAMES, default="c", help="(c)")
    parser.add_argument(
        "--strategy",
        choices=("table", "table-code", "product", "program"),
        default="program",
        help="for C: interpret a table, or have it as code; one function a product; or the whole "
        "program (program)",
    )
    parser.add_argument(
        "--precision", choices=("float32", "float64"), help="(the target's own, or its inputs')"
    )
    parser.add_argument(
        "--algebra",
        metavar="NAME",
        help="of a script without algebra pragma: pga3, …, a signature 'P Q R', or a definition of "
        "your own, FILE.toml (cga3)",
    )
    parser.add_argument(
        "--stats", action="store_true", help="operations after each pass, to stderr"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write there; a header goes beside it"
    )


def generate_code(arguments: argparse.Namespace) -> None:
    """Generate, then print or write."""
    from motorcade.ga.codegen.generate import generate
    from motorcade.ga.codegen.passes.stats import table_of_passes
    from motorcade.replays.files.atomic import write_bytes

    made = generate(
        arguments.script,
        target=arguments.target,
        strategy=arguments.strategy,
        precision=arguments.precision,
        algebra=arguments.algebra,
    )
    if arguments.stats:
        sys.stderr.write(table_of_passes(made.program.passes))
    if arguments.output is None:
        # The first file needs no other: a header is for its callers.
        sys.stdout.write(next(iter(made.files.values())))
        return
    places = _places(arguments.output, made.files)
    if any(path.exists() and path.samefile(arguments.script) for path in places):
        raise ValueError(f"-o {arguments.output}: expected another file than the script itself")
    for path, text in places.items():
        write_bytes(path, text.encode())


def _places(output: Path, files: dict[str, str]) -> dict[Path, str]:
    """Where each file goes: the first to `output`, a header beside it."""
    suffixes = [Path(name).suffix for name in files]
    if len(files) > 1 and output.suffix != suffixes[0]:
        raise ValueError(f"-o {output}: expected a name that ends in {suffixes[0]}")
    paths = [output, *(output.with_suffix(suffix) for suffix in suffixes[1:])]
    return dict(zip(paths, files.values(), strict=True))
