"""A scene edited by several browsers at once: what they ask for, and what they are answered.

While a gesture goes on its object is shown where it is taken to, and nothing of it is in the scene;
at its end it becomes one step, which is on the disk before anybody is answered. So two browsers
drag two objects at once, and a process that is killed loses what is being dragged and nothing else.

Who holds what: an object is moved by one browser at a time, with all that hangs on it.

What a page gets of a scene: its objects, where each is over the footage, what it does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from motorcade.animation.authoring import (
    Drag,
    Dragged,
    Edit,
    Scene,
    SceneEditor,
    Snapping,
    gesture_of,
)
from motorcade.animation.authoring.fields import anchor_json, layer_json, part_json
from motorcade.animation.authoring.gestures import Together
from motorcade.animation.authoring.pointing import DragPlane, OutOfReach, Ray
from motorcade.ga import Similarity
from motorcade.replays.pipeline.packing import packed, scaled_rows
from motorcade.replays.stages.view.acted import Acted
from motorcade.replays.studio.dragging import Grab, LimbDrag, ObjectDrag, joints_held_by
from motorcade.replays.studio.filmed import Filmed, PlayedScene, spoken
from motorcade.replays.studio.messages import (
    Answer,
    frame_number,
    frame_of_axes,
    name_of,
    number_of,
    pixels_of,
    point_of,
)
from motorcade.replays.studio.props import GROUND, Props, free_name, free_place_m, pace_at, thinned
from motorcade.replays.studio.write_ahead import SceneHistory


@dataclass
class ObjectLocks:
    """Which objects the visitors of a scene have locked.

    >>> from motorcade.animation.authoring import Scene, VersorObjectPose
    >>> from motorcade.ga import Similarity
    >>> from motorcade.replays.studio.session import ObjectLocks
    >>> still = VersorObjectPose(Similarity.identity())
    >>> scene = Scene({"table": None, "cup": "table"}, {"table": still, "cup": still})
    >>> locks = ObjectLocks()
    >>> locks.take(1, "cup", scene)
    >>> locks.take(2, "table", scene)
    Traceback (most recent call last):
    ValueError: Somebody else is moving cup.
    """

    held: dict[int, str] = field(default_factory=dict)

    def take(self, visitor: int, name: str, scene: Scene) -> None:
        """Take hold of an object.

        Raises:
            ValueError: no such object, or another holds it, what it hangs on or what hangs on it.
        """
        self.require_free(visitor, name, scene)
        self.held[visitor] = name

    def require_free(self, visitor: int, name: str, scene: Scene) -> None:
        """Refuse what another visitor's gesture is about; raises as `take`."""
        scene.pose(name)
        for other, held in self.held.items():
            if other != visitor and (above(scene, name, held) or above(scene, held, name)):
                raise ValueError(f"Somebody else is moving {held}.")

    def require_all_free(self, visitor: int) -> None:
        """Refuse what concerns the whole scene while another visitor moves something.

        Raises ValueError: somebody does.
        """
        for other, held in self.held.items():
            if other != visitor:
                raise ValueError(f"Somebody else is moving {held}.")

    def let_go(self, visitor: int) -> None:
        """Hold nothing any more."""
        self.held.pop(visitor, None)


def above(scene: Scene, name: str, other: str) -> bool:
    """Whether an object is another, or hangs on it."""
    parents: Mapping[str, str | None] = scene.parents
    at: str | None = name
    while at is not None and at != other:
        at = parents.get(at)
    return at is not None


Message = Mapping[str, Any]
BEYOND = "There is nothing there to drag it over."
SNAPS = Snapping(angle_rad=float(np.radians(15.0)), distance_m=0.01, scale=0.1)


