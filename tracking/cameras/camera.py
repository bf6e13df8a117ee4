"""Cameras: intrinsics, distortion, size; points to pixels and back; zoomed and turned images.

Conventions: OpenCV camera axes (x right, y down, z forward), metres, pixel (0, 0) is the centre of
the top-left pixel, no skew. Models and their coefficients, in OpenCV's and Kalibr's order:

==============  ====================================================  =============================
model           coefficients                                          source
==============  ====================================================  =============================
``pinhole``     none                                                  Hartley & Zisserman, ch. 6
``radtan``      k1 k2 | k1 k2 p1 p2 | ... k3 | ... k3 k4 k5 k6        Brown 1966; OpenCV ``calib3d``
``equidistant`` k1 k2 k3 k4                                           Kannala & Brandt 2006
==============  ====================================================  =============================

The one derivative of reprojection is here too. A pose is perturbed by a twist in its own frame,
``world_T_camera.retract(twist)``: rotation (rad), then translation (m). The derivative by a pose
elsewhere in a chain follows by the adjoint of what lies between: a twist of the rig in
``world_T_rig @ rig_T_camera`` moves the camera by ``camera_T_rig.adjoint() @ twist``.

A zoom about the lens's centre scales its image about there, distortion and all. So an image that
was taken zoomed shows, scaled back, what the camera's own focal length would have shown of it, and
all that asks a recording for one camera stays as it is.

A phone stores what its sensor reads and notes beside it how the image is to be shown: mirrored or
not, and turned by quarter turns. Turning an image turns its camera's axes about the optical axis;
no pixel is resampled, so the turned camera is exact.

With x' = -y, y' = x for a quarter turn clockwise, Brown's tangential terms (p1, p2) become
(p2, -p1); radial terms stay. Pixel (u, v) of w x h becomes (h - 1 - v, u).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Literal, TypeVar, cast

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray, checked_floats
from motorcade.tracking.cameras import lenses

CameraModel = Literal["pinhole", "radtan", "equidistant"]
_COEFFICIENT_COUNTS: dict[str, tuple[int, ...]] = {
    "pinhole": (0,),
    "radtan": (2, 4, 5, 8),
    "equidistant": (4,),
}

_MARGIN = 1.1
"""A model is to be one-to-one so far beyond an image's corners: its slope is nothing at a fold."""


