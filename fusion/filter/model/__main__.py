"""``python -m motorcade.fusion.filter.model``: write the model as C, one function a definition.

``void name(const double pose[8], …, double next_pose[8], …)``; results may not overlap anything
that is read.
"""

from __future__ import annotations

import sys
from pathlib import Path

from motorcade.fusion.filter.model.definitions import MEASUREMENTS, MOTION, Definition
from motorcade.ga.codegen.library_kernels.kernel import collected
from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.recording import trace
from motorcade.ga.codegen.tape import Operand, Tape
from motorcade.ga.codegen.targets.c import c_dialect
from motorcade.ga.codegen.targets.shared.c_family import comment, declarations, indented, loads
from motorcade.ga.codegen.targets.shared.expressions import statements
from motorcade.ga.codegen.targets.shared.text import call

GENERATED = Path(__file__).resolve().parents[1] / "native" / "generated"
_NOTE = "Written by `python -m motorcade.fusion.filter.model`; edit fusion/filter/model."
_HEADER = """{title}
#ifndef MOTORCADE_FILTER_MODEL_H
#define MOTORCADE_FILTER_MODEL_H

#ifdef __cplusplus
extern "C" {{
#endif

{declared}
#ifdef __cplusplus
}}
#endif

#endif
"""
_GROUPS = {"motion": MOTION, "measurements": MEASUREMENTS}


def model_files() -> dict[str, str]:
    """Name and text of each generated file.

    Raises:
        ModuleNotFoundError: without CasADi or mpmath, which only this needs.
    """
    files = {"model.h": _header()}
    for group, definitions in _GROUPS.items():
        parts = [
            comment([f"The filter's {group}.", _NOTE]),
            '#include "model.h"\n\n#include <math.h>',
        ]
        parts += [_function(definition) for definition in definitions]
        files[f"{group}.c"] = "\n\n".join(parts) + "\n"
    return files


def write_model(folder: Path) -> list[Path]:
    """Write the generated files into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    files = model_files()
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in files]


def tape_of(definition: Definition) -> Tape:
    """The operations of a definition."""
    return collected(
        trace(definition.name, definition.inputs, definition.outputs, definition.define)
    )


def _header() -> str:
    declared = [
        line
        for definitions in _GROUPS.values()
        for definition in definitions
        for line in (_documented(definition), f"{_head(definition)};", "")
    ]
    title = "The filter's model: its motion, its measurements and their derivatives."
    return _HEADER.format(title=comment([title, _NOTE]), declared="\n".join(declared))


def _documented(definition: Definition) -> str:
    sides = (("in", definition.inputs), ("out", definition.outputs))
    operands = [
        f"{side} {operand.name}: {' '.join(operand.components)}"
        for side, of_side in sides
        for operand in of_side
        if operand.components != (operand.name,)
    ]
    return comment([*definition.summary, *operands])


def _head(definition: Definition) -> str:
    parameters = [
        f"double {operand.name}" if operand.width == 1 else f"const double {_array(operand)}"
        for operand in definition.inputs
    ] + [f"double {_array(operand)}" for operand in definition.outputs]
    return "\n".join(call(f"void {definition.name}", parameters, ""))


def _array(operand: Operand) -> str:
    return f"{operand.name}[{operand.width}]"


def _function(definition: Definition) -> str:
    tape = tape_of(definition)
    written = statements(tape, c_dialect(DOUBLE))
    body = [
        *(
            line
            for operand in definition.inputs
            if operand.width > 1 or not tape.components_read(operand.name)
            for line in loads(operand, tape, "const double")
        ),
        *declarations(written.body, "const double", "const _Bool"),
        *(
            f"{operand.name}[{i}] = {value};"
            for operand, row in zip(definition.outputs, written.results, strict=True)
            for i, value in enumerate(row)
        ),
    ]
    return "\n".join([_head(definition), "{", *indented(body), "}"])


if __name__ == "__main__":
    written = write_model(GENERATED)
    sys.stdout.write(f"{GENERATED}: {len(written)} files\n")
