"""One drawn clip of each kind: its focal length lies within what is said of it."""

import numpy as np
import pytest

from tests.tracking.self_calibration.coverage import KINDS, calibrated, drawn_clip


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_focal_length_lies_within_its_range(kind: str) -> None:
    clip = drawn_clip(kind, np.random.default_rng([2026, KINDS.index(kind)]))
    found = calibrated(clip)
    assert abs(found.camera.fx / clip.focal - 1.0) < 2.5 * found.sigma_focal
    assert found.sigma_focal < (0.03 if kind in ("breathing", "head on") else 0.01)
    assert kind == "breathing" or found.breathing == 0.0
    assert not found.camera.folds()


@pytest.mark.slow
@pytest.mark.parametrize("number", [18, 24])
def test_glare_in_one_part_of_the_image_widens_the_range(number: int) -> None:
    """It moves corners there alike in all views, which neither views nor points show."""
    clip = drawn_clip("glare", np.random.default_rng([777, number]))
    found = calibrated(clip)
    assert abs(found.camera.fx / clip.focal - 1.0) < 2.0 * found.sigma_focal
    assert 0.0035 < found.sigma_focal < 0.005
