"""Names of a script never break the code: a language's own are refused, the others compile."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.codegen.targets import TARGETS
from motorcade.ga.codegen.targets.names import C_NAMES, file_identifier
from motorcade.ga.script import parse

COMPILER = shutil.which("gcc")


def written(target: str, text: str, name: str = "scene") -> dict[str, str]:
    return TARGETS[target](compile_script(parse(text), name), None)


REFUSED_VARIABLES = [
    ("c", "double", "reserved in C or C\\+\\+", "double_"),
    ("c", "template", "reserved in C or C\\+\\+", "template_"),
    ("c", "fabs", "reserved", "fabs_"),
    ("c", "M_PI", "reserved", "M_PI_"),
    ("c", "a__b", "reserved", "a_b"),
    ("c", "_Bool", "reserved", "Bool"),
    ("c", "out_a", "used by the generated code", "out_a_"),
    ("c-batch", "row", "reserved", "row_"),
    ("c-batch", "in_other", "used by the generated code", "in_other_"),
    ("c-batch", "out_a_e1", "used by the generated code", "out_a_e1_"),
    ("numpy", "lambda", "reserved in Python code", "lambda_"),
    ("numpy", "np", "reserved", "np_"),
    ("numpy", "float", "reserved", "float_"),
    ("numpy", "_full", "reserved", "_full_"),
    ("torch", "torch", "reserved", "torch_"),
    ("torch", "None", "reserved", "None_"),
    ("casadi", "ca", "reserved", "ca_"),
    ("casadi", "_names", "reserved", "names"),
    ("glsl", "vec3", "reserved in GLSL", "vec3_"),
    ("glsl", "mix", "reserved", "mix_"),
    ("glsl", "gl_Position", "reserved", "Position"),
    ("glsl", "a__b", "reserved", "a_b"),
    ("glsl", "out_a", "used by the generated code", "out_a_"),
    ("cpp", "std", "reserved in C or C\\+\\+", "std_"),
    ("cpp", "M_PI", "reserved", "M_PI_"),
    ("rust", "fn", "reserved in Rust", "fn_"),
    ("rust", "None", "reserved", "None_"),
    ("rust", "_", "reserved", "_0"),
    ("javascript", "await", "reserved in JavaScript", "await_"),
    ("javascript", "Math", "reserved", "Math_"),
    ("wgsl", "f32", "reserved in WGSL", "f32_"),
    ("wgsl", "target", "reserved", "target_"),
    ("wgsl", "a__b", "reserved", "a_b"),
    ("wgsl", "out_a", "used by the generated code", "out_a_"),
    ("julia", "end", "reserved in Julia", "end_"),
    ("julia", "real_sqrt", "reserved", "real_sqrt_"),
    ("julia", "in", "reserved", "in_"),
]


@pytest.mark.parametrize(("target", "variable", "why", "other"), REFUSED_VARIABLES)
def test_a_variable_is_refused_with_the_name_to_use(
    target: str, variable: str, why: str, other: str
) -> None:
    script = "?a = {}*e1 + other*e2;"
    with pytest.raises(ValueError, match=f"variable {variable} is {why}") as refused:
        written(target, script.format(variable))
    assert str(refused.value).endswith(f": rename {variable} to {other}")
    written(target, script.format(other))


@pytest.mark.parametrize(
    ("target", "name", "other"),
    [
        ("c", "main", "main_"),
        ("c", "y1", "y1_"),
        ("c", "write", "write_"),
        ("c-batch", "sinf", "sinf_"),
        ("c", "class", "class_"),
        ("c", "_scene", "scene"),
        ("numpy", "class", "class_"),
        ("numpy", "numpy", "numpy_"),
        ("torch", "torch", "torch_"),
        ("casadi", "jac", "jac_"),
        ("glsl", "main", "main_"),
        ("glsl", "normalize", "normalize_"),
        ("rust", "main", "main_"),
        ("javascript", "class", "class_"),
        ("wgsl", "select", "select_"),
        ("julia", "sqrt", "sqrt_"),
    ],
)
def test_a_file_name_is_refused_with_the_name_to_use(target: str, name: str, other: str) -> None:
    with pytest.raises(ValueError, match=f"file name {name} is .*: rename {name} to {other}$"):
        written(target, "?a = x;", name)
    written(target, "?a = x;", other)


def test_a_name_that_is_taken_is_not_proposed() -> None:
    with pytest.raises(ValueError, match=r"rename double to double_0$"):
        written("c", "?a = double*e1 + double_*e2;")


def test_outputs_that_would_share_a_parameter_are_refused() -> None:
    text = "?a_e1 = x*e2;\n?a = y*e1^e2;"
    written("c", text)
    with pytest.raises(ValueError, match=r"a_e1 .*out_a_e1_e2.*: rename a to a_$|rename a_e1 to"):
        written("c-batch", text)


@pytest.mark.parametrize("target", list(TARGETS))
def test_outputs_may_have_any_name_and_that_of_a_variable(
    target: str, tmp_path: Path, loaded: Any
) -> None:
    text = "x = x + 1;\n?x;\n?double = 2*x;\n?lambda = 3*x*e1;\n?float = x;\n?np = x;"
    made = written(target, text)
    if target in ("c", "c-batch"):
        compiled(made["scene.c"], tmp_path)
    elif target == "numpy":
        assert loaded(made["scene.py"], "scene").scene(x=1.0)["np"] == {"1": 2.0}


def compiled(source: str, folder: Path) -> None:
    if COMPILER is None:
        pytest.skip("no gcc here")
    (folder / "scene.c").write_text(source)
    flags = ["-std=gnu17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    command = ["gcc", *flags, str(folder / "scene.c")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_variables_named_like_intermediate_values_are_kept_apart(loaded: Any) -> None:
    text = "s = sin(t0)*t1;\n?a = s*s + s*t2 + s;"
    made = loaded(written("numpy", text)["scene.py"], "scene").scene(t0=0.5, t1=2.0, t2=3.0)
    s = 2.0 * 0.479425538604203
    assert made["a"]["1"] == pytest.approx(s * s + 3 * s + s, rel=1e-14)


@pytest.mark.skipif(COMPILER is None, reason="no gcc here")
@pytest.mark.parametrize("target", ["c", "c-batch"])
def test_no_macro_of_the_compiler_or_of_math_h_can_be_a_variable(
    target: str, tmp_path: Path
) -> None:
    macros = subprocess.run(
        ["gcc", "-std=gnu17", "-E", "-dM", "-include", "math.h", "-include", "stddef.h", "-"],
        input="",
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    found = re.findall(r"^#define ([A-Za-z]\w*) ", macros, re.MULTILINE)
    assert "M_PI" in found
    variables = [name for name in (*found, *library_functions()) if not C_NAMES.keeps(name)]
    compiled(written(target, f"?a = {' + '.join(variables[:200])};")["scene.c"], tmp_path)


def library_functions() -> list[str]:
    """What the headers that every C program includes declare, ``y1`` and ``index`` among them."""
    headers = "".join(f"#include <{name}.h>\n" for name in ("math", "stdlib", "string", "stdio"))
    told = subprocess.run(
        ["gcc", "-std=gnu17", "-E", "-P", "-"],
        input=headers,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    declared = set(re.findall(r"\b([a-z]\w*) ?\(", told))
    return sorted(declared - {"__attribute__", "__asm__"})


@pytest.mark.skipif(COMPILER is None, reason="no gcc here")
def test_no_function_of_the_c_library_can_be_a_file_name() -> None:
    declared = library_functions()
    assert {"sin", "y1", "index", "printf"} <= set(declared)
    free = [n for n in declared if not C_NAMES.keeps(n) and n not in C_NAMES.functions]
    assert free == []


@pytest.mark.parametrize("target", list(TARGETS))
def test_no_text_of_a_script_gets_into_the_code(target: str) -> None:
    text = '// */ """ secret\n/* secret */\n?a = x*e1; // secret\n//#pragma output a e1'
    assert all("secret" not in made for made in written(target, text).values())


def test_file_names_become_identifiers() -> None:
    names = {
        "scene": "scene",
        "scene_": "scene_",
        "my-scene.v2": "my_scene_v2",
        "2d": "script_2d",
        "--": "script",
        "größe": "gr_e",
    }
    assert {name: file_identifier(name) for name in names} == names
