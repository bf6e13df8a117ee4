"""A pose for every frame that comes, and a word on how far it can be relied on.

The world is the board (x right, y up as printed, z out of its face), the marker that was seen
first, or with SLAM a plane that was mapped (z towards the camera): the largest at first, then the
one that is asked for.

states      searching   nothing was seen yet, or the camera is not known
            tracking    measured in this frame
            weak        measured with a doubt that `why` names, or predicted for up to 0.1 s, by
                        an IMU that is sure for up to 0.5 s
            lost        nothing is known of where the camera is
            relocalised tracking, for half a second after it was lost

A camera is found while it is used: fits run in a thread of their own after 8, 24 and 64 views of
the board; meanwhile no view is looked for, since the two would share one interpreter. A camera is
taken once its focal length is known to 5 %, and a later one where it is known better.
"""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from motorcade.fusion.smoothing import LiveSmoother
from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.live.frames import LiveFrame
from motorcade.replays.live.inertial import BRIDGED_S, InertialPoses
from motorcade.tracking import (
    Board,
    BoardTracker,
    Camera,
    Plane,
    SelfCalibration,
    SelfCalibrationError,
    SingleMarker,
    SlamSettings,
    TrackingError,
    VisualSlam,
    detect_markers,
    find_planes,
    self_calibrate_board,
)
from motorcade.tracking.boards import BoardCorners
from motorcade.tracking.measurements import MarkerObservation
from motorcade.tracking.pose import refine

FITTED_AT = (8, 24, 64)
GOOD_SIGMA = 0.05
"""The relative doubt of a focal length with which a camera is taken: depth is as doubtful."""
_APART_NS = 100_000_000
_MOVED = 0.01
"""How far, in image widths, a view's corners are from those of the view before, in the mean."""


class LiveCalibration:
    """Collects views of a board, and finds the camera from them.

    Args:
        size: width and height of the images, pixels.

    It needs what every calibration from a plane needs: views of several tilts. A board that is
    always seen head on gives no focal length, and `status` says so.

    >>> from motorcade.replays.live.tracker import LiveCalibration
    >>> LiveCalibration((640, 480)).status
    'finding the camera: 0 of 8 views; move round the board, and tilt it'
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        self.calibrated: SelfCalibration | None = None
        self._views: list[BoardCorners] = []
        self._stamps: list[int] = []
        self._reason = ""
        self._worker = ThreadPoolExecutor(1, "calibration")
        self._fit: Future[SelfCalibration] | None = None

    @property
    def done(self) -> bool:
        """Whether no more views are wanted."""
        return len(self._views) >= FITTED_AT[-1] and self._fit is None

    @property
    def status(self) -> str:
        """What is known of the camera, or what is lacking, for people."""
        if self.calibrated is not None:
            focal, sigma = self.calibrated.camera.fx, self.calibrated.sigma_focal
            doubts = "".join(f"; {doubt}" for doubt in self.calibrated.doubts)
            return f"camera found: focal length {focal:.0f} ± {sigma * focal:.0f} px{doubts}"
        views = len(self._views)
        wanted = next((count for count in FITTED_AT if count > views), FITTED_AT[-1])
        text = f"finding the camera: {views} of {wanted} views; move round the board, and tilt it"
        return f"{text} ({self._reason})" if self._reason else text

    def wants(self, time_ns: int) -> bool:
        """Whether a view at this stamp would be taken."""
        if self.done or self._fit is not None:
            return False
        return not self._stamps or time_ns - self._stamps[-1] >= _APART_NS

    def add(self, time_ns: int, view: BoardCorners) -> None:
        """Take a view, where the board has moved since the one before."""
        if not (self.wants(time_ns) and view.spanning and self._moved(view)):
            return
        self._views.append(view)
        self._stamps.append(time_ns)
        if len(self._views) in FITTED_AT:
            stamps = np.array(self._stamps)
            self._fit = self._worker.submit(
                self_calibrate_board, tuple(self._views), self.size, stamps
            )

    def poll(self) -> SelfCalibration | None:
        """A camera that is new and better than the one before; None without."""
        if self._fit is None or not self._fit.done():
            return None
        fit, self._fit = self._fit, None
        try:
            calibration = fit.result()
        except SelfCalibrationError as fault:
            self._reject(str(fault))
            return None
        if calibration.sigma_focal > GOOD_SIGMA:
            self._reject(f"known to {calibration.sigma_focal:.0%} only")
            return None
        if self.calibrated is not None and calibration.sigma_focal >= self.calibrated.sigma_focal:
            return None
        self.calibrated = calibration
        return calibration

    def _reject(self, reason: str) -> None:
        """Say why there is no camera yet; after the last fit begin with other views."""
        self._reason = reason
        if self.calibrated is None and len(self._views) >= FITTED_AT[-1]:
            self._views, self._stamps = self._views[-1:], self._stamps[-1:]

    def close(self) -> None:
        """Leave what is under way."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _moved(self, view: BoardCorners) -> bool:
        if not self._views:
            return True
        before = self._views[-1]
        _, here, there = np.intersect1d(view.ids, before.ids, return_indices=True)
        if len(here) == 0:
            return True
        steps = view.corners_px[here] - before.corners_px[there]
        return float(np.linalg.norm(steps, axis=-1).mean()) > _MOVED * self.size[0]


