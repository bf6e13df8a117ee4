"""Latitudes, longitudes and heights as metres east, north and up of a place, by PROJ."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.ga.arrays import FloatArray, checked_floats


@dataclass(frozen=True)
class GeodeticOrigin:
    """The place on WGS 84 where a world has its origin; x points east, y north, z up there.

    Args:
        latitude_deg, longitude_deg: latitude from -90 to 90.
        height_m: above the ellipsoid, not above the sea.

    Raises:
        ValueError: a latitude out of its range, NaN or infinity.

    Examples:
        >>> from motorcade.fusion.measurements import GeodeticOrigin
        >>> GeodeticOrigin(latitude_deg=47.0, longitude_deg=8.5, height_m=400.0).height_m
        400.0
    """

    latitude_deg: float
    longitude_deg: float
    height_m: float

    def __post_init__(self) -> None:
        _checked(self.latitude_deg, self.longitude_deg, self.height_m)

    @cached_property
    def _pipeline(self) -> Any:
        from pyproj import Transformer

        return Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            "+step +proj=cart +ellps=WGS84 +step +proj=topocentric +ellps=WGS84 "
            f"+lat_0={self.latitude_deg!r} +lon_0={self.longitude_deg!r} +h_0={self.height_m!r}"
        )

    def local_m(
        self, latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike
    ) -> FloatArray:
        """Places ``(N, 3)`` east, north and up of the origin, of N on the ellipsoid.

        Raises:
            ValueError: latitudes beyond ±90°, shapes that do not agree, NaN or infinity.
            ModuleNotFoundError: without pyproj.
        """
        latitude, longitude, height = _checked(latitude_deg, longitude_deg, height_m)
        columns = self._pipeline.transform(longitude, latitude, height)
        return np.stack(columns, axis=-1)

    def geodetic(self, local_m: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Latitudes (deg), longitudes (deg) and heights (m) ``(N,)`` of places ``(N, 3)``.

        Raises:
            ValueError: another shape, NaN or infinity.
            ModuleNotFoundError: without pyproj.
        """
        east, north, up = np.moveaxis(checked_floats(local_m, "local_m", (3,)), -1, 0)
        longitude, latitude, height = self._pipeline.transform(east, north, up, direction="INVERSE")
        return latitude, longitude, height


def _checked(
    latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    latitude, longitude, height = (
        checked_floats(value, name, ())
        for value, name in (
            (latitude_deg, "latitude_deg"),
            (longitude_deg, "longitude_deg"),
            (height_m, "height_m"),
        )
    )
    if latitude.shape != longitude.shape or latitude.shape != height.shape:
        raise ValueError(
            "latitude_deg, longitude_deg, height_m: expected one shape, got "
            f"{latitude.shape}, {longitude.shape}, {height.shape}"
        )
    if np.any(np.abs(latitude) > 90.0):
        raise ValueError("latitude_deg: expected -90 to 90, got more; is it the longitude?")
    return latitude, longitude, height