@dataclass(frozen=True)
class Camera:
    """Intrinsics of one camera.

    Fields:
        width, height: image size, pixels.
        fx, fy: focal lengths, pixels, above zero.
        cx, cy: principal point, pixels; (0, 0) is the centre of the top-left pixel.
        model: "pinhole", "radtan" or "equidistant".
        distortion: the model's coefficients (see the table of this module).

    Raises:
        ValueError: a size or focal length that is not positive, a number that is not finite, an
            unknown model, a count of coefficients that the model does not have.

    >>> from motorcade.ga import Motor, Rotor
    >>> from motorcade.tracking import Camera
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5, "radtan", (-0.2, 0.05, 0.0, 0.0))
    >>> world_T_camera = Motor.from_rotor_translation(Rotor.identity(), [0.0, 0.0, -2.0])
    >>> camera.project(world_T_camera.inverse().apply([0.2, 0.1, 0.0])).round(2)  # of the world
    array([369.38, 264.44])
    >>> camera.unproject([319.5, 239.5])  # the ray along the optical axis
    array([0., 0., 1.])
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    model: CameraModel = "pinhole"
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            size = getattr(self, name)
            if isinstance(size, bool) or not isinstance(size, (int, np.integer)) or size <= 0:
                raise ValueError(
                    f"Camera.{name}: expected a whole number of pixels above 0, got {size!r}"
                )
            object.__setattr__(self, name, int(size))
        for name in ("fx", "fy", "cx", "cy"):
            object.__setattr__(self, name, _finite(getattr(self, name), f"Camera.{name}"))
        for name in ("fx", "fy"):
            if getattr(self, name) <= 0.0:
                raise ValueError(
                    f"Camera.{name}: expected pixels above 0, got {getattr(self, name)}"
                )
        if self.model not in _COEFFICIENT_COUNTS:
            raise ValueError(
                f"Camera.model: expected {' or '.join(_COEFFICIENT_COUNTS)}, got {self.model!r}"
            )
        terms = tuple(_finite(value, "Camera.distortion") for value in self.distortion)
        counts = _COEFFICIENT_COUNTS[self.model]
        if len(terms) not in counts:
            expected = " or ".join(map(str, counts))
            raise ValueError(
                f"Camera.distortion: {self.model} expects {expected} coefficients, got {len(terms)}"
            )
        object.__setattr__(self, "distortion", terms)

    @cached_property
    def matrix(self) -> FloatArray:
        """The 3 by 3 intrinsic matrix, pixels, read-only."""
        matrix = np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])
        matrix.setflags(write=False)
        return matrix

    def project(self, points_camera: ArrayLike, *, allow_nan: bool = False) -> FloatArray:
        """Map points in the camera frame, ``(*, 3)`` metres, to pixels ``(*, 2)``.

        Points that the model gives no image (at or behind the camera's plane; for "equidistant"
        only the camera centre and what is straight behind it) become NaN. Far outside the
        calibrated field a radtan polynomial may fold back into the image; nothing here can know
        where it was fitted.

        Args:
            points_camera: the points.
            allow_nan: let points that are not finite become NaN, instead of refusing them.

        Raises:
            ValueError: not ``(*, 3)`` or not finite.
        """
        points = np.asarray(points_camera, np.float64)
        if not allow_nan or points.shape[-1:] != (3,):
            points = checked_floats(points_camera, "points_camera", (3,))
        return self._to_pixels(lenses.distort(self.model, self._coefficients, points))

    def project_jacobian(self, points_camera: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Project, and give the derivative of the pixels by the points.

        Returns:
            pixels ``(*, 2)`` and their Jacobian ``(*, 2, 3)`` in pixels per metre; NaN where
            `project` gives NaN.

        Raises:
            ValueError: not ``(*, 3)`` or not finite.
        """
        points = checked_floats(points_camera, "points_camera", (3,))
        plane, jacobian = lenses.distort_jacobian(self.model, self._coefficients, points)
        return self._to_pixels(plane), jacobian * np.array([[self.fx], [self.fy]])

    def unproject(self, pixels: ArrayLike) -> FloatArray:
        """Map pixels ``(*, 2)`` to rays ``(*, 3)`` of unit depth (z = 1) in the camera frame.

        Newton's method on the distortion, to 1e-12 of the image plane's unit. NaN where there is no
        such ray: outside what a radtan polynomial reaches before it folds back, or at 90 degrees
        and more from the axis of an equidistant lens.

        Raises:
            ValueError: not ``(*, 2)`` or not finite.
        """
        px = checked_floats(pixels, "pixels", (2,))
        plane = (px - (self.cx, self.cy)) / (self.fx, self.fy)
        ideal = lenses.undistort(self.model, self._coefficients, plane)
        return np.concatenate([ideal, np.ones_like(ideal[..., :1])], axis=-1)

    def bearings(self, pixels: ArrayLike) -> FloatArray:
        """Map pixels ``(*, 2)`` to unit vectors ``(*, 3)`` along their rays in the camera frame.

        As `unproject`, but an equidistant lens sees at 90 degrees and more from its axis too.

        Raises:
            ValueError: not ``(*, 2)`` or not finite.
        """
        px = checked_floats(pixels, "pixels", (2,))
        plane = (px - (self.cx, self.cy)) / (self.fx, self.fy)
        return lenses.bearings(self.model, self._coefficients, plane)

    def undistort(self, pixels: ArrayLike) -> FloatArray:
        """Where pixels ``(*, 2)`` of this camera lie in the image of `undistorted`.

        Straight lines of the world are straight there. NaN where `unproject` gives NaN.

        Raises:
            ValueError: not ``(*, 2)`` or not finite.
        """
        return self._to_pixels(self.unproject(pixels)[..., :2])

    def distort(self, pixels: ArrayLike) -> FloatArray:
        """Where pixels ``(*, 2)`` of `undistorted` lie in this camera's image.

        Raises:
            ValueError: not ``(*, 2)`` or not finite.
        """
        return self.project(self.undistorted().unproject(pixels))

    def folds(self) -> bool:
        """Whether the lens model folds back in the image, or within a tenth beyond its corners.

        Radial terms that were fitted to the middle of images often do; pixels beyond the fold
        have no ray. Told by the radial terms alone.

        >>> from motorcade.tracking import Camera
        >>> lens = "radtan", (-0.5, 0.0)  # grows up to a radius of 0.54 focal lengths
        >>> [Camera(640, 480, f, f, 319.5, 239.5, *lens).folds() for f in (500.0, 1000.0)]
        [True, False]
        """
        far_x, far_y = (
            max(middle + 0.5, size - 0.5 - middle) / focal
            for middle, size, focal in (
                (self.cx, self.width, self.fx),
                (self.cy, self.height, self.fy),
            )
        )
        return _MARGIN * math.hypot(far_x, far_y) >= lenses.reach(self.model, self._coefficients)

    def undistorted(self) -> Camera:
        """The pinhole camera of the same size and matrix: what `undistort_image` shows."""
        return Camera(self.width, self.height, self.fx, self.fy, self.cx, self.cy)

    def undistort_image(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Resample an image as `undistorted` would have taken it.

        Grey ``(height, width)`` or colour ``(height, width, channels)``, bilinear.
        Pixels without a source are black. The maps are computed once a camera.

        Raises:
            ValueError: not uint8, or not of the camera's size.
        """
        if image.dtype != np.uint8 or image.ndim not in (2, 3):
            raise ValueError(
                f"image: expected a uint8 image of 2 or 3 dimensions, "
                f"got {image.dtype} of shape {image.shape}"
            )
        if image.shape[:2] != (self.height, self.width):
            raise ValueError(
                f"image: expected {self.width} x {self.height} pixels, "
                f"got {image.shape[1]} x {image.shape[0]}"
            )
        if self.model == "pinhole":
            return image.copy()
        resampled = cv2.remap(image, *_undistortion_maps(self), cv2.INTER_LINEAR)
        return cast("NDArray[np.uint8]", resampled.reshape(image.shape))

    def undistort_depth(self, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """Resample a depth image ``(height, width)`` likewise, taking the nearest pixel.

        Depths of different surfaces are never mixed; pixels without a source are NaN.

        Raises:
            ValueError: not of the camera's size.
        """
        if depth_m.shape != (self.height, self.width):
            raise ValueError(
                f"depth_m: expected shape {(self.height, self.width)}, got {depth_m.shape}"
            )
        if self.model == "pinhole":
            return depth_m.copy()
        outside: dict[str, Any] = {
            "borderMode": cv2.BORDER_CONSTANT,
            "borderValue": (float("nan"),),
        }
        source = _undistortion_source(self)
        resampled = cv2.remap(depth_m, source, None, cv2.INTER_NEAREST, **outside)
        return cast("NDArray[np.float32]", resampled)

    @cached_property
    def _coefficients(self) -> FloatArray:
        """Radtan coefficients padded to eight, the others as they are."""
        padded = self.distortion + (0.0,) * (8 - len(self.distortion))
        return np.array(padded if self.model == "radtan" else self.distortion)

    def _to_pixels(self, plane: FloatArray) -> FloatArray:
        return plane * (self.fx, self.fy) + (self.cx, self.cy)


@lru_cache(maxsize=8)
def _undistortion_source(camera: Camera) -> NDArray[np.float32]:
    """Where in the taken image each undistorted pixel comes from, ``(height, width, 2)``."""
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return camera.distort(np.stack([columns, rows], axis=-1)).astype(np.float32)


@lru_cache(maxsize=8)
def _undistortion_maps(camera: Camera) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
    """The same as fixed-point maps for `cv2.remap`: faster than floats, to 1/32 of a pixel."""
    whole, fraction = cv2.convertMaps(_undistortion_source(camera), None, cv2.CV_16SC2)
    return whole, fraction


def _finite(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name}: expected a number, got {value!r}")
    if not math.isfinite(value):
        raise ValueError(f"{name}: expected a finite number, got {value}")
    return float(value)


def project(
    camera: Camera, world_T_camera: Motor, points_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pixels ``(n, 2)`` and depths ``(n,)`` of points ``(n, 3)`` of the world, NaN passed on.

    Pixels are NaN where `Camera.project` gives NaN, and where a point is NaN.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking.cameras.camera import Camera
    >>> from motorcade.tracking.cameras.camera import project
    >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
    >>> one_metre_back = Motor.from_twist([0.0, 0.0, 0.0, 0.0, 0.0, -1.0])
    >>> project(camera, one_metre_back, np.array([[0.1, 0.0, 0.0]]))
    (array([[369.5, 239.5]]), array([1.]))
    """
    in_camera = to_frame(world_T_camera, points_m)
    return camera.project(in_camera, allow_nan=True), in_camera[:, 2]


def to_frame(world_T_frame: Motor, points_m: FloatArray) -> FloatArray:
    """Points ``(*, 3)`` of the world in a frame, NaN passed on (`Motor.apply` refuses it)."""
    pose = world_T_frame.as_matrix()
    in_frame: FloatArray = (points_m - pose[:3, 3]) @ pose[:3, :3]
    return in_frame


def reproject(camera: Camera, in_camera: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pixels of points ``(*, 3)`` in the camera's frame, and the derivatives.

    Returns:
        pixels ``(*, 2)``, their derivative ``(*, 2, 6)`` by the twist of the camera's pose, and
        ``(*, 2, 3)`` by the point in the camera's frame; NaN where a point has no image.
    """
    pixels, by_point = camera.project_jacobian(in_camera)
    return pixels, by_twist(in_camera, by_point), by_point


def by_twist(in_camera: FloatArray, by_point: FloatArray) -> FloatArray:
    """Derivative ``(*, r, 6)`` by the twist of the camera's pose, of r numbers of a point.

    Args:
        in_camera: ``(*, 3)`` the point, which moves by ``X x d(rotation) - d(translation)``.
        by_point: ``(*, r, 3)`` derivative of the numbers by it.
    """
    x, y, z = (in_camera[..., None, axis] for axis in range(3))
    a, b, c = (by_point[..., axis] for axis in range(3))
    jacobian = np.empty((*by_point.shape[:-1], 6))
    jacobian[..., 0] = z * b - y * c
    jacobian[..., 1] = x * c - z * a
    jacobian[..., 2] = y * a - x * b
    np.negative(by_point, out=jacobian[..., 3:])
    return jacobian


Pixels = TypeVar("Pixels", NDArray[np.uint8], NDArray[np.float32])
_ALIASED = 0.5
MOST_KNOTS = 500
"""A curve is written with no more times than this."""


@dataclass(frozen=True, eq=False)
class Zoom:
    """Focal lengths over time, in those of a camera.

    Distortion is held to be the same in every focal length, which lenses keep roughly; a rolling
    shutter's rows keep their times only near a ratio of 1.

    Args:
        time_s: ``(K,)`` rising, on the clock of the frames' stamps.
        ratio: ``(K,)`` focal length over the camera's, above 0; geometric between, constant beyond.

    Raises:
        ValueError: another number of ratios than of times, times that do not rise, or ratios that
            are not above 0.

    >>> from motorcade.tracking.cameras.camera import Zoom
    >>> Zoom([0.0, 2.0], [1.0, 4.0]).at([-1_000_000_000, 1_000_000_000])
    array([1., 2.])
    """

    time_s: FloatArray
    ratio: FloatArray

    def __post_init__(self) -> None:
        for name in ("time_s", "ratio"):
            values = np.array(getattr(self, name), np.float64)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.time_s.ndim != 1 or not len(self.time_s) or np.any(np.diff(self.time_s) <= 0.0):
            raise ValueError("Zoom.time_s: expected rising seconds, got some that do not rise")
        if self.ratio.shape != self.time_s.shape or not np.all(self.ratio > 0.0):
            expected = f"expected {len(self.time_s)} numbers above 0, one a time"
            raise ValueError(f"Zoom.ratio: {expected}, got {self.ratio.tolist()[:4]}")

    def at(self, time_ns: IntArray | int) -> FloatArray:
        """Focal length over the camera's ``(*,)`` at stamps ``(*,)``."""
        time_s = 1e-9 * np.asarray(time_ns, np.float64)
        return np.asarray(np.exp(np.interp(time_s, self.time_s, np.log(self.ratio))))

    def unzoomed(self, image: Pixels, camera: Camera, time_ns: int) -> Pixels:
        """An image ``(h, w)`` or ``(h, w, 3)`` as the camera's own focal length shows it.

        What it does not show is black, or NaN of an image of numbers.
        """
        ratio = float(self.at(time_ns))
        depth = image.dtype != np.uint8
        if ratio > 1.0 and not depth:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), _ALIASED * (ratio**2 - 1) ** 0.5))
        scale, centre = 1.0 / ratio, np.array([camera.cx, camera.cy])
        shown = np.column_stack([scale * np.eye(2), (1.0 - scale) * centre])
        size, how = (camera.width, camera.height), cv2.INTER_NEAREST if depth else cv2.INTER_CUBIC
        outside = np.nan if depth else 0.0
        moved = cv2.warpAffine(image, shown, size, flags=how, borderValue=(outside,) * 4)
        return np.asarray(moved, image.dtype)


