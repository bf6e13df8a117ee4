"""What can be put into a scene: the mannequin, and the files that lie beside the scene.

A browser names one of these; no other file is ever read for it.

Where on an anchor there is room for one more.

Ways drawn by hand: points so far apart that somebody can walk them.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from motorcade.animation import Character, mannequin
from motorcade.animation.authoring import Scene, SceneAnchor, ScenePart
from motorcade.animation.behaviour import gait_between
from motorcade.animation.ik import fitted_legs
from motorcade.animation.retarget import legs_of
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.replays.stages.view.acting import MANNEQUIN, character_named, rigid_clip
from motorcade.replays.studio.filmed import Filmed

log = logging.getLogger("motorcade.studio")

SUFFIXES = (".glb", ".gltf", ".vrm", ".dae", ".fbx", ".md5mesh")
MOST_FILES = 200
GROUND = "ground"


@dataclass(frozen=True, eq=False)
class Props:
    """Characters and props on offer."""

    folder: Path
    files: tuple[str, ...] = ()
    _names: dict[str, list[str]] = field(default_factory=dict)

    def listed(self) -> list[dict[str, str]]:
        """For the page: files with labels, the mannequin first; none that cannot be read."""
        props = [{"file": MANNEQUIN, "label": "Person", "kind": "character"}]
        for file in self.files:
            try:
                kind = self._kind(file)
            except (ValueError, OSError, RuntimeError, ImportError) as fault:
                log.warning("not on offer: %s", " ".join(str(fault).split()))
                continue
            props.append({"file": file, "label": Path(file).stem, "kind": kind})
        return props

    def clips(self, part: ScenePart) -> list[str]:
        """What an object can do: clips of its own, and those that the mannequin lends."""
        if part.kind == "group":
            return []
        if part.file not in self._names:
            who = self._character(part.file)
            own = [clip.name for clip in who.clips]
            lent = [clip.name for clip in mannequin().clips]
            both = [*own, *(name for name in lent if name not in own)]
            self._names[part.file] = both if part.kind == "character" else own
        return self._names[part.file]

    def require_offered(self, line: Mapping[str, Any], scene: Scene) -> None:
        """Refuse an edit that names a file which is neither on offer nor in the scene.

        Raises ValueError: it does.
        """
        value = line.get("object") if line.get("do") == "add" else line
        file = value.get("file") if isinstance(value, Mapping) else None
        known = {MANNEQUIN, *self.files, *(part.file for part in scene.parts.values())}
        if file is not None and (not isinstance(file, str) or file not in known):
            raise ValueError("file: expected one that is on offer")

    def entry(self, file: str, scene: Scene, filmed: Filmed, frame: int = 0) -> dict[str, Any]:
        """An object of a file as the scene's own, near the middle of the first anchor: where
        nothing stands, and in view at a frame if there is such a place.

        Raises ValueError: a file that is not on offer, or cannot be read.
        """
        self.require_offered({"file": file}, scene)
        kind = self._kind(file)
        who = self._character(file)
        label = "Person" if file == MANNEQUIN else Path(file).stem
        anchor = next(iter(scene.anchors))
        ground = filmed.ground(scene.anchors[anchor])
        own = scene.anchors[anchor] == filmed.first
        place = np.array([*(filmed.place_m if own else ground.position_m), 0.0])
        height_m = filmed.height_m if own else ground.height_m
        on = anchor, scene.anchors[anchor]
        place[:2] = free_place_m(scene, *on, place[:2], height_m, filmed, frame)
        plane_T_camera = ground.world_T_plane.inverse() @ filmed.world_T_camera[frame]
        towards = plane_T_camera.translation_m[:2] - place[:2]
        turn = np.degrees(np.arctan2(towards[1], towards[0]))
        entry = {
            "name": free_name(label, scene),
            "kind": kind,
            "file": file,
            "parent": anchor,
            "position_m": place.tolist(),
            "euler_deg": [0.0, 0.0, float(turn)],
        }
        tall = max(who.height_m, float(np.ptp(who.vertices, axis=0).max()))
        if kind == "character":
            entry["height_m"] = height_m
        elif not 0.02 * height_m < tall < 3.0 * height_m:
            entry["height_m"] = 0.4 * height_m * who.height_m / tall
        return entry

    def _kind(self, file: str) -> str:
        return "character" if len(self._character(file).skeleton) > 4 else "prop"

    def _character(self, file: str) -> Character:
        return character_named(file if file == MANNEQUIN else str((self.folder / file).absolute()))


def files_beside(folder: Path) -> tuple[str, ...]:
    """Names of files in a folder that may hold characters or props, in order."""
    if not folder.is_dir():
        return ()
    files = (one for one in folder.iterdir() if one.suffix.lower() in SUFFIXES and one.is_file())
    return tuple(sorted(one.name for one in files))[:MOST_FILES]


def free_name(label: str, scene: Scene) -> str:
    """A name that nothing has."""
    taken: Sequence[str] = [*scene.parents, *scene.anchors]
    if label not in taken:
        return label
    return next(f"{label} {k}" for k in range(2, len(taken) + 3) if f"{label} {k}" not in taken)


MOST_PLACES = 400
"""That are looked at; where all are taken, the one that is farthest from others is given."""


def free_place_m(
    scene: Scene,
    on: str,
    anchor: SceneAnchor,
    middle_m: ArrayLike,
    height_m: float,
    filmed: Filmed,
    frame: int,
    beside: str | None = None,
) -> FloatArray:
    """A place ``(2,)`` of an anchor's plane where nothing stands, near a middle.

    One that is in view at a frame comes first.

    Args:
        scene: that there is so far.
        on: the anchor's name in it, if it is there already.
        anchor: what it is.
        middle_m: ``(2,)`` the first choice.
        height_m: of who will stand there; as wide as that is the room.
        filmed: the footage.
        frame: on show.
        beside: an object that is not in its own way.

    Raises ValueError: an anchor that is not in this recording.
    """
    poses = filmed.world_T_anchor(anchor)
    world_T_plane = poses[min(frame, poses.shape[0] - 1)]
    places: FloatArray = np.asarray(middle_m) + 0.45 * height_m * _spiral(MOST_PLACES)
    apart = np.minimum(_apart(places, _taken_m(scene, on, beside)), 0.4 * height_m)
    seen = _in_view(places, height_m, world_T_plane, filmed, frame)
    place: FloatArray = places[np.lexsort((np.arange(MOST_PLACES), ~seen, -apart))[0]]
    return place


def _taken_m(scene: Scene, on: str, beside: str | None) -> FloatArray:
    """Where things stand on an anchor, ``(N, 2)`` in its plane: all along a walk and keyframes."""
    taken = [np.zeros((0, 2))]
    for name, parent in scene.parents.items():
        if parent == on and name != beside:
            part = scene.part(name)
            times = [0.0, *(one.time_s for one in part.keyframes)]
            poses = [scene.pose_at(name, one).as_motor_scale()[0].translation_m for one in times]
            taken.append(np.array(poses)[:, :2])
            if part.walk is not None:
                taken.append(np.asarray(part.walk.path_m, dtype=np.float64).reshape(-1, 2))
    return np.concatenate(taken)


def _spiral(count: int) -> FloatArray:
    """Places ``(count, 2)`` for one after another, so that none stands in another."""
    number = np.arange(count)
    spiral: FloatArray = np.sqrt(number)[:, None] * np.exp(2.4j * number)[:, None].view(np.float64)
    return spiral


def _apart(places: FloatArray, taken: FloatArray) -> FloatArray:
    """How far each place is from the nearest that is taken."""
    ways = np.linalg.norm(places[:, None] - taken[None], axis=-1)
    apart: FloatArray = ways.min(axis=1, initial=np.inf)
    return apart


def _in_view(
    places: FloatArray, height_m: float, world_T_plane: Similarity, filmed: Filmed, frame: int
) -> np.ndarray:
    """Whether one of a height that stands there is in the image from head to foot."""
    camera = filmed.camera
    world_T_camera: Motor = filmed.world_T_camera[frame]
    seen = np.ones(len(places), dtype=bool)
    for up_m in (0.0, height_m):
        points = world_T_plane.apply(np.insert(places, 2, up_m, axis=1))
        points = world_T_camera.inverse().apply(points)
        pixels = camera.project(points)
        inside = (pixels > 0.0) & (pixels < [camera.width - 1, camera.height - 1])
        seen &= inside.all(axis=-1) & (points[:, 2] > 0.0)
    return seen


GAITS = ("walk", "jog", "run")


def pace_at(character: Character, speed_m_s: float, scale: float) -> dict[str, Any]:
    """The fields of a walk at a speed: a gait, or the two between whose speeds it lies.

    Args:
        character: who walks; the mannequin's gaits fit it, or it has its own by these names.
        speed_m_s: in the world.
        scale: of the walker: a small one goes by the gait by which a tall one goes as many of its
            own heights a second.

    Raises ValueError: slower than a walk or faster than a run of its size, or a character without
    legs or gaits.
    """
    skeleton = character.skeleton
    legs = tuple(fitted_legs(legs_of(skeleton), character))
    speeds = {
        name: gait_between([rigid_clip(character, name)], skeleton, legs)[1] for name in GAITS
    }
    order = sorted(speeds, key=lambda name: speeds[name])
    own = speed_m_s / scale
    slowest, fastest = speeds[order[0]], speeds[order[-1]]
    if not 0.99 * slowest <= own <= 1.01 * fastest:
        low, high = scale * slowest, scale * fastest
        raise ValueError(f"Somebody of this size goes at {low:.3g} to {high:.3g} m/s.")
    own = min(max(own, slowest), fastest)
    above = next(k for k, name in enumerate(order) if own <= speeds[name])
    gaits = [order[0]] if above == 0 else order[above - 1 : above + 1]
    return {"gaits": gaits, "speed_m_s": own}


STEP, SHORTEST, BENT = 0.15, 0.5, 0.04
"""In heights of the walker: between points, of the whole way, and how far a point may be from the
line between its neighbours to be left out."""
MOST_POINTS = 100


def thinned(points_m: FloatArray, height_m: float) -> FloatArray:
    """A way ``(P, 2)`` through the points of a drawn line ``(N, 2)`` that matter.

    Raises ValueError: a line that is too short to be walked.

    >>> import numpy as np
    >>> from motorcade.replays.studio.props import thinned
    >>> line = np.column_stack([np.linspace(0.0, 3.0, 200), np.zeros(200)])
    >>> thinned(line, 1.0).round(6).tolist()
    [[0.0, 0.0], [3.0, 0.0]]
    """
    from skimage.measure import approximate_polygon

    kept = list(points_m[:1])
    for point in points_m[1:]:
        if np.linalg.norm(point - kept[-1]) >= STEP * height_m:
            kept.append(point)
    if len(kept) > 1:
        kept[-1] = points_m[-1]  # where the finger was lifted
    path = np.array(kept).reshape(-1, 2)
    if len(path) < 2 or np.ptp(path, axis=0).max() < SHORTEST * height_m:
        raise ValueError("Draw a longer way on the ground.")
    tolerance = BENT * height_m
    needed: FloatArray = approximate_polygon(path, tolerance)
    while len(needed) > MOST_POINTS:
        tolerance *= 2.0
        needed = approximate_polygon(path, tolerance)
    return needed