LiveState = Literal["searching", "tracking", "weak", "lost", "relocalised"]

PREDICTED_S = 0.1
"""How long a pose is predicted after the last measured one; `LiveSmoother.predict` says why."""
WORST_PX = 1.0
"""Of corners left out of a pose: from here on what is drawn is seen to slide."""
HELD_OUT = 6
"""Of so many corners one is left out, another in every frame."""
_SURE = np.log(100.0)
"""Log likelihood ratio from which on the better of a plane's two poses is believed."""
_SIGMA_PX = 0.2
_ALIKE_RAD = np.radians(3.0)
_FEW_CORNERS = 8
_REPOSED_NS = 500_000_000
_PLANE_EVERY, _PLANE_NOISE, _FEWEST_POINTS, _FEWEST_NEAR = 15, 0.01, 60, 15
_NEAR_RAY_RAD, _SAME_PLANE_RAD = np.radians(12.0), np.radians(10.0)


@dataclass(frozen=True)
class FirstMarker:
    """Whichever marker of a family is seen first and largest; it is the world from then on.

    Args:
        family: one of `tracking.FAMILIES`.
        side_m: of the black square, metres.

    Raises ValueError: an unknown family, or a side that is not above 0.
    """

    family: str
    side_m: float

    def __post_init__(self) -> None:
        SingleMarker(self.family, 0, self.side_m)


Target = Board | FirstMarker | Literal["slam"]


@dataclass(frozen=True, eq=False)
class LivePose:
    """What is known of the camera in one frame.

    Fields:
        time_ns: the frame's stamp.
        state: see above.
        why: the reason of any state but "tracking", for people; "" without.
        world_T_camera: None while nothing is known.
        camera: whose pose it is; None until it is found.
        held_out_px: ``(n,)`` distances of corners that had no part in a pose from where that pose,
            fitted to the others, has them; empty where none can be spared.
        measured: whether the pose was measured in this very frame.
        world_T_map: with SLAM, where its map lies in the world of this pose.
        map_number: with SLAM, of that map: nothing is known between two.
    """

    time_ns: int
    state: LiveState
    why: str = ""
    world_T_camera: Motor | None = None
    camera: Camera | None = None
    held_out_px: FloatArray = field(default_factory=lambda: np.zeros(0))
    measured: bool = False
    world_T_map: Motor | None = None
    map_number: int = 0


