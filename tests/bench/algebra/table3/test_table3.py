"""Table 3 again: every method gives scipy's poses before it is timed, and the words follow it."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("casadi", reason="CasADi, which writes the code that is timed, is not here")
pytest.importorskip("scipy", reason="scipy, the reference of all methods, is not here")

from tests.bench.algebra.table3 import measure, methods
from tests.bench.algebra.table3.characters import RIGS, characters, random_character
from tests.bench.algebra.table3.paper import PAPER_MS, overheads_ms, paper_ns
from tests.bench.algebra.table3.reference import blended_matrices
from tests.bench.algebra.table3.report import table3_table, verdict

pytestmark = pytest.mark.slow
COMPILED = pytest.mark.skipif(
    not (shutil.which("cc") or shutil.which("gcc")), reason="no C compiler"
)


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    """A run that is as short as can be, of code that is compiled quickly."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(methods, "FLAGS", (*methods.FLAGS, "-O0"))
        return measure.bench_table3(seconds=1e-6, rounds=2)


@pytest.fixture(scope="module")
def blends(tmp_path_factory: pytest.TempPathFactory) -> methods.Blends:
    few = [m for m in methods.METHODS if m.name in ("quaternion", "motor_linear_program")]
    return methods.compile_blends(tmp_path_factory.mktemp("blends"), "float64", few)


@COMPILED
def test_a_run_has_every_method_on_every_character_in_both_precisions(
    found: dict[str, Any],
) -> None:
    keys = {(row["method"], row["scalar"], row["character"]) for row in found["rows"]}
    labels = [method.label for method in methods.METHODS]
    scalars, names = ("float32", "float64"), [name for name, _, _ in RIGS]
    assert keys == {(m, s, c) for m in labels for s in scalars for c in names}
    assert len(found["rows"]) == len(keys) == 84
    arrays = {row["method"] for row in found["array_rows"]}
    assert arrays >= {m.label for m in (*methods.ARRAY_METHODS, *measure.BESIDE_ARRAYS)}
    assert [one["joints"] for one in found["characters"]] == [43, 53, 53]


@COMPILED
def test_figures_carry_units_and_agree_with_each_other(found: dict[str, Any]) -> None:
    for row in json.loads(json.dumps(found))["rows"]:
        assert row["ns_a_joint_lower_quartile"] <= row["ns_a_joint"]
        assert row["ns_a_joint"] <= row["ns_a_joint_upper_quartile"]
        assert row["ms_a_character"] * 1e6 == pytest.approx(row["ns_a_joint"] * row["joints"])


@COMPILED
def test_the_table_shows_all_and_ends_in_what_was_left_out(found: dict[str, Any]) -> None:
    table = table3_table(found | {"left_out": ["GLM: none"]})
    assert table.endswith("left out: GLM: none")
    for method in methods.METHODS:
        assert sum(line.startswith(method.label) for line in table.splitlines()) >= 2
    assert " ".join(table.split()).count(found["verdict"]) == 1


@COMPILED
@pytest.mark.parametrize("name", ["quaternion", "motor_linear_program"])
def test_another_path_than_the_reference_is_refused(blends: methods.Blends, name: str) -> None:
    (method,) = (m for m in methods.METHODS if m.name == name)
    measure.timer(blends, method, random_character(43))
    other = methods.Method(method.name, method.label, method.rows, "screw")
    with pytest.raises(RuntimeError, match=re.escape(f"{method.label}, float64: expected")):
        measure.timer(blends, other, random_character(43))


def test_a_missing_compiler_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    found = measure.bench_table3(seconds=1e-6, rounds=1)
    assert found["rows"] == []
    assert any("no C compiler here" in reason for reason in found["left_out"])
    assert "Nothing was measured" in table3_table(found)


def test_the_paths_part_where_they_should() -> None:
    one = random_character(20)
    ends = [blended_matrices(p, one.first, one.second, 1.0) for p in ("slerp", "screw", "linear")]
    for matrices in ends:
        np.testing.assert_allclose(matrices, one.second.as_matrix()[:, :3], atol=1e-12)
    slerp, screw, linear = (
        blended_matrices(p, one.first, one.second, 0.3) for p in ("slerp", "screw", "linear")
    )
    np.testing.assert_allclose(slerp[..., :3], screw[..., :3], atol=1e-12)
    assert np.max(np.abs(slerp[..., 3] - screw[..., 3])) > 1e-3
    assert np.max(np.abs(linear - screw)) > 1e-3


def test_characters_have_the_joints_and_rest_poses_of_their_rigs(data_dir: Path) -> None:
    shown = characters(data_dir)
    assert [one.joints for one in shown] == [43, 53, 53]
    assert [one.source for one in shown] == [Path(rig).name for _, _, rig in RIGS]
    # From the rigs' own text: the neck of the first, a foot, the pelvis.
    np.testing.assert_allclose(shown[0].first.translation_m[1], [0, 0, 0.89333898], atol=1e-7)
    foot = [[0.99503785, -0.09949735, 0], [0.09949735, 0.99503785, 0], [0, 0, 1]]
    np.testing.assert_allclose(shown[1].first.as_matrix()[1, :3, :3], foot, atol=1e-7)
    np.testing.assert_allclose(shown[2].first.translation_m[1], [0, 0.93899, 0.00675], atol=1e-12)


def test_the_papers_figures_are_those_that_its_ratios_were_told_from() -> None:
    told = {
        "Dual-Quaternions": 5.6,
        "CGA Gaalop": 7.9,
        "Quaternions": 10.2,
        "CGA Versor": 19.8,
        "CGA Gaigen": 42.3,
    }
    assert {row: round(paper_ns(row), 1) for row in told} == told
    second, third = overheads_ms()
    assert (round(second.least_ms, 4), round(second.most_ms, 4)) == (0.0011, 0.0014)
    assert (round(third.least_ms, 4), round(third.most_ms, 4)) == (0.0003, 0.0009)
    assert all(len(row) == 3 for row in PAPER_MS.values())


def rows(**ns: float) -> list[dict[str, Any]]:
    """Rows of a run by the names of their methods; those not named take 50 ns."""
    return [
        {
            "method": m.label,
            "scalar": "float32",
            "character": name,
            "joints": joints,
            "ns_a_joint": ns.get(m.name, 50.0),
        }
        for m in methods.METHODS
        for name, joints, _ in RIGS
    ]


def test_the_verdict_says_what_the_figures_say() -> None:
    usual = {
        "dual_quaternion": 6.0,
        "motor_table": 3000.0,
        "motor_table_code": 300.0,
        "motor_product": 97.0,
        "motor_program": 90.0,
        "motor_linear_table": 2000.0,
        "motor_linear_table_code": 200.0,
        "motor_linear_product": 9.0,
        "motor_linear_program": 6.3,
        "rotor_table_code": 700.0,
        "rotor_program": 70.0,
    }
    words = verdict(rows(**usual))
    assert "agrees: linear and `program` takes 1.05 times" in words
    assert "program holds for both" in words
    assert "`program` is 10.0 times faster than `table-code`" in words
    assert "apart is the path" in words
    turned = verdict(
        rows(
            **(
                usual
                | {
                    "motor_linear_program": 60.0,
                    "rotor_table_code": 35.0,
                    "motor_linear_product": 95.0,
                }
            )
        )
    )
    assert "does not agree: linear and `program` takes 10.00 times" in turned
    assert "`program` is 2.0 times slower than `table-code`" in turned
    assert "apart is the generator" in turned
    swapped = verdict(rows(**(usual | {"motor_program": 99.0})))
    assert "program does not hold for both" in swapped
