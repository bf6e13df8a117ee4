"""Stage `placed`: which character stands where: on a board, a marker, a plane or the floor."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from motorcade.animation import Clip, Placement, place_on_plane
from motorcade.animation.authoring import Scene, between_keyframes, read_scene
from motorcade.animation.authoring.parts import Interpolation
from motorcade.animation.behaviour import LookTarget
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray, IntArray, frozen
from motorcade.replays.io.readers.manifest.cast import NOBODY, Cast, read_cast
from motorcade.replays.io.readers.manifest.section import FILE_KNOBS
from motorcade.replays.io.recording import Recording
from motorcade.replays.stages.camera.offered import as_found
from motorcade.replays.stages.values.camera_poses import CameraPoses, MarkerPoses
from motorcade.replays.stages.values.errors import Integrity
from motorcade.replays.stages.values.view import PlacedCharacter, PlayedPart
from motorcade.replays.stages.view.acted import MOST_POSES, Acted, acted, things_of
from motorcade.replays.stages.view.acting import (
    MANNEQUIN,
    character_named,
    clip_named,
    path_of,
    played,
    standing_clip,
    walked,
)
from motorcade.replays.stages.view.anchored import GroundKind, Grounds
from motorcade.replays.stages.view.ground import Ground

log = logging.getLogger("motorcade.placed")

NOTHING = FILE_KNOBS["placed.scene"]
# What a cast says in place of knobs; those that are lists of numbers may be empty.
CAST_SAYS = ("character", "clip", "up", "front", "hide", "path", "position_m", "heading_deg")
SCENE_SAYS = (*CAST_SAYS, "height_m", "cast")
LISTS = ("path", "position_m", "hide")
# A clip that is raised or lowered by more of the height is named in the log.
TOLD_SHARE = 0.01
# Seen from so steeply above a figure lifts its head to the camera; from where hardly more than that
# is seen of it, the run says so.
LOOKS_UP_DEG, FROM_ABOVE_DEG = 45.0, 70.0
FROM_ABOVE = "it is seen from nearly straight above"


def placed(
    recording: Recording,
    camera_poses: CameraPoses,
    integrity: Integrity,
    marker_poses: MarkerPoses | None = None,
    *,
    character: Path = Path(MANNEQUIN),
    cast: Path = Path(NOBODY),
    scene: Path = Path(NOTHING),
    interpolation: Interpolation | None = None,
    clip: str | None = None,
    path: tuple[float, ...] = (),
    on: GroundKind = "auto",
    marker: int | None = None,
    floor_m: float = 0.0,
    floor: int = 0,
    position_m: tuple[float, ...] = (),
    heading_deg: float | None = None,
    up: str | None = None,
    front: str | None = None,
    hide: tuple[str, ...] = (),
    height_m: float | None = None,
) -> PlacedCharacter:
    """Stand the character on the board or markers, on a plane that was found, or on a floor.

    `character` is the mannequin or a file that holds one (glTF, Collada, MD5, FBX), `clip` one of
    its clips or of the mannequin's, which are retargeted: idle, walk, jog, run, wave, turn. With a
    `path` of points x,y,x,y,… in the plane's frame, metres, it walks along them at the clip's own
    speed with planted feet and stays at the end; the clip is then the walk unless another is named.
    (A board's frame begins at its top left corner as printed, a checkerboard's at its first inner
    one: y runs up, so points on the board have y < 0. A path that leaves it is named in the log.)
    `cast` is a TOML file of several characters that walk, turn, act, and keep apart
    (docs/manifests/every_cast_key.toml); it says in place of `character`, `clip`, `path`,
    `position_m` and `heading_deg` who does what where.
    `scene` is a scene file (docs/manifests/every_scene_key.json): characters and props with
    keyframes, clips, layers and walks on anchors of their own. It says all but `on`, `marker` and
    `floor_m`, which tell the ground of what hangs on no anchor. `interpolation` joins all of its
    keyframes by motors, quaternions or Euler angles, whatever they say, to compare.
    `on` "auto" takes the likeliest candidate: of the board or the marker seen most, where the poses
    come from it, the face if it lies and the top edge if it stands upright; else of the planes that
    are found in depth or among the points that SLAM mapped, and a level at the foot of these, the
    one that is most probably level, a surface, and seen well. `floor` takes another by its number
    in the report, from 1 on. "board" is its face however it stands, "plane" a plane alone, "floor"
    z = `floor_m`, in the world of SLAM a level `floor_m` above the foot of what was mapped.
    "marker" takes the marker with the id `marker`, which may move: it is looked for in every frame,
    and where it is not seen the character waits, and glides back once it is. Name it in
    `marker_poses.moving` where loose markers are mapped. `position_m` (x, y) lies
    in the plane's own frame; without it the character stands in the middle of the board or marker,
    on a plane where it is in view best and longest, or on the floor where the first camera looks.
    `up` and `front` are axes of the character's file, such as z and -y, where its own are wrong;
    `hide` names meshes of it that are not drawn, such as props held all at once.
    `heading_deg` turns from the plane's x towards its y; without it the character looks at the
    first camera, or up to where the camera usually is where that is steeply above. `height_m` is
    the character's; without it, half the shorter side of the board or plane, a marker's side, and
    at most 1.75 m, or 1.75 m on a floor; where lengths have no unit, as tall as the camera is high
    above the plane, at most a quarter of the scene's depth, and a fifth of the image at least
    where there is room.
    Raises ValueError for a board or plane that is asked for and not there.
    """
    if position_m and len(position_m) != 2:
        raise ValueError(f"placed.position_m: expected x,y, got {len(position_m)} numbers")
    axes = up, front, hide
    stated = (character != Path(MANNEQUIN), clip, *axes, path, position_m, heading_deg is not None)
    if str(cast) != NOBODY:
        _refuse_beside("cast", *map(bool, stated))
    if interpolation is not None and str(scene) == NOTHING:
        raise ValueError("placed.interpolation: expected none without placed.scene")
    if str(scene) != NOTHING:
        _refuse_beside("scene", *map(bool, stated), height_m is not None, str(cast) != NOBODY)
    recording = as_found(recording, camera_poses.camera, camera_poses.depth_camera)
    way = path_of(path) if path else None
    if (on == "marker") != (marker is not None):
        raise ValueError(f"placed.marker: expected an id with placed.on=marker, got {marker}")
    grounds = Grounds(recording, camera_poses, marker_poses, integrity.drawn)
    ground, ground_motion = grounds.asked(on, marker, floor_m, floor)
    choices = grounds.choices(on, floor_m)
    plane = ground.world_T_plane
    if str(scene) != NOTHING:
        read = read_scene(scene)
        folder = scene.absolute().parent
        return replace(
            _scene_on(BoundScene(read, folder, grounds, ground, interpolation)), choices=choices
        )
    if str(cast) != NOBODY:
        height = ground.height_m if height_m is None else height_m
        seen_from = integrity.drawn
        members = read_cast(cast)
        played_on = _cast_on(members, ground, ground_motion, height, seen_from, recording)
        return replace(played_on, choices=choices, doubt=ground.doubt)
    who, doubts, looks_at_m = character_named(str(character), *axes), [ground.doubt], None
    clip = clip or ("idle" if way is None else "walk")
    motion = clip_named(who, clip)
    if way is None:
        position = np.array(position_m or ground.position_m)
        away = (plane.inverse() @ integrity.drawn.motors).translation_m - np.append(position, 0.0)
        usual = np.median(away, axis=0)
        steep_deg = np.rad2deg(np.arctan2(usual[2], np.hypot(*usual[:2])))
        looks_up = steep_deg > LOOKS_UP_DEG and ground_motion is None and heading_deg is None
        heading = float(np.arctan2(*(usual if looks_up else away[0])[1::-1]))
        looks_at_m = plane.apply(usual + np.append(position, 0.0)) if looks_up else None
        doubts += [FROM_ABOVE] * bool(steep_deg > FROM_ABOVE_DEG)
    else:  # in the middle of its way, where shadow and light are made for
        if position_m:
            raise ValueError("placed.position_m: expected none beside placed.path, which says it")
        position = 0.5 * (way.points_m.min(axis=0) + way.points_m.max(axis=0))
        heading = 0.0
    if heading_deg is not None:
        heading = float(np.deg2rad(heading_deg))
    placement = place_on_plane(
        who,
        position,
        heading,
        height_m=ground.height_m if height_m is None else height_m,
        world_T_plane=plane,
    )
    inside = plane.inverse() @ placement.world_T_character
    points = np.zeros((0, 2)) if way is None else way.points_m
    if way is not None:  # refused here rather than when it is drawn
        walked(who, motion, points, placement.scale, inside)
        _warn_of_points_off(points, ground)
    else:
        _tell_of_raising(standing_clip(who, motion)[1] / who.height_m, clip)
    return PlacedCharacter(
        str(character),
        clip,
        placement,
        ground.name,
        frozen(points),
        inside,
        ground_motion,
        up=up,
        front=front,
        hide=hide,
        looks_at_m=looks_at_m,
        choices=choices,
        doubt="; ".join(filter(None, doubts)),
    )


def _tell_of_raising(share: float, clip: str) -> None:
    """Say in the log where an author's clip floats over the ground or is sunk, by more than 1 %."""
    if abs(share) > TOLD_SHARE:
        where, done = ("below", "raised") if share > 0.0 else ("over", "lowered")
        log.info(
            "'%s' stands %.1f %% of the height %s the ground in its file: %s by that",
            clip,
            100.0 * abs(share),
            where,
            done,
        )


