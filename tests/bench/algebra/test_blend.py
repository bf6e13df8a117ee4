"""The benchmark measures the same work on both sides, or says that it could not."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, kernels
from tests.bench.__main__ import main
from tests.bench.algebra import blend, glm
from tests.bench.tables import SUITES
from tests.bench.timing import on_one_core


@pytest.mark.parametrize("scalar", ["float32", "float64"])
@pytest.mark.parametrize("joints", [54, 1000])
def test_glm_and_the_kernels_turn_alike(joints: int, scalar: glm.Scalar, tmp_path: Path) -> None:
    try:
        program = glm.compile_glm(tmp_path)
    except glm.NotMeasured as missing:
        pytest.skip(str(missing))
    rows, (floor,) = blend._one_size(program, None, scalar, joints, 0.002, 1)
    assert {row.method for row in rows} == {*blend.OURS.values(), *blend.GLM.values()}
    assert all(row.ns > 0 for row in rows)
    assert floor["memory_ns"] > 0


@pytest.mark.parametrize("scalar", ["float32", "float64"])
def test_quaternions_in_arrays_turn_as_the_kernels_do(scalar: glm.Scalar, tmp_path: Path) -> None:
    try:
        program = glm.compile_arrays(tmp_path)
    except glm.NotMeasured as missing:
        pytest.skip(str(missing))
    poses = blend.random_poses(64)
    figures = glm.measure_arrays(program, poses, scalar, 0.002)
    for ours, other in (("blend_matrix", "nlerp_arrays"), ("screw_blend_matrix", "slerp_arrays")):
        _, checksum = blend._ours(ours, poses, scalar, 0.001)
        blend._check_same(ours, checksum, figures[other]["checksum"], scalar)
        assert figures[other]["ns"] > 0
    rows, floors = blend._one_size(None, program, scalar, 54, 0.002, 1)
    assert {row.method for row in rows} == {*blend.OURS.values(), *blend.ARRAYS.values()}
    assert floors == []


def test_other_work_is_found_out() -> None:
    blend._check_same("blend_matrix", 100.0, 100.001, "float32")
    with pytest.raises(RuntimeError, match="give other rotations"):
        blend._check_same("blend_matrix", 100.0, 100.001, "float64")


def test_our_checksum_is_that_of_the_matrices_of_the_poses_blended() -> None:
    poses = blend.random_poses(64)
    _, checksum = blend._ours("screw_blend_matrix", poses, "float64", 0.001)
    first, second = (
        Motor.from_quaternion_translation(poses[:, side, :4], poses[:, side, 4:]) for side in (0, 1)
    )
    rotation = first.interpolate(second, blend.FRACTION).rotor.as_matrix()
    weight = (4 * np.arange(3)[:, None] + np.arange(3)) + 1.0
    assert checksum == pytest.approx(float(np.sum(rotation * weight)), rel=1e-11)


def test_a_missing_compiler_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(glm.NotMeasured, match=r"no C\+\+ compiler here \(apt-get install g\+\+\)"):
        glm.compile_glm(tmp_path)


def test_one_core_and_one_thread_only_inside_the_block() -> None:
    before = kernels.threads()
    with on_one_core():
        assert kernels.threads() == 1
    assert kernels.threads() == before


def test_the_table_tells_what_was_left_out() -> None:
    rows = [
        {
            "method": "motor linear",
            "scalar": scalar,
            "joints": joints,
            "ns": 1.5,
            "over_slerp_mix": None,
            "over_nlerp_mix": None,
        }
        for scalar in ("float32", "float64")
        for joints in blend.SIZES
    ]
    found = {"rows": rows, "floors": [], "python": {"scipy": 345.0}, "left_out": ["GLM: none"]}
    table = blend.blend_table(found)
    assert "left out: GLM: none" in table
    assert "motor linear, float32" in table


def test_unknown_suites_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["blnd"])
    told = capsys.readouterr().err
    assert "expected suites of" in told
    assert "got 'blnd'" in told


@pytest.mark.parametrize("name", SUITES)
def test_every_suite_is_where_the_table_says(name: str) -> None:
    module, *functions = SUITES[name]
    suite = importlib.import_module(f"tests.bench.{module}")
    assert all(callable(getattr(suite, function)) for function in functions)


def test_the_help_names_every_suite(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    told = capsys.readouterr().out
    assert all(name in told for name in SUITES)
