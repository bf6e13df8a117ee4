"""A law over many cases in one test: what a runner does about each takes longer."""

from __future__ import annotations

import copy
import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np
import pytest


def over(**cases: Iterable[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Run a law with every combination of some arguments; a failure says which it was.

    A mapping gives functions of a generator, and the law what they draw; its keys are told.
    """

    def in_one(law: Callable[..., None]) -> Callable[..., None]:
        wanted = inspect.signature(law).parameters

        @functools.wraps(law)
        def run(rng: np.random.Generator, **fixtures: Any) -> None:
            for values in product(*cases.values()):
                chosen = dict(zip(cases, values, strict=True))
                own = copy.deepcopy(rng)  # each case draws what it would draw alone
                drawn = {
                    name: options[chosen[name]](own) if isinstance(options, Mapping) else value
                    for (name, value), options in zip(chosen.items(), cases.values(), strict=True)
                }
                if "rng" in wanted:
                    drawn["rng"] = own
                try:
                    law(**drawn, **fixtures)
                except pytest.skip.Exception:
                    continue
                except BaseException as fault:
                    fault.add_note(f"with {chosen}")
                    raise

        kept = [value for name, value in wanted.items() if name not in {*cases, "rng"}]
        kept.append(inspect.Parameter("rng", inspect.Parameter.POSITIONAL_OR_KEYWORD))
        signature = inspect.Signature(kept)
        run.__signature__ = signature  # type: ignore[attr-defined]
        return run

    return in_one
