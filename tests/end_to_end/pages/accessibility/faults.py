"""What axe-core finds wrong in a page that a browser shows: serious and critical faults."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

AXE = Path(__file__).resolve().parents[4] / "build/web/node_modules/axe-core/axe.min.js"
UNFOLD = "document.querySelectorAll('details').forEach(one => { one.open = true; })"
_ASKED = (
    "axe.run(document, { resultTypes: ['violations'] }).then(all => all.violations"
    ".filter(one => ['serious', 'critical'].includes(one.impact))"
    ".map(one => [one.id, one.nodes.slice(0, 3).map(node => node.html.slice(0, 120))]))"
)


def serious_faults(evaluate: Callable[[str], Any]) -> list[Any]:
    """Rules that are broken, each with the first of the elements that break it.

    Args:
        evaluate: gives the value of an expression in the page.
    """
    if not AXE.is_file():
        pytest.skip("no axe-core here: make lint brings it")
    evaluate(UNFOLD)
    evaluate(AXE.read_text(encoding="utf-8") + "; 0")
    found: list[Any] = evaluate(_ASKED)
    return found
