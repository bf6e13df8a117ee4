"""Errors are as large as stated, with each kind of measurements."""

from __future__ import annotations

import pytest

from tests.fusion.measurements.along import KINDS
from tests.fusion.measurements.consistency import consistency


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_errors_are_as_large_as_stated(kind):
    for name, both in consistency(kind, 40, 2, ("live", "smoothed")).items():
        for found in both:
            assert 0.8 < found.ratio < 1.25, name
            assert found.share_within > 0.6, name
