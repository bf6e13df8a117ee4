"""`python -m tests.end_to_end.slam`: loops, a kidnapped camera, sessions that meet.

A textured room is drawn with exact ground truth. ``loops``: once around and on, by one camera, with
depth and by a pair, with loops closed and without: errors of both, and how many frames after the
camera was back each loop was closed. ``kidnapped``: the camera is put elsewhere ten times, within
what was mapped or beyond: how many frames until it has a pose again, and how wrong each pose is.
``sessions``: a second session begins where the first never was, and comes to where it was.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from motorcade.fusion.metrics import Align, evaluate
from motorcade.ga import Motor, Trajectory
from motorcade.replays.files.trajectories import even_stamps
from motorcade.tracking.slam import SlamFrame, SlamResult, SlamSettings, VisualSlam
from tests.textured_room.paths import LOOP_S
from tests.textured_room.renderer import Renderer, View
from tests.textured_room.scenarios import RATE_HZ, Scenario, scenario

KINDS = ("one camera", "depth", "pair")
WRONG_M, WRONG_DEG = 0.05, 2.0
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
        mapped: whether the camera was there before.
        frames: until it had a pose again; None where it got none.
        new_map: whether that is in a new map.
        error_m, error_deg: the worst of its poses, in the world of the map they are given in.
    """

    mapped: bool
    frames: int | None
    new_map: bool
    error_m: float
    error_deg: float

    @property
    def wrong(self) -> bool:
        """Whether a pose was given that is not so."""
        return self.error_m > WRONG_M or self.error_deg > WRONG_DEG


def kidnappings(seed: int, count: int = 10, kind: str = "depth") -> Iterator[Kidnapping]:
    """Map half the way around, then go on for six frames each from places drawn at random."""
    made = replace(scenario("loop", seed=seed), darkened=(0, 0))
    rng, renderer = np.random.default_rng([seed, 5]), made.renderer()
    slam = VisualSlam(made.sensor.camera, _settings(made, kind))
    worlds: dict[int, Motor] = {}
    clock = 0

    def seen(at_s: float) -> tuple[SlamFrame, float, float]:
        """Track a view; its pose's error in the map that it is given in."""
        nonlocal clock
        clock += 1
        pose = made.path(at_s)
        frame = track(slam, kind, clock * _STEP_NS, renderer.view(pose, rng))
        if frame.world_T_camera is None:
            return frame, 0.0, 0.0
        world = worlds.setdefault(frame.map_number, pose @ frame.world_T_camera.inverse())
        apart = pose.inverse() @ world @ frame.world_T_camera
        moved_m = float(np.linalg.norm(apart.translation_m))
        return frame, moved_m, float(np.degrees(apart.rotor.angle()))

    for step in range(0, _LAP // 2, 2):
        seen(step / RATE_HZ)
    for _ in range(count):
        start_s = float(rng.uniform(0.0, LOOP_S))
        known = set(worlds)
        found = [seen(start_s + step / RATE_HZ) for step in range(6)]
        posed = [k for k, one in enumerate(found) if one[0].world_T_camera is not None]
        first = posed[0] + 1 if posed else None
        new = any(found[k][0].map_number not in known for k in posed)
        worst = (max(one[axis] for one in found) for axis in (1, 2))
        yield Kidnapping(start_s < 0.5 * LOOP_S, first, new, *worst)


@dataclass(frozen=True)
class Sessions:
    """Two sessions.

    Fields:
        connected: whether the second ended in the map of the first.
        posed: frames of the second that have a pose there; frames: of all.
        error_m: the worst of them, in the first session's world.
    """

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
        return Sessions(False, 0, frames, float("inf"))
    truth = made.path(path.time_ns * 1e-9 + LOOP_S - 3.0)
    apart = (made.path(0.0).inverse() @ truth).inverse() @ path.motors
    error_m = float(np.linalg.norm(apart.translation_m, axis=1).max())
    return Sessions(not second.separate, len(path), frames, error_m)


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
    arguments = parser.parse_args()
    for seed in arguments.seeds:
        if "loops" in arguments.what:
            for one in loops(seed):
                print(
                    f"loop, {one.kind}, seed {seed}: {1e3 * one.open_m:.1f} mm open, "
                    f"{1e3 * one.closed_m:.1f} closed ({one.open_m / one.closed_m:.1f} times), "
                    f"{one.late} frames after coming back",
                    flush=True,
                )
        if "kidnapped" in arguments.what:
            for taken in kidnappings(seed):
                where = "mapped" if taken.mapped else "unknown"
                print(
                    f"kidnapped, seed {seed}, {where}: pose after "
                    f"{taken.frames} frames, {'new map' if taken.new_map else 'known map'}, "
                    f"{1e3 * taken.error_m:.1f} mm, {taken.error_deg:.2f}°"
                    f"{' WRONG' if taken.wrong else ''}",
                    flush=True,
                )
        if "sessions" in arguments.what:
            joined = sessions(seed)
            print(
                f"sessions, seed {seed}: {'connected' if joined.connected else 'apart'}, "
                f"{joined.posed} of {joined.frames} frames, worst {1e3 * joined.error_m:.1f} mm",
                flush=True,
            )


if __name__ == "__main__":
    main()
