"""Scripts of any shape as code of every target: written and read back, or refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motorcade.ga.codegen.targets import TARGETS
from tests.fuzz.own import ended
from tests.fuzz.runner import Feed
from tests.ga.codegen.sweep.drawn import script_case
from tests.ga.gaalop.targets import Prepared, prepared

__all__ = ["prepare"]


def prepare(folder: Path) -> Feed:
    """A script, in all targets: refused where one of them has to refuse its names."""

    def feed(rng: np.random.Generator) -> str:
        entry = prepared(script_case(int(rng.integers(1 << 20)), int(rng.integers(1 << 20))))
        if not isinstance(entry, Prepared):
            return "refused"
        ends = {ended(lambda write=write: write(entry.program, None)) for write in TARGETS.values()}
        return "refused" if "refused" in ends else "valid"

    return feed
