"""What a character may stand on where no board or marker is: surfaces that were found, and a level.

Each candidate has three shares that multiply to its rank: the probability that what it takes for up
is up (`tracking.planes.estimate_up`), the probability that it is a surface (`belief_in`), and in
how much of the film a character on it is seen well (`in_view`). All are offered, the best first.

Where on a plane a character finds room and is seen well: whole, for long, not tiny.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motorcade.animation.vectors import axes_along
from motorcade.ga import Motor, Rotor, Trajectory
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.recording import Frame, Recording
from motorcade.replays.stages.values.camera_poses import CameraPoses
from motorcade.replays.stages.view.ground import (
    FARTHEST_M,
    FLOOR_HEIGHT_M,
    Ground,
    upward,
    where_it_looks,
)
from motorcade.replays.stages.view.views import scene_views, share_unhidden
from motorcade.tracking.cameras.camera import Camera
from motorcade.tracking.depth.sweep import SceneViews
from motorcade.tracking.planes import (
    FlatSurface,
    Plane,
    UpEstimate,
    belief_in,
    estimate_up,
    find_planes,
    find_planes_in_depth,
    foot_level,
    segment_rays,
)

_CAMERAS, _STEPS, _INSIDE = 40, 15, 0.8
# Of the character's height: what is higher than this, and nearer than this, is in its way; so many
# points of a sensor may be wrong.
_STEP, _ROOM, _STRAYS = 0.05, 0.2, 3
_MARGIN, _LARGE_ENOUGH, _HEADLESS, _FROM_MIDDLE = 0.03, 0.2, 0.3, 0.05
# Seen from straight above, what a character is worth beside one seen from the side.
_FORESHORTENED = 0.5
# Places whose view is tried, heights apart, until one shows so much of the character.
_TRIED, _APART, _IN_THE_OPEN = 6, 0.5, 0.9
# Half of a character's width, what is nearer than it by this factor hides it, of so many points.
_HALF_WIDE, _NEARER, _HIDING = 0.15, 0.95, 1000


def best_place(
    outline_m: FloatArray,
    height_m: float,
    camera: Camera,
    plane_T_camera: Motor,
    points_m: FloatArray,
    noise_m: float,
    unhidden: Callable[[FloatArray], float] = lambda place: 1.0,
) -> tuple[tuple[float, float], float]:
    """The place on a plane where the character is in view best, taken over the camera's path.

    A frame counts fully where it shows the character whole and at least a fifth as tall as the
    image, less where it is smaller, only its feet are shown, or points lie before it. Of places
    that are seen alike the one nearest the plane's middle is taken. Places where something stands
    are skipped, unless there are no others.

    Args:
        outline_m: ``(k, 2)`` convex, anticlockwise, about the origin of the plane's frame.
        height_m: of the character.
        camera: that takes the images; its distortion is left aside.
        plane_T_camera: Motor ``(N,)``, its poses in the plane's frame.
        points_m: ``(p, 3)`` seen or mapped, in the plane's frame.
        noise_m: of these.
        unhidden: what other views tell of a place ``(2,)``: the share of the character there that
            nothing hides. Of a few places, far apart, the best is taken by both.

    Returns:
        x and y in the plane's frame, its origin where no place is in view; and how well it is
        seen there, as `share_seen` says.
    """
    places = _places(outline_m)
    seen = share_seen(places, height_m, camera, plane_T_camera, points_m)
    score = seen
    if not score.any():
        return (0.0, 0.0), 0.0
    free = _free(places, height_m, points_m, noise_m)
    if np.any(score[free] > 0.0):
        score = np.where(free, score, -np.inf)
    reach = np.linalg.norm(outline_m, axis=1).max()
    score = score - _FROM_MIDDLE * np.linalg.norm(places, axis=1) / reach
    best, worth = int(np.argmax(score)), -np.inf
    for k in _apart(places, score, _APART * height_m):
        share = unhidden(places[k])
        if share * score[k] > worth:
            best, worth, seen[k] = k, share * score[k], share * seen[k]
        if share > _IN_THE_OPEN:
            break
    x, y = places[best]
    return (float(x), float(y)), float(seen[best])


def _apart(places: FloatArray, score: FloatArray, apart_m: float) -> list[int]:
    """A few places in the order of their score, none near one that is better."""
    chosen: list[int] = []
    for k in np.argsort(-score, kind="stable"):
        away = np.linalg.norm(places[chosen] - places[k], axis=1)
        if score[k] > 0.0 and away.min(initial=np.inf) >= apart_m:
            chosen.append(int(k))
        if len(chosen) == _TRIED:
            break
    return chosen


def share_seen(
    places_m: FloatArray,
    height_m: float,
    camera: Camera,
    plane_T_camera: Motor,
    points_m: FloatArray,
) -> FloatArray:
    """How well ``(n,)`` a character on places ``(n, 2)`` is seen over the path: 1 in all frames.

    Arguments as of `best_place`.
    """
    poses, pinhole = _some(plane_T_camera).inverse(), camera.undistorted()
    ends = np.stack(
        [np.pad(places_m, ((0, 0), (0, 1)), constant_values=z) for z in (0.0, height_m)]
    )
    seen = poses.reshape(-1, 1, 1).apply(ends[None])
    ahead = np.all(seen[..., 2] > 0.25 * height_m, axis=1)
    pixels = pinhole.project(np.where(ahead[:, None, :, None], seen, [0.0, 0.0, 1.0]))
    inside = _inside(pixels, pinhole) & ahead[:, None]
    tall = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=-1)
    # From above a character is short, and as near as it is.
    wide = height_m * pinhole.fy / np.maximum(seen[:, 0, :, 2], 0.25 * height_m)
    share = np.maximum(tall, _FORESHORTENED * wide) / pinhole.height
    worth = np.minimum(share / _LARGE_ENOUGH, 1.0) * inside[:, 0]
    worth = np.where(inside[:, 1], worth, _HEADLESS * worth)
    near = poses.reshape(-1, 1).apply(points_m[None, :: 1 + len(points_m) // _HIDING])
    for k, points in enumerate(near):
        points = points[points[:, 2] > 0.0]
        worth[k] *= _unhidden(pinhole.project(points), points[:, 2], pixels[k], seen[k, ..., 2])
    return np.asarray(worth.mean(axis=0))


def tall_at(place: tuple[float, float], camera: Camera, plane_T_camera: Motor) -> float:
    """The height of a character that reaches over a fifth of the image, upwards or aside.

    From above it looks short: there it is taller, but by no more than twice.
    """
    camera_T_plane = _some(plane_T_camera).inverse()
    feet, up = camera_T_plane.apply([*place, 0.0]), camera_T_plane.rotor.apply([0.0, 0.0, 1.0])
    feet, up = feet[feet[:, 2] > 0.0], up[feet[:, 2] > 0.0]
    if not len(feet):
        return 0.0
    # How the image of one with its height grows, in images, if it were as far as its feet.
    size = np.array([camera.width / camera.fx, camera.height / camera.fy])
    reach = np.abs(up[:, :2] - up[:, 2:] * feet[:, :2] / feet[:, 2:]) / size
    reach = np.maximum(reach.max(axis=1), _FORESHORTENED / size.min())
    return float(_LARGE_ENOUGH * np.median(feet[:, 2] / reach))


def _some(plane_T_camera: Motor) -> Motor:
    """A few poses, evenly over the path."""
    last = len(plane_T_camera) - 1
    return plane_T_camera[np.unique(np.linspace(0, last, _CAMERAS).round().astype(int))]


def _unhidden(
    px: FloatArray, depth_m: FloatArray, ends_px: FloatArray, ends_m: FloatArray
) -> FloatArray:
    """1 for each place ``(n,)`` that hardly any point is before, less where things hide it.

    Pixels ``(p, 2)`` and depths ``(p,)`` are of points ahead, ``(2, n, 2)`` and ``(2, n)`` of feet
    and heads.
    """
    low, high = ends_px.min(axis=0), ends_px.max(axis=0)
    aside = _HALF_WIDE * (high[:, 1] - low[:, 1])
    nearer = depth_m[:, None] < _NEARER * ends_m.min(axis=0)
    nearer &= (px[:, 1, None] > low[:, 1]) & (px[:, 1, None] < high[:, 1])
    nearer &= np.abs(px[:, 0, None] - ends_px[0, :, 0]) < aside
    return np.where(np.count_nonzero(nearer, axis=0) > _STRAYS, _HEADLESS, 1.0)


def _places(outline_m: FloatArray) -> FloatArray:
    """A grid over the plane, the origin and what lies well within its outline."""
    low, high = outline_m.min(axis=0), outline_m.max(axis=0)
    grid = np.stack(np.meshgrid(*np.linspace(low, high, _STEPS).T), axis=-1).reshape(-1, 2)
    corner, along = _INSIDE * outline_m, np.roll(outline_m, -1, axis=0) - outline_m
    away = grid[:, None] - corner
    within = np.all(along[:, 0] * away[..., 1] - along[:, 1] * away[..., 0] >= 0.0, axis=1)
    return np.concatenate([np.zeros((1, 2)), grid[within]])


def _free(
    places: FloatArray, height_m: float, points_m: FloatArray, noise_m: float
) -> NDArray[np.bool_]:
    """Whether hardly a point stands up from the plane where the character would."""
    lowest = max(_STEP * height_m, 4.0 * noise_m)
    up = points_m[(points_m[:, 2] > lowest) & (points_m[:, 2] < height_m)]
    near = np.array(
        [np.count_nonzero(np.hypot(*(up[:, :2] - one).T) < _ROOM * height_m) for one in places]
    )
    return near <= _STRAYS


def _inside(pixels: FloatArray, camera: Camera) -> NDArray[np.bool_]:
    size = np.array([camera.width, camera.height])
    edge = _MARGIN * size
    return np.asarray(np.all((pixels > edge) & (pixels < size - edge), axis=-1))


MOST_CANDIDATES = 6
SURE = 0.9
"""What is less probable than this is doubted."""
_FRAMES_SEARCHED, _EVERY_PX, _FEWEST_POINTS = 5, 4, 50
_FRAMES_WITH_LINES = 8
# Surfaces reach farther than the points that were found on them: lines so far out are theirs.
_BEYOND = 2.0
# Of the scene's depth: how far a point of a map may lie off a plane, a character's greatest and
# least height where lengths have no unit.
_POINT_NOISE, _FREE_HEIGHT, _LEAST_FREE_HEIGHT = 0.01, 0.25, 0.05
# A plane in measured depth has the normals of its points behind it; below half, a plane is more
# likely none; a level is a guess.
_BELIEF_IN_DEPTH, _BELIEVED, _BELIEF_IN_LEVEL, _OFFERED = 0.9, 0.5, 0.3, 0.1
# One sees that a figure leans by more.
_VISIBLE_DEG = 5.0
# A doll is at most so many times as tall as one that is seen well.
_LARGEST_SHARE = 2.0
# A level reaches as far as the points at its height; as thick as this, in their noise.
_THICKNESS = 3.0


@dataclass(frozen=True, eq=False)
class SeenScene:
    """What of a recording tells what there is to stand on.

    Fields:
        recording: with the camera that was found.
        path: `world_T_camera` along which it is drawn.
        points: ``(p, 3)`` of depth or of the map, in the world.
        planes: among them, with normals towards the camera.
        beliefs: that each is a surface.
        unit: of lengths: "m" or "units".
        found_in: what the planes were found in, as words.
        depth_m: how far away the points are in the median.
        gravity: up and how it was measured, where it was.
        has_level: whether there is a map, at whose foot a level can lie.
        views: of the scene, where no depth was measured.
    """

    recording: Recording
    path: Trajectory
    points: FloatArray
    planes: tuple[Plane, ...] = ()
    beliefs: tuple[float, ...] = ()
    unit: str = "m"
    found_in: str = ""
    depth_m: float = 1.0
    gravity: tuple[FloatArray, str] | None = None
    has_level: bool = False
    views: SceneViews | None = None


def seen_scene(recording: Recording, camera_poses: CameraPoses, path: Trajectory) -> SeenScene:
    """The planes that the depth of a few frames shows, or else those among the map's points."""
    gravity, mapped = upward(recording, camera_poses, path), camera_poses.points
    has_level = camera_poses.origin == "slam" and len(mapped) > 0
    unit = "m" if camera_poses.metric else "units"
    scene = SeenScene(recording, path, mapped, unit=unit, gravity=gravity, has_level=has_level)
    for frame in _spread(recording, path, _FRAMES_SEARCHED):
        world_T_camera = path.motors_at(np.int64(frame.time_ns))
        planes, points = _seen_in_depth(recording.camera, frame)
        if planes:
            return replace(
                scene,
                points=world_T_camera.apply(points),
                planes=tuple(plane.transformed_by(world_T_camera) for plane in planes),
                beliefs=(_BELIEF_IN_DEPTH,) * len(planes),
                unit="m",
                found_in=f"the depth of {frame.name}",
                depth_m=float(np.median(points[:, 2])),
            )
    if len(mapped) < _FEWEST_POINTS:
        return scene
    first = path.motors[0]
    depth_m = _scene_depth(mapped, first)
    noise_m, rng = _POINT_NOISE * depth_m, np.random.default_rng(0)
    planes = find_planes(mapped, noise_m, rng, seen_from_m=first.translation_m).planes
    eyes = path.motors.translation_m[[0, len(path) // 2, -1]]
    beliefs = tuple(belief_in(plane, mapped, noise_m, eyes) for plane in planes)
    camera = recording.camera
    views = None if camera is None else scene_views(recording, path, camera.undistorted())
    return replace(
        scene, planes=planes, beliefs=beliefs, found_in="the map", depth_m=depth_m, views=views
    )


def weigh_up(scene: SeenScene) -> UpEstimate:
    """Up by gravity, or else by how the camera was held and moved, the surfaces, and lines."""
    return estimate_up(
        scene.path.motors,
        depth_m=scene.depth_m,
        surfaces=[
            FlatSurface(plane.normal, belief)
            for plane, belief in zip(scene.planes, scene.beliefs, strict=True)
            if belief >= _BELIEVED
        ],
        lines=None if scene.gravity is not None else _lines(scene),
        gravity_up=None if scene.gravity is None else scene.gravity[0],
    )


def grounds_in(scene: SeenScene, up: UpEstimate, *, planes_only: bool = False) -> list[Ground]:
    """Every surface as something to stand on, and a level at the foot of the map; best first."""
    pairs = zip(scene.planes, scene.beliefs, strict=True)
    grounds = [_on_plane(scene, *pair, up) for pair in pairs if pair[1] >= _OFFERED]
    if scene.has_level and not planes_only:
        grounds.append(_foot_ground(scene, up))
    waiting = sorted(grounds, key=lambda ground: -ground.rank)
    tried: list[Ground] = []
    while waiting and waiting[0].rank > max((ground.rank for ground in tried), default=-1.0):
        tried.append(_in_the_open(waiting.pop(0), scene))
    return sorted(tried + waiting, key=lambda ground: -ground.rank)[:MOST_CANDIDATES]


def _on_plane(scene: SeenScene, plane: Plane, belief: float, up: UpEstimate) -> Ground:
    wide, tall = plane.size_m
    size = f"a plane of {wide:.2f} x {tall:.2f} {scene.unit} found in {scene.found_in}"
    share = up.probability(plane.normal)
    height_m = min(0.5 * min(wide, tall), _highest(scene, plane.world_T_plane))
    doubts = []
    if share < SURE:
        wall = up.probability_across(plane.normal)
        other = ", or a wall" if wall > 0.5 * (1.0 - share) else ""
        doubts.append(f"that its normal is up is a guess ({100 * share:.0f} % sure){other}")
    if belief < _BELIEVED:
        doubts.append(f"it may be no surface ({100 * belief:.0f} % sure)")
    tilt_deg = np.rad2deg(np.arctan2(_POINT_NOISE * scene.depth_m, 0.5 * min(wide, tall)))
    if tilt_deg > _VISIBLE_DEG and belief != _BELIEF_IN_DEPTH:
        doubts.append(f"it is so narrow that it may be tilted by {tilt_deg:.0f} degrees")
    how = "up being its normal" if scene.gravity is None else scene.gravity[1]
    ground = Ground(
        plane.world_T_plane, (0.0, 0.0), height_m, f"{size}, {how}", doubt="; ".join(doubts)
    )
    return _fitted(ground, scene, plane.outline, min(wide, tall), share * belief, plane.rms_m)


def foot_ground(scene: SeenScene, up: UpEstimate, floor_m: float = 0.0) -> Ground:
    """A level at the foot of what was mapped, `floor_m` above it."""
    return _in_the_open(_foot_ground(scene, up, floor_m), scene)


def _foot_ground(scene: SeenScene, up: UpEstimate, floor_m: float = 0.0) -> Ground:
    direction, how = scene.gravity or (
        up.direction,
        "up being guessed from how the camera was held and moved, and from lines it saw",
    )
    doubt = "how high the ground lies is a guess"
    if scene.gravity is None:
        doubt = f"up is a guess ({100 * up.share:.0f} % sure), and {doubt}"
    eyes = scene.path.motors.translation_m @ direction
    foot = foot_level(scene.points, direction, float(np.median(eyes))) + floor_m
    noise_m = _POINT_NOISE * scene.depth_m
    near = scene.points[np.abs(scene.points @ direction - foot) < _THICKNESS * noise_m]
    middle = near.mean(axis=0) if len(near) else np.zeros(3)
    plane = Motor.from_rotor_translation(
        _turned_up(direction), middle + (foot - middle @ direction) * direction
    )
    outline = plane.inverse().apply(near)[:, :2]
    farthest_m = FARTHEST_M if scene.unit == "m" else scene.depth_m
    position = where_it_looks(plane.inverse() @ scene.path.motors[0], farthest_m)
    name = f"a level at the foot of the map, {how}"
    ground = Ground(plane, position, _highest(scene, plane), name, doubt=doubt)
    if np.linalg.matrix_rank(outline, tol=1e-9) < 2:
        return ground
    from scipy.spatial import ConvexHull

    outline = outline[ConvexHull(outline).vertices]
    return _fitted(ground, scene, outline, np.inf, up.share * _BELIEF_IN_LEVEL, noise_m)


def _fitted(
    ground: Ground,
    scene: SeenScene,
    outline: FloatArray,
    room_m: float,
    share: float,
    noise_m: float,
) -> Ground:
    """The ground with the place on it that is seen best, and a height that one sees.

    Where lengths have no unit, a character is no speck as long as there is room for it.
    """
    camera = scene.recording.camera
    if camera is None:
        return ground
    plane_T_world = ground.world_T_plane.inverse()
    seen_from, points = plane_T_world @ scene.path.motors, plane_T_world.apply(scene.points)
    height_m, place, seen = ground.height_m, ground.position_m, 0.0
    for attempt in range(2):
        place, seen = best_place(outline, height_m, camera, seen_from, points, noise_m)
        tall_m = tall_at(place, camera, seen_from)
        if attempt or height_m == FLOOR_HEIGHT_M:
            break
        if scene.unit == "m":  # a doll, which the room there is allows; not out of the image
            height_m = min(height_m, _LARGEST_SHARE * tall_m)
        else:
            height_m = max(height_m, min(room_m, tall_m))
    return replace(
        ground,
        position_m=place,
        height_m=height_m,
        outline_m=outline,
        rank=share * seen,
    )


def _in_the_open(ground: Ground, scene: SeenScene) -> Ground:
    """The ground with a place where the views show nothing before the figure, if there is one."""
    camera, outline, views = scene.recording.camera, ground.outline_m, scene.views
    if camera is None or outline is None or views is None or ground.rank == 0.0:
        return ground
    plane_T_world, height_m = ground.world_T_plane.inverse(), ground.height_m
    seen_from, points = plane_T_world @ scene.path.motors, plane_T_world.apply(scene.points)
    before = share_seen(np.array([ground.position_m]), height_m, camera, seen_from, points)[0]
    place, seen = best_place(
        outline,
        height_m,
        camera,
        seen_from,
        points,
        _POINT_NOISE * scene.depth_m,
        partial(share_unhidden, views, height_m=height_m, world_T_plane=ground.world_T_plane),
    )
    return replace(ground, position_m=place, rank=ground.rank * seen / float(before))


def _highest(scene: SeenScene, world_T_plane: Motor) -> float:
    """Greatest height of a character: a person's; without metres, by the scene and the camera."""
    if scene.unit == "m":
        return FLOOR_HEIGHT_M
    # Whoever holds a camera is about as tall as it is high above what they stand on.
    above = float(np.median((world_T_plane.inverse() @ scene.path.motors).translation_m[:, 2]))
    return min(_FREE_HEIGHT * scene.depth_m, max(above, _LEAST_FREE_HEIGHT * scene.depth_m))


def _lines(scene: SeenScene) -> FloatArray | None:
    """Rays to the ends of segments in a few frames; those on believed surfaces tell nothing."""
    recording, camera = scene.recording, scene.recording.camera
    if camera is None or isinstance(recording.frames, CornerFrames):
        return None
    line_rays = []
    for frame in _spread(recording, scene.path, _FRAMES_WITH_LINES):
        world_T_camera = scene.path.motors_at(np.int64(frame.time_ns))
        rays = segment_rays(frame.gray(), camera, world_T_camera)
        middle = rays.mean(axis=1)
        middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
        on = np.zeros(len(rays), dtype=bool)
        for plane, belief in zip(scene.planes, scene.beliefs, strict=True):
            meets = plane.met_by(world_T_camera.translation_m, middle)
            at = np.isfinite(meets).all(axis=-1)
            inwards = plane.centre_m + (meets[at] - plane.centre_m) / _BEYOND
            on[at] |= plane.holds(inwards) & (belief >= _BELIEVED)
        line_rays.append(rays[~on])
    return np.concatenate(line_rays) if line_rays else None


def _spread(recording: Recording, path: Trajectory, most: int) -> Iterator[Frame]:
    """Frames that have a pose, evenly over the recording."""
    stamps = recording.frames.time_ns
    posed = np.flatnonzero((stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1]))
    step = max(1, len(posed) // most)
    for index in posed[::step][:most]:
        yield recording.frames[int(index)]


def _seen_in_depth(camera: Camera | None, frame: Frame) -> tuple[tuple[Plane, ...], FloatArray]:
    """The planes in a frame's depth, and its points ``(p, 3)``, thinned, in the camera's frame."""
    nothing: tuple[tuple[Plane, ...], FloatArray] = (), np.zeros((0, 3))
    depth = None if camera is None or frame.read_depth is None else frame.depth_m()
    if camera is None or depth is None:
        return nothing
    try:
        surfaces = find_planes_in_depth(depth, camera, np.random.default_rng(0))
    except ValueError:  # hardly any depth in this frame: another may have more
        return nothing
    y, x = np.mgrid[: depth.shape[0] : _EVERY_PX, : depth.shape[1] : _EVERY_PX].reshape(2, -1)
    ahead = depth[y, x].astype(np.float64)
    known = np.isfinite(ahead) & (ahead > 0.0)
    rays = camera.unproject(np.stack([x[known], y[known]], axis=-1).astype(np.float64))
    return surfaces.planes, np.asarray(rays / rays[:, 2:] * ahead[known, None])


def _scene_depth(points: FloatArray, world_T_camera: Motor) -> float:
    """Median distance of the points before a camera along its axis."""
    ahead = world_T_camera.inverse().apply(points)[:, 2]
    return float(np.median(ahead[ahead > 0.0])) if np.any(ahead > 0.0) else 1.0


def _turned_up(up: FloatArray) -> Rotor:
    """A frame whose z is `up`."""
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    return axes_along(x, np.cross(up, x))
