"""Two views and more: triangulation, the pose of one image, and how a map starts from two.

Poses are ``world_T_camera``, the camera is an undistorted pinhole or a fisheye as it is, points are
metres (or the free unit of a monocular map). A covariance belongs to the perturbation
``world_T_camera.retract(step)``, rotation (rad), then translation.

Sources: Hartley & Zisserman 2003, ch. 12; Barath et al. 2020 (MAGSAC++, in OpenCV).

A scene with depth fits an essential matrix, a flat one a homography; both are fitted (MAGSAC) and
scored alike. Where a rotation alone explains the motion of the corners there is no parallax, and
nothing is started: the scale-free map that would follow is arbitrary.

Sources: Hartley & Zisserman 2003, ch. 9 and 13; scores: Mur-Artal et al. 2015; MAGSAC++: Barath
et al. 2020.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.cameras.camera import Camera, project
from motorcade.tracking.images import track_corners
from motorcade.tracking.native._least_squares import Lens, View
from motorcade.tracking.optimise import NormalEquations, Stop
from motorcade.tracking.slam.features import Corners, SlamImage, find_corners

BoolArray = NDArray[np.bool_]

OUTLIER_PX = 3.0
_HUBER_PX = 1.5
_SIGMA_FLOOR_PX = 0.3
_STOP = Stop(steps=10, gain=1e-7, damping=1e-9)
_SAMPLES = 300
_FEWEST = 6
# A pinhole stretches a fisheye's pixels fivefold along the radius where rays stand 65 degrees off
# the axis; corners beyond are left to those who know the lens.
_FLAT_COSINE = np.cos(np.deg2rad(65.0))


@dataclass(frozen=True, eq=False)
class FittedPose:
    """A pose fitted to points and their pixels.

    Args:
        world_T_camera: the pose.
        covariance: ``(6, 6)``, rotation (rad) then translation, of the right perturbation.
        inliers: ``(n,)`` which points the pose explains within `OUTLIER_PX`.
        error_px: root mean square reprojection error of the inliers.
    """

    world_T_camera: Motor
    covariance: FloatArray
    inliers: BoolArray
    error_px: float


def is_native(camera: Camera) -> bool:
    """Whether SLAM works in the images as the lens made them.

    So it does for a fisheye: a pinhole's image ends where the rays do long before 90 degrees. Of
    other lenses the images are undistorted once, which is faster.
    """
    return camera.model == "equidistant"


def seen_through(camera: Camera) -> Camera:
    """The camera whose images SLAM works in, and whose pixels its map holds."""
    return camera if is_native(camera) else camera.undistorted()


def flattened(camera: Camera, px: FloatArray) -> FloatArray:
    """Pixels ``(n, 2)`` of a pinhole with the camera's matrix; NaN far from the axis of a fisheye.

    For estimators that know nothing but pinholes, and may leave corners out.
    """
    if not is_native(camera):
        return px
    bearings = camera.bearings(px)
    near = bearings[:, 2] > _FLAT_COSINE
    flat = np.full(px.shape, np.nan)
    flat[near] = camera.undistorted().project(bearings[near])
    return flat


def reach(camera: Camera, in_camera: FloatArray) -> FloatArray:
    """How far ``(n,)`` points are, as the size of what is seen of them goes by it.

    That is the depth along the axis of a pinhole, and the distance from a fisheye.
    """
    return np.linalg.norm(in_camera, axis=-1) if is_native(camera) else in_camera[:, 2]


def triangulate(
    first: Motor, second: Motor, px: FloatArray, other_px: FloatArray, camera: Camera
) -> FloatArray:
    """Points ``(n, 3)`` seen at pixels ``(n, 2)`` from two poses; linear, all at once."""
    rows = []
    for world_T_camera, pixels in ((first, px), (second, other_px)):
        pose = world_T_camera.inverse().as_matrix()
        normals = _across(camera, pixels)
        rows += [
            normals[:, k, :1] * pose[0] + normals[:, k, 1:2] * pose[1] + normals[:, k, 2:] * pose[2]
            for k in (0, 1)
        ]
    system = np.stack(rows, axis=1)
    system = system / np.linalg.norm(system, axis=-1, keepdims=True)
    known = np.isfinite(system).all(axis=(-1, -2))
    system[~known] = 0.0
    # The smallest eigenvector of A^T A: four by four, and far faster than a batch of SVDs.
    _, vectors = np.linalg.eigh(np.swapaxes(system, -1, -2) @ system)
    homogeneous = vectors[..., 0]
    scale = np.where(np.abs(homogeneous[:, 3:]) > 1e-12, homogeneous[:, 3:], np.nan)
    points: FloatArray = homogeneous[:, :3] / np.where(known[:, None], scale, np.nan)
    return points


def _across(camera: Camera, px: FloatArray) -> FloatArray:
    """Two vectors ``(n, 2, 3)`` across the ray of each pixel: normals of planes that hold it."""
    normals = np.zeros((len(px), 2, 3))
    if not is_native(camera):
        normals[:, [0, 1], [0, 1]] = -1.0
        normals[:, :, 2] = camera.unproject(px)[:, :2]
        return normals
    bearings = camera.bearings(px)
    least = np.zeros_like(bearings)
    axis = np.argmin(np.abs(np.nan_to_num(bearings)), axis=-1)
    np.put_along_axis(least, axis[:, None], 1.0, axis=-1)
    normals[:, 0] = np.cross(bearings, least)
    normals[:, 1] = np.cross(bearings, normals[:, 0])
    return normals


def parallax_rad(first: Motor, second: Motor, points: FloatArray) -> FloatArray:
    """Angles ``(n,)`` between the rays from two cameras to the points."""
    a, b = (points - pose.translation_m for pose in (first, second))
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    angle: FloatArray = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angle


def in_world(world_T_map: Similarity, map_T_camera: Motor) -> Motor:
    """Rigid poses ``(*)`` of a map's cameras in a world of another unit."""
    place = world_T_map.apply(map_T_camera.translation_m)
    return Motor.from_rotor_translation(world_T_map.rotor @ map_T_camera.rotor, place)


