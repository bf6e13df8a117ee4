"""Stage `overlay`: the character in the footage, as H.264 video, and what that shows of it."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from motorcade.animation import Character
from motorcade.animation.ik.feet import segments
from motorcade.animation.retarget import body_of, facing_rad, legs_of
from motorcade.animation.vectors import wrapped
from motorcade.fusion.smoothing.view import steady_view, turned_homography
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.lookahead import ahead
from motorcade.ga.names import nearest_name
from motorcade.ga.progress import track
from motorcade.render import (
    Performer,
    RendererName,
    RenderUnavailable,
    render_performers,
    write_video,
)
from motorcade.render.composite import Matching, stored_ends
from motorcade.render.figures import FigureSeen
from motorcade.render.lens import LensWarp, warped
from motorcade.render.light import (
    ExposureMeter,
    Prints,
    lighting_of_footage,
    lighting_without_depth,
)
from motorcade.render.light.monocular import ground_of_footage
from motorcade.render.scene import ImageArray, Lighting
from motorcade.render.shots import StampedFrame
from motorcade.render.video import OriginalVideo, read_original
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.engine.stage import Unavailable
from motorcade.replays.io.readers.frames.corners import CornerFrames
from motorcade.replays.io.readers.frames.video import VideoFrames
from motorcade.replays.io.recording import Frame, FrameSequence, Recording
from motorcade.replays.stages.camera.offered import as_found
from motorcade.replays.stages.values.camera_poses import CameraPoses, MarkerPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.paths import SmoothedPaths
from motorcade.replays.stages.values.view import FigureCheck, OverlayVideo, PlacedCharacter
from motorcade.replays.stages.view.acting import performers
from motorcade.replays.stages.view.ground import prints_of
from motorcade.replays.stages.view.views import scene_views
from motorcade.tracking.masks import refine_mask
from motorcade.tracking.rolling import as_read

# Frames, spread over the recording, from which light is estimated.
LIT_FRAMES = 16
# Corners of the space that a character takes, in its heights.
_AROUND = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (0.0, 1.0)])
# A path is extrapolated so far beyond its ends, where poses were measured.
EXTRAPOLATED_S = 0.1


def overlay(
    recording: Recording,
    camera_poses: CameraPoses,
    smoothed: SmoothedPaths,
    integrity: Integrity,
    placed: PlacedCharacter,
    marker_poses: MarkerPoses | None = None,
    *,
    representation: str | None = None,
    renderer: RendererName = "fast",
    light: Literal["fixed", "estimated"] = "estimated",
    lens: Literal["distort", "undistort"] = "distort",
    view: Literal["footage", "steady", "live"] = "footage",
    gain: float = 1.0,
    exposure_s: float = 0.0,
    noise: float | None = None,
) -> OverlayVideo:
    """Draw the placed character into every frame that has a pose.

    `representation` says along which of the smoothed paths; without it, what `integrity` chose.
    `renderer` draws: "fast", or "pyrender" (docs/rendering.md says when to take which).
    `light=estimated` takes sun and ambient light from frames with depth; without depth it takes
    brightness and colour from board or markers, else from the images' mean, and the direction
    from shadows, faces and shading where they tell it; what is drawn follows the exposure.
    The footage stays as it was taken, and what is drawn is distorted as the lens does;
    `lens=undistort` undistorts the footage instead.
    `view=steady` turns each image, footage and all, so that the figure moves evenly in it, and
    `view=live` does so by the past alone: what is drawn shakes less and slides no more (the footage
    is then undistorted, and its edge repeated where the image reaches beyond it).
    `gain` brightens what is drawn, `exposure_s` blurs it by the motion in that time, `noise` (of
    255; none: each frame's own) grains it. In footage without colour the character has none.
    The path is extrapolated to measured poses within 0.1 s of its ends, as fusion may end before
    them; frames without a pose are shown as they are. Where the recording has depth, what is nearer
    hides the character; where it has none, the board, markers and the ground do, and what other
    images show nearer; masks of who walks in front hide it in any. Raises `Unavailable` without
    OpenGL and for recordings of corners, and ValueError without a camera or for a representation
    that was not smoothed.
    """
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    if isinstance(recording.frames, CornerFrames):
        raise Unavailable("the recording holds corners of markers and no images to draw into")
    path = extrapolated(
        _chosen(smoothed, integrity, representation), camera_poses.measurements.trajectory
    )
    lasting_s = 1e-9 * float(np.ptp(recording.frames.time_ns))
    shown = performers(placed, lasting_s)
    character = shown[0].character
    middle_m = placed.placement.apply([0.0, 0.0, 0.5 * character.height_m])
    if recording.readout_s and placed.ground_motion is None:
        around = placed.placement.apply(character.height_m * _AROUND)
        path = as_read(path, recording.camera, around, recording.shutter_s)
    start = time.perf_counter()
    recording = as_found(recording, camera_poses.camera, camera_poses.depth_camera)
    distorted = lens == "distort" and view == "footage"
    footage = _Footage(recording, distorted)
    lighting, lit_by, meter, ends = None, "a fixed light", None, (0, 255)
    marker_map = None if marker_poses is None else marker_poses.marker_map
    prints = prints_of(recording, camera_poses, marker_map)
    if light == "estimated":
        lighting, lit_by, meter, ends = _estimated(footage, path, placed, character, prints)
    views = None
    if placed.ground_motion is None:
        views = scene_views(recording, path, LensWarp(footage.camera).pinhole)
    if view != "footage":
        path = footage.turned(path, steady_view(path, middle_m, live=view == "live"))
    visibility: list[tuple[FigureSeen, ...] | None] = []
    images = render_performers(
        footage.frames(track(recording.frames, "drawing", len(recording.frames))),
        footage.camera,
        path,
        shown,
        lighting=lighting,
        matching=Matching(gain, exposure_s, noise, ends),
        prints=prints
        if all(one.ground_motion is None for one in shown)
        else None,  # where things move, a map may not hold
        meter=meter,
        views=views,
        renderer=renderer,
        visibility=visibility,
    )
    file, frames = new_file("overlay.mp4"), recording.frames
    try:
        write_video(file, footage.counted(images), frames.time_ns, _original(frames))
    except RenderUnavailable as missing:
        raise Unavailable(str(missing)) from missing
    return OverlayVideo(
        file,
        footage.drawn_into,
        len(recording.frames),
        placed.stands_on,
        lit_by,
        "original" if distorted else "undistorted" if view == "footage" else "steadied",
        integrity.drawn_is if representation is None else "smoothed",
        _checks(placed, shown, visibility, frames.time_ns),
        footage.camera.height,
        time.perf_counter() - start,
    )


def _checks(
    placed: PlacedCharacter,
    shown: list[Performer],
    visibility: list[tuple[FigureSeen, ...] | None],
    time_ns: IntArray,
) -> tuple[FigureCheck, ...]:
    """What the film shows of each figure."""
    names = [part.name for part in placed.parts] or [Path(placed.character).stem]
    return tuple(
        check_figure(
            name,
            performer,
            [None if frame is None else frame[k] for frame in visibility],
            time_ns[: len(visibility)],
        )
        for k, (name, performer) in enumerate(zip(names, shown, strict=True))
    )


def _original(frames: FrameSequence) -> OriginalVideo | None:
    """The video that the frames come from, where they do."""
    frames = getattr(frames, "taken", frames)  # of a lens that zooms
    if not isinstance(frames, VideoFrames):
        return None
    return replace(read_original(frames.path), until_ns=frames.followed_ns)


def _estimated(
    footage: _Footage,
    path: Trajectory,
    placed: PlacedCharacter,
    character: Character,
    prints: Prints | None,
) -> tuple[Lighting, str, ExposureMeter | None, tuple[int, int]]:
    """The light of a few undistorted frames, spread over the recording, how it was found, what
    follows the exposure, and the bytes between which the camera stores.
    """
    frames = footage.recording.frames
    some = np.unique(np.linspace(0, len(frames) - 1, LIT_FRAMES).round())
    straight = _Footage(footage.recording, distorted=False)
    seen = [frame[:3] for frame in straight.frames(frames[int(k)].still() for k in some)]
    camera, stand = straight.camera, placed.placement
    ground = None
    if placed.ground_motion is None:  # else it is at one place in one image only
        ground = ground_of_footage(seen, camera, path, stand, prints)
    meter = None if ground is None else ExposureMeter(ground)
    height_m = stand.scale * character.height_m
    light = lighting_of_footage(seen, camera, path, stand, height_m)
    if light is None:
        light = lighting_without_depth(seen, camera, path, stand, height_m, prints, ground)
    return *light, meter, stored_ends([image for _, image, _ in seen])


class _Footage:
    """The frames on their way to the renderer and back, and how many of them came back changed.

    Distorted footage is as the lens took it; other footage as a camera without distortion has it.
    """

    def __init__(self, recording: Recording, distorted: bool) -> None:
        assert recording.camera is not None  # checked by the stage
        self.recording, self._taken_by = recording, recording.camera
        self.camera = recording.camera if distorted else recording.camera.undistorted()
        self.drawn_into = 0
        self._distorted = distorted
        self._given: deque[ImageArray] = deque()
        self._turn: tuple[Trajectory, Trajectory] | None = None

    def turned(self, taken: Trajectory, shown: Trajectory) -> Trajectory:
        """Show the frames from now on in the attitudes of `shown`, which is given back."""
        self._turn = taken, shown
        return shown

    def frames(self, frames: Iterable[Frame]) -> Iterator[StampedFrame]:
        """Stamp, image, depth and mask of frames, and their focal length over the camera's."""
        for prepared in ahead(self._prepared, frames):
            self._given.append(prepared[1])
            yield prepared

    def _prepared(self, frame: Frame) -> StampedFrame:
        zoom = frame.zoom if self._distorted else 1.0
        frame = (frame.taken or frame) if self._distorted else frame
        image, depth_m, mask = frame.image(), frame.depth_m(), frame.mask()
        mask = None if mask is None else refine_mask(mask, image)
        if not self._distorted:
            image = self._taken_by.undistort_image(image)
            depth_m = None if depth_m is None else self._taken_by.undistort_depth(depth_m)
            mask = None if mask is None else self._taken_by.undistort_image(mask)
        if self._turn is not None:
            taken, shown = self._turn
            if taken.time_ns[0] <= frame.time_ns <= taken.time_ns[-1]:
                rotors = (one.motors_at(np.int64(frame.time_ns)).rotor for one in (taken, shown))
                turn = turned_homography(self.camera.matrix, *rotors)
                image = warped(image, turn)
                depth_m = None if depth_m is None else warped(depth_m, turn)
                mask = None if mask is None else warped(mask, turn)
        return StampedFrame(frame.time_ns, image, depth_m, mask, zoom)

    def counted(self, images: Iterable[ImageArray]) -> Iterator[ImageArray]:
        """The drawn frames as they are."""
        for image in images:
            undrawn = self._given.popleft()
            before = undrawn if undrawn.ndim == 3 else undrawn[..., None]
            self.drawn_into += bool(np.any(image != before))
            yield image


def extrapolated(path: Trajectory, measured: Trajectory) -> Trajectory:
    """The path to the measured poses just before its first and after its last, at even velocity.

    That something was measured there says that the camera saw; where it was then is better said by
    how the smoothed path goes on than by one noisy pose, and so nothing jumps.
    """
    stamps, poses = [path.time_ns], [path.motors]
    reach_ns = np.int64(1e9 * EXTRAPOLATED_S)
    for end, inwards in ((path.time_ns[0], 1), (path.time_ns[-1], -1)):
        beyond = inwards * (end - measured.time_ns)
        rows = np.flatnonzero((beyond > 0) & (beyond <= reach_ns))
        within_ns = min(reach_ns, path.time_ns[-1] - path.time_ns[0])
        if not len(rows) or within_ns == 0:
            continue
        last, before = path.motors_at(np.stack([end, end + inwards * within_ns]))
        twist = (before.inverse() @ last).as_twist()
        extended = last.reshape(1) @ Motor.from_twist(beyond[rows, None] / within_ns * twist)
        where = 0 if inwards > 0 else len(stamps)
        stamps.insert(where, measured.time_ns[rows])
        poses.insert(where, extended)
    return Trajectory(np.concatenate(stamps), Motor.concatenate(poses), path.parent, path.child)


def _chosen(
    smoothed: SmoothedPaths, integrity: Integrity, representation: str | None
) -> Trajectory:
    if representation is None:
        return integrity.drawn
    if representation not in smoothed.trajectories:
        known = ", ".join(smoothed.trajectories)
        near = nearest_name(representation, smoothed.trajectories)
        raise ValueError(
            f"overlay.representation: expected one of {known}, got {representation!r}{near}"
        )
    return smoothed.trajectories[representation]


# A foot is on the ground that is within this share of the height of how it rests.
TOUCHES = 0.003
# Whoever covers less than this share of its height in a second stands; the way is taken over this.
GOES, OVER_S = 0.3, 0.5
RATE_HZ = 60.0
# Ten minutes of one figure are enough to judge how it goes.
MOST = 36_000


def check_figure(
    name: str,
    performer: Performer,
    frames: Sequence[FigureSeen | None],
    time_ns: IntArray,
) -> FigureCheck:
    """What a film shows of a figure.

    Args:
        name: what it is called.
        performer: who does what.
        frames: of each frame what is seen of it; None without a pose.
        time_ns: ``(F,)`` stamps of these frames.
    """
    time_s = 1e-9 * (time_ns - time_ns[:1])
    there = np.array([performer.seen(float(second)) for second in time_s])
    rows = [
        (seen.visible_px, seen.drawn_px, seen.inside, seen.height_px, seen.bottom)
        if seen is not None and here
        else (np.nan,) * 5
        for seen, here in zip(frames, there, strict=True)
    ]
    visible, drawn, inside, height, bottom = np.array(rows).reshape(-1, 5).T
    slide, astray = _feet_and_way(performer, time_ns)
    return FigureCheck(name, visible, drawn, inside, height, bottom, astray, slide)


def _feet_and_way(performer: Performer, time_ns: IntArray) -> tuple[float, FloatArray]:
    """The worst slide of a foot in one contact, in heights, and how far it faces off its way.

    The second is ``(F,)`` radians; NaN where it stands, or nothing tells where it faces.
    """
    skeleton, clip = performer.character.skeleton, performer.clip
    nothing = np.full(len(time_ns), np.nan)
    if not len(time_ns):
        return 0.0, nothing
    lasts_s = 1e-9 * float(time_ns[-1] - time_ns[0])
    clock = np.arange(min(int(lasts_s * RATE_HZ) + 1, MOST)) / RATE_HZ
    body = body_of(skeleton)
    if "hips" not in body or len(clock) < 3:
        return 0.0, nothing
    world = Similarity.from_motor_scale(skeleton.world(clip.at(clock).rigid))
    if performer.motion is not None:
        stamps = time_ns[0] + np.rint(1e9 * clock).astype(np.int64)
        held = np.clip(stamps, performer.motion.time_ns[0], performer.motion.time_ns[-1])
        way = performer.motion.at(held)
        whole = way if isinstance(way, Similarity) else Similarity.from_motor_scale(way)
        world = whole.reshape(-1, 1) @ world
    at = world.translation_m / np.median(world.scale)
    tall = performer.character.height_m
    slide = 0.0
    for leg in legs_of(skeleton):
        ball = skeleton.index(leg.ball)
        low = at[:, ball, 2] <= skeleton.rest_world.translation_m[ball, 2] + TOUCHES * tall
        for start, end in segments(low):
            off = at[start:end, ball, :2] - np.median(at[start:end, ball, :2], axis=0)
            slide = max(slide, float(np.linalg.norm(off, axis=1).max()) / tall)
    facing = facing_rad(skeleton, at)
    if facing is None:
        return slide, nothing
    half = max(int(0.5 * OVER_S * RATE_HZ), 1)
    rows = np.arange(len(clock))
    first, last = np.maximum(rows - half, 0), np.minimum(rows + half, len(rows) - 1)
    step = at[last, body["hips"], :2] - at[first, body["hips"], :2]
    speed = np.linalg.norm(step, axis=1) / np.maximum(clock[last] - clock[first], 1e-9) / tall
    off_rad = np.abs(wrapped(np.arctan2(step[:, 1], step[:, 0]) - facing))
    off_rad = np.where(speed > GOES, off_rad, np.nan)
    nearest = np.rint(1e-9 * (time_ns - time_ns[0]) * RATE_HZ).astype(np.int64)
    return slide, off_rad[np.minimum(nearest, len(rows) - 1)]