def _refuse_beside(what: str, *stated: bool) -> None:
    """ValueError where a knob says what the cast or scene says already."""
    for name, is_stated in zip(CAST_SAYS if what == "cast" else SCENE_SAYS, stated, strict=True):
        if is_stated:
            raise ValueError(
                f"placed.{name}: expected none beside placed.{what}, which says it"
                + (f"; --set placed.{name}= takes away the manifest's" if name in LISTS else "")
            )


def _cast_on(
    cast: Cast,
    ground: Ground,
    ground_motion: Trajectory | None,
    height_m: float,
    seen_from: Trajectory,
    recording: Recording,
) -> PlacedCharacter:
    """Everybody of a cast on a ground; the first stands for all where one is asked for."""
    plane = ground.world_T_plane
    camera = _camera_on(plane, ground_motion, seen_from, int(recording.frames.time_ns[0]))
    parts, apart_m = played(cast, plane, height_m, camera, recording.duration_s)
    for member in cast.members:
        _warn_of_points_off(member.path_m, ground)
    first = parts[0]
    return PlacedCharacter(
        first.character,
        first.states[0].clip,
        first.placement,
        ground.name,
        plane_T_character=plane.inverse() @ first.placement.world_T_character,
        ground_motion=ground_motion,
        parts=parts,
        apart_m=apart_m if np.isfinite(apart_m) else None,
    )