def points_in_world(world_T_map: Similarity, points: FloatArray) -> FloatArray:
    """A map's points ``(n, 3)`` likewise, NaN passed on."""
    moved = np.full(points.shape, np.nan)
    known = np.isfinite(points[:, 0])
    moved[known] = world_T_map.apply(points[known])
    return moved


@lru_cache(maxsize=8)
def lens_of(camera: Camera) -> Lens:
    """The camera as compiled equations take it."""
    return Lens(camera.model, camera.fx, camera.fy, camera.cx, camera.cy, camera.distortion)


def _covariance(view: View, pose: Motor, inliers: BoolArray, sigma: float) -> FloatArray:
    """Of the pose by the inliers alone; infinite where they do not fix it."""
    camera_T_world = pose.inverse().as_matrix()
    equations = NormalEquations(*view.linearise(camera_T_world, OUTLIER_PX))
    if np.count_nonzero(inliers) < _FEWEST or np.linalg.cond(equations.information) >= 1e14:
        return np.full((6, 6), np.inf)
    return equations.covariance(sigma)


def refine_pose(
    world_T_camera: Motor, points: FloatArray, px: FloatArray, camera: Camera
) -> FittedPose:
    """Robust least squares of the reprojection error, from a pose that is near.

    Args:
        world_T_camera: the start.
        points: ``(n, 3)``.
        px: ``(n, 2)`` where they were seen.
        camera: the pinhole that saw them.

    The pose found is a unit motor however far rounding has taken the start from one: poses that
    are moved along with a keyframe, which was made of such a pose, double their defect every time.

    Points behind the camera count as outliers. With fewer than six inliers, or points that do not
    fix the pose, the covariance is infinite.

    >>> import numpy as np
    >>> from motorcade.ga import Motor
    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.slam.geometry import refine_pose
    >>> camera, rng = Camera(640, 480, 500.0, 500.0, 319.5, 239.5), np.random.default_rng(0)
    >>> points = rng.uniform([-1.0, -1.0, 2.0], [1.0, 1.0, 4.0], (50, 3))
    >>> world_T_camera = Motor.from_twist([0.02, -0.01, 0.0, 0.1, 0.0, 0.05])
    >>> px = camera.project(world_T_camera.inverse().apply(points))
    >>> fit = refine_pose(Motor.identity(), points, px, camera)
    >>> bool(np.abs(fit.world_T_camera.local(world_T_camera)).max() < 1e-6)
    True
    """
    start = Motor.normalize(world_T_camera.coefficients)
    view = View(lens_of(camera), points, px, _HUBER_PX, OUTLIER_PX)
    stop = (_STOP.steps, _STOP.gain, _STOP.damping, _STOP.most_damping)
    coefficients, error = view.refine(start.coefficients, *stop)
    pose = Motor.normalize(coefficients)
    inliers = error <= OUTLIER_PX
    rms = float(np.sqrt(np.mean(error[inliers] ** 2))) if inliers.any() else float("inf")
    sigma = max(rms / np.sqrt(2.0), _SIGMA_FLOOR_PX)
    return FittedPose(pose, _covariance(view, pose, inliers, sigma), inliers, rms)