@dataclass
class EditingSession:
    """What visitors do to one scene."""

    filmed: Filmed
    history: SceneHistory
    played: PlayedScene
    props: Props
    view: SceneView
    _locks: ObjectLocks = field(default_factory=ObjectLocks)
    _drags: dict[int, ObjectDrag | LimbDrag] = field(default_factory=dict)
    _frames: dict[int, int] = field(default_factory=dict)
    _version: int = 0

    def joined(self, visitor: int) -> Message:
        """What a browser is told when it comes."""
        return {**self._scene(None), "version": self._version}

    def left(self, visitor: int) -> Message | None:
        """A browser is gone: what it held goes back to where it was."""
        return self._dropped(visitor)

    def answer(self, visitor: int, message: Message) -> Answer:
        """Do what a browser asks for; what is refused is said in a line, and changes nothing."""
        do = message.get("do")
        number = message.get("n")
        number = number if type(number) is int else None
        try:
            acts = self._acts()
            if not isinstance(do, str) or do not in acts:
                raise ValueError(f"do: expected one of {', '.join(acts)}")
            answer = acts[do](visitor, message)
        except OutOfReach:
            return Answer({"n": number, "ok": do == "drag", "said": BEYOND, "error": BEYOND})
        except (ValueError, OSError, RuntimeError, ImportError) as fault:
            reason = " ".join(str(fault).split())[:300]
            return Answer({"n": number, "ok": False, "error": reason})
        return Answer({"n": number, "ok": True, **answer.reply}, answer.news)

    def _acts(self) -> dict[str, Callable[[int, Message], Answer]]:
        return {
            "begin": self._begin,
            "drag": self._drag,
            "end": self._end,
            "cancel": self._cancel,
            "undo": lambda visitor, _: self._step(visitor, "undo"),
            "redo": lambda visitor, _: self._step(visitor, "redo"),
            "edit": self._edit,
            "place": self._place,
            "copy": self._copy,
            "hang": self._hang,
            "walk": self._walk,
            "numbers": self._numbers,
        }

    # Gestures

    def _begin(self, visitor: int, message: Message) -> Answer:
        name = name_of(message, "object")
        frame = frame_number(message, self.filmed.frames)
        scene = self.history.scene
        scene.pose(name)
        rays = self._rays(frame, message)
        if message.get("gesture") == "joint":
            return self._begin_joint(visitor, message, frame, rays)
        point = point_of(message, "point")
        axis = point_of(message, "axis")
        grab = Grab(
            name_of(message, "gesture"),
            rays,
            point,
            (0.0, 0.0, 1.0) if axis is None else (float(axis[0]), float(axis[1]), float(axis[2])),
            frame_of_axes(message),
        )
        drag = self._drags.get(visitor)
        if isinstance(drag, LimbDrag) or drag is None or drag.name != name:
            if drag is not None:
                raise ValueError("begin: expected what is held to be let go first")
            self._locks.take(visitor, name, scene)
            drag = ObjectDrag(
                scene,
                name,
                float(self.filmed.time_s[frame]),
                self.anchors(scene, frame),
                self.filmed.up,
                SNAPS if message.get("snap") is True else Snapping(),
            )
        try:
            drag.take(grab)
        except ValueError:
            if visitor not in self._drags:
                self._locks.let_go(visitor)
            raise
        return self._held(visitor, drag, frame)

    def _begin_joint(
        self, visitor: int, message: Message, frame: int, rays: tuple[Ray, ...]
    ) -> Answer:
        """Take a hand, a foot or the head: its limb follows, and the rest of the body stays."""
        self._require_idle(visitor)
        if len(rays) != 1:
            raise ValueError("pixels: expected those of one finger")
        name, scene = name_of(message, "object"), self.history.scene
        joint = None if message.get("joint") is None else name_of(message, "joint")
        drag = LimbDrag(self.played, scene, name, frame, rays[0], joint)
        self._locks.take(visitor, name, scene)
        return self._held(visitor, drag, frame)

    def _held(self, visitor: int, drag: ObjectDrag | LimbDrag, frame: int) -> Answer:
        self._drags[visitor] = drag
        self._frames[visitor] = frame
        return Answer({}, {"holds": sorted(self._locks.held.values())})

    def _drag(self, visitor: int, message: Message) -> Answer:
        drag, frame = self._drag_of(visitor), self._frames[visitor]
        amount = number_of(message, "amount") if "amount" in message else None
        rays = () if amount is not None else self._rays(frame, message)
        if isinstance(drag, LimbDrag):
            joints = {drag.name: packed(scaled_rows(drag.move(rays))[None])}
            return Answer({"joints": joints}, {"joints": joints})
        scene = drag.move(rays, amount)
        poses = self._poses(scene, drag)
        return Answer({"poses": poses, "said": drag.shown_amount()}, {"poses": poses})

    def _end(self, visitor: int, message: Message) -> Answer:
        drag = self._drag_of(visitor)
        news = self._dropped(visitor)
        gesture, before = drag.gesture(), self.history.scene
        if gesture is not None:
            self.history.do(gesture, {} if isinstance(drag, LimbDrag) else drag.anchors)
        if self.history.scene is before:
            return Answer(dict(news or {}), news)
        return self._changed(before)

    def _cancel(self, visitor: int, message: Message) -> Answer:
        news = self._dropped(visitor)
        return Answer(dict(news or {}), news)

    def _drag_of(self, visitor: int) -> ObjectDrag | LimbDrag:
        if visitor not in self._drags:
            raise ValueError("Nothing is held.")
        return self._drags[visitor]

    def _dropped(self, visitor: int) -> Message | None:
        """Let go without a change: everybody sees the object back where the scene has it."""
        drag = self._drags.pop(visitor, None)
        self._frames.pop(visitor, None)
        self._locks.let_go(visitor)
        if drag is None:
            return None
        names = self.history.scene.branch(drag.name)
        return {"free": names, "holds": sorted(self._locks.held.values())}

    # Edits

    def _step(self, visitor: int, way: Literal["undo", "redo"]) -> Answer:
        self._locks.require_all_free(visitor)
        self._require_idle(visitor)
        before = self.history.scene
        self.history.step(way)
        return self._changed(before)

    def _edit(self, visitor: int, message: Message) -> Answer:
        line = message.get("edit")
        if not isinstance(line, dict):
            raise ValueError("edit: expected an object of JSON")
        # Each of many is looked at as it would be alone.
        lines = line.get("gestures") if line.get("do") == "together" else [line]
        if (
            not isinstance(lines, list)
            or not lines
            or not all(isinstance(one, dict) for one in lines)
        ):
            raise ValueError("edit: gestures: expected a list of objects of JSON")
        return self._edited(visitor, message, *lines)

    def _edited(self, visitor: int, message: Message, *lines: Mapping[str, Any]) -> Answer:
        """Do edits and drags as one step, at the moment that the browser shows."""
        frame = frame_number(message, self.filmed.frames)
        self._require_idle(visitor)
        before = self.history.scene
        for line in lines:
            self._require_free(visitor, line)
            self.props.require_offered(line, before)
        steps = tuple(map(_edit_of, lines))
        gesture = steps[0] if len(steps) == 1 else Together(steps)
        trial = SceneEditor(before)
        trial.stand(self.anchors(before, frame, lines))
        after = trial.do(gesture)
        for name in after.parents:  # what cannot be shown is refused before it is kept
            if before.parts.get(name) is not after.parts.get(name):
                self.view.about(after, name, None)
        self.history.do(gesture, trial.world_T_anchor)
        return self._changed(before)

    def _require_idle(self, visitor: int) -> None:
        if visitor in self._drags:
            raise ValueError("Let go first.")

    def _require_free(self, visitor: int, line: Mapping[str, Any]) -> None:
        named = line.get("objects") if line.get("do") == "group" else [line.get("object")]
        for name in named if isinstance(named, list) else []:
            if isinstance(name, str) and name in self.history.scene.parents:
                self._locks.require_free(visitor, name, self.history.scene)

    def _place(self, visitor: int, message: Message) -> Answer:
        """Somebody or something new, in the middle of what there is to stand on."""
        scene, lines = self.history.scene, []
        if not scene.anchors:
            stand = anchor_json(self.filmed.first)
            lines.append({"do": "anchor", "name": free_name(GROUND, scene), **stand})
            scene = Edit(lines[0]).applied(scene)
        frame = frame_number(message, self.filmed.frames)
        entry = self.props.entry(name_of(message, "file"), scene, self.filmed, frame)
        answer = self._edited(visitor, message, *lines, {"do": "add", "object": entry})
        return Answer({**answer.reply, "object": entry["name"]}, answer.news)

    def _copy(self, visitor: int, message: Message) -> Answer:
        """The same again, beside it."""
        name, scene = name_of(message, "object"), self.history.scene
        scene.pose(name)
        new = free_name(name.rstrip(" 0123456789") or name, scene)
        frame = frame_number(message, self.filmed.frames)
        time_s = float(self.filmed.time_s[frame])
        # To the right in the image, on the ground that it stands on.
        world_T_parent = scene.world_T_parent(name, time_s, self.anchors(scene, frame))
        right = self.filmed.world_T_camera[frame].rotor.apply([1.0, 0.0, 0.0])
        axis = world_T_parent.rotor.inverse().apply(right) * [1.0, 1.0, 0.0]
        aside = 0.6 * self.filmed.height_m / float(world_T_parent.scale)
        drag = Drag(new, "translate", axis + np.array([1e-6, 0.0, 0.0]), "parent", time_s)
        shift = Dragged(drag, (aside,)).as_json()
        copy = {"do": "copy", "object": name, "name": new}
        answer = self._edited(visitor, message, copy, shift)
        return Answer({**answer.reply, "object": new}, answer.news)

    def _hang(self, visitor: int, message: Message) -> Answer:
        """On another parent: on what was tracked it is put, on an object it stays where it is."""
        name, scene = name_of(message, "object"), self.history.scene
        on = None if message.get("on") is None else name_of(message, "on")
        frame = frame_number(message, self.filmed.frames)
        lines: list[dict[str, Any]] = []
        anchor = None if on is None else scene.anchors.get(on, self.filmed.stands.get(on))
        if anchor is not None and on not in scene.anchors:
            lines.append({"do": "anchor", "name": on, **anchor_json(anchor)})
        time_s = float(self.filmed.time_s[frame])
        lines.append({"do": "reparent", "object": name, "parent": on, "time_s": time_s})
        if anchor is not None:
            ground, filmed = self.filmed.ground(anchor), self.filmed
            tall, middle_m = scene.part(name).height_m or ground.height_m, ground.position_m
            x, y = free_place_m(scene, str(on), anchor, middle_m, tall, filmed, frame, name)
            put = {"position_m": [x, y, 0.0], "euler_deg": [0.0, 0.0, 0.0], "time_s": time_s}
            lines.append({"do": "set", "object": name, **put})
        return self._edited(visitor, message, *lines)

    def _walk(self, visitor: int, message: Message) -> Answer:
        """A way drawn on the image, as points of the plane that the walker stands on.

        Without one, what is said of when it sets out and how fast it goes.
        """
        name = name_of(message, "object")
        if "pixels" not in message:
            return self._pace(visitor, message, name)
        frame = frame_number(message, self.filmed.frames)
        scene, time_s = self.history.scene, float(self.filmed.time_s[frame])
        plane = scene.world_T_parent(name, time_s, self.anchors(scene, frame))
        surface = DragPlane(plane.translation_m, plane.rotor.apply([0.0, 0.0, 1.0]))
        points = []
        for ray in self._rays(frame, message, most=1000):
            try:
                points.append(plane.inverse().apply(surface.met_by(ray))[:2])
            except OutOfReach:
                break  # the finger went over the horizon: the way ends before
        acted = self.played.acted(scene, name)[1]
        tall = acted.size * acted.character.height_m
        path = thinned(np.array(points).reshape(-1, 2), tall)
        walk = part_json(scene.part(name)).get("walk", {}) | {"path_m": path.tolist()}
        line = {"do": "set", "object": name, "keyframes": [], "walk": walk}
        return self._edited(visitor, message, line)

    def _pace(self, visitor: int, message: Message, name: str) -> Answer:
        """When a walker sets out and how fast it goes, by the gait that it has for that."""
        scene = self.history.scene
        part = scene.part(name)
        if part.walk is None:
            raise ValueError("object: expected one that walks")
        walk = part_json(part)["walk"]
        if "start_s" in message:
            walk["start_s"] = max(0.0, number_of(message, "start_s"))
        if "speed_m_s" in message:
            walker = self.played.acted(scene, name)[1]
            scale = walker.size * float(scene.pose(name).as_similarity().scale)
            walk |= pace_at(walker.character, number_of(message, "speed_m_s"), scale)
        return self._edited(visitor, message, {"do": "set", "object": name, "walk": walk})

    def _numbers(self, visitor: int, message: Message) -> Answer:
        """Where an object is in its parent at the moment on show, as numbers."""
        name = name_of(message, "object")
        time_s = float(self.filmed.time_s[frame_number(message, self.filmed.frames)])
        pose, scale = self.history.scene.pose_at(name, time_s).as_motor_scale()
        numbers = {"position_m": pose.translation_m.tolist(), "scale": float(scale)}
        euler_deg = np.degrees(pose.rotor.as_euler()).tolist()
        return Answer({"numbers": {**numbers, "euler_deg": euler_deg}})

    # What browsers are told

    def _changed(self, before: Scene) -> Answer:
        self._version += 1
        changes = {**self._scene(before), "version": self._version}
        return Answer(changes, changes)

    def _scene(self, before: Scene | None) -> dict[str, Any]:
        """The scene as far as it is not as before; the names, where others or in another order."""
        scene = self.history.scene
        changes: dict[str, Any] = {"undo": self.history.can_undo, "redo": self.history.can_redo}
        names = list(scene.parents)
        if before is None or names != list(before.parents):
            changes["names"] = names
        changes["objects"] = [
            self.view.about(scene, name, before)
            for name in names
            if before is None or not self.view.as_before(scene, name, before)
        ]
        return {"scene": changes, "holds": sorted(self._locks.held.values())}

    def _poses(self, scene: Scene, drag: ObjectDrag) -> dict[str, list[float]]:
        """Where what is dragged, and all that hangs on it, is in the image on show."""
        return {
            name: scaled_rows(scene.world_T_object(name, drag.time_s, drag.anchors)).tolist()
            for name in scene.branch(drag.name)
        }

    def anchors(
        self, scene: Scene, frame: int, lines: Sequence[Mapping[str, Any]] = ()
    ) -> dict[str, Similarity]:
        """Where anchors are in an image, those that edits bring included."""
        known = dict(scene.anchors)
        for line in lines:
            name = line.get("name")
            if line.get("do") == "anchor" and isinstance(name, str) and name in self.filmed.stands:
                known[name] = self.filmed.stands[name]
        stands = {}
        for name, anchor in known.items():
            poses = self.filmed.world_T_anchor(anchor)
            stands[name] = poses[min(frame, poses.shape[0] - 1)]
        return stands

    def _rays(self, frame: int, message: Message, most: int = 2) -> tuple[Ray, ...]:
        pixels = pixels_of(message, most)
        if not len(pixels):
            return ()
        origin, directions = self.filmed.rays(frame, pixels)
        return tuple(Ray(origin, one) for one in directions)