class LiveTracker:
    """Gives the camera's pose in frames as they come.

    Args:
        target: the board in view; `FirstMarker`; or "slam" for a scene without either.
        camera: what takes the frames; None finds it from the board, within seconds in which the
            board is seen from several sides.

    Raises ValueError: SLAM without a camera.

    It breaks down where two boards that look the same are in view, and where a board repeats
    itself turned round: it is then taken for the one that it was last.

    >>> import numpy as np
    >>> from motorcade.replays.live import LiveFrame, LiveTracker
    >>> from motorcade.tracking import Camera, board_named
    >>> board = board_named("checkerboard_6x5_30mm")
    >>> image, _ = board.draw(pixels_per_m=1000.0)  # a camera that hangs before its middle
    >>> frames = [LiveFrame(k * 33_000_000, image) for k in range(3)]
    >>> height, width = image.shape
    >>> camera = Camera(width, height, 500.0, 500.0, 0.5 * width - 0.5, 0.5 * height - 0.5)
    >>> tracker = LiveTracker(board, camera)
    >>> for frame in frames:
    ...     pose = tracker.update(frame)
    >>> pose.state, pose.world_T_camera.translation_m.round(2)[2]  # metres from its face
    ('tracking', np.float64(0.5))
    """

    def __init__(self, target: Target, camera: Camera | None = None) -> None:
        if target == "slam" and camera is None:
            raise ValueError("LiveTracker: expected a camera with SLAM, which does not find one")
        self.target: Target = target
        self.camera = camera
        self.calibration: LiveCalibration | None = None
        self._stated = camera is not None
        self.inertial = InertialPoses()
        self._smoother = LiveSmoother()
        self._board: BoardTracker | None = None
        self._slam: _PlaneSlam | None = None
        self._begun_ns = self._last_ns = 0
        self._measured_ns: int | None = None
        self._found_ns: int | None = None
        self._lost = self._sure = False
        self._count = 0

    @property
    def target_name(self) -> str:
        """What is looked for, for people."""
        if isinstance(self.target, FirstMarker):
            return f"a marker of {self.target.family}"
        return self.target.name if isinstance(self.target, Board) else "the place"

    @property
    def camera_status(self) -> str:
        """What is known of the camera, for people."""
        return "camera as stated" if self.calibration is None else self.calibration.status

    def update(self, frame: LiveFrame) -> LivePose:
        """Take the next frame.

        Raises ValueError: a stamp that is not later than the one before, or an image of another
        size than the stated camera's.
        """
        self._check(frame)
        self._last_ns = frame.time_ns
        self.inertial.add_imu(frame.imu)
        self._begun_ns = self._begun_ns if self._count else frame.time_ns
        self._count += 1
        if isinstance(self.target, FirstMarker):
            self._take_marker(self.target, frame)
        if isinstance(self.target, Board) and not self._stated:
            self._calibrate(self.target, frame)
        if isinstance(self.target, FirstMarker) or self.camera is None:
            lacking = self.camera_status
            if isinstance(self.target, FirstMarker):
                lacking = f"{self.target_name} is not in view"
            return LivePose(frame.time_ns, "searching", lacking)
        if self.target == "slam":
            self._slam = self._slam or _PlaneSlam(self.camera)
            return self._remembered(self._slam.update(frame))
        return self._remembered(self._by_board(frame, self.camera, self.target))

    def choose_ground(self, pose: LivePose, pixel: FloatArray) -> bool:
        """With SLAM make the plane that an earlier frame shows at a pixel the world.

        Returns:
            whether another plane is the world now; never without SLAM.

        Raises ValueError: nothing flat is mapped there.
        """
        motor = self.in_world(pose)
        if self._slam is None or motor is None or not self._slam.choose_plane(motor, pixel):
            return False
        self._measured_ns = None  # what was smoothed is of another world
        return True

    def in_world(self, pose: LivePose) -> Motor | None:
        """``world_T_camera`` of an earlier frame, in the world that is now; None where unknown."""
        if self._slam is None or pose.world_T_map is None or pose.world_T_camera is None:
            return pose.world_T_camera
        if pose.map_number != self._slam.map_number:
            return None
        return self._slam.world_T_map @ pose.world_T_map.inverse() @ pose.world_T_camera

    def forget_inertial(self) -> None:
        """Begin anew to find how the IMU sits on the camera: one of both is another."""
        self.inertial.close()
        self.inertial = InertialPoses()

    def close(self) -> None:
        """Leave what is being calibrated, synchronised and mapped."""
        self.inertial.close()
        if self.calibration is not None:
            self.calibration.close()
        self._slam = None

    def _check(self, frame: LiveFrame) -> None:
        if self._count and frame.time_ns <= self._last_ns:
            raise ValueError(
                f"frame: expected a stamp after {self._last_ns} ns, got {frame.time_ns} ns"
            )
        height, width = frame.gray.shape
        camera = self.camera
        if self._stated and camera is not None and (camera.width, camera.height) != (width, height):
            raise ValueError(
                f"frame: expected {camera.width} x {camera.height} pixels as the camera has, got "
                f"{width} x {height}; set the camera to that size, or leave it to be found"
            )

    # The camera and the target -------------------------------------------------------------------

    def _take_marker(self, target: FirstMarker, frame: LiveFrame) -> None:
        """Make the largest marker in view the board."""
        seen = detect_markers(frame.gray, target.family)
        if seen:
            span = [float(np.ptp(marker.corners_px, axis=0).prod()) for marker in seen]
            marker_id = int(seen[int(np.argmax(span))].marker_id)
            self.target = SingleMarker(target.family, marker_id, target.side_m)

    def _calibrate(self, board: Board, frame: LiveFrame) -> None:
        """Take views of the board until its camera is known well; begin anew at another size."""
        height, width = frame.gray.shape
        if self.calibration is None or self.calibration.size != (width, height):
            if self.calibration is not None:
                self.calibration.close()
            self.calibration, self.camera = LiveCalibration((width, height)), None
        if self.calibration.wants(frame.time_ns):
            view = board.detect(frame.gray)
            if view is not None:
                self.calibration.add(frame.time_ns, view)
        better = self.calibration.poll()
        if better is not None:
            self.camera, self._board = better.camera, None
            self.forget_inertial()  # its poses were those of another camera

    # The pose ------------------------------------------------------------------------------------

    def _by_board(self, frame: LiveFrame, camera: Camera, board: Board) -> LivePose:
        if self._board is None:
            self._board = BoardTracker(camera, board)
        seen = self._board.update(frame.gray, frame.time_ns)
        if seen is None:
            return LivePose(frame.time_ns, "lost", f"{board.name} is not in view", camera=camera)
        observation = seen.observation
        ids = observation.ids
        corners = BoardCorners(ids, observation.corners_px, board.points_m[ids])
        held_out = held_out_px(corners, camera, seen.world_T_camera, self._count)
        continued = self._sure and self._continues(frame.time_ns)
        self._sure = continued or is_one_pose(observation)
        why = ""
        if len(ids) < min(_FEW_CORNERS, len(board.points_m)):
            why = f"only {len(ids)} corners are seen"
        elif not self._sure:
            why = "two poses fit alike; look at it more from the side"
        elif seen.error_px > WORST_PX or (len(held_out) and np.mean(held_out**2) > WORST_PX**2):
            why = "corners lie more than a pixel off"
        if self._sure and seen.error_px <= WORST_PX:
            predicted = self._predicted(frame.time_ns) if continued else None
            motor, covariance = seen.world_T_camera, seen.covariance
            self.inertial.add_pose(frame.time_ns, motor, covariance, predicted)
        state: LiveState = "weak" if why else "tracking"
        return LivePose(frame.time_ns, state, why, seen.world_T_camera, camera, held_out, True)

    def _continues(self, time_ns: int) -> bool:
        return self._measured_ns is not None and time_ns - self._measured_ns <= _REPOSED_NS

    def _remembered(self, pose: LivePose) -> LivePose:
        """The pose, or one predicted from those before it where there is none."""
        time_s = 1e-9 * (pose.time_ns - self._begun_ns)
        if pose.world_T_camera is not None:
            if not self._continues(pose.time_ns):
                self._smoother.reset()
            motor = pose.world_T_camera
            self._smoother.update(time_s, motor.translation_m, motor.rotor.as_quaternion())
            self._measured_ns = pose.time_ns
            self._found_ns = pose.time_ns if self._lost else self._found_ns
            self._lost = False
            again = self._found_ns is not None and pose.time_ns - self._found_ns < _REPOSED_NS
            return replace(pose, state="relocalised") if again and not pose.why else pose
        if self._measured_ns is None:
            return replace(pose, state="searching")
        passed_s = 1e-9 * (pose.time_ns - self._measured_ns)
        bridged = self.inertial.at(pose.time_ns) if self.inertial.used else None
        if bridged is not None and passed_s <= BRIDGED_S:
            why = f"{pose.why}; by the IMU"
            return replace(pose, state="weak", why=why, world_T_camera=bridged)
        if passed_s > PREDICTED_S:
            self._lost = True
            return pose
        motor = self._predicted(pose.time_ns)
        return replace(pose, state="weak", why=f"{pose.why}; predicted", world_T_camera=motor)

    def _predicted(self, time_ns: int) -> Motor:
        _, position_m, wxyz = self._smoother.predict(1e-9 * (time_ns - self._begun_ns))
        return Motor.from_rotor_translation(Rotor.from_quaternion(wxyz), position_m)


