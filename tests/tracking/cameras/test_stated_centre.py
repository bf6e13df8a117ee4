"""A principal point that images of another size or rotation have is named with its mend."""

import pytest

from motorcade.tracking import Camera
from motorcade.tracking.audit import centre_finding, said_camera

RIGHT = Camera(480, 360, 420.0, 421.0, 244.0, 175.0)


@pytest.mark.parametrize("factor", [0.5, 2.0, 3.0])
def test_intrinsics_of_another_size_are_named(factor: float) -> None:
    stated = Camera(
        480, 360, factor * 420.0, factor * 421.0, factor * 244.5 - 0.5, factor * 175.5 - 0.5
    )
    finding = centre_finding(stated)
    assert finding is not None
    assert f"divide fx, fy, cx and cy by {factor:g}" in finding.advice
    assert "say fx = 420.00, fy = 421.00, cx = 244.00, cy = 175.00" in finding.advice


def test_images_turned_by_a_quarter_are_named() -> None:
    finding = centre_finding(Camera(360, 480, 420.0, 421.0, 244.0, 175.0))
    assert finding is not None
    assert "say width = 480, height = 360, rotation_deg = 90, or 270" in finding.advice


@pytest.mark.parametrize(("cx", "cy"), [(244.0, 175.0), (190.0, 210.0), (239.5, 250.0)])
def test_a_centre_that_lenses_have_is_not_doubted(cx: float, cy: float) -> None:
    assert centre_finding(Camera(480, 360, 420.0, 420.0, cx, cy)) is None


def test_a_camera_is_said_in_keys() -> None:
    lens = Camera(480, 360, 420.0, 421.0, 244.0, 175.0, "radtan", (-0.3, 0.1, 0.0, 0.0))
    assert said_camera(lens) == (
        'say model = "radtan", fx = 420.00, fy = 421.00, cx = 244.00, cy = 175.00, '
        "distortion = [-0.3000, 0.1000, 0.0000, 0.0000]"
    )