Stored = TypeVar("Stored", bound=np.generic)
_QUARTER_TURN = np.array([[0, -1], [1, 0]])


@dataclass(frozen=True)
class ImageOrientation:
    """How a stored image is shown: mirrored left to right or not, then turned clockwise.

    Fields:
        quarter_turns: 0 to 3, clockwise.
        mirrored: before that.

    Raises:
        ValueError: another number of quarter turns.

    >>> import numpy as np
    >>> from motorcade.tracking.cameras.camera import ImageOrientation
    >>> ImageOrientation(1).upright(np.array([[1, 2, 3], [4, 5, 6]]))
    array([[4, 1],
           [5, 2],
           [6, 3]])
    """

    quarter_turns: int = 0
    mirrored: bool = False

    def __post_init__(self) -> None:
        if self.quarter_turns not in range(4):
            raise ValueError(f"quarter_turns: expected 0 to 3, got {self.quarter_turns!r}")

    @property
    def degrees(self) -> int:
        """Clockwise: 0, 90, 180 or 270."""
        return 90 * self.quarter_turns

    @property
    def matrix(self) -> NDArray[np.int64]:
        """(2, 2) from stored directions (right, down) to shown ones."""
        turn = np.linalg.matrix_power(_QUARTER_TURN, self.quarter_turns)
        return np.asarray(turn @ np.diag([-1 if self.mirrored else 1, 1]), np.int64)

    def size(self, stored: tuple[int, int]) -> tuple[int, int]:
        """Width and height as shown."""
        return (stored[1], stored[0]) if self.quarter_turns % 2 else stored

    def upright(self, image: NDArray[Stored]) -> NDArray[Stored]:
        """A stored image ``(height, width, ...)`` as it is shown; the image itself where it is
        stored so.
        """
        if self == AS_STORED:
            return image
        seen = image[:, ::-1] if self.mirrored else image
        return np.ascontiguousarray(np.rot90(seen, -self.quarter_turns))


