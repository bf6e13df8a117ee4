"""Inputs that are led by what they reach: parsers in Python under atheris, libFuzzer for Python.

An input that runs lines or compares values that none before did is kept and changed further, so
that words, lengths and nesting are found which no sample has. Each target begins with the samples
of its kind. Faults are what they are for every kind (see `tests.fuzz.own`).
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numpy as np

from tests.fuzz.own import ended
from tests.fuzz.runner import REPOSITORY, Result, SkippedError
from tests.fuzz.targets import TARGETS, Target

__all__ = ["run"]

LONGEST_BYTES = 4096
SLOWEST_S = 10
MEMORY_MIB = 3000
TELL_EVERY = 500
FROM_VALID, MOST_VALID = 0.6, 500
"""Share of changes that are made of valid inputs, and how many of these are kept for it."""
KEPT_WHOLE, BROKEN = 0.7, 0.15
"""Shares of changes that keep words whole, and of our faults; the others are libFuzzer's own."""


def run(target: str, seed: int, inputs: int, seconds: float) -> Result:
    """Feed a target for so long; faults end it.

    Raises:
        SkippedError: atheris is not installed.
        RuntimeError: it sees nothing of what runs, so that nothing is led.
    """
    if find_spec("atheris") is None:
        raise SkippedError("atheris, which leads by coverage, is not installed")
    result, begun = Result(target, seed), time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        numbers = map(str, (seed, inputs, max(1, round(seconds))))
        done = subprocess.run(
            [sys.executable, "-m", "tests.fuzz.guided", target, name, *numbers],
            cwd=REPOSITORY,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        counts = folder / "counts.json"
        result.ended = Counter(json.loads(counts.read_text()) if counts.is_file() else {})
        result.inputs = result.ended.total()  # those after it was last told are not counted
        peaks = [int(one) for one in re.findall(r"rss: (\d+)Mb", done.stderr)]
        result.peak_bytes = max(peaks, default=0) << 20
        if done.returncode == 0 and " cov: " not in done.stderr:
            raise RuntimeError(f"{target}: no line that runs is seen: {done.stderr[-1500:]}")
        if done.returncode:
            found = next(folder.glob("fault-*"), None)
            what = b"" if found is None else found.read_bytes()[:300]
            result.ended["FAULT"] += 1
            result.faults.append(f"{target} --seed {seed}: {what!r}: {done.stderr[-1500:]}")
    result.seconds = time.monotonic() - begun
    return result


class _BySource(MetaPathFinder):
    """Loads modules by the usual loader: of that of an editable install, atheris sees nothing."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            spec = finder.find_spec(name, path, target)
            if spec is not None:
                if spec.origin is not None and spec.origin.endswith(".py"):
                    spec.loader = SourceFileLoader(name, spec.origin)
                return spec
        return None


def _lead(target: str, folder: Path, seed: int, inputs: int, seconds: int) -> None:
    """Run atheris in this process, which it ends."""
    import logging

    import atheris

    logging.getLogger("motorcade").setLevel(logging.CRITICAL)
    sys.meta_path.insert(0, _BySource())
    with atheris.instrument_imports(include=["motorcade"]):
        chosen = TARGETS[target](folder)
        for sample in chosen.samples:
            chosen.read(sample)  # they are valid; and whatever is imported on the way
    corpus = folder / "corpus"
    corpus.mkdir()
    for index, sample in enumerate(chosen.samples):
        (corpus / f"{index}").write_bytes(sample[:LONGEST_BYTES])
    counts: Counter[str] = Counter()
    kept = folder / "counts.json"

    valid = [sample[:LONGEST_BYTES] for sample in chosen.samples]

    def feed(data: bytes) -> None:
        outcome = ended(lambda: chosen.read(data))
        counts[outcome] += 1
        if outcome == "valid":
            valid.append(data)
            if len(valid) > MOST_VALID:
                valid.pop(len(chosen.samples))
        if counts.total() % TELL_EVERY == 0:
            kept.write_text(json.dumps(counts))

    options = [f"-seed={seed}", f"-max_len={LONGEST_BYTES}", f"-timeout={SLOWEST_S}"]
    options += [f"-rss_limit_mb={MEMORY_MIB}", f"-max_total_time={seconds}", f"-runs={inputs}"]
    options += [f"-artifact_prefix={folder}/fault-", "-mutate_depth=2"]
    changes = _changes(chosen, valid)
    atheris.Setup([sys.argv[0], *options, str(corpus)], feed, custom_mutator=changes)
    atheris.Fuzz()


def _changes(target: Target, valid: list[bytes]) -> Callable[[bytes, int, int], bytes]:
    """What libFuzzer asks to change an input: its bytes, the most that it may have, a seed."""
    import atheris

    from tests.fuzz.mutations import mutated, reworded, tokens  # of modules that are instrumented

    known = tokens(b"\n".join((*target.samples, *target.words)))

    def changed(data: bytes, most: int, seed: int) -> bytes:
        rng = np.random.default_rng(seed)
        if rng.random() < FROM_VALID:  # else what libFuzzer keeps, which is refused most often
            data = valid[int(rng.integers(len(valid)))]
        kind = rng.random()
        if kind < KEPT_WHOLE:
            made = reworded(data, known, rng)
        elif kind < KEPT_WHOLE + BROKEN:
            made = mutated(target.suffix, data, rng)
        else:
            made = atheris.Mutate(data, most)
        return bytes(made[:most])

    return changed


if __name__ == "__main__":
    os.environ.setdefault("MOTORCADE_THREADS", "1")
    _target, _folder, *_numbers = sys.argv[1:]
    _lead(_target, Path(_folder), *map(int, _numbers))
