"""A script as GLSL compiles for desktop and ES shaders, and computes what its evaluation says."""

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.precision import DOUBLE
from motorcade.ga.codegen.programs import Program, compile_script
from motorcade.ga.codegen.targets import glsl
from motorcade.ga.script import parse

moderngl = pytest.importorskip("moderngl", reason="moderngl is not installed")

PREAMBLES = {
    "330": "#version 330 core\n",
    "300 es": "#version 300 es\nprecision highp float;\n",
}
# As many values as any driver can write beside each other.
WRITTEN_AT_ONCE = 64


@pytest.fixture(scope="module")
def context() -> Iterator[Any]:
    try:
        made = moderngl.create_standalone_context(backend="egl", require=330)
    except Exception as missing:
        pytest.skip(f"no OpenGL context by EGL here: {missing}")
    made.simple_framebuffer((1, 1)).use()  # without one, drawing is an error
    yield made
    made.release()


def computed(context: Any, preamble: str, program: Program, inputs: dict[str, Any]) -> np.ndarray:
    """All components of all outputs, one a row, by transform feedback."""
    (function,) = glsl.write(program, None).values()
    rows = len(next(iter(inputs.values())))
    packed = np.zeros((rows, -(-len(inputs) // 4) * 4), np.float32)
    packed[:, : len(inputs)] = np.stack(list(inputs.values()), axis=1)
    attributes = [f"in{k}" for k in range(packed.shape[1] // 4)]
    outputs = [o for o in program.tape.outputs if o.components]
    places = iter([f"out_{o.name}[{i}]" for o in outputs for i in range(o.width)])
    parts = []
    while chosen := list(islice(places, WRITTEN_AT_ONCE)):
        shader = [preamble, function, *(f"in vec4 {name};" for name in attributes)]
        shader += [f"out float made{k};" for k in range(len(chosen))]
        shader += ["void main() {", f"gl_Position = {' + '.join(attributes)};"]
        shader += [f"float out_{o.name}[{o.width}];" for o in outputs]
        given = [f"in{k // 4}[{k % 4}]" for k in range(len(inputs))]
        shader.append(
            f"{program.name}({', '.join([*given, *(f'out_{o.name}' for o in outputs)])});"
        )
        shader += [*(f"made{k} = {place};" for k, place in enumerate(chosen)), "}"]
        names = [f"made{k}" for k in range(len(chosen))]
        compiled = context.program(vertex_shader="\n".join(shader), varyings=names)
        buffer = context.buffer(packed.tobytes())
        layout = (buffer, f"{packed.shape[1] // 4 * '4f '}".strip(), *attributes)
        result = context.buffer(reserve=4 * len(chosen) * rows)
        vertices = context.vertex_array(compiled, [layout])
        vertices.transform(result, moderngl.POINTS, vertices=rows)
        assert context.error == "GL_NO_ERROR"
        parts.append(np.frombuffer(result.read(), np.float32).reshape(rows, -1).T)
    return np.concatenate(parts)


@pytest.mark.parametrize("version", list(PREAMBLES))
def test_it_agrees_with_evaluation(script: str, version: str, cases: Any, context: Any) -> None:
    case = cases(script, "float32")
    made = computed(context, PREAMBLES[version], case.program, case.inputs)
    case.checked(case.by_place(made), 1e-5)


def test_nothing_is_left_of_an_output_without_components() -> None:
    program = compile_script(parse("?zero = x - x;\n?a = x;"), "gone")
    (text,) = glsl.write(program, None).values()
    assert "void gone(float x, out float out_a[1])" in text
    assert "zero: none, it is zero" in text


def test_it_is_in_single_precision_only() -> None:
    program = compile_script(parse("?a = x;"), "one")
    with pytest.raises(ValueError, match="target glsl: expected precision float32, got float64"):
        glsl.write(program, DOUBLE)
