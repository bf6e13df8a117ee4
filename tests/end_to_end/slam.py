"""`python -m tests.end_to_end.slam`: loops, a kidnapped camera, sessions that meet.

A textured room is drawn with exact ground truth. ``loops``: once around and on, by one camera, with
depth and by a pair, with loops closed and without: errors of both, and how many frames after the
camera was back each loop was closed. ``kidnapped``: the camera is put elsewhere ten times, within
what was mapped or beyond: how many frames until it has a pose again, and how wrong each pose is.
One camera's maps have a unit of their own, which is taken from the frames before. ``sessions``: a
second session begins where the first never was, and comes to where it was.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.metrics import Align, alignment_of, associate, evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.trajectories import even_stamps
from motorcade.tracking.slam import SlamFrame, SlamResult, SlamSettings, VisualSlam
from tests.textured_room.paths import LOOP_S
from tests.textured_room.renderer import Renderer, View
from tests.textured_room.scenarios import RATE_HZ, Scenario, scenario

KINDS = ("one camera", "depth", "pair")
WRONG_M, WRONG_DEG = 0.05, 2.0
# Frames from where the camera is put; one camera must move before it can begin a map.
_FRAMES = {"one camera": 24, "depth": 6, "pair": 6}
_LAP = round(LOOP_S * RATE_HZ)
_STEP_NS = round(1e9 / RATE_HZ)


def track(slam: VisualSlam, kind: str, time_ns: int, view: View) -> SlamFrame:
    """Feed a view as a kind of camera sees it."""
    depth_m = view.depth_m if kind == "depth" else None
    return slam.track(time_ns, view.gray, depth_m, view.right if kind == "pair" else None)


def _settings(made: Scenario, kind: str, close_loops: bool = True) -> SlamSettings:
    baseline_m = made.sensor.baseline_m if kind == "pair" else None
    return SlamSettings(baseline_m=baseline_m, close_loops=close_loops)


@dataclass(frozen=True)
class Loop:
    """Errors (m, after alignment) of one loop, and when it was closed.

    Fields:
        late: frames from coming back to the start until a loop to it was closed; negative where
            the start came into view before. None where none was closed.
    """

    kind: str
    seed: int
    open_m: float
    closed_m: float
    late: int | None


def loops(seed: int, kinds: Iterable[str] = KINDS) -> Iterator[Loop]:
    """Draw a loop once, and run each kind with loops closed and without."""
    made = scenario("loop", seed=seed)
    camera, truth = made.sensor.camera, made.truth()
    runs = {
        (kind, closed): VisualSlam(camera, _settings(made, kind, closed))
        for kind in kinds
        for closed in (False, True)
    }
    for time_ns, view in zip(truth.time_ns.tolist(), made.views(), strict=True):
        for (kind, _), slam in runs.items():
            track(slam, kind, time_ns, view)
    for kind in kinds:
        left_open, closed = (runs[kind, one].finish() for one in (False, True))
        late = [round((one.time_ns * 1e-9 - LOOP_S) * RATE_HZ) for one in closed.loops]
        errors = (_ape_m(one, truth) for one in (left_open, closed))
        yield Loop(kind, seed, *errors, min(late, default=None))


def _ape_m(result: SlamResult, truth: Trajectory) -> float:
    if result.trajectory is None:
        return float("inf")
    align: Align = "se3" if result.metric else "sim3"
    return evaluate(result.trajectory, truth, align=align).ape_m.rmse


@dataclass(frozen=True)
class Kidnapping:
    """One time that the camera was put elsewhere.

    Fields:
        kind: of camera.
        mapped: whether the camera was there before.
        frames: until it had a pose again; None where it got none.
        new_map: whether that is in a new map.
        error_m, error_deg: the worst of its poses, in the world of the map they are given in.
    """

    kind: str
    mapped: bool
    frames: int | None
    new_map: bool
    error_m: float
    error_deg: float

    @property
    def wrong(self) -> bool:
        """Whether a pose was given that is not so."""
        return self.error_m > WRONG_M or self.error_deg > WRONG_DEG


class _Placed:
    """Poses given by each map, and the true ones."""

    def __init__(self, metric: bool) -> None:
        self._metric = metric
        self._poses: dict[int, list[tuple[Motor, Motor]]] = {}

    def add(self, number: int, found: Motor, true: Motor) -> None:
        """Take a frame's pose."""
        self._poses.setdefault(number, []).append((found, true))

    def counts(self) -> dict[int, int]:
        """Poses of each map so far."""
        return {number: len(poses) for number, poses in self._poses.items()}

    def errors(self, number: int, since: int) -> tuple[float, float]:
        """Largest errors (m, degrees) of a map's poses from the place `since` on.

        The map's first pose says where its world lies. One camera's unit is fitted to the poses
        before, or to its own where the map is new.
        """
        poses = self._poses[number]
        time_ns = even_stamps(len(poses), RATE_HZ)
        found, true = (Trajectory(time_ns, Motor.stack(one)) for one in zip(*poses, strict=True))
        how: Align = "origin" if self._metric else "scaled_origin"
        fitted_to = None if self._metric or since < 3 else since
        placed = alignment_of(associate(found, true), how, fitted_to).apply_to(found)
        apart = true.motors[since:].inverse() @ placed.motors[since:]
        moved_m = np.linalg.norm(apart.translation_m, axis=-1)
        return float(moved_m.max()), float(np.degrees(apart.rotor.angle()).max())


