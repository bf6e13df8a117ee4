"""Which tests reach which lines, and how long each takes: one run of the tests under coverage."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from coverage import CoverageData

from tests.mutation.mutants import Mutant
from tests.mutation.running import Watch, forked, run_tests

__all__ = ["Measured", "measured"]

_LONGEST_S = 3600.0


@dataclass(frozen=True)
class Measured:
    """What a run of the tests told: seconds of each that passed, lines with their tests."""

    seconds: dict[str, float]
    lines: CoverageData

    @cached_property
    def _of_no_line(self) -> set[str]:
        """Tests that call nothing: they look at the modules themselves."""
        reaching = {name.rpartition("|")[0] for name in self.lines.measured_contexts()}
        return self.seconds.keys() - reaching

    def tests_of(self, file: Path, mutant: Mutant, most_s: float) -> list[str]:
        """Tests that reach a mutant, quick ones first, in files that reach it most often first.

        Of all that reach it as many as take `most_s` together; at least one parameter of each test
        function comes before the second of any.
        """
        contexts = self.lines.contexts_by_lineno(str(file.resolve()))
        names = _names(contexts, range(mutant.lines[0], mutant.lines[1] + 1))
        if mutant.at_import or names == {""}:
            names = _names(contexts, contexts) | self._of_no_line
        turns: Counter[str] = Counter()
        ranked = []
        for name in sorted(
            names & self.seconds.keys(), key=lambda name: (self.seconds[name], name)
        ):
            function = name.partition("[")[0]
            ranked.append((turns[function], self.seconds[name], name))
            turns[function] += 1
        chosen, spent = [], 0.0
        for _, seconds, name in sorted(ranked):
            spent += seconds
            if chosen and spent > most_s:
                break
            chosen.append(name)
        functions = Counter(
            name.partition("::")[0] for name in {n.partition("[")[0] for n in chosen}
        )
        return sorted(chosen, key=lambda name: -functions[name.partition("::")[0]])


def _names(contexts: Mapping[int, Iterable[str]], lines: Iterable[int]) -> set[str]:
    """Tests that reach these lines; "" stands for the import."""
    return {name.rpartition("|")[0] for line in lines for name in contexts.get(line, ())}


def measured(room: str, tests: Iterable[Path], folder: Path, *, anew: bool) -> Measured:
    """What is kept in a folder of a run of these tests, after that run where there was none yet."""
    name = "+".join(path.as_posix().replace("/", ".") for path in tests)
    kept, lines = folder / f"{name}.json", folder / f"{name}.coverage"
    if anew or not kept.exists():
        folder.mkdir(parents=True, exist_ok=True)
        lines.unlink(missing_ok=True)
        os.environ["COVERAGE_FILE"] = str(lines)
        watch = forked(lambda: _run(room, tests), _LONGEST_S)
        for failed in watch.failed:
            print(f"left out, it fails: {failed}", flush=True)
            watch.seconds.pop(failed, None)
        kept.write_text(json.dumps(watch.seconds), encoding="utf-8")
    data = CoverageData(str(lines))
    data.read()
    return Measured(json.loads(kept.read_text("utf-8")), data)


def _run(room: str, tests: Iterable[Path]) -> Watch:
    watch = Watch()
    options = [f"--cov={room}", "--cov-context=test", "--cov-report="]
    code = run_tests(watch, *options, *(str(path) for path in tests))
    if code not in (0, 1):
        raise RuntimeError(f"pytest ends with {code} after {len(watch.seconds)} tests")
    return watch
