"""The simulated sensor and the integration of its samples, by other ways to the same numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from motorcade.fusion.imu import (
    ADIS16448,
    ContinuousPath,
    ImuStream,
    estimate_noise,
    simulate_imu,
)
from motorcade.fusion.motions import MOTIONS, Factor, Motion
from motorcade.fusion.motions.motion import Polynomial
from motorcade.fusion.preintegration import preintegrate
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

__all__ = [
    "against_differences",
    "against_gtsam",
    "bench_simulator",
    "halved_steps",
    "simulator_table",
]

_MOTIONS = ("handheld", "gimbal_crossing", "walk_and_look")
_GRAVITY = np.array([0.0, 0.0, -9.81])
# Central differences of the eighth order, 2 ms apart.
_STEP_S = 2e-3
_FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
_HOURS = 4.0


def bench_simulator() -> dict[str, Any]:
    """Rates and forces, orders of integration, preintegration, and densities by Allan deviation."""
    rows = []
    for name in _MOTIONS:
        path = ContinuousPath.through(MOTIONS[name].sampled(50.0, 4.0), 0.1)
        rate, force = against_differences(path)
        turned, moved = halved_steps(path)
        row = {
            "motion": name,
            "rate_rad_s": rate,
            "force_m_s2": force,
            "halved_rotation": turned,
            "halved_position": moved,
        }
        try:
            row["gtsam"] = against_gtsam(path)
        except ModuleNotFoundError:
            row["gtsam"] = None
        rows.append(row)
    return {"rows": rows, "allan": _allan()}


def against_differences(path: ContinuousPath) -> tuple[float, float]:
    """Largest differences of angular rate and specific force from those of differenced poses."""
    stream = simulate_imu(path, 200.0, None, np.random.default_rng(0)).stream
    inner = slice(10, -10)
    time_s = (stream.time_ns[inner] - path.start_ns) * 1e-9
    poses = path.twists(time_s[:, None] + _STEP_S * np.arange(-4, 5)).pose
    middle = poses[:, 4:5]
    vectors = (middle.rotor.inverse() @ poses.rotor).as_rotation_vector()
    rate = np.einsum("k,nki->ni", _FIRST, vectors) / _STEP_S
    places = poses.translation_m - middle.translation_m
    acceleration = np.einsum("k,nki->ni", _SECOND, places) / _STEP_S**2
    force = middle[:, 0].rotor.inverse().apply(acceleration - _GRAVITY)
    return (
        float(np.max(np.abs(stream.angular_rate_rad_s[inner] - rate))),
        float(np.max(np.abs(stream.specific_force_m_s2[inner] - force))),
    )


def halved_steps(path: ContinuousPath) -> tuple[float, float]:
    """The least factor by which a halved step shrinks the error at the end, of turn and place."""
    errors = np.array([_integrated(path, rate_hz) for rate_hz in (50.0, 100.0, 200.0, 400.0)])
    turned, moved = np.min(errors[:-1] / errors[1:], axis=0)
    return float(turned), float(moved)


def _integrated(path: ContinuousPath, rate_hz: float) -> FloatArray:
    made = simulate_imu(path, rate_hz, None, np.random.default_rng(0))
    ends = made.stream.time_ns[[0, -1]]
    summed = preintegrate(made.stream, ends, ADIS16448)
    pose, _ = summed.propagate(made.path.motors[:1], made.velocity_m_s[:1], _GRAVITY)
    apart = (pose.inverse() @ made.path.motors[-1:]).as_twist()[0]
    return np.array([np.linalg.norm(apart[:3]), np.linalg.norm(apart[3:])])


def against_gtsam(path: ContinuousPath) -> float:
    """Largest difference in turn, place and velocity of preintegration over 0.5 s, by its rule."""
    import gtsam

    stream = simulate_imu(path, 200.0, ADIS16448, np.random.default_rng(0)).stream
    half = ImuStream(
        stream.time_ns[:101], stream.angular_rate_rad_s[:101], stream.specific_force_m_s2[:101]
    )
    own = preintegrate(half, half.time_ns[[0, -1]], ADIS16448, rule="held").motion[0]
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)
    other = gtsam.PreintegratedCombinedMeasurementsManifold(params, gtsam.imuBias.ConstantBias())
    for k, dt_s in enumerate(np.diff(half.time_ns) * 1e-9):
        other.integrateMeasurement(
            half.specific_force_m_s2[k], half.angular_rate_rad_s[k], float(dt_s)
        )
    moved, gained = own.translation_m
    parts = (
        own[0].rotor.as_matrix() - other.deltaRij().matrix(),
        moved - other.deltaPij(),
        gained - other.deltaVij(),
    )
    return max(float(np.max(np.abs(part))) for part in parts)


def _allan() -> dict[str, float]:
    """Densities found in hours of a simulated sensor at rest, over those put in."""
    standing = Motion((Factor(np.zeros(6), Polynomial((1.0,))),), Motor)
    path = ContinuousPath.along(standing, 3600.0 * _HOURS)
    stream = simulate_imu(path, 40.0, ADIS16448, np.random.default_rng(0)).stream
    found, true = asdict(estimate_noise(stream).noise), asdict(ADIS16448)
    return {name: found[name] / true[name] for name in true}


def simulator_table(found: Mapping[str, Any]) -> str:
    """A line a motion, then the densities."""
    heads = ("rad/s", "m/s²", "turn ÷", "place ÷", "gtsam")
    title = "simulator: differences, halved steps, 0.5 s"
    lines = [f"{title:<48}" + "".join(f"{head:>10}" for head in heads)]
    for row in found["rows"]:
        gtsam = "–" if row["gtsam"] is None else f"{row['gtsam']:.1g}"
        lines.append(
            f"{row['motion']:<48}{row['rate_rad_s']:>10.1g}{row['force_m_s2']:>10.1g}"
            f"{row['halved_rotation']:>10.2f}{row['halved_position']:>10.2f}{gtsam:>10}"
        )
    ratios = "".join(f"{ratio:>10.3f}" for ratio in found["allan"].values())
    name = f"Allan deviation over {_HOURS:g} h, found over put in"
    lines.append(f"{name:<48}{ratios}   (gyro σ, walk; accel σ, walk)")
    return "\n".join(lines)
