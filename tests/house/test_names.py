"""No two public classes of the product share a name, whatever modules they are in."""

import re
from collections import defaultdict
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
ROOMS = ("ga", "tracking", "fusion", "animation", "render", "replays")
_CLASS = re.compile(r"^class ([A-Z]\w*)", re.M)


def classes() -> dict[str, list[str]]:
    """Files by the public classes that they define at their top."""
    found = defaultdict(list)
    for room in ROOMS:
        for path in sorted((REPOSITORY / room).rglob("*.py")):
            for name in _CLASS.findall(path.read_text(encoding="utf-8")):
                found[name].append(str(path.relative_to(REPOSITORY)))
    return found


FOUND = classes()

if not FOUND:
    pytest.skip(
        "the source tree is not here: an installed wheel is tested", allow_module_level=True
    )


def test_no_two_classes_share_a_name() -> None:
    shared = {name: places for name, places in FOUND.items() if len(places) > 1}
    faults = [f"{name}: {places}" for name, places in shared.items()]
    assert not faults, "\n".join(faults)
