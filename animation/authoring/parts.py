"""What an object of a scene is and does, its keyframes played, and what scenes hang on.

Times are seconds from the first frame of the recording in which the scene is set.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from motorcade.animation.authoring.poses import EulerObjectPose, VersorObjectPose
from motorcade.animation.clip import between
from motorcade.animation.easing import FADE_S
from motorcade.ga import Rotor, Similarity
from motorcade.ga.arrays import FloatArray, checked_floats, checked_number, checked_positive, frozen
from motorcade.ga.names import check_word

AnchorKind = Literal["auto", "board", "marker", "plane", "floor"]
PartKind = Literal["character", "prop", "group"]
Interpolation = Literal["motor", "quaternion", "euler"]
"""How keyframes are joined: along screws; turned by rotors and moved straight; angle by angle."""
ANCHORS, KINDS = get_args(AnchorKind), get_args(PartKind)
INTERPOLATIONS = get_args(Interpolation)
MASKS = ("whole", "upper", "left_arm", "right_arm", "head")
"""The joints that a layer may move: words for them and all that hang on them."""


@dataclass(frozen=True)
class SceneAnchor:
    """What tracking found and a scene hangs on: its frame lies in the plane, z out of it.

    Args:
        on: a board, a marker (which may move), a plane that is found, the floor, or whichever of
            board, plane and floor there is first.
        marker: id of the marker, with `on="marker"` alone.
        floor_m: height of the floor.

    Raises:
        ValueError: another word, or an id where there is no marker, or none where there is.

    >>> from motorcade.animation.authoring import SceneAnchor
    >>> SceneAnchor("marker", marker=7)
    SceneAnchor(on='marker', marker=7, floor_m=0.0)
    """

    on: AnchorKind = "auto"
    marker: int | None = None
    floor_m: float = 0.0

    def __post_init__(self) -> None:
        check_word(self.on, ANCHORS, "SceneAnchor.on")
        if (self.on == "marker") != (self.marker is not None):
            raise ValueError(
                f"SceneAnchor.marker: expected an id with on='marker' alone, got {self.marker}"
            )
        checked_number(self.floor_m, "SceneAnchor.floor_m")


@dataclass(frozen=True, eq=False)
class SceneLayer:
    """A clip over the others from one time to another.

    Args:
        clip: its name; a loop repeats, any other is played once and holds its last pose.
        joints: the word for those that it moves; see `MASKS`.
        weight: its share, 0 to 1.
        additive: whether it is added, as the difference to its own first pose.
        start_s, end_s: from when to when; None for ever.
        fade_s: how long its weight takes to rise from nothing and to fall again, within these.

    Raises:
        ValueError: an empty name, another word, a weight out of range, an end before its start, a
            time below 0 to fade in.
    """

    clip: str
    joints: str = "upper"
    weight: float = 1.0
    additive: bool = False
    start_s: float = 0.0
    end_s: float | None = None
    fade_s: float = FADE_S

    def __post_init__(self) -> None:
        if not self.clip:
            raise ValueError("SceneLayer.clip: expected a name, got an empty string")
        check_word(self.joints, MASKS, "SceneLayer.joints")
        if not 0.0 <= self.weight <= 1.0:
            raise ValueError(f"SceneLayer.weight: expected 0 to 1, got {self.weight}")
        _checked_span(self.start_s, self.end_s, "SceneLayer")
        if not 0.0 <= self.fade_s < np.inf:
            raise ValueError(f"SceneLayer.fade_s: expected 0 or more, got {self.fade_s}")


@dataclass(frozen=True, eq=False)
class SceneWalk:
    """A way on foot, from standing to standing.

    Args:
        path_m: ``(P, 2)`` points x, y in the plane of the parent, metres; where it stands first.
        start_s: when it sets out.
        speed_m_s: at the size of the character's file; None for the first gait's own.
        gaits: names of clips that it walks by, blended to the speed.

    Raises:
        ValueError: fewer than two points or neighbours at one place, a time below 0, a speed that
            is not positive, no gait.
    """

    path_m: FloatArray
    start_s: float = 0.0
    speed_m_s: float | None = None
    gaits: tuple[str, ...] = ("walk",)

    def __post_init__(self) -> None:
        path = checked_floats(self.path_m, "SceneWalk.path_m", (2,))
        if path.ndim != 2 or len(path) < 2:
            raise ValueError(f"SceneWalk.path_m: expected (P, 2), P >= 2, got {path.shape}")
        if float(np.linalg.norm(np.diff(path, axis=0), axis=1).min()) < 1e-6:
            raise ValueError("SceneWalk.path_m: expected neighbours apart, got two at one place")
        object.__setattr__(self, "path_m", frozen(path))
        if not self.start_s >= 0.0:
            raise ValueError(f"SceneWalk.start_s: expected 0 or more, got {self.start_s}")
        if self.speed_m_s is not None:
            checked_positive(self.speed_m_s, "SceneWalk.speed_m_s")
        if not self.gaits:
            raise ValueError("SceneWalk.gaits: expected one clip or more, got none")


@dataclass(frozen=True, eq=False)
class SceneKeyframe:
    """Where an object is in its parent at a time.

    Args:
        time_s: when.
        parent_T_object: batch shape ().
        angles_deg: intrinsic x-y'-z'' as they were written, where the turn was given so: what
            joins keyframes angle by angle goes by these.

    Raises:
        ValueError: a batch, or a time that is not finite.
    """

    time_s: float
    parent_T_object: Similarity
    angles_deg: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        checked_number(self.time_s, "SceneKeyframe.time_s")
        if self.parent_T_object.shape != ():
            raise ValueError(
                "SceneKeyframe.parent_T_object: expected one similarity, got a batch of shape "
                f"{self.parent_T_object.shape}"
            )


@dataclass(frozen=True, eq=False)
class JointKeyframe:
    """A pose: how some joints are turned in their parents at a time.

    A joint comes to its first pose out of what clips have it do, goes from one pose to the next
    along the geodesic, and after one that ends goes back to its clips.

    Args:
        time_s: when.
        rotors: by the names of joints, in place of what clips have them do.
        end_s: until when they are held so, but not beyond the next pose of theirs; None for ever.

    Raises:
        ValueError: no joints, an end that is not after the time.
    """

    time_s: float
    rotors: Mapping[str, Rotor]
    end_s: float | None = None

    def __post_init__(self) -> None:
        _checked_span(self.time_s, self.end_s, "JointKeyframe")
        if not self.rotors:
            raise ValueError("JointKeyframe.rotors: expected one joint or more, got none")
        object.__setattr__(self, "rotors", MappingProxyType(dict(self.rotors)))


@dataclass(frozen=True, eq=False)
class ScenePart:
    """What an object of a scene is and does.

    Args:
        kind: a character, a prop, or a group: a frame that others hang on.
        file: "mannequin", or a file's name as the scene gives it; "" for a group alone.
        height_m: as tall as it stands at scale 1; None for the metres of its file.
        clip: name of what it plays; None for "idle" of a character, and the rest of a prop.
        clip_start_s: when the clip begins.
        layers: clips over it.
        walk: its way, which then says where it is in its parent.
        keyframes: where it is at which times, rising; none for one that stays.
        interpolation: how they are joined.
        joint_keyframes: how joints are turned, rising.
        visible_s: from when to when it is seen; None for always.

    Raises:
        ValueError: what does not go together, times that do not rise; the message names the field.

    >>> from motorcade.animation.authoring import ScenePart
    >>> ScenePart("prop", "cup.glb").keyframes
    ()
    >>> ScenePart("group", "cup.glb")
    Traceback (most recent call last):
    ValueError: ScenePart.file: expected none for a group, got 'cup.glb'
    """

    kind: PartKind = "group"
    file: str = ""
    height_m: float | None = None
    clip: str | None = None
    clip_start_s: float = 0.0
    layers: tuple[SceneLayer, ...] = ()
    walk: SceneWalk | None = None
    keyframes: tuple[SceneKeyframe, ...] = ()
    interpolation: Interpolation = "motor"
    joint_keyframes: tuple[JointKeyframe, ...] = field(default_factory=tuple)
    visible_s: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_word(self.kind, KINDS, "ScenePart.kind")
        check_word(self.interpolation, INTERPOLATIONS, "ScenePart.interpolation")
        if (self.kind == "group") != (not self.file):
            expected = "none for a group" if self.kind == "group" else "the name of a file"
            raise ValueError(f"ScenePart.file: expected {expected}, got {self.file!r}")
        if self.height_m is not None:
            checked_positive(self.height_m, "ScenePart.height_m")
        checked_number(self.clip_start_s, "ScenePart.clip_start_s")
        self._check_kind()
        for name in ("keyframes", "joint_keyframes"):
            times = np.array([one.time_s for one in getattr(self, name)])
            if np.any(np.diff(times) <= 0.0):
                raise ValueError(f"ScenePart.{name}: expected times that rise, got {times}")
        if self.visible_s is not None:
            _checked_span(*self.visible_s, "ScenePart.visible_s")

    def _check_kind(self) -> None:
        """Refuse what only some kinds have."""
        for name in ("height_m", "clip", "joint_keyframes", "visible_s"):
            if self.kind == "group" and getattr(self, name):
                raise ValueError(f"ScenePart.{name}: expected none for a group")
        for name in ("walk", "layers"):
            if self.kind != "character" and getattr(self, name):
                raise ValueError(f"ScenePart.{name}: expected none for a {self.kind}")
        if self.walk is not None and self.keyframes:
            raise ValueError("ScenePart.keyframes: expected none beside a walk, which says where")

    @property
    def keyframe_count(self) -> int:
        """Of poses and of joints."""
        return len(self.keyframes) + len(self.joint_keyframes)

    def angles_at(self, number: int) -> FloatArray:
        """``(3,)`` rad of a keyframe, as written or as its turn has them."""
        keyframe = self.keyframes[number]
        if keyframe.angles_deg is not None:
            return np.asarray(np.radians(keyframe.angles_deg), dtype=np.float64)
        return keyframe.parent_T_object.rotor.as_euler()


def _checked_span(start_s: float, end_s: float | None, where: str) -> None:
    checked_number(start_s, f"{where}: start")
    if end_s is not None and not checked_number(end_s, f"{where}: end") > start_s:
        raise ValueError(f"{where}: expected an end after {start_s:g} s, got {end_s:g} s")


def between_keyframes(
    part: ScenePart, time_s: FloatArray, interpolation: Interpolation | None = None
) -> Similarity:
    """`parent_T_object` ``(T,)`` of a part with keyframes, at times ``(T,)``.

    Before the first keyframe it is as there, after the last as there. "motor" follows the screw
    from one to the next, or the spiral where the scale changes; "quaternion" turns along the
    geodesic, moves straight and grows evenly in the logarithm; "euler" joins angles (those that
    were written, else those of the turn), position and scale each straight, as editors on Euler
    angles do: near ±90° of the middle angle it spins.

    Args:
        part: with one keyframe or more.
        time_s: seconds from the first frame.
        interpolation: in place of the part's own.

    Raises:
        ValueError: a part without keyframes.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import ScenePart, between_keyframes
    >>> from motorcade.animation.authoring.parts import SceneKeyframe
    >>> from motorcade.ga import Motor, Similarity
    >>> low, high = (
    ...     Similarity.from_motor_scale(Motor.from_translation([0.0, 0.0, z])) for z in (0.0, 1.0)
    ... )
    >>> keys = (SceneKeyframe(0.0, low), SceneKeyframe(2.0, high))
    >>> ball = ScenePart("prop", "ball.glb", keyframes=keys)
    >>> between_keyframes(ball, np.array([-1.0, 0.5, 9.0])).translation_m[:, 2]
    array([0.  , 0.25, 1.  ])
    """
    keys = part.keyframes
    if not keys:
        raise ValueError("between_keyframes(part): expected one keyframe or more, got none")
    clock = checked_floats(time_s, "between_keyframes(time_s)", ())
    at = np.array([one.time_s for one in keys])
    coefficients = np.empty((len(clock), 12))
    before, after, share = between(at, clock)
    how = interpolation or part.interpolation
    for first, last in np.unique(np.stack([before, after]), axis=1).T:
        rows = np.flatnonzero(before == first)
        coefficients[rows] = _joined(part, int(first), int(last), share[rows], how).coefficients
    return Similarity.normalize(coefficients)


def _joined(
    part: ScenePart, first: int, last: int, share: FloatArray, interpolation: Interpolation
) -> Similarity:
    """The poses ``(T,)`` at shares ``(T,)`` of the way from one keyframe to the next."""
    a, b = (part.keyframes[k].parent_T_object for k in (first, last))
    if interpolation == "motor":
        return a.reshape(1).interpolate(b.reshape(1), share)
    if interpolation == "quaternion":
        return VersorObjectPose(a).towards(VersorObjectPose(b), share)
    ends = [
        EulerObjectPose(part.angles_at(k), end.translation_m, float(end.scale))
        for k, end in ((first, a), (last, b))
    ]
    return ends[0].towards(ends[1], share)


FEWEST = 2


@dataclass(frozen=True)
class InterpolationFigures:
    """How an object goes through its keyframes.

    Fields:
        turned_over_geodesic: how far it turns in all, over the least that the keyframes need.
        peak_rad_s, mean_rad_s: its fastest and its mean rate of rotation.
        off_screw_m, off_screw_rad: how far it is from the motors' path at the same time, at most.
    """

    turned_over_geodesic: float
    peak_rad_s: float
    mean_rad_s: float
    off_screw_m: float
    off_screw_rad: float


def compare_interpolations(
    part: ScenePart, samples: int = 1000
) -> dict[Interpolation, InterpolationFigures]:
    """The same keyframes joined in each way, in figures.

    Args:
        part: with two keyframes or more.
        samples: steps from one keyframe to the next.

    Raises:
        ValueError: fewer than two keyframes, or fewer than one step.

    >>> import numpy as np
    >>> from motorcade.animation.authoring import compare_interpolations, scene_of
    >>> keys = [
    ...     {"time_s": 0, "euler_deg": [0, 89.9, 0]}, {"time_s": 1, "euler_deg": [170, 89.9, 170]}
    ... ]
    >>> thing = {"name": "a", "kind": "prop", "file": "a.glb", "keyframes": keys}
    >>> found = compare_interpolations(scene_of({"objects": [thing]}, "scene").part("a"))
    >>> [round(found[way].turned_over_geodesic, 1) for way in ("motor", "quaternion", "euler")]
    [1.0, 1.0, 17.0]
    """
    keys = part.keyframes
    if len(keys) < FEWEST or samples < 1:
        raise ValueError(
            f"compare_interpolations: expected {FEWEST} keyframes and a step or more, got "
            f"{len(keys)} and {samples}"
        )
    at = np.array([one.time_s for one in keys])
    ends = pairwise(at)
    steps = [np.linspace(a, b, samples, endpoint=False) for a, b in ends]
    time_s = np.append(np.concatenate(steps), at[-1])
    screw = between_keyframes(part, time_s, "motor")
    least = float(np.sum(_turns(Rotor.stack([one.parent_T_object.rotor for one in keys]))))
    figures: dict[Interpolation, InterpolationFigures] = {}
    for way in INTERPOLATIONS:
        poses = between_keyframes(part, time_s, way)
        turns = _turns(poses.rotor)
        rates = turns / np.diff(time_s)
        off_m = np.linalg.norm(poses.translation_m - screw.translation_m, axis=-1)
        off_rad = (screw.rotor.inverse() @ poses.rotor).angle()
        figures[way] = InterpolationFigures(
            float(np.sum(turns)) / least if least > 0.0 else 1.0,
            float(rates.max()),
            float(np.sum(turns) / (at[-1] - at[0])),
            float(off_m.max()),
            float(np.max(np.minimum(off_rad, 2.0 * np.pi - off_rad))),
        )
    return figures


def _turns(rotors: Rotor) -> FloatArray:
    """Angles from one rotor to the next."""
    angle = (rotors[:-1].inverse() @ rotors[1:]).angle()
    return np.asarray(np.minimum(angle, 2.0 * np.pi - angle))
