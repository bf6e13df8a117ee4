"""Blends called from Python, 54 and 64 joints: ours, NumPy, scipy, pytransform3d, clifford.

Each does a screw or slerp blend of two poses a joint in float64, and leaves matrices where it can;
what is not installed is named, not skipped silently.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from motorcade.ga import Motor, Similarity, kernels
from tests.bench.timing import median_seconds

__all__ = ["Peers", "python_peers"]

JOINTS = 54
SECONDS = 0.3
CLIFFORD_JOINTS = 2


@dataclass
class Peers:
    """Microseconds a call for 54 joints unless the name says otherwise, and what was left out."""

    microseconds: dict[str, float] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    def add(self, name: str, call: Callable[[], object], scale: float = 1.0) -> None:
        """Time a call; `scale` makes up for fewer joints."""
        self.microseconds[name] = 1e6 * scale * median_seconds(call, SECONDS)


def python_peers(fraction: float) -> Peers:
    """Measure all that is installed."""
    peers = Peers()
    for joints, scalar in ((64, "float32"), (JOINTS, "float32"), (64, "float64")):
        peers.add(f"raw kernel, {joints} joints, {scalar}", _raw(joints, scalar, fraction))
    first, second = _motors(64)
    peers.add("Motor.interpolate, 64 joints", lambda: first.interpolate(second, fraction))
    for scalar in ("float32", "float64"):
        _add_similarities(peers, 64, scalar, fraction)
    peers.add("NumPy kernels", _numpy(fraction))
    for name, prepare in (
        ("scipy", _scipy),
        ("pytransform3d", _pytransform3d),
    ):
        try:
            peers.add(name, prepare(fraction))
        except ModuleNotFoundError as missing:
            peers.left_out.append(f"{name}: not installed ({missing.name})")
    try:
        peers.add("clifford", _clifford(fraction), JOINTS / CLIFFORD_JOINTS)
    except ModuleNotFoundError as missing:
        peers.left_out.append(f"clifford: not installed ({missing.name})")
    return peers


def _add_similarities(peers: Peers, joints: int, scalar: str, fraction: float) -> None:
    pairs = Similarity.random(np.random.default_rng(joints), (2, joints)).astype(scalar)
    one, other = pairs[0], pairs[1]
    size = f"{joints} joints, {scalar}"
    peers.add(f"Similarity @, {size}", lambda: one @ other)
    peers.add(f"Similarity.interpolate, {size}", lambda: one.interpolate(other, fraction))


def _motors(joints: int) -> tuple[Motor, Motor]:
    pairs = Motor.random(np.random.default_rng(joints), (2, joints))
    return pairs[0], pairs[1]


def _raw(joints: int, scalar: str, fraction: float) -> Callable[[], object]:
    """The compiled function itself on storage as it wants it, matrices out."""
    first, second = _motors(joints)
    a, b = kernels.Block(8, joints, scalar), kernels.Block(8, joints, scalar)
    a.array[:], b.array[:] = first.coefficients, second.coefficients
    out = kernels.Block(12, joints, scalar)
    kernel = kernels.function("screw_blend_matrix")
    return lambda: kernel(a, b, fraction, out)


def _numpy(fraction: float) -> Callable[[], object]:
    from motorcade.ga.kernels import numpy_backend

    first, second = (motor.coefficients for motor in _motors(JOINTS))
    out = np.empty((JOINTS, 12))
    kernel = numpy_backend.function("screw_blend_matrix")
    return lambda: kernel(first, second, fraction, out)


def _scipy(fraction: float) -> Callable[[], object]:
    from scipy.spatial.transform import RigidTransform

    a, b = (RigidTransform.from_matrix(motor.as_matrix()) for motor in _motors(JOINTS))
    return lambda: (
        a * RigidTransform.from_exp_coords(fraction * (a.inv() * b).as_exp_coords())
    ).as_matrix()


def _pytransform3d(fraction: float) -> Callable[[], object]:
    from pytransform3d.transformations import dual_quaternion_sclerp, transform_from_dual_quaternion

    a, b = (motor.as_dual_quaternion() for motor in _motors(JOINTS))

    def blend() -> None:
        for start, end in zip(a, b, strict=True):
            transform_from_dual_quaternion(dual_quaternion_sclerp(start, end, fraction))

    return blend


def _clifford(fraction: float) -> Callable[[], object]:
    from clifford.g3c import blades, einf
    from clifford.tools.g3c.rotor_parameterisation import ga_exp, ga_log

    e23, e13, e12 = blades["e23"], blades["e13"], blades["e12"]
    basis = [1.0, e23, -e13, e12, blades["e1"] ^ einf, blades["e2"] ^ einf, blades["e3"] ^ einf]
    basis.append(blades["e123"] ^ einf)
    pairs = [
        [sum(x * blade for x, blade in zip(row, basis, strict=True)) for row in motor.coefficients]
        for motor in _motors(CLIFFORD_JOINTS)
    ]

    def blend() -> None:
        for start, end in zip(*pairs, strict=True):
            start * ga_exp(fraction * ga_log(~start * end))

    return blend