def _scene_on(bound: BoundScene) -> PlacedCharacter:
    """All of a scene; its first character stands for all where one is asked for."""
    parts = bound.parts()
    first = parts[0]
    placement, inside = light_placement(first, character_named(first.character).height_m)
    stands_on = dict.fromkeys(bound.ground_of(part.name)[0].name for part in parts)
    return PlacedCharacter(
        first.character,
        first.name,
        placement,
        " and ".join(stands_on),
        plane_T_character=inside,
        ground_motion=first.ground_motion,
        parts=parts,
    )


def _camera_on(
    plane: Motor, ground_motion: Trajectory | None, seen_from: Trajectory, start_ns: int
) -> LookTarget:
    """Where the camera is on a plane, which may move, by seconds from the first frame on."""
    stamps = seen_from.time_ns
    now = plane
    if ground_motion is not None:
        known = np.clip(stamps, ground_motion.time_ns[0], ground_motion.time_ns[-1])
        now = ground_motion.motors_at(known) @ plane
    time_s = np.asarray(1e-9 * (stamps - start_ns), dtype=np.float64)
    return LookTarget(time_s, (now.inverse() @ seen_from.motors).translation_m)


def _warn_of_points_off(path_m: FloatArray, ground: Ground) -> None:
    """Warn of points ``(P, 2)`` of a path that lie beside the board or marker."""
    if ground.extent_m is None:
        return
    low, high = ground.extent_m
    slack = 1e-6 * (high - low)
    off = np.any((path_m < low - slack) | (path_m > high + slack), axis=-1)
    if np.any(off):
        first = path_m[int(np.argmax(off))]
        log.warning(
            "placed.path: %d of %d points lie off %s, the first at x, y = %g, %g m: it reaches "
            "from %g to %g m in x and from %g to %g m in y, which runs up as printed",
            np.count_nonzero(off),
            len(path_m),
            ground.name,
            *first,
            low[0],
            high[0],
            low[1],
            high[1],
        )


# Poses are told so often, and at every frame besides: what curves between is off by micrometres.
RATE_HZ = 120.0