AS_STORED = ImageOrientation()


def turned_camera(camera: Camera, quarter_turns: int) -> Camera:
    """The camera of images turned clockwise; any whole number of quarter turns.

    What `camera` has at a pixel, this one has where that pixel goes, along axes that are turned
    with the image (`camera_T_turned`).

    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.cameras.camera import turned_camera
    >>> turned_camera(Camera(640, 480, 500.0, 505.0, 310.0, 240.0), 1)
    Camera(width=480, height=640, fx=505.0, fy=500.0, cx=239.0, cy=310.0, model='pinhole', \
distortion=())
    """
    for _ in range(quarter_turns % 4):
        distortion = camera.distortion
        if camera.model == "radtan" and len(distortion) > 2:
            k1, k2, p1, p2, *others = distortion
            distortion = (k1, k2, p2, -p1, *others)
        camera = Camera(
            camera.height,
            camera.width,
            camera.fy,
            camera.fx,
            camera.height - 1 - camera.cy,
            camera.cx,
            camera.model,
            distortion,
        )
    return camera


def camera_T_turned(quarter_turns: int) -> Motor:
    """From the axes of `turned_camera` to those of the camera before it was turned.

    >>> from motorcade.tracking.cameras.camera import camera_T_turned
    >>> camera_T_turned(1).apply([0.0, 1.0, 0.0]).round(9)  # down as shown is right as stored
    array([1., 0., 0.])
    """
    angle_rad = -0.5 * math.pi * (quarter_turns % 4)
    turn = Rotor.from_rotation_vector([0.0, 0.0, angle_rad])
    return Motor.from_rotor_translation(turn, [0.0, 0.0, 0.0])
