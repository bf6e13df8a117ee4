"""`make bench SUITE=animation`: posing, blending and skinning a character, on one core and two;
limbs brought to targets, and how far feet slide.

The characters are the rigs of the data folder where they are present, and else the mannequin.
Posing is timed by the compiled runtime alone and called from Python; the plain NumPy way of doing
the same stands beside it. ozz-animation, the runtime to compare to, was measured on a machine of
the same class at 25.3 ns a joint for two samples, blend and local to model (67 joints), 2.7 ns a
joint for a blend of two layers and 4.4 to 4.7 ns a vertex for linear skinning.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from time import perf_counter
from typing import Any, Literal

import numpy as np

from motorcade.animation import (
    Character,
    GroundPath,
    Skeleton,
    blend_poses,
    legs_of,
    mannequin,
    skin,
    walk_along,
)
from motorcade.animation.ik import Leg, find_stances
from motorcade.animation.place import on_the_spot
from motorcade.animation.place.walks import Walk
from motorcade.animation.skin import SKIN_METHODS, PoseRuntime, Skinner, palette
from motorcade.ga import Motor, kernels
from tests.bench.data import data_folder
from tests.bench.kinematics import solving
from tests.bench.timing import median_seconds, on_one_core, seconds_a_call

__all__ = ["AnimationRow", "animation_table", "bench_animation"]

POSED = "makehuman/mh_male_ge53_27k.glb"
SKINNED = "makehuman/mh_male_ge53_135k_dressed.glb"
LOADED = "kaykit/Knight.glb"
LAYERS = ((0, 0.1, 0.4), (1, 0.2, 0.6))
CROWD = 100
# Short enough to fit between two interruptions by other work on the machine.
REPEATS, ROUNDS = 100, 51

_PLURAL = {"matrix": "matrices", "motor": "motors"}


@dataclass(frozen=True)
class AnimationRow:
    """One job: its figure, the unit, and what the figure is about."""

    job: str
    figure: float
    unit: str
    subject: str


def bench_animation() -> dict[str, Any]:
    """Measure everything; medians. Returns a JSON-ready tree of `rows` (see `AnimationRow`)."""
    posed, skinned = _character(POSED), _character(SKINNED)
    with on_one_core():
        rows = [*_posing(*posed), *_crowd(*posed), *_skinning(*skinned, threads=1)]
        rows += [AnimationRow(*made, posed[0]) for made in solving(posed[1])]
        rows += _feet()
    rows += [*_skinning(*skinned, threads=2), *_loading()]
    return {"rows": [asdict(row) for row in rows]}


def animation_table(found: Mapping[str, Any]) -> str:
    """A row a job."""
    lines = [f"{'characters':<66}{'figure':>10}"]
    subject = None
    for row in found["rows"]:
        if row["subject"] != subject:
            subject = row["subject"]
            lines += ["", subject]
        lines.append(f"{row['job']:<66}{row['figure']:>10.2f} {row['unit']}")
    return "\n".join(lines)


def _character(name: str) -> tuple[str, Character]:
    from motorcade.animation.formats import read_character

    path = data_folder() / "rigs" / name
    made = read_character(path) if path.is_file() else mannequin()
    title = path.stem if path.is_file() else "mannequin"
    size = f"{len(made.skeleton)} joints, {len(made.vertices)} vertices"
    return f"{title}: {size}", made


def _posing(title: str, character: Character) -> list[AnimationRow]:
    joints, rows = len(character.skeleton), []
    methods: tuple[Literal["motor_linear", "motor"], ...] = ("motor_linear", "motor")
    kinds: tuple[Literal["matrix", "motor"], ...] = ("matrix", "motor")
    for method in methods:
        runtime = PoseRuntime(character.skeleton, character.clips, method)
        for kind in kinds:
            spent = [runtime.repeat(LAYERS, REPEATS, kind) for _ in range(ROUNDS)]
            job = f"two samples, blend ({method}), local to model, palette of {_PLURAL[kind]}"
            rows.append(AnimationRow(job, 1e9 * median(spent) / joints, "ns a joint", title))
        out = np.empty((joints, 12), np.float32)

        def call(runtime: PoseRuntime = runtime, out: Any = out) -> object:
            return runtime.palette(LAYERS, "matrix", out)

        seconds = median_seconds(call, 0.2)
        job = f"the same ({method}), called from Python"
        rows.append(AnimationRow(job, 1e6 * seconds, "µs a character", title))
    plain = median_seconds(lambda: _plain(character), 0.2)
    rows.append(AnimationRow("the same in NumPy, float64", 1e6 * plain, "µs a character", title))
    return rows


def _plain(character: Character) -> object:
    poses = [character.clips[k].at(time_s).coefficients for k, time_s, _ in LAYERS]
    blended = blend_poses(Motor(np.stack(poses)), [weight for *_, weight in LAYERS])
    return palette(character.skeleton, blended, "linear")


def _crowd(title: str, character: Character) -> list[AnimationRow]:
    """Two layers of a crowd blended at once, on poses that lie apart as kernels want them."""
    count = CROWD * len(character.skeleton)
    blocks = [kernels.Block(8, count, "float32") for _ in range(3)]
    times = np.linspace(0.0, 1.0, CROWD)
    for block, clip in zip(blocks[:2], character.clips, strict=False):
        block.array[:] = clip.at(times).coefficients.reshape(count, 8)
    rows = []
    for kernel, method in (("blend", "motor_linear"), ("screw_blend", "motor")):
        seconds = seconds_a_call(kernel, 0.2, blocks[0], blocks[1], 0.4, blocks[2])
        job = f"two layers of {CROWD} characters blended ({method})"
        rows.append(AnimationRow(job, 1e9 * seconds / count, "ns a joint", title))
    return rows


def _skinning(title: str, character: Character, threads: int) -> list[AnimationRow]:
    pose, count = character.clips[0].at(0.3), len(character.vertices)
    where = "one core" if threads == 1 else f"{threads} threads"
    rows = []
    for method in SKIN_METHODS:
        skinner = Skinner(character, method)
        entries = palette(character.skeleton, pose, method)[0].astype(np.float32)
        before = kernels.threads()
        kernels.set_threads(threads)
        try:
            call = _skin_call(skinner, np.ascontiguousarray(entries))
            seconds = median_seconds(call, 0.3)
        finally:
            kernels.set_threads(before)
        job = f"skinning, position and normal, {method}, {where}"
        rows.append(AnimationRow(job, 1e9 * seconds / count, "ns a vertex", title))
    if threads == 1:
        start = perf_counter()
        skin(character, pose, "motor")
        plain = (perf_counter() - start) / count
        job = "skinning in NumPy, float64, motor"
        rows.append(AnimationRow(job, 1e9 * plain, "ns a vertex", title))
    return rows


def _feet() -> list[AnimationRow]:
    """How far the ball of a standing foot goes along a bend, as it is played and planted."""
    figure, rows = mannequin(), []
    skeleton, legs = figure.skeleton, legs_of(figure.skeleton)
    path = GroundPath(np.array([[0, 0], [1.5, 0], [2.5, 1.0], [2.5, 2.5], [4.0, 3.0]]))
    for name in ("walk", "jog", "run"):
        loop, speed_m_s = on_the_spot(figure.clip(name), skeleton, legs)
        made = walk_along(path, loop, skeleton, legs, speed_m_s, starts=False, stops=False)
        plain = loop.at(loop.time_s[0] + made.time_s)
        # When feet stand is told by the clip on a straight way: a turn drags them along.
        ahead = Motor.from_twist(np.outer(speed_m_s * made.time_s, [0, 0, 0, 1.0, 0, 0]))
        straight = ahead.reshape(-1, 1).apply(skeleton.world(plain).translation_m)
        stances = [find_stances(straight[:, skeleton.index(leg.ball)], made.time_s) for leg in legs]
        for how, poses in (("played", plain), ("planted", made.poses)):
            job = f"{name} along a bend, {how}: largest slide of a standing ball"
            slide = _slide_m(made, skeleton, legs, stances, poses)
            rows.append(AnimationRow(job, 1e3 * slide, "mm", "feet of the mannequin"))
    return rows


def _slide_m(
    made: Walk, skeleton: Skeleton, legs: Sequence[Leg], stances: Sequence[Any], poses: Any
) -> float:
    worst = 0.0
    world = made.plane_T_character.reshape(-1, 1) @ skeleton.world(poses)
    for leg, standing in zip(legs, stances, strict=True):
        at, rows = world[:, skeleton.index(leg.ball)].translation_m, np.flatnonzero(standing)
        for run in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
            if len(run):
                moved = np.ptp(at[run, :2], axis=0)
                worst = max(worst, float(np.linalg.norm(moved)))
    return worst


def _skin_call(skinner: Skinner, entries: Any) -> Any:
    return lambda: skinner.skin_palette(entries)


def _loading() -> list[AnimationRow]:
    from motorcade.animation.formats import read_character

    path = data_folder() / "rigs" / LOADED
    if not path.is_file():
        return []
    spent = []
    for _ in range(5):
        start = perf_counter()
        made = read_character(path)
        spent.append(perf_counter() - start)
    job = f"loaded with all keys of {len(made.clips)} clips decoded"
    return [AnimationRow(job, median(spent), "s", path.stem)]
