"""Inverse kinematics in the suite `animation`: many targets at once, and single calls.

Single calls, as in live use, are timed from Python, each on the next of a set of random targets.
Beside them stand FABRIK in plain NumPy, as it is usually written, and ikpy where it is installed
(`pip install ikpy`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from itertools import cycle
from time import process_time
from typing import Any

import numpy as np

from motorcade.animation import Chain, Character, Skeleton, bend_limb, legs_of, reach_with
from motorcade.animation.ik import Ball, Hinge, IkSolver, PoseGoal, fabrik
from motorcade.animation.ik.chain import Floating
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from tests.bench.timing import median_seconds

__all__ = ["Solving", "solving"]

# Job, figure, unit.
Solving = tuple[str, float, str]

COUNT, JOINTS, CHAINS = 2000, 20, 1000
LIMIT_RAD = float(np.radians(60.0))
TURN_RAD = 0.8


def solving(character: Character) -> Iterator[Solving]:
    """Rows of the table."""
    rng = np.random.default_rng(8)
    yield from _limbs(character, rng)
    yield from _points(rng)
    yield from _figures(rng)
    yield from _peers(rng)


def _targets(rng: np.random.Generator, count: int, low: float, high: float) -> FloatArray:
    """Points ``(count, 3)`` at random in a shell around the origin."""
    made = rng.standard_normal((count, 3))
    made *= rng.uniform(low, high, (count, 1)) / np.linalg.norm(made, axis=1, keepdims=True)
    return made


def _one_call(job: str, targets: FloatArray, solve: Callable[[FloatArray], object]) -> Solving:
    ahead = cycle(targets)
    return job, 1e6 * median_seconds(lambda: solve(next(ahead)), 0.3), "µs a call"


def _limbs(character: Character, rng: np.random.Generator) -> Iterator[Solving]:
    leg, rest = legs_of(character.skeleton)[0], character.skeleton.rest
    limb = (leg.hip, leg.knee, leg.ankle)
    at = character.skeleton.rest_world.translation_m
    hip, knee, ankle = (at[character.skeleton.index(name)] for name in limb)
    reach = float(np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee))
    goals = hip + reach * _targets(rng, COUNT, 0.3, 0.95)
    seconds = median_seconds(lambda: bend_limb(character.skeleton, rest, limb, goals), 0.3)
    yield f"legs of two bones brought to targets, {COUNT} at once", COUNT / seconds, "solves/s"
    chain = Chain(limb)
    seconds = median_seconds(lambda: reach_with(character.skeleton, rest, chain, goals), 0.3)
    yield f"the same legs by FABRIK, {COUNT} at once", COUNT / seconds, "solves/s"


def _points(rng: np.random.Generator) -> Iterator[Solving]:
    """FABRIK on points, at once and in single calls, beside plain NumPy."""
    start = np.zeros((JOINTS, 3))
    start[:, 0] = np.linspace(0.0, 1.0, JOINTS)
    start[:, 1] = 0.01 * np.sin(7.0 * start[:, 0])
    goals, far = _targets(rng, COUNT, 0.2, 0.95), _targets(rng, COUNT, 1.1, 2.0)
    chains = np.repeat(start[None], COUNT, axis=0)
    for bend, how in ((np.pi, ""), (LIMIT_RAD, ", bends of 60 degrees at most")):
        job = f"chains of {JOINTS} joints by FABRIK{how}"
        seconds = median_seconds(partial(fabrik, chains, goals, bend), 0.3)
        yield f"{job}, {COUNT} at once", COUNT / seconds, "solves/s"
        yield _one_call(f"{job}, one call", goals, partial(_reached, start, bend))
        yield _one_call(
            f"the same in plain NumPy{how}",
            goals,
            partial(_plain_fabrik, start, bend),
        )
    yield _one_call(
        f"chains of {JOINTS} joints by FABRIK, out of reach", far, lambda one: fabrik(start, one)
    )


def _straight() -> Skeleton:
    """A chain of unit length along z."""
    shift = np.zeros((JOINTS + 1, 3))
    shift[1:, 2] = 1.0 / JOINTS
    names = tuple(f"j{k}" for k in range(JOINTS + 1))
    return Skeleton(names, np.arange(JOINTS + 1) - 1, Motor.from_translation(shift))


def _figures(rng: np.random.Generator) -> Iterator[Solving]:
    """The solver of figures, single calls."""
    skeleton, goals = _straight(), _targets(rng, COUNT, 0.2, 0.95)
    names = skeleton.names[:-1]
    kinds = {
        "balls without limits": Ball(),
        "balls limited in swing and twist": Ball(LIMIT_RAD, (-TURN_RAD, TURN_RAD)),
    }
    solvers = {name: IkSolver(skeleton, dict.fromkeys(names, kind)) for name, kind in kinds.items()}
    solvers["hinges"] = IkSolver(skeleton, _hinges(names))
    for name, solver in solvers.items():
        yield _one_call(
            f"a chain of {JOINTS} {name}, one call",
            goals,
            partial(_solved, solver, 4),
        )
    limited = solvers["balls limited in swing and twist"]
    far = _targets(rng, COUNT, 1.1, 2.0)
    for restarts in (4, 0):
        yield _one_call(
            f"the same limited balls, out of reach, restarts={restarts}",
            far,
            partial(_solved, limited, restarts),
        )
    yield from _random_limits(rng)
    yield _tree(rng)


def _random_limits(rng: np.random.Generator) -> Iterator[Solving]:
    """Chains each with limits and a target out of reach of its own: the usual call, and the worst.

    Of three calls the shortest counts, so that other work on the machine does not.
    """
    skeleton, spent = _straight(), []
    for target in _targets(rng, CHAINS, 1.1, 2.0):
        widest = rng.uniform(0.1, 1.2, 2)
        joints = {
            name: Ball(float(swing), (-float(low), float(high)))
            for name, (swing, low, high) in zip(
                skeleton.names, widest[[0, 1, 1]] * rng.uniform(0.3, 1.0, (JOINTS, 3)), strict=False
            )
        }
        solver = IkSolver(skeleton, joints)
        calls = []
        for _ in range(3):
            start = process_time()
            _solved(solver, 4, target)
            calls.append(process_time() - start)
        spent.append(1e6 * min(calls))
    job = f"{CHAINS} chains of random limits, out of reach"
    yield f"{job}, one call", float(np.median(spent)), "µs a call"
    yield f"{job}, the slowest call", max(spent), "µs a call"


def _solved(solver: IkSolver, restarts: int, target: FloatArray) -> object:
    skeleton = solver.skeleton
    goals = [PoseGoal(skeleton.names[-1], target)]
    return solver.solve(skeleton.rest, goals, restarts=restarts)


def _tree(rng: np.random.Generator) -> Solving:
    """Floating hips, two hands at places, two feet held in place and turn."""
    parents, shifts = [-1], [[0.0, 0.0, 0.9]]
    joints: dict[str, Ball | Floating | Hinge] = {"hips": Floating()}
    names = ["hips"]
    for limb, start, bone in (
        ("left_arm", [0, 0.2, 0.5], [0, 0.3, 0]),
        ("right_arm", [0, -0.2, 0.5], [0, -0.3, 0]),
        ("left_leg", [0, 0.1, 0], [0, 0, -0.45]),
        ("right_leg", [0, -0.1, 0], [0, 0, -0.45]),
    ):
        for k, shift in enumerate((start, bone, bone)):
            parents.append(0 if k == 0 else len(names) - 1)
            names.append(f"{limb}{k}")
            shifts.append(shift)
        axis = [0.0, 1.0, 0.0] if limb.endswith("leg") else [0.0, 0.0, -float(np.sign(bone[1]))]
        joints |= {f"{limb}0": Ball(1.8, (-1.0, 1.0)), f"{limb}1": Hinge(axis, 0.0, 2.6)}
        joints |= {f"{limb}2": Ball(1.0, (-1.0, 1.0), axis=bone)}
    figure = Skeleton(tuple(names), np.array(parents), Motor.from_translation(shifts))
    solver = IkSolver(figure, joints)
    feet = [PoseGoal.anchor(figure, figure.rest, f"{side}_leg2") for side in ("left", "right")]

    def solve(shift: FloatArray) -> object:
        hands = [
            PoseGoal(f"{side}_arm2", np.array([0.3, 0.3 * sign, 1.2]) + shift)
            for side, sign in (("left", 1.0), ("right", -1.0))
        ]
        return solver.solve(figure.rest, [*feet, *hands])

    job = f"a figure of {len(names)} joints, two hands and two feet with turns, one call"
    return _one_call(job, _targets(rng, COUNT, 0.0, 0.15), solve)


def _hinges(names: tuple[str, ...]) -> dict[str, Hinge]:
    """Hinges about x and y in turns."""
    axes = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    return {name: Hinge(axes[k % 2], -TURN_RAD, TURN_RAD) for k, name in enumerate(names)}


def _peers(rng: np.random.Generator) -> Iterator[Solving]:
    """Ikpy on the same chain of hinges, from the same pose."""
    try:
        chain, link = import_module("ikpy.chain"), import_module("ikpy.link")
    except ImportError:
        return
    links: list[Any] = [link.OriginLink()]
    for name, hinge in _hinges(_straight().names[:-1]).items():
        links.append(
            link.URDFLink(
                name=name,
                origin_translation=[0.0, 0.0, 0.0 if name == "j0" else 1.0 / JOINTS],
                origin_orientation=[0.0, 0.0, 0.0],
                rotation=hinge.axis,
                bounds=(hinge.low_rad, hinge.high_rad),
            )
        )
    tip = {"origin_translation": [0.0, 0.0, 1.0 / JOINTS], "origin_orientation": [0.0, 0.0, 0.0]}
    links.append(link.URDFLink(name="end", joint_type="fixed", rotation=None, **tip))
    made = chain.Chain(links, active_links_mask=[False, *[True] * JOINTS, False])
    goals = _targets(rng, 50, 0.2, 0.95)
    yield _one_call(f"a chain of {JOINTS} hinges by ikpy, one call", goals, made.inverse_kinematics)


def _reached(start: FloatArray, bend_rad: float, target: FloatArray) -> object:
    return fabrik(start, target, bend_rad)


def _plain_fabrik(
    start: FloatArray, bend_rad: float, target: FloatArray, tolerance: float = 1e-5
) -> FloatArray:
    """FABRIK as it is usually written: a loop over joints, at most 500 rounds; cones of bends are
    kept on the way up by turning a bone back in the plane of both.
    """
    points, base = start.copy(), start[0].copy()
    bones = np.linalg.norm(np.diff(start, axis=0), axis=1)
    total = float(bones.sum())
    for _ in range(500):
        if np.linalg.norm(points[-1] - target) <= tolerance * total:
            break
        points[-1] = target
        for k in range(len(bones) - 1, -1, -1):
            away = points[k] - points[k + 1]
            points[k] = points[k + 1] + bones[k] / np.linalg.norm(away) * away
        points[0] = base
        before = None
        for k in range(len(bones)):
            away = points[k + 1] - points[k]
            away /= np.linalg.norm(away)
            if before is not None and bend_rad < np.pi and before @ away < np.cos(bend_rad):
                across = away - (before @ away) * before
                across /= np.linalg.norm(across)
                away = np.cos(bend_rad) * before + np.sin(bend_rad) * across
            points[k + 1] = points[k] + bones[k] * away
            before = away
    return points
