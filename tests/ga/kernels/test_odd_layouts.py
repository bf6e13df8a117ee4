"""Kernels on arrays of any layout, and on outputs that lie in the way of inputs.

Also run under the sanitizers (`make sanitize`), which see what is read or written beside an array.
"""

from collections import Counter
from pathlib import Path

from tests.fuzz.kinds import kernels
from tests.fuzz.runner import fresh


def test_any_layout_gives_what_tidy_copies_give_or_is_refused(tmp_path: Path) -> None:
    feed = kernels.prepare(tmp_path)
    ended = Counter(feed(fresh(8, number)) for number in range(1500))
    assert min(ended["valid"], ended["refused"]) > 200
