"""Programs say what their scripts say: inputs, outputs, blades, and what is refused."""

import pytest

pytest.importorskip("casadi", reason="CasADi, which only the generator needs, is not installed")

from motorcade.ga.codegen.programs import compile_script
from motorcade.ga.script import ScriptError, parse


def test_inputs_come_in_the_order_of_first_use_and_outputs_in_that_of_the_script() -> None:
    program = compile_script(parse("?b = y*e3^e1 + x; ?a = b*b + z*einf;", "f.clu"), "f")
    assert [operand.name for operand in program.tape.inputs] == ["y", "x", "z"]
    assert all(operand.components == ("1",) for operand in program.tape.inputs)
    assert [operand.name for operand in program.tape.outputs] == ["b", "a"]
    assert program.tape.outputs[0].components == ("1", "e1^e3")
    assert program.tape.outputs[1].components == ("1", "einf", "e1^e3")


def test_an_output_of_which_nothing_is_left_keeps_its_name() -> None:
    program = compile_script(parse("?gone = x*e1 - x*e1; ?left = 2;", "f.clu"), "f")
    assert program.tape.outputs[0].components == ()
    assert program.tape.outputs[1].components == ("1",)


@pytest.mark.parametrize("name", ["", "2a", "a-b", "ä", "a b", "a\n"])
def test_names_that_are_no_identifiers_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="name: expected an identifier, got"):
        compile_script(parse("?a = x;", "f.clu"), name)


def test_what_cannot_be_compiled_is_refused() -> None:
    with pytest.raises(ValueError, match="f: expected a script with outputs, got none"):
        compile_script(parse("a = x;", "f.clu"), "f")
    with pytest.raises(ScriptError, match="no free variable can be named algebra"):
        compile_script(parse("?a = algebra;", "f.clu"), "f")
