"""Latitudes and longitudes as metres: against the closed formulas of the ellipsoid."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.fusion.measurements import GeodeticOrigin, PositionMeasurements
from motorcade.ga.arrays import FloatArray

pytest.importorskip("pyproj")
_RADIUS_M, _FLATTENING = 6378137.0, 1.0 / 298.257223563  # of WGS 84


def geocentric(latitude_deg: FloatArray, longitude_deg: FloatArray, height_m: FloatArray):
    """Places from the middle of the Earth."""
    phi, lam = np.radians(latitude_deg), np.radians(longitude_deg)
    square = _FLATTENING * (2.0 - _FLATTENING)
    across = _RADIUS_M / np.sqrt(1.0 - square * np.sin(phi) ** 2)
    level = (across + height_m) * np.cos(phi)
    up = (across * (1.0 - square) + height_m) * np.sin(phi)
    return np.stack([level * np.cos(lam), level * np.sin(lam), up], axis=-1)


def test_east_north_and_up_are_those_of_the_ellipsoid(rng):
    origin = GeodeticOrigin(-33.9, 151.2, 20.0)
    latitude = origin.latitude_deg + 0.1 * rng.standard_normal(50)
    longitude = origin.longitude_deg + 0.1 * rng.standard_normal(50)
    height = 100.0 * rng.standard_normal(50)
    phi, lam = np.radians([origin.latitude_deg, origin.longitude_deg])
    east = np.array([-np.sin(lam), np.cos(lam), 0.0])
    up = np.array([np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)])
    axes = np.stack([east, np.cross(up, east), up])
    away = geocentric(latitude, longitude, height) - geocentric(
        *(np.array(x) for x in (origin.latitude_deg, origin.longitude_deg, origin.height_m))
    )
    found = origin.local_m(latitude, longitude, height)
    np.testing.assert_allclose(found, away @ axes.T, atol=1e-6)
    back = origin.geodetic(found)
    for own, given in zip(back, (latitude, longitude, height), strict=True):
        np.testing.assert_allclose(own, given, atol=1e-8)


def test_the_origin_is_the_worlds():
    origin = GeodeticOrigin(47.0, 8.5, 400.0)
    seen = PositionMeasurements.from_geodetic(
        np.array([0, 1]), [47.0, 47.001], [8.5, 8.5], [400.0, 400.0], np.eye(3), origin
    )
    np.testing.assert_allclose(seen.position_m[0], 0.0, atol=1e-9)
    assert seen.position_m[1, 1] == pytest.approx(111.18, abs=0.01)
    assert abs(seen.position_m[1, 0]) < 1e-6


def test_what_lies_nowhere_is_refused():
    with pytest.raises(ValueError, match="latitude_deg: expected -90 to 90"):
        GeodeticOrigin(151.2, -33.9, 0.0)
    with pytest.raises(ValueError, match="height_m: expected finite"):
        GeodeticOrigin(0.0, 0.0, np.nan)
    with pytest.raises(ValueError, match="expected one shape"):
        GeodeticOrigin(0.0, 0.0, 0.0).local_m([0.0, 1.0], [0.0], [0.0])