def pose_by_sampling(points: FloatArray, px: FloatArray, camera: Camera) -> FittedPose | None:
    """Pose from scratch: MAGSAC over minimal samples, then `refine_pose`; None where none is found.

    OpenCV seeds its samples alike at every call, so the same points give the same pose.
    """
    flat = flattened(camera, px)
    near = np.isfinite(flat[:, 0])
    if np.count_nonzero(near) < _FEWEST:
        return None
    try:
        solved, turn, shift, _ = cv2.solvePnPRansac(
            np.ascontiguousarray(points[near]),
            np.ascontiguousarray(flat[near]),
            np.array(camera.matrix),
            None,
            iterationsCount=_SAMPLES,
            reprojectionError=OUTLIER_PX,
            confidence=0.999,
            flags=cv2.USAC_MAGSAC,
        )
    except cv2.error:
        return None  # samples that allow no pose at all: OpenCV 5 throws where it finds no model
    if not solved or not np.isfinite(turn).all() or not np.isfinite(shift).all():
        return None
    return refine_pose(pose_from_opencv(turn, shift).inverse(), points, px, camera)


def pose_from_opencv(turn: FloatArray, shift: FloatArray) -> Motor:
    """A motor from OpenCV's rotation vector ``(3,)`` or matrix ``(3, 3)``, and its translation."""
    vector = cv2.Rodrigues(turn)[0] if np.size(turn) == 9 else turn
    return Motor.from_rotor_translation(
        Rotor.from_rotation_vector(np.ravel(vector)), np.ravel(shift)
    )


FEWEST_CORNERS = 80
_FEWEST_POINTS = 50
_LEAST_FLOW_PX = 4.0  # what must remain of the motion when the rotation is taken out
_PARALLAX_RAD = np.deg2rad(1.0)
_THRESHOLD_PX = 1.0
_HOMOGRAPHY_SHARE = 0.45
_CHI2_POINT, _CHI2_LINE = 5.99, 3.84
_GOOD_PX = 2.0
_RIVAL = 0.8  # a second solution with so much of the best one's support leaves it undecided
_KEPT_SHARE = 0.25
_MOST_PENDING = 600


@dataclass(frozen=True, eq=False)
class TwoViews:
    """The second view from the first, for a baseline of length 1.

    Args:
        first_T_second: where the second camera stands.
        good: ``(n,)`` inliers that have parallax.
        model: "essential" or "homography".
    """

    first_T_second: Motor
    good: BoolArray
    model: str


@dataclass(frozen=True, eq=False)
class TwoViewStart:
    """Two images from which a map can start, and the corners tracked between them.

    Args:
        first, second: the images; corners: those of the first that were tracked to the second.
        second_px: ``(n, 2)`` where they are there; views: the geometry.
        between: of each image in between its stamp, rows of `corners` and pixels.
    """

    first: SlamImage
    second: SlamImage
    corners: Corners
    second_px: FloatArray
    views: TwoViews
    between: tuple[tuple[int, BoolArray, FloatArray], ...]


