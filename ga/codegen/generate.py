"""From a script's file to source code: what `motorcade generate` does."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from motorcade.ga.codegen.precision import PRECISIONS, Precision
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.strategies import product, table
from motorcade.ga.codegen.targets import TARGETS
from motorcade.ga.codegen.targets.names import RefusedName, file_identifier
from motorcade.ga.files import read_bounded
from motorcade.ga.script import Script, parse
from motorcade.ga.script.meaning import first_place, with_algebra
from motorcade.ga.script.syntax import MAX_SCRIPT_CHARACTERS

_LONGEST_CHARACTER_BYTES = 4
MAX_FILE_BYTES = _LONGEST_CHARACTER_BYTES * MAX_SCRIPT_CHARACTERS

WriteCalls = Callable[[Script, Program, Precision | None], dict[str, str]]

# How else than as the program that `TARGETS` write a script becomes C.
STRATEGIES: dict[str, WriteCalls] = {
    "table": table.write,
    "table-code": table.write_code,
    "product": product.write,
}


@dataclass(frozen=True)
class Generated:
    """The program of a script, and the text of each file of code by its name."""

    program: Program
    files: dict[str, str]


def generate(
    path: Path,
    *,
    target: str = "c",
    strategy: str = "program",
    precision: str | None = None,
    algebra: str | None = None,
) -> Generated:
    """Write a script as code; the file's name without suffix names the function.

    Args:
        path: of the script.
        target: one of `TARGETS`.
        strategy: ``program``, or one of `STRATEGIES` for the target ``c``.
        precision: float32 or float64; each target's own if None.
        algebra: as a pragma names it, or the path of a definition that ends in .toml, for scripts
            that do not say theirs; cga3 if None.

    Raises:
        FileError: the file, or an algebra's, cannot be read, is too large or wrong.
        ScriptError: what is wrong with the script, and where; names that the target keeps for
            itself.
        ValueError: a script without outputs, anything
            above that is not known or that the target does not have.
    """
    write = TARGETS[_one_of("target", target, TARGETS)]
    _one_of("strategy", strategy, ["program", *STRATEGIES])
    if strategy != "program" and target != "c":
        raise ValueError(f"target {target}: expected the strategy program, got {strategy}")
    kind = None if precision is None else _precision(precision)
    name = _function_name(path)
    script = read_script(path)
    if algebra is not None:
        script = with_algebra(script, algebra)
    program = compile_script(script, name)
    try:
        if strategy == "program":
            return Generated(program, write(program, kind))
        return Generated(program, STRATEGIES[strategy](script, program, kind))
    except RefusedName as refused:
        place = first_place(script, refused.name)
        if place is None:
            raise
        raise script.source.error(place, str(refused)) from None


def read_script(path: Path) -> Script:
    """Read and parse a script.

    Raises FileError: the file cannot be read, or is too large; ValueError: it is no UTF-8;
    ScriptError: what is wrong with the script, and where.
    """
    data = read_bounded(path, MAX_FILE_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as refused:
        raise ValueError(
            f"{path}: expected UTF-8 text, got the byte {data[refused.start]:#04x} "
            f"at offset {refused.start}"
        ) from refused
    return parse(text, str(path), path.parent)


def _function_name(path: Path) -> str:
    """The file's name without suffix, where it is an identifier."""
    wanted = file_identifier(path.stem)
    if wanted != path.stem:
        raise ValueError(
            f"{path}: expected a file name that is an identifier, as it names the function: "
            f"rename it to {wanted}{path.suffix}"
        )
    return wanted


def _precision(name: str) -> Precision:
    known = {precision.numpy: precision for precision in PRECISIONS}
    return known[_one_of("precision", name, known)]


def _one_of(field: str, value: str, known: Iterable[str]) -> str:
    if value not in known:
        raise ValueError(f"{field}: expected {', '.join(known)}, got {value!a}")
    return value
