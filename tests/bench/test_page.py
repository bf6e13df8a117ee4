"""The page of benchmarks says what was measured, beside what, and by which command."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.bench.page import MACHINE, headlines, machine, page
from tests.bench.tables import SUITES
from tests.ga.kernels.accuracy_fresh import LIMITS

HOST = ("processor", "cores", "kernels", "compiler", "python", "numpy")
BLEND = [
    {
        "method": method,
        "scalar": "float32",
        "joints": joints,
        "ns": ns,
        "over_slerp_mix": 8.0 / ns,
        "over_nlerp_mix": 6.0 / ns,
    }
    for joints in (64, 1000, 100_000)
    for method, ns in (
        ("motor linear", 2.0),
        ("motor screw", 4.0),
        ("GLM slerp + mix", 8.0),
        ("GLM nlerp + mix", 6.0),
    )
]
FIGURES: dict[str, Any] = {
    MACHINE: {"processor": "a small one", "cores": "2"},
    "accuracy": {
        "hard": {"float32": {"log": 2e-7, "exp": 3e-7}, "float64": {"log": 5e-16, "exp": 4e-16}},
        "fresh": {
            precision: dict.fromkeys(LIMITS, (size, 1.5)) | {"log": (size, 2.5)}
            for precision, size in (("float32", 3e-7), ("float64", 6e-16))
        },
    },
    "smooth": {
        "rows": [
            {"job": "RTS", "way": "motors", "seconds": 0.5, "over_ours": 1.0},
            {"job": "RTS", "way": "NumPy", "seconds": 2.0, "over_ours": 4.0},
        ],
        "bytes_a_pose": {"one_euro": 80.0},
    },
}


def test_a_headline_names_both_sides_their_ratio_and_the_command() -> None:
    found = {one.what: one for one in headlines(FIGURES | {"blend": {"rows": BLEND}})}
    blended = found["two poses blended, motor linear, float32, 1000 joints"]
    assert (blended.ours, blended.other) == ("2.0 ns a joint", "6.0 (GLM nlerp + mix)")
    assert (blended.ratio, blended.suite) == (3.0, "blend")
    assert found["RTS"].ratio == 4.0
    hard = found["largest error of all kernels where formulas fail, float64 (`log`)"]
    assert hard.ours == "5.0e-16"
    fresh = found["largest error on a million fresh motors, float64 (`log`)"]
    assert fresh.ours == "2.5 roundings times the condition"


def test_the_page_holds_machine_tables_and_commands() -> None:
    text = page(FIGURES)
    assert "| processor | a small one |" in text
    for suite in ("accuracy", "smooth"):
        assert f"## {suite}" in text
        assert f"```sh\nmake bench SUITE={suite}\n```" in text
    assert "RTS: NumPy" in text
    told = re.search(r"## Not in this run\n\n(.*)", text)
    assert told is not None
    assert {f"`make bench SUITE={name}`" for name in set(SUITES) - set(FIGURES)} == set(
        told[1].rstrip(".").split(", ")
    )


def test_the_same_figures_make_the_same_page(tmp_path: Path) -> None:
    kept = tmp_path / "bench.json"
    kept.write_text(json.dumps(FIGURES))
    assert page(json.loads(kept.read_text())) == page(FIGURES)


@pytest.mark.parametrize("figures", [{}, {"blnd": {}}, {MACHINE: {}}])
def test_what_is_no_suite_is_refused(figures: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="figures: expected suites of"):
        page(figures)


def test_the_machine_is_told_without_a_date() -> None:
    told = machine()
    assert set(told) == {*HOST, "beside"}
    assert all(told.values())