def flow_beyond_rotation_px(first_px: FloatArray, px: FloatArray, camera: Camera) -> float:
    """Median motion of corners that the best rotation leaves over, pixels.

    Rotation by Kabsch's method, reweighted so that a minority of corners cannot turn it.
    """
    rays = []
    for pixels in (first_px, px):
        rays.append(camera.bearings(pixels))
    weight = np.ones(len(px))
    left = np.zeros(len(px))
    for _ in range(8):
        u, _, vt = np.linalg.svd((rays[1] * weight[:, None]).T @ rays[0])
        turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
        seen = camera.project(rays[0] @ turn.T)
        left = np.nan_to_num(np.linalg.norm(seen - px, axis=1), nan=np.inf)
        weight = 1.0 / (1.0 + left**2)
    return float(np.median(left))


def two_views(first_px: FloatArray, px: FloatArray, camera: Camera) -> TwoViews | None:
    """Relative pose of two views from corners ``(n, 2)`` in both; None where it is undecided.

    Refused: a flow that rotation explains, too few inliers, too little parallax, or two
    solutions that explain the views almost equally well.
    """
    flat_first, flat = flattened(camera, first_px), flattened(camera, px)
    near = np.isfinite(flat_first[:, 0]) & np.isfinite(flat[:, 0])
    if np.count_nonzero(near) < FEWEST_CORNERS:
        return None
    flat_first, flat = flat_first[near], flat[near]
    essential, _ = cv2.findEssentialMat(
        flat_first,
        flat,
        np.array(camera.matrix),
        method=cv2.USAC_MAGSAC,
        prob=0.9999,
        threshold=_THRESHOLD_PX,
    )
    homography, _ = cv2.findHomography(flat_first, flat, cv2.USAC_MAGSAC, 2.0 * _THRESHOLD_PX)
    plane, deep = 0.0, 0.0
    if homography is not None:
        plane = _homography_score(homography, flat_first, flat)
    if essential is not None and essential.shape == (3, 3):
        deep = _essential_score(essential, flat_first, flat, camera.matrix)
    if plane + deep <= 0.0:
        return None
    model = "homography" if plane / (plane + deep) > _HOMOGRAPHY_SHARE else "essential"
    poses = _from_homography if model == "homography" else _from_essential
    matrix = homography if model == "homography" else essential
    supported = [
        (_support(pose, first_px, px, camera), pose) for pose in poses(matrix, camera.matrix)
    ]
    if not supported:  # a homography of nothing but a turn
        return None
    supported.sort(key=lambda support: -int(np.count_nonzero(support[0])))
    good, pose = supported[0]
    count = int(np.count_nonzero(good))
    rival = int(np.count_nonzero(supported[1][0])) if len(supported) > 1 else 0
    if count < max(_FEWEST_POINTS, 0.5 * len(px)) or rival > _RIVAL * count:
        return None
    return TwoViews(pose, good, model)


def _homography_score(homography: FloatArray, first_px: FloatArray, px: FloatArray) -> float:
    forth = _squared(_mapped(homography, first_px), px)
    back = _squared(_mapped(np.linalg.inv(homography).astype(np.float64), px), first_px)
    return sum(float(np.maximum(_CHI2_POINT - d, 0.0).sum()) for d in (forth, back))


def _essential_score(
    essential: FloatArray, first_px: FloatArray, px: FloatArray, matrix: FloatArray
) -> float:
    to_plane = np.linalg.inv(matrix)
    fundamental = to_plane.T @ essential @ to_plane
    a, b = (np.concatenate([pixels, np.ones((len(px), 1))], axis=1) for pixels in (first_px, px))
    score = 0.0
    for lines, points in ((a @ fundamental.T, b), (b @ fundamental, a)):
        squared = np.sum(lines * points, axis=1) ** 2 / np.sum(lines[:, :2] ** 2, axis=1)
        score += float(np.where(squared < _CHI2_LINE, _CHI2_POINT - squared, 0.0).sum())
    return score


def _mapped(homography: FloatArray, px: FloatArray) -> FloatArray:
    there = px @ homography[:, :2].T + homography[:, 2]
    mapped: FloatArray = there[:, :2] / there[:, 2:]
    return mapped


