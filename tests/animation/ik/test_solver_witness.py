"""The solver of figures beside SciPy's, which knows of no rotors, trees or limits of ours."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from motorcade.animation import Skeleton
from motorcade.animation.ik import Ball, Hinge, IkSolver, PoseGoal
from motorcade.ga import Motor, Rotor
from tests.animation.ik.figures import axes_of, chain, swing_and_twist, turns


class Witness:
    """A chain of hinges and balls in SciPy's rotations; parameters as SLSQP wants them."""

    def __init__(self, skeleton: Skeleton, joints: dict, size_m: float) -> None:
        self.skeleton, self.joints, self.size_m = skeleton, joints, size_m
        quaternions = skeleton.rest.rotor.as_quaternion()
        self.rest = Rotation.from_quat(quaternions, scalar_first=True)
        self.shifts = skeleton.rest.translation_m
        self.bounds, self.ellipses = [], []
        for name in skeleton.names[:-1]:
            kind = joints[name]
            if isinstance(kind, Hinge):
                self.bounds.append((kind.low_rad, kind.high_rad))
                continue
            half = np.broadcast_to(kind.swing_rad, (2,))
            self.ellipses.append((len(self.bounds), half))
            self.bounds += [(-half[0], half[0]), (-half[1], half[1]), kind.twist_rad]

    def end(self, x: np.ndarray) -> tuple[np.ndarray, Rotation]:
        turn, at, k = Rotation.identity(), np.zeros(3), 0
        for j, name in enumerate(self.skeleton.names):
            at = at + turn.apply(self.shifts[j])
            turn = turn * self.rest[j]
            if name not in self.joints:
                continue
            kind = self.joints[name]
            if isinstance(kind, Hinge):
                axis = np.asarray(kind.axis) / np.linalg.norm(kind.axis)
                turn = turn * Rotation.from_rotvec(x[k] * axis)
                k += 1
                continue
            axis, across = axes_of(self.skeleton, name, kind)
            swing = x[k] * across + x[k + 1] * np.cross(axis, across)
            turn = turn * Rotation.from_rotvec(swing) * Rotation.from_rotvec(x[k + 2] * axis)
            k += 3
        return at, turn

    def cost(self, x: np.ndarray, place: np.ndarray, rotor: Rotation | None) -> float:
        at, turn = self.end(x)
        left = np.sum(((at - place) / self.size_m) ** 2)
        if rotor is not None:
            left += np.sum((turn * rotor.inv()).as_rotvec() ** 2)
        return float(0.5 * left)

    def best_from(self, x: np.ndarray, place: np.ndarray, rotor: Rotation | None) -> float:
        rules = [
            {"type": "ineq", "fun": lambda x, k=k, h=half: 1.0 - np.sum((x[k : k + 2] / h) ** 2)}
            for k, half in self.ellipses
        ]
        options = {"maxiter": 300, "ftol": 1e-14}
        found = minimize(
            self.cost, x, (place, rotor), "SLSQP", bounds=self.bounds, constraints=rules,
            options=options,
        )  # fmt: skip
        allowed = all(rule["fun"](found.x) > -1e-9 for rule in rules)
        return float(found.fun) if allowed else np.inf

    def parameters(self, pose: Motor) -> np.ndarray:
        made: list[float] = []
        for name in self.skeleton.names[:-1]:
            kind, turn = self.joints[name], turns(self.skeleton, pose, name)
            if isinstance(kind, Hinge):
                made.append(turn.as_rotvec() @ np.asarray(kind.axis) / np.linalg.norm(kind.axis))
                continue
            axis, across = axes_of(self.skeleton, name, kind)
            swing, twist = swing_and_twist(turn, axis)
            made += [swing @ across, swing @ np.cross(axis, across), twist]
        return np.array(made)


def limited_joints(rng: np.random.Generator, skeleton: Skeleton) -> dict:
    made = {}
    for k, name in enumerate(skeleton.names[:-1]):
        axis, across = rng.standard_normal((2, 3))
        wide = rng.uniform(0.4, 1.4, 2)
        made[name] = (
            Hinge(axis, -0.7, 1.0),
            Ball((wide[0], wide[1]), (-0.5, 0.5), axis=axis, across=across),
            Ball(float(wide[0]), (-0.8, 0.2)),
        )[(k + int(rng.integers(3))) % 3]
    return made


@pytest.mark.parametrize("oriented", [False, True])
@pytest.mark.parametrize("distance", [0.0, 0.6, 1.0, 5.0])
def test_slsqp_finds_nothing_better_nearby(oriented, distance, rng):
    for _ in range(3):
        skeleton = chain(rng, 5)
        joints = limited_joints(rng, skeleton)
        solver = IkSolver(skeleton, joints)
        witness = Witness(skeleton, joints, solver.size_m)
        place = skeleton.rest.translation_m[0] + distance * rng.standard_normal(3)
        rotor = Rotor.random(rng) if oriented else None
        solved = solver.solve(skeleton.rest, [PoseGoal("j4", place, rotor)])
        x = witness.parameters(solved.local_pose)
        turn = None
        if rotor is not None:
            turn = Rotation.from_quat(rotor.as_quaternion(), scalar_first=True)
        at, found = witness.end(x)
        assert np.linalg.norm(at - place) == pytest.approx(solved.error_m[0], abs=1e-9)
        if turn is not None:
            angle = (found * turn.inv()).magnitude()
            assert angle == pytest.approx(solved.error_rad[0], abs=1e-7)
        ours = witness.cost(x, place, turn)
        assert witness.best_from(x, place, turn) > ours - max(1e-4 * ours, 1e-11)
