"""Commands on scripts and on the program itself: `motorcade draw`, `generate`, `completion`,
`doctor`.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

from motorcade.replays.cli.arguments import (
    Commands,
    add_choice,
    add_file,
    add_flag,
    add_number,
    add_output,
    print_json,
)


def add_draw(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        draw_file,
        "draw",
        "draw what a CLUScript marks with ':', as SVG or as a page that turns",
        "motorcade draw reach.clu x=1 y=0.5 t=0,0.25,0.5 -o reach.svg",
    )
    add_file(parser, "script", "with marks such as :a;", "SCRIPT")
    parser.add_argument(
        "values",
        nargs="*",
        type=_value,
        metavar="NAME=VALUE",
        help="of free variables; several values with commas draw as many objects, or a path",
    )
    parser.add_argument(
        "--algebra",
        metavar="NAME",
        help="of a script that does not name it: cga3, pga3, … or a definition, FILE.toml (cga3)",
    )
    add_number(
        parser,
        "--view",
        "the direction to the viewer in degrees, from x about z and up (-52 22)",
        (-52.0, 22.0),
        nargs=2,
        metavar=("AZIMUTH", "ELEVATION"),
    )
    parser.add_argument(
        "--size",
        nargs=2,
        type=int,
        default=(640, 480),
        metavar=("WIDTH", "HEIGHT"),
        help="in pixels (640 480)",
    )
    add_output(parser, "FILE", "to write: .svg or .html")


def _value(text: str) -> tuple[str, list[float]]:
    name, _, value = text.partition("=")
    try:
        values = [float(part) for part in value.split(",")]
    except ValueError:
        values = []
    if not name or not values or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE or NAME=VALUE,…, got {text[:40]!a}")
    return name, values


def draw_file(arguments: argparse.Namespace) -> None:
    """Read, draw, and write the image."""
    import numpy as np

    from motorcade.ga.codegen.generate import read_script
    from motorcade.ga.drawing import draw_script
    from motorcade.ga.drawing.view import View
    from motorcade.ga.script.meaning import with_algebra
    from motorcade.replays.io.files import write_bytes

    by_name = dict(arguments.values)
    if len(by_name) < len(arguments.values):
        raise ValueError("NAME=VALUE: expected each variable once")
    view = View(*arguments.view, *arguments.size)
    script = read_script(arguments.script)
    if arguments.algebra is not None:
        script = with_algebra(script, arguments.algebra)
    values: dict[str, Any] = {n: np.array(v) if len(v) > 1 else v[0] for n, v in by_name.items()}
    image = draw_script(
        script,
        title=arguments.script.stem,
        view=view,
        **values,
    )
    texts = {".svg": image.svg, ".html": image.html}
    if arguments.output.suffix not in texts:
        raise ValueError(f"-o {arguments.output}: expected a name that ends in .svg or .html")
    write_bytes(arguments.output, texts[arguments.output.suffix]().encode())
    for note in image.left_out:
        sys.stderr.write(f"{note}\n")


TARGET_NAMES = (
    *("c", "c-batch", "numpy", "glsl", "casadi", "torch"),
    *("cpp", "rust", "javascript", "wgsl", "julia", "latex"),
)


def add_generate(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        generate_code,
        "generate",
        "write a CLUScript as C, NumPy, GLSL, Rust, JavaScript, … or LaTeX",
        "motorcade generate blend.clu --target numpy -o blend.py",
    )
    add_file(parser, "script", "its name names the function", "SCRIPT")
    add_choice(parser, "--target", TARGET_NAMES, "(c)", "c")
    add_choice(
        parser,
        "--strategy",
        ("table", "table-code", "product", "program"),
        "for C: interpret a table, or have it as code; one function a product; or the whole "
        "program (program)",
        "program",
    )
    add_choice(parser, "--precision", ("float32", "float64"), "(the target's own, or its inputs')")
    parser.add_argument(
        "--algebra",
        metavar="NAME",
        help="of a script without algebra pragma: pga3, …, a signature 'P Q R', or a definition of "
        "your own, FILE.toml (cga3)",
    )
    add_flag(parser, "--stats", "operations after each pass, to stderr")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write there; a header goes beside it"
    )


def generate_code(arguments: argparse.Namespace) -> None:
    """Generate, then print or write."""
    from motorcade.ga.codegen.generate import generate
    from motorcade.ga.codegen.passes.stats import table_of_passes
    from motorcade.replays.io.files import write_bytes

    generated = generate(
        arguments.script,
        target=arguments.target,
        strategy=arguments.strategy,
        precision=arguments.precision,
        algebra=arguments.algebra,
    )
    if arguments.stats:
        sys.stderr.write(table_of_passes(generated.program.passes))
    if arguments.output is None:
        # The first file needs no other: a header is for its callers.
        sys.stdout.write(next(iter(generated.files.values())))
        return
    places = _places(arguments.output, generated.files)
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


SHELLS = ("bash", "zsh", "fish", "tcsh")


def add_completion(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        completion,
        "completion",
        "print the script by which a shell completes commands and options, for its folder "
        "of completions or its start-up file",
        "motorcade completion bash",
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def completion(arguments: argparse.Namespace) -> None:
    """Print the script."""
    import shtab

    print(shtab.complete(_completing_files(arguments.every_command()), arguments.shell))


def _completing_files(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """The parser, in which shtab finds that names of files are completed as such."""
    import shtab

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _completing_files(command)
        elif action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]  # shtab's way to say it
    return parser


def add_doctor(commands: Commands) -> None:
    """Register the command."""
    parser = commands.add(
        doctor,
        "doctor",
        "say what this machine has and lacks: kernels, compiler, OpenGL, video, packages",
        "motorcade doctor --json",
    )
    add_flag(parser, "--json", "machine-readable")


def doctor(arguments: argparse.Namespace) -> None:
    """Print what was found; RuntimeError where the install itself is broken."""
    from motorcade.replays.tasks.doctor import examine

    findings = examine()
    broken = [one for one in findings if one.needed and not one.works]
    if arguments.json:
        print_json({"works": not broken, "findings": [asdict(one) for one in findings]})
    else:
        for group, members in groupby(findings, key=lambda finding: finding.group):
            print(group)
            for member in members:
                mark = "ok" if member.works else "--"
                print(f"  {mark} {member.name:30} {member.detail}")
                if not member.works:
                    print(f"     {'':30} for {member.enables}: {member.remedy}")
    if broken:
        text = "; ".join(f"{one.name}: {one.detail}; {one.remedy}" for one in broken)
        raise RuntimeError(f"the install is broken: {text}")