def _squared(a: FloatArray, b: FloatArray) -> FloatArray:
    squared: FloatArray = np.sum((a - b) ** 2, axis=1)
    return squared


def _from_essential(essential: FloatArray, _: FloatArray) -> Iterator[Motor]:
    turned, other, shift = cv2.decomposeEssentialMat(essential)
    for turn in (turned, other):
        for sign in (1.0, -1.0):
            yield pose_from_opencv(turn, sign * np.ravel(shift)).inverse()


def _from_homography(homography: FloatArray, matrix: FloatArray) -> Iterator[Motor]:
    _, turns, shifts, _ = cv2.decomposeHomographyMat(homography, np.array(matrix))
    for turn, shift in zip(turns, shifts, strict=True):
        length = float(np.linalg.norm(shift))
        if length > 1e-6:
            yield pose_from_opencv(turn, np.ravel(shift) / length).inverse()


def _support(pose: Motor, first_px: FloatArray, px: FloatArray, camera: Camera) -> BoolArray:
    """Corners whose point lies before both cameras, reprojects well and has parallax."""
    first = Motor.identity()
    points = triangulate(first, pose, first_px, px, camera)
    near, _ = project(camera, first, points)  # behind a camera none is seen
    other, _ = project(camera, pose, points)
    error = np.sqrt(np.maximum(_squared(near, first_px), _squared(other, px)))
    good = np.nan_to_num(error, nan=np.inf) < _GOOD_PX
    parallax = parallax_rad(first, pose, points)
    wide = good & (parallax > _PARALLAX_RAD)
    if np.count_nonzero(wide) < _FEWEST_POINTS:
        return np.zeros(len(px), dtype=np.bool_)
    return good


class TwoViewInitialiser:
    """Tracks the corners of a first image until a later one gives a map.

    Args:
        camera: the pinhole; features: corners to track.
    """

    def __init__(self, camera: Camera, features: int) -> None:
        self._camera = camera
        self._features = features
        self._first: SlamImage | None = None

    def feed(self, image: SlamImage) -> TwoViewStart | None:
        """Take the next image; a `TwoViewStart` once one is found."""
        if self._first is None or not self._tracked(image):
            self._restart(image)
            return None
        rows = self._rows
        first_px = self._corners.px[rows]
        flow = flow_beyond_rotation_px(first_px, self._px, self._camera)
        views = None
        if flow >= _LEAST_FLOW_PX:
            views = two_views(first_px, self._px, self._camera)
        if views is None:
            kept = np.zeros(len(self._corners), dtype=np.bool_)
            kept[rows] = True
            self._between.append((image.time_ns, kept, self._px))
            del self._between[:-_MOST_PENDING]
            return None
        corners = Corners(first_px, self._corners.descriptors[rows])
        position = np.cumsum(np.isin(np.arange(len(self._corners)), rows)) - 1
        between = []
        for stamp, kept, px in self._between:
            still = np.isin(np.flatnonzero(kept), rows)
            mask = np.zeros(len(rows), dtype=np.bool_)
            mask[position[np.flatnonzero(kept)[still]]] = True
            between.append((stamp, mask, px[still]))
        return TwoViewStart(self._first, image, corners, self._px, views, tuple(between))

    def _restart(self, image: SlamImage) -> None:
        self._corners = find_corners(image.gray, self._features)
        self._first = image if len(self._corners) >= FEWEST_CORNERS else None
        self._last, self._px = image, self._corners.px
        self._rows = np.arange(len(self._corners))
        self._motion = np.zeros_like(self._px)
        self._between: list[tuple[int, BoolArray, FloatArray]] = []

    def _tracked(self, image: SlamImage) -> bool:
        """Track the corners one image on; False where too few remain."""
        guess = self._px + self._motion
        px, tracked = track_corners(self._last.pyramid, image.pyramid, self._px, guess)
        self._motion = (px - self._px)[tracked]
        self._rows, self._px, self._last = self._rows[tracked], px[tracked], image
        return len(self._rows) >= max(FEWEST_CORNERS, _KEPT_SHARE * len(self._corners))
