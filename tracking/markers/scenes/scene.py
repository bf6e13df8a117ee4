"""What is stated of markers, bodies and cameras before anything is seen.

Markers are fixed to bodies, and so are cameras. A body stands still in the world or moves; what is
stated of a pose is a prior, with the covariance it was stated with. Two bodies that move each have
a pose in every frame: a wand before cameras that stand still, or a block before a camera that is
carried about.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class StatedPose:
    """A pose as it was stated.

    Fields:
        pose: a Motor.
        covariance: ``(6, 6)`` of its right perturbation, rotation (rad) then translation (m).
    """

    pose: Motor
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class FixedMarker:
    """A marker on a body.

    Fields:
        side_m: of its black square.
        stated: ``body_T_marker``; None where it is to be found.
    """

    side_m: float
    stated: StatedPose | None = None


@dataclass(frozen=True, eq=False)
class BodyOdometry:
    """Odometry of what is fixed to a body.

    Its steps are as uncertain as a constant velocity predicts them badly, between bounds.

    Fields:
        trajectory: ``odometry_world_T_odometry``; only its steps matter.
        body_T_odometry: takes what the odometry tracks to the body.
        least, most: ``(2,)`` rad/s² and m/s²: bounds on a step's deviation over its time squared.
    """

    trajectory: Trajectory
    body_T_odometry: Motor
    least: tuple[float, float] = (5.0, 5.0)
    most: tuple[float, float] = (50.0, 50.0)


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
    """

    name: str
    moves: bool
    stated: StatedPose | None = None
    markers: Mapping[int, FixedMarker] = field(default_factory=dict)
    other_side_m: float | None = None
    ignored: frozenset[int] = frozenset()
    odometry: BodyOdometry | None = None
    still: tuple[float, float] | None = None


@dataclass(frozen=True)
class CornerDistance:
    """A measured distance between corners (0 to 3, clockwise from the printed top left) of markers.

    Fields:
        markers, corners: of both ends.
        distance_m, sigma_m: as measured.
    """

    markers: tuple[int, int]
    corners: tuple[int, int]
    distance_m: float
    sigma_m: float


@dataclass(frozen=True)
class CornerCoordinate:
    """A measured coordinate along a direction of the world.

    Fields:
        marker: its id.
        corner: 0 to 3; None for the marker's centre.
        direction: unit vector of the world.
        length_m, sigma_m: as measured.
    """

    marker: int
    corner: int | None
    direction: tuple[float, float, float]
    length_m: float
    sigma_m: float


@dataclass(frozen=True, eq=False)
class MarkerScene:
    """All of it.

    Fields:
        bodies: at least one that stands still.
        camera_body: name of the body that carries each camera.
        cameras: ``body_T_camera`` of those that were stated.
        distances, coordinates: measured by hand.
        sigma_px: noise of a corner's coordinate, as stated.
        by_frame: whether nothing is to be learnt of markers from other frames ("amnesia").

    Raises:
        ValueError: no body that stands still, a camera on a body that is not there, or a marker on
            two bodies.
    """

    bodies: tuple[MarkerBody, ...]
    camera_body: Mapping[str, str]
    cameras: Mapping[str, StatedPose]
    distances: tuple[CornerDistance, ...] = ()
    coordinates: tuple[CornerCoordinate, ...] = ()
    sigma_px: float = 1.0
    by_frame: bool = False

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