def _edit_of(line: Message) -> Dragged | Edit:
    """A line that is one change of the scene, and not of its history or of where anchors stand."""
    gesture = gesture_of(line, "edit")
    if not isinstance(gesture, Dragged | Edit):
        raise ValueError(f"edit: expected a drag or an edit, got {gesture.as_json()['do']}")
    return gesture


MOST_POINTS = 400
"""Of the line that shows a way."""


@dataclass(frozen=True)
class SceneView:
    """Objects as JSON for `editor.js`."""

    filmed: Filmed
    played: PlayedScene
    props: Props
    _held_by: dict[int, dict[str, list[Any]]] = field(default_factory=dict)

    def as_before(self, scene: Scene, name: str, before: Scene) -> bool:
        """Whether there is surely nothing to tell of an object that a page does not know."""
        return (
            name in before.parents
            and scene.parts.get(name) is before.parts.get(name)
            and scene.poses[name] is before.poses[name]
            and self.played.stands_alike(before, scene, name)
        )

    def about(self, scene: Scene, name: str, before: Scene | None) -> dict[str, Any]:
        """An object; where it stands is left out for one that stands as it did before.

        Raises ValueError: a file, clip, joint or anchor that is not there.
        """
        part, parent = scene.part(name), scene.parents[name]
        about: dict[str, Any] = {
            "name": name,
            "kind": part.kind,
            "parent": parent,
            "on": self._label(scene, parent),
            "figure": None,
            "motion": None,
            "clip": part.clip,
            "clips": self.props.clips(part),
            "walk": part.walk is not None,
            "walks": None,
            "turns": [[one.time_s, one.end_s] for one in part.joint_keyframes],
            "layers": [layer_json(one) for one in part.layers],
            "keys": [one.time_s for one in part.keyframes],
            "interpolation": part.interpolation,
            "visible_s": None if part.visible_s is None else list(part.visible_s),
        }
        if part.kind != "group":
            number, acted = self.played.acted(scene, name)
            figure = self.played.figure(acted)
            about |= {"motion": number, "figure": figure}
            if part.walk is not None:
                about["walks"] = walked_about(acted, float(scene.poses[name].as_similarity().scale))
            if part.kind == "character":
                if figure not in self._held_by:
                    names = acted.character.skeleton.names
                    held = joints_held_by(acted.character.skeleton)
                    self._held_by[figure] = {body: [k, names[k]] for body, k in held.items()}
                about["held_by"] = self._held_by[figure]
        if before is None or not self.played.stands_alike(before, scene, name):
            track = self.played.world_T_object(scene, name)
            about["track"] = packed(scaled_rows(track), "f64")
            about["ground"] = packed(scaled_rows(self.played.world_T_parent(scene, name)), "f64")
            way = track.translation_m
            moves = len(way) > 1
            about["way"] = packed(way[:: -(-len(way) // MOST_POINTS)]) if moves else None
        return about

    def _label(self, scene: Scene, parent: str | None) -> str:
        if parent is None:
            return "the world"
        anchor = scene.anchors.get(parent)
        return parent if anchor is None else spoken(anchor).lower()


def walked_about(acted: Acted, scale: float) -> dict[str, Any]:
    """From when to when one walks, how fast in the world of its parent, and by which gait."""
    going = [state for state in acted.states if state.state in ("walk", "arrive")]
    if not going:  # it sets out after the recording
        return {"start_s": acted.states[-1].end_s, "end_s": acted.states[-1].end_s}
    assert acted.parent_T_character is not None  # of one that walks
    steps_m = np.diff(acted.parent_T_character.translation_m, axis=0)
    fastest = np.linalg.norm(steps_m, axis=1).max(initial=0.0) / np.diff(acted.time_s).max()
    return {
        "start_s": going[0].start_s,
        "end_s": going[-1].end_s,
        "speed_m_s": float(fastest),
        "gait": going[0].clip,
    }