def kidnappings(seed: int, kind: str = "depth", count: int = 10) -> Iterator[Kidnapping]:
    """Map half the way around, then go on for some frames each from places drawn at random."""
    made = replace(scenario("loop", seed=seed), darkened=(0, 0))
    rng, renderer = np.random.default_rng([seed, 5]), made.renderer()
    slam = VisualSlam(made.sensor.camera, _settings(made, kind))
    placed = _Placed(kind != "one camera")
    clock = 0

    def seen(at_s: float) -> SlamFrame:
        nonlocal clock
        clock += 1
        pose = made.path(at_s)
        frame = track(slam, kind, clock * _STEP_NS, renderer.view(pose, rng))
        if frame.world_T_camera is not None:
            placed.add(frame.map_number, frame.world_T_camera, pose)
        return frame

    for step in range(0, _LAP // 2, 2):
        seen(step / RATE_HZ)
    for _ in range(count):
        start_s = float(rng.uniform(0.0, LOOP_S))
        before = placed.counts()
        found = [seen(start_s + step / RATE_HZ) for step in range(_FRAMES[kind])]
        posed = [number for number, one in enumerate(found) if one.world_T_camera is not None]
        numbers = {found[number].map_number for number in posed}
        errors = [(0.0, 0.0), *(placed.errors(one, before.get(one, 0)) for one in sorted(numbers))]
        yield Kidnapping(
            kind,
            start_s < 0.5 * LOOP_S,
            posed[0] + 1 if posed else None,
            any(one not in before for one in numbers),
            max(moved_m for moved_m, _ in errors),
            max(turned_deg for _, turned_deg in errors),
        )


@dataclass(frozen=True)
class Sessions:
    """Two sessions.

    Fields:
        kind: of camera.
        connected: whether the second ended in the map of the first.
        posed: frames of the second that have a pose there; frames: of all.
        error_m: the worst of them, in the first session's world.
    """

    kind: str
    connected: bool
    posed: int
    frames: int
    error_m: float


def sessions(seed: int, kind: str = "depth") -> Sessions:
    """Map the first 5 s of the loop; then start 3 s before it and go on for 5 s."""
    made = replace(scenario("loop", seed=seed), darkened=(0, 0))
    renderer, camera = made.renderer(), made.sensor.camera
    first = _session(VisualSlam(camera, _settings(made, kind)), made, renderer, kind, (0.0, 5.0))
    again = VisualSlam(camera, _settings(made, kind), known=first.map, extend=True)
    second = _session(again, made, renderer, kind, (LOOP_S - 3.0, LOOP_S + 2.0))
    path, frames = second.trajectory, len(second.states)
    if path is None:
        return Sessions(kind, False, 0, frames, float("inf"))
    truth = made.path(path.time_ns * 1e-9 + LOOP_S - 3.0)
    apart = (made.path(0.0).inverse() @ truth).inverse() @ _in_metres(first, made, path)
    error_m = float(np.linalg.norm(apart.translation_m, axis=1).max())
    return Sessions(kind, not second.separate, len(path), frames, error_m)


def _in_metres(first: SlamResult, made: Scenario, path: Trajectory) -> Motor:
    """A path in the world of a first session, whose unit is told by its own path."""
    if first.metric or first.trajectory is None:
        return path.motors
    stamps = first.trajectory.time_ns
    true = Trajectory(stamps, made.path(0.0).inverse() @ made.path(stamps * 1e-9))
    return alignment_of(associate(first.trajectory, true), "sim3").apply(path.motors)


def _session(
    slam: VisualSlam, made: Scenario, renderer: Renderer, kind: str, span_s: tuple[float, float]
) -> SlamResult:
    rng = np.random.default_rng([made.seed, 6])
    for time_ns in even_stamps(round((span_s[1] - span_s[0]) * RATE_HZ), RATE_HZ).tolist():
        track(slam, kind, time_ns, renderer.view(made.path(span_s[0] + time_ns * 1e-9), rng))
    return slam.finish()


def main() -> None:
    """Run what is named, or all."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.slam")
    parser.add_argument("what", nargs="*", default=["loops", "kidnapped", "sessions"])
    parser.add_argument("--seeds", type=int, nargs="*", default=[0])
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=KINDS)
    arguments = parser.parse_args()
    for seed in arguments.seeds:
        if "loops" in arguments.what:
            for one in loops(seed, arguments.kinds):
                print(
                    f"loop, {one.kind}, seed {seed}: {1e3 * one.open_m:.1f} mm open, "
                    f"{1e3 * one.closed_m:.1f} closed ({one.open_m / one.closed_m:.1f} times), "
                    f"{one.late} frames after coming back",
                    flush=True,
                )
        for kind in arguments.kinds:
            if "kidnapped" in arguments.what:
                for taken in kidnappings(seed, kind):
                    print(_kidnapping_line(taken, seed), flush=True)
            if "sessions" in arguments.what:
                joined = sessions(seed, kind)
                print(
                    f"sessions, {kind}, seed {seed}: "
                    f"{'connected' if joined.connected else 'apart'}, {joined.posed} of "
                    f"{joined.frames} frames, worst {1e3 * joined.error_m:.1f} mm",
                    flush=True,
                )


def _kidnapping_line(taken: Kidnapping, seed: int) -> str:
    where = "mapped" if taken.mapped else "unknown"
    found = "new map" if taken.new_map else "known map"
    pose = "no pose" if taken.frames is None else f"pose after {taken.frames} frames, {found}"
    return (
        f"kidnapped, {taken.kind}, seed {seed}, {where}: {pose}, {1e3 * taken.error_m:.1f} mm, "
        f"{taken.error_deg:.2f}°{' WRONG' if taken.wrong else ''}"
    )


if __name__ == "__main__":
    main()