def is_one_pose(observation: MarkerObservation) -> bool:
    """Whether pixels alone tell which of a plane's two poses it is, or both are much the same."""
    better, worse = observation.candidate_error_px
    odds = len(observation.ids) * (worse**2 - better**2) / (2.0 * _SIGMA_PX**2)
    apart = observation.candidates[0].inverse() @ observation.candidates[1]
    return bool(odds > _SURE or apart.rotor.angle() < _ALIKE_RAD)


def held_out_px(
    corners: BoardCorners, camera: Camera, world_T_camera: Motor, turn: int
) -> FloatArray:
    """How far corners lie from where a pose fitted without them has them.

    Args:
        corners: all that were found.
        camera: who saw them.
        world_T_camera: a pose near the right one, to begin from.
        turn: which of every `HELD_OUT` corners is left out; any whole number.

    Returns:
        ``(n,)`` pixels, empty where too few corners would be left.

    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.replays.live.tracker import held_out_px
    >>> from motorcade.tracking import Camera, board_named
    >>> from motorcade.tracking.boards import BoardCorners
    >>> points_m = board_named("checkerboard_6x5_30mm").points_m
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> pose = Motor.from_rotor_translation(Rotor.from_rotation_vector([3.0, 0.2, 0]), [0, 0, 0.5])
    >>> pixels = camera.project(pose.inverse().apply(points_m))
    >>> pixels[7] += 3.0  # a corner that is wrong, and has no part in the pose
    >>> held_out_px(BoardCorners(range(30), pixels, points_m), camera, pose, 1).round(1)
    array([0. , 4.2, 0. , 0. , 0. ])
    """
    out = (np.arange(len(corners)) - turn) % HELD_OUT == 0
    rest = corners.keep(~out)
    if len(rest) < _FEW_CORNERS or not out.any():
        return np.zeros(0)
    try:
        pose = refine(rest, camera, world_T_camera).world_T_camera
    except TrackingError:
        return np.zeros(0)
    left = corners.keep(out)
    expected = camera.project(pose.inverse().apply(left.points_m))
    distances: FloatArray = np.linalg.norm(left.corners_px - expected, axis=-1)
    return distances[np.isfinite(distances)]


