"""What is stated of markers, bodies and cameras before anything is seen.

Markers are fixed to bodies, and so are cameras. A body stands still in the world or moves; what is
stated of a pose is a prior, with the covariance it was stated with. Two bodies that move each have
a pose in every frame: a wand before cameras that stand still, or a block before a camera that is
carried about.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray


def positive_definite(covariance: FloatArray) -> bool:
    """Whether a covariance is finite, ``(6, 6)`` and has the Cholesky factor that it weighs by."""
    covariance = np.asarray(covariance, np.float64)
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all():
        return False
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        return False
    return True


def _finite(field: str, *values: float) -> None:
    for value in values:
        if not np.isfinite(value):
            raise ValueError(f"{field}: expected a finite number, got {value}")


def _above_zero(field: str, *values: float) -> None:
    for value in values:
        if not 0.0 < value < np.inf:
            raise ValueError(f"{field}: expected a finite number above 0, got {value}")


def _corners(field: str, *values: int) -> None:
    for value in values:
        if value not in range(4):
            raise ValueError(f"{field}: expected a corner of 0 to 3, got {value}")


@dataclass(frozen=True, eq=False)
class StatedPose:
    """A pose as it was stated.

    Fields:
        pose: a Motor.
        covariance: ``(6, 6)`` of its right perturbation, rotation (rad) then translation (m);
            positive definite.
    """

    pose: Motor
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class FixedMarker:
    """A marker on a body.

    Fields:
        side_m: of its black square.
        stated: ``body_T_marker``; None where it is to be found.

    Raises:
        ValueError: a side that is not above 0.
    """

    side_m: float
    stated: StatedPose | None = None

    def __post_init__(self) -> None:
        _above_zero("FixedMarker.side_m", self.side_m)


@dataclass(frozen=True, eq=False)
class BodyOdometry:
    """Odometry of what is fixed to a body.

    Its steps are as uncertain as a constant velocity predicts them badly, between bounds.

    Fields:
        trajectory: ``odometry_world_T_odometry``; only its steps matter.
        body_T_odometry: takes what the odometry tracks to the body.
        least, most: ``(2,)`` rad/s² and m/s²: bounds on a step's deviation over its time squared.

    Raises:
        ValueError: bounds that are not above 0.
    """

    trajectory: Trajectory
    body_T_odometry: Motor
    least: tuple[float, float] = (5.0, 5.0)
    most: tuple[float, float] = (50.0, 50.0)

    def __post_init__(self) -> None:
        _above_zero("BodyOdometry.least", *self.least)
        _above_zero("BodyOdometry.most", *self.most)


@dataclass(frozen=True, eq=False)
class MarkerBody:
    """A rigid body that carries markers, cameras or both.

    Fields:
        name: of it.
        moves: whether it has a pose of its own in every frame.
        stated: ``world_T_body`` of one that stands still, where it was stated.
        markers: by id.
        other_side_m: side of markers that no body lists, where they belong to this one.
        ignored: ids that it has not.
        odometry: of what is fixed to it.
        still: ``(2,)`` deviations, rad and m, of its motion from frame to frame about none; None
            where nothing is known of it.

    Raises:
        ValueError: a side or deviations that are not above 0.
    """

    name: str
    moves: bool
    stated: StatedPose | None = None
    markers: Mapping[int, FixedMarker] = field(default_factory=dict)
    other_side_m: float | None = None
    ignored: frozenset[int] = frozenset()
    odometry: BodyOdometry | None = None
    still: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.other_side_m is not None:
            _above_zero("MarkerBody.other_side_m", self.other_side_m)
        if self.still is not None:
            _above_zero("MarkerBody.still", *self.still)


@dataclass(frozen=True)
class CornerDistance:
    """A measured distance between corners (0 to 3, clockwise from the printed top left) of markers.

    Fields:
        markers, corners: of both ends.
        distance_m, sigma_m: as measured.

    Raises:
        ValueError: a corner that is none, a length that is no number, or a deviation not above 0.
    """

    markers: tuple[int, int]
    corners: tuple[int, int]
    distance_m: float
    sigma_m: float

    def __post_init__(self) -> None:
        _corners("CornerDistance.corners", *self.corners)
        _finite("CornerDistance.distance_m", self.distance_m)
        _above_zero("CornerDistance.sigma_m", self.sigma_m)


@dataclass(frozen=True)
class CornerCoordinate:
    """A measured coordinate along a direction of the world.

    Fields:
        marker: its id.
        corner: 0 to 3; None for the marker's centre.
        direction: unit vector of the world.
        length_m, sigma_m: as measured.

    Raises:
        ValueError: a corner that is none, a length or direction that is no number, or a deviation
            not above 0.
    """

    marker: int
    corner: int | None
    direction: tuple[float, float, float]
    length_m: float
    sigma_m: float

    def __post_init__(self) -> None:
        if self.corner is not None:
            _corners("CornerCoordinate.corner", self.corner)
        _finite("CornerCoordinate.direction", *self.direction)
        _finite("CornerCoordinate.length_m", self.length_m)
        _above_zero("CornerCoordinate.sigma_m", self.sigma_m)


@dataclass(frozen=True, eq=False)
class MarkerScene:
    """All of it.

    Fields:
        bodies: at least one that stands still.
        camera_body: name of the body that carries each camera.
        cameras: ``body_T_camera`` of those that were stated.
        distances, coordinates: measured by hand.
        sigma_px: noise of a corner's coordinate, as stated.
        wiggle: ``(2,)`` deviations, rad and m, of each frame's pose of a camera on its body about
            its usual one, of those that sit loosely or expose apart from the others.
        ignored: what was stated and is not used, in a sentence each.

    Raises:
        ValueError: no body that stands still, a camera on a body that is not there, a marker on
            two bodies, a camera that wiggles and is not there, noise or a wiggle that is not above
            0, or a covariance that is not positive definite.
    """

    bodies: tuple[MarkerBody, ...]
    camera_body: Mapping[str, str]
    cameras: Mapping[str, StatedPose]
    distances: tuple[CornerDistance, ...] = ()
    coordinates: tuple[CornerCoordinate, ...] = ()
    sigma_px: float = 1.0
    wiggle: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if all(body.moves for body in self.bodies):
            raise ValueError("MarkerScene.bodies: expected one that stands still, got none")
        names = {body.name for body in self.bodies}
        for camera, name in self.camera_body.items():
            if name not in names:
                raise ValueError(
                    f"MarkerScene.camera_body: {camera} is on {name}, which is no body"
                )
        listed = [marker for body in self.bodies for marker in body.markers]
        if len(set(listed)) < len(listed):
            raise ValueError("MarkerScene.bodies: expected a marker on one body, got it on two")
        _above_zero("MarkerScene.sigma_px", self.sigma_px)
        for camera, deviations in self.wiggle.items():
            if camera not in self.camera_body:
                raise ValueError(f"MarkerScene.wiggle: {camera} is no camera of the scene")
            _above_zero(f"MarkerScene.wiggle of {camera}", *deviations)
        for what, stated in self._stated_poses():
            if not positive_definite(stated.covariance):
                raise ValueError(
                    f"MarkerScene: expected a covariance of {what} that is (6, 6) and positive "
                    "definite, got another"
                )

    def _stated_poses(self) -> Iterator[tuple[str, StatedPose]]:
        """Every pose that was stated, and what of."""
        for body in self.bodies:
            if body.stated is not None:
                yield f"body {body.name}", body.stated
            for marker_id, marker in body.markers.items():
                if marker.stated is not None:
                    yield f"marker {marker_id}", marker.stated
        for name, stated in self.cameras.items():
            yield f"camera {name}", stated

    def body_of(self, marker_id: int) -> int | None:
        """Which body a marker is on; None for one that is to be ignored."""
        for row, body in enumerate(self.bodies):
            if marker_id in body.markers:
                return row
        for row, body in enumerate(self.bodies):
            if body.other_side_m is not None:
                return None if marker_id in body.ignored else row
        return None

    def side_m(self, marker_id: int) -> float | None:
        """The side of a marker; None for one that is to be ignored."""
        row = self.body_of(marker_id)
        if row is None:
            return None
        body = self.bodies[row]
        return body.markers[marker_id].side_m if marker_id in body.markers else body.other_side_m
