"""Python functions become programs that compute what the functions do."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga import Motor
from motorcade.ga.algebra import CGA3, EGA3, PGA3, Multivector
from motorcade.ga.algebra.conformal import of_versor
from motorcade.ga.codegen import program
from motorcade.ga.codegen.functions import CompiledFunction, compile_function
from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.script import parse

ROTOR = "1 e2^e3 e3^e1 e1^e2"
MOTOR = f"{ROTOR} e1^einf e2^einf e3^einf e1^e2^e3^einf"


@program(algebra=CGA3, motor=MOTOR, vector="e1 e2 e3")
def moved(motor: Multivector, vector: Multivector, size: Multivector) -> Multivector:
    point = size * vector
    point = point + (point * point) * CGA3.blade("einf") / 2 + CGA3.blade("e0")
    return motor.sandwich(point)


def test_a_program_of_python_moves_points_as_the_library_does(rng: np.random.Generator) -> None:
    motor = Motor.random(rng, (9,))
    vectors = rng.standard_normal((9, 3))
    coordinates = dict(zip(("e1", "e2", "e3"), vectors.T, strict=True))
    made = moved(of_versor(motor), CGA3.multivector(coordinates), 2.0)
    assert isinstance(made, Multivector)
    expected = motor.apply(2.0 * vectors)
    found = np.stack([made.coefficient(name) for name in ("e1", "e2", "e3")], axis=-1)
    np.testing.assert_allclose(found / made.coefficient("e0")[:, None], expected, atol=1e-12)
    assert made.blades == ("e1", "e2", "e3", "e0", "einf"), "odd parts cancel and are not there"


def test_a_function_and_a_script_are_one_program() -> None:
    def area(x: Any, y: Any) -> dict[str, Any]:
        return {"area": (x * CGA3.blade("e1")) ^ (y * CGA3.blade("e2")), "twice": x + x}

    made = compile_function(area)
    script = parse("?area = (x*e1)^(y*e2); ?twice = x + x;", "area.clu")
    assert made.program.tape == compile_script(script, "area").tape
    assert isinstance(made, CompiledFunction)
    both = made(2.0, y=np.array([1.0, 3.0]))
    assert isinstance(both, dict)
    np.testing.assert_array_equal(both["area"].coefficient("e1^e2"), [2.0, 6.0])
    np.testing.assert_array_equal(both["twice"].coefficient("1"), 4.0)


def test_inputs_are_the_blades_that_were_named() -> None:
    def turned(rotor: Any, x: Any) -> Any:
        return rotor * x

    made = compile_function(turned, algebra=EGA3, rotor=ROTOR)
    inputs = made.program.tape.inputs
    assert [operand.components for operand in inputs] == [tuple(ROTOR.split()), ("1",)]
    assert made.program.tape.outputs[0].name == "result"
    result = made(EGA3.multivector({"e1^e3": 1.0, "1": 2.0}), 3.0)
    assert isinstance(result, Multivector)
    assert result.coefficient("e1^e3") == 3.0
    assert result.coefficient("e3^e1") == -3.0
    assert result.coefficient("1") == 6.0


def test_what_depends_on_values_is_refused() -> None:
    def compared(x: Any) -> Any:
        return x if x.scalar_part() > 0 else -x

    def ordered(x: Any) -> Any:
        return x if x > 0 else -x

    def tested(x: Any) -> Any:
        return 1 / x if x else x

    def equal(x: Any) -> Any:
        return x if x == 0 else 1 / x

    def unequal(x: Any) -> Any:
        return 1 / x if x != 0.0 else x

    for function in (compared, ordered, tested, equal, unequal):
        with pytest.raises(ValueError, match="got a branch on one; both ways can be computed"):
            compile_function(function)


def test_functions_that_cannot_be_traced_are_refused() -> None:
    def optional(x: Any = 1.0) -> Any:
        return x

    def variadic(*x: Any) -> Any:
        return x[0]

    def nothing(x: Any) -> None:
        del x

    def elsewhere(x: Any) -> Any:
        del x
        return PGA3.blade("e1")

    def clashing(x: Any, x1: Any) -> Any:
        return x * x1

    for function, blades, message in (
        (optional, {}, "optional: expected plain parameters"),
        (variadic, {}, "variadic: expected plain parameters"),
        (nothing, {}, "nothing: expected to return multivectors, got NoneType"),
        (elsewhere, {}, "elsewhere: expected results in"),
        (clashing, {"x": "e1 e2"}, "got two of the name x1"),
        (clashing, {"y": "e1"}, "expected blades of a parameter, got some of y"),
        (clashing, {"x": "e9"}, "expected a blade of"),
        (clashing, {"x": " "}, "got a parameter without any"),
    ):
        with pytest.raises(ValueError, match=message):
            compile_function(function, **blades)
    with pytest.raises(ValueError, match="function: expected an identifier, got '<lambda>'"):
        compile_function(lambda x: x)


def test_arguments_that_do_not_fit_are_refused() -> None:
    def plain(x: Any, y: Any) -> Any:
        return x * y

    made = compile_function(plain, algebra=EGA3, x="e1 e2")
    for args, message in (
        ((1.0,), "plain: expected arguments x, y, got 0"),
        ((EGA3.blade("e3"), 1.0), "x: expected blades e1 e2, got also e3"),
        ((CGA3.blade("e1"), 1.0), "x: expected a multivector of"),
        ((EGA3.blade("e1"), np.nan), "expected a finite number"),
    ):
        with pytest.raises(ValueError, match=message):
            made(*args)
