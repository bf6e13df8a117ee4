"""A slice of `fuzz`: whatever stands in a file of a recording, a refusal or a valid value."""

import logging

import pytest

from tests.replays.readers import fuzz


@pytest.mark.slow
@pytest.mark.parametrize("seed", [7, 8])
def test_broken_recordings_are_refused_or_read(seed: int) -> None:
    logging.getLogger("motorcade").setLevel(logging.CRITICAL)
    try:
        ended, faults = fuzz.run(300, seed, print)
    finally:
        logging.getLogger("motorcade").setLevel(logging.NOTSET)
    assert not faults
    assert min(ended["refused"], ended["valid"]) > 30
