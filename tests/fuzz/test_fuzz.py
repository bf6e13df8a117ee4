"""A slice of every kind that is fuzzed; and that faults, crashes and hangs are found at all."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz import guided, runner, targets
from tests.fuzz.__main__ import recorded, table
from tests.fuzz.kinds import casts, manifests, scripts
from tests.fuzz.own import RefusedError, ended, is_own, refusals

QUICK = {"scripts": 700, "rigs": 1000}


@pytest.mark.parametrize(
    "kind",
    [
        kind if kind in QUICK else pytest.param(kind, marks=pytest.mark.slow)
        for kind in runner.KINDS
    ],
)
def test_hostile_inputs_are_refused_or_read(kind: str, tmp_path: Path) -> None:
    """By the command: a fork of this process inherits drivers and threads that no command has."""
    record, inputs = tmp_path / "runs.jsonl", str(QUICK.get(kind, 150))
    command = [sys.executable, "-m", "tests.fuzz", kind, "--seed", "20", "--inputs", inputs]
    command += ["--seconds", "60", "--record", str(record)]
    done = subprocess.run(command, cwd=runner.REPOSITORY, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    if not record.exists():
        pytest.skip(done.stdout.strip())
    (found,) = map(json.loads, record.read_text().splitlines())
    assert found["ended"]["refused"] > 0
    assert len(found["ended"]) > 1


@pytest.mark.parametrize("kind", scripts.MAKERS)
def test_scripts_of_every_kind_are_made(kind: str) -> None:
    texts = {scripts.MAKERS[kind][1](np.random.default_rng(seed)) for seed in range(20)}
    assert len(texts) > 5


def test_every_key_of_a_manifest_has_right_values() -> None:
    keys = {key for table, keys in manifests.KEYS.items() for key in keys}
    assert keys - set(manifests.KEYS) == set(manifests.RIGHT)


def test_every_key_of_a_cast_has_right_values() -> None:
    keys = {key for keys in casts.KEYS.values() for key in keys}
    assert keys - set(casts.KEYS) == set(casts.RIGHT)


def prepare(folder: Path) -> runner.Feed:
    """Inputs that end in every way there is, by their first random number."""

    def feed(rng: np.random.Generator) -> str:
        kind = int(rng.integers(6))
        if kind == 0:
            raise KeyError("left")
        if kind == 1:
            os.kill(os.getpid(), signal.SIGSEGV)
        if kind == 2:
            time.sleep(runner.WALL_S + 60)
        if kind == 3:
            held = np.ones(runner.GROWTH_BYTES // 4)
            return str(held.size)
        return "valid"

    return feed


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "feed_of", lambda kind, folder: prepare(folder))
    monkeypatch.setattr(runner, "WALL_S", 1)
    monkeypatch.setattr(runner, "GROWTH_BYTES", 1 << 27)


@pytest.mark.usefixtures("made_up")
def test_faults_crashes_hangs_and_growth_are_counted_and_the_rest_goes_on() -> None:
    told: list[str] = []
    found = runner.run("made up", seed=5, inputs=12, seconds=300.0, tell=told.append)
    kinds = [int(runner.fresh(5, number).integers(6)) for number in range(12)]
    assert found.inputs >= 12 - kinds.count(1)  # what a crash takes along may be lost
    assert found.ended["FAULT"] >= sum(kind < 3 for kind in kinds)
    for kind, text in (
        (0, "KeyError: 'left'"),
        (1, "process ended with -11"),
        (2, "waited"),
        (3, "grew"),
    ):
        assert (kind in kinds) == any(text in line for line in told)
    assert f"--only {kinds.index(0)}: " in "\n".join(told)


def test_only_errors_that_the_product_raises_itself_are_own() -> None:
    from motorcade.ga import Rotor

    assert ended(lambda: Rotor([1.0, 1.0, 0.0, 0.0])) == "refused"
    assert ended(lambda: Rotor([1.0, 0.0, 0.0, 0.0])) == "valid"
    for fault in (lambda: np.zeros(3).reshape(2, 2), lambda: {}["a"], lambda: int("x")):
        with pytest.raises((ValueError, KeyError)) as caught:
            ended(fault)
        assert not is_own(caught.value)
    with pytest.raises(RefusedError), refusals():
        Rotor(np.zeros(3))


@pytest.mark.slow
@pytest.mark.parametrize("target", targets.TARGETS)
def test_inputs_led_by_coverage_are_refused_or_read(target: str) -> None:
    pytest.importorskip("atheris", reason="atheris, which leads by coverage, is not installed")
    found = guided.run(target, seed=20, inputs=600, seconds=20.0)
    assert not found.faults
    assert found.inputs >= 500
    assert set(found.ended) == {"valid", "refused"}


def test_results_are_told_in_a_table() -> None:
    first, second = runner.Result("rigs", 7), runner.Result("rigs", 9)
    first.add(0, "refused", "", 0.1)
    second.add(4, "character", "", 0.3)
    second.add(5, "FAULT", "door.py:1: KeyError: x", 0.2)
    lines = [json.dumps(recorded(one)) for one in (first, second)]
    rows = table(lines).splitlines()
    assert rows[2] == "| rigs | 3 | 1 | 1 | 1 | 7, 9 | 0.3 s | 0 MiB |"
    assert rows[3].startswith("| all | 3 | 1 | 1 | 1 |")


def test_the_page_shows_what_was_fed_last() -> None:
    lines = Path(__file__).with_name("fuzzed.jsonl").read_text().splitlines()
    page = Path(__file__).parents[2] / "SECURITY.md"
    if not page.exists():
        pytest.skip("no pages here: an installed wheel is tested")
    assert table(lines) in page.read_text()