@dataclass(frozen=True, eq=False)
class BoundScene:
    """A scene over the time of a recording.

    Args:
        scene: as it was read.
        folder: that its files are named from.
        grounds: what of the recording can be stood on.
        world: what takes the shadows of objects that hang on no anchor, where no anchor stays.
        interpolation: how all keyframes are joined, in place of what their objects say.

    Raises:
        ValueError: an anchor that is not there, a file, clip or joint that is not; by name.
    """

    scene: Scene
    folder: Path
    grounds: Grounds
    world: Ground
    interpolation: Interpolation | None = None
    _anchors: dict[str, tuple[Ground, Trajectory | None]] = field(default_factory=dict)
    _acted: dict[str, Acted] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, anchor in self.scene.anchors.items():
            try:
                ground, motion = self.grounds.asked(anchor.on, anchor.marker, anchor.floor_m)
            except ValueError as fault:
                raise ValueError(f"scene, anchor '{name}': {fault}") from fault
            self._anchors[name] = ground, motion
        lasts_s = 1e-9 * float(self._span_ns[1] - self._span_ns[0])
        poses = 0
        for name in things_of(self.scene):
            performed = acted(self.scene, name, self.folder, lasts_s)
            poses += performed.poses.coefficients.size // 8 + int(RATE_HZ * lasts_s)
            if poses > MOST_POSES:
                raise ValueError(
                    f"scene, '{name}': expected at most {MOST_POSES} poses of joints and objects "
                    f"up to here, got {poses}: fewer of them, or a shorter recording"
                )
            self._acted[name] = performed

    def parts(self) -> tuple[PlayedPart, ...]:
        """All characters and props; first the first character, or prop where there is none."""
        return tuple(map(self._part, self._acted))

    def ground_of(self, name: str) -> tuple[Ground, Trajectory | None]:
        """What an object's shadow falls on, and how that moves: its anchor's plane.

        Of one that hangs on none, the first anchor that does not move, or else the run's ground.
        """
        anchor = self.scene.anchor_of(name)
        if anchor is not None:
            return self._anchors[anchor]
        still = (ground for ground, motion in self._anchors.values() if motion is None)
        return next(still, self.world), None

    @property
    def _span_ns(self) -> tuple[int, int]:
        stamps = self.grounds.recording.frames.time_ns
        return int(stamps[0]), int(stamps[-1])

    def _part(self, name: str) -> PlayedPart:
        performed, part = self._acted[name], self.scene.part(name)
        ground, ground_motion = self.ground_of(name)
        return PlayedPart(
            name,
            performed.file,
            Placement(ground.world_T_plane, 1.0),
            performed.time_s,
            performed.poses,
            performed.states,
            worst_slide_m=performed.worst_slide_m,
            motion=self._motion(name, ground.world_T_plane),
            ground_motion=ground_motion,
            visible_s=part.visible_s,
        )

    def _motion(self, name: str, world_T_plane: Motor) -> Trajectory:
        """`plane_T_character` over the recording, its size included."""
        chain, above = [name], self.scene.parents[name]
        while above is not None and above not in self.scene.anchors:
            chain.append(above)
            above = self.scene.parents[above]
        stamps = self._stamps() if any(map(self._moves, chain)) else np.array(self._span_ns[:1])
        time_s = np.asarray(1e-9 * (stamps - self._span_ns[0]), dtype=np.float64)
        poses = Similarity.identity((len(stamps),))
        if above is None:
            poses = Similarity.from_motor_scale(world_T_plane.inverse()).reshape(1) @ poses
        for link in reversed(chain):
            poses = poses @ self._local(link, time_s)
        sized = Similarity.from_motor_scale(Motor.identity(), self._acted[name].size)
        plane_T_character = Similarity.normalize((poses @ sized).coefficients)
        return Trajectory(stamps, plane_T_character, "placement", "character")

    def _moves(self, name: str) -> bool:
        part = self.scene.part(name)
        return len(part.keyframes) > 1 or part.walk is not None

    def _local(self, name: str, time_s: FloatArray) -> Similarity:
        """`parent_T_object` ``(T,)``."""
        part, pose = self.scene.part(name), self.scene.pose(name).as_similarity()
        if part.keyframes:
            return between_keyframes(part, time_s, self.interpolation)
        performed = self._acted.get(name)
        if performed is not None and performed.parent_T_character is not None:
            way = Clip("way", performed.time_s, performed.parent_T_character.reshape(-1, 1))
            return Similarity.from_motor_scale(way.at(time_s).rigid[:, 0], pose.scale)
        return pose.reshape(1)[np.zeros(len(time_s), dtype=np.int64)]

    def _stamps(self) -> IntArray:
        """Of all frames, and evenly between."""
        first, last = self._span_ns
        count = int(np.ceil(1e-9 * (last - first) * RATE_HZ)) + 1
        even = np.linspace(first, last, count).round().astype(np.int64)
        return np.unique(np.concatenate([self.grounds.recording.frames.time_ns, even]))


def light_placement(first: PlayedPart, height_m: float) -> tuple[Placement, Motor]:
    """Where light is made for, and the same in the plane: upright, under one where it is at first.

    Args:
        first: of a scene.
        height_m: of its character, in its file's metres.

    Returns:
        its placement, as large as it is there, and where it stands in the plane's frame.
    """
    assert first.motion is not None  # every part of a scene has one
    pose = first.motion.poses[0]
    assert isinstance(pose, Similarity)
    x, y, _ = pose.apply([0.0, 0.0, 0.5 * height_m])
    inside = Motor.from_translation([x, y, 0.0])
    world = first.placement.world_T_character @ inside
    return replace(first.placement, world_T_character=world, scale=float(pose.scale)), inside