class _PlaneSlam:
    """SLAM in its threads; the world is a plane of its map, or the map until there is one.

    At first it is the largest plane that was mapped, then the one that was asked for.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._slam = VisualSlam(camera, SlamSettings(threads=True))
        self.world_T_map = Motor.identity()
        self._flat = False
        self.map_number = 0
        self._tracked = 0

    def update(self, frame: LiveFrame) -> LivePose:
        seen = self._slam.track(frame.time_ns, frame.gray)
        if seen.world_T_camera is None:
            why = "the place is not recognised"
            if seen.state == "initialising":
                why = "move sideways, so that depth is seen"
            return self._of_map(LivePose(frame.time_ns, "lost", why))
        if seen.map_number != self.map_number:
            self.world_T_map, self.map_number = Motor.identity(), seen.map_number
            self._flat, self._tracked = False, 0
        self._tracked += 1
        if not self._flat and self._tracked % _PLANE_EVERY == 0:
            planes = self._planes(self._slam.snapshot().points, seen.world_T_camera.translation_m)
            self._flat = bool(planes)
            self.world_T_map = planes[0].world_T_plane.inverse() if planes else self.world_T_map
        why = "few corners are tracked" if seen.state == "weak" else ""
        if not self._flat:
            why = "nothing flat is found yet; tap on what is flat, or move sideways"
        state: LiveState = "weak" if why else "tracking"
        pose = LivePose(frame.time_ns, state, why, self.world_T_map @ seen.world_T_camera)
        return self._of_map(replace(pose, measured=True))

    def _of_map(self, pose: LivePose) -> LivePose:
        pose = replace(pose, camera=self._camera, world_T_map=self.world_T_map)
        return replace(pose, map_number=self.map_number)

    def choose_plane(self, world_T_camera: Motor, pixel: FloatArray) -> bool:
        """As `LiveTracker.choose_ground`: the nearest plane that reaches the pixel's ray.

        Where no large plane does, one is fitted to the points near the ray. The plane that is the
        world already stays as it is, so that what stands on it does.
        """
        map_T_camera = self.world_T_map.inverse() @ world_T_camera
        eye = map_T_camera.translation_m
        ray = map_T_camera.rotor.apply(self._camera.bearings(pixel))
        points = self._slam.snapshot().points
        away = points - eye
        near = away @ ray > np.cos(_NEAR_RAY_RAD) * np.linalg.norm(away, axis=-1)
        large = [plane for plane in self._planes(points, eye) if _reaches(plane, eye, ray)]
        planes = large or self._planes(points[near], eye, most=1, least_share=0.5)
        met = [float(np.linalg.norm(plane.met_by(eye, ray) - eye)) for plane in planes]
        if not np.isfinite(met).any():
            raise ValueError("pixels: nothing flat is mapped there yet; move sideways, to see it")
        plane = planes[int(np.nanargmin(met))]
        above = self.world_T_map.apply(plane.met_by(eye, ray))[2]
        tilt = np.arccos(np.clip(self.world_T_map.rotor.apply(plane.normal)[2], -1.0, 1.0))
        if self._flat and tilt < _SAME_PLANE_RAD and abs(above) < 3.0 * _noise(points, eye):
            return False
        self.world_T_map, self._flat = plane.world_T_plane.inverse(), True
        return True

    @staticmethod
    def _planes(points: FloatArray, eye: FloatArray, **wanted: Any) -> tuple[Plane, ...]:
        if len(points) < (_FEWEST_NEAR if wanted else _FEWEST_POINTS):
            return ()
        rng, noise = np.random.default_rng(0), _noise(points, eye)
        return find_planes(points, noise, rng, seen_from_m=eye, **wanted).planes


def _noise(points: FloatArray, eye: FloatArray) -> float:
    return _PLANE_NOISE * float(np.median(np.linalg.norm(points - eye, axis=-1)))


def _reaches(plane: Plane, eye: FloatArray, ray: FloatArray) -> bool:
    hit = plane.met_by(eye, ray)
    ahead = bool((hit - eye) @ ray > 0.0)
    return ahead and bool(plane.holds(hit))
