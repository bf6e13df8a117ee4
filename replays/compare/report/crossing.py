"""A passage through gimbal lock, drawn frame by frame: the true camera and every smoothed one.

The camera is a pyramid seen from a fixed place without perspective; what is drawn are the recorded
poses themselves, none between them. The page's script only shows one frame after another.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.compare.report.names import shown
from motorcade.replays.compare.report.pictures import Replayed

_SHOWN = ("euler", "euler_unwrapped", "quaternion", "motor")
_SIZE = 100.0
# Corners of the picture clockwise from the top left, the mark above it, and where it looks.
_CAMERA = np.array(
    [
        [-0.52, -0.38, 0.88],
        [0.52, -0.38, 0.88],
        [0.52, 0.38, 0.88],
        [-0.52, 0.38, 0.88],
        [0.0, -0.66, 0.88],
        [0.0, 0.0, 1.15],
    ]
)
_EYE = np.array([1.25, -1.6, 0.8])
_UP = np.array([0.0, 0.0, 1.0])
_LOCK = np.array([1.15, 0.0, 0.0])
_MOMENTS = 7
_APART_S = 0.1
_WIDTH, _HEIGHT = 900.0, 120.0
_LOW_DEG, _HIGH_DEG = 0.01, 180.0


@dataclass(frozen=True, eq=False)
class Crossing:
    """What the page draws.

    Fields:
        motion, degradation, method, seed: of what is drawn.
        names: "truth" and the representations.
        data: for the script: stamps in ms, points and errors by name, the worst frame.
        lock: where the line of sight is locked, on the drawing.
        strip: rows of the film strip: a name, and for each moment its points as SVG text, the
            truth's, and the error in degrees.
        moments_s: times of the strip's columns.
        curves: polylines of the error over time as SVG text, by name.
        ticks: (degrees as text, height) of the curves' axis.
        worst_deg: largest error of each representation.
    """

    motion: str
    degradation: str
    method: str
    seed: int
    names: list[str]
    data: dict[str, Any]
    lock: tuple[float, float]
    strip: list[tuple[str, list[dict[str, str]]]]
    moments_s: list[str]
    curves: dict[str, str]
    ticks: list[tuple[str, float]]
    worst_deg: dict[str, float]


def crossing(replayed: Replayed) -> Crossing:
    """Draw a motion; representations that were refused are left out."""
    paths = {"truth": replayed.true}
    paths |= {name: replayed.paths[name] for name in _SHOWN if name in replayed.paths}
    points = {name: _drawn(path) for name, path in paths.items()}
    errors = {"truth": np.zeros(len(replayed.time_s))} | replayed.rotation_errors_deg()
    errors = {name: errors[name] for name in paths}
    worst = _passage(replayed, errors)
    columns = _columns(replayed.time_s, worst)
    return Crossing(
        motion=replayed.motion,
        degradation=replayed.degradation,
        method=replayed.method,
        seed=replayed.seed,
        names=list(paths),
        data={
            "ms": np.round(1e3 * replayed.time_s).astype(int).tolist(),
            "points": {name: one.reshape(len(one), -1).tolist() for name, one in points.items()},
            "errors": {name: np.round(one, 2).tolist() for name, one in errors.items()},
            "start": int(columns[0]),
        },
        lock=tuple(_projected(_LOCK).round(1).tolist()),
        strip=[(name, [_moment(points, errors, name, i) for i in columns]) for name in paths],
        moments_s=[f"{replayed.time_s[i]:.2f} s" for i in columns],
        curves={
            name: _curve(replayed.time_s, one) for name, one in errors.items() if name != "truth"
        },
        ticks=[(f"{deg:g}°", _height(np.array(deg)).item()) for deg in (0.1, 1.0, 10.0, 100.0)],
        worst_deg={name: float(np.max(one)) for name, one in errors.items() if name != "truth"},
    )


def _drawn(path: Motor) -> FloatArray:
    """Whole pixels ``(N, 6, 2)`` of the camera's points."""
    world = path.rotor[..., None].apply(_CAMERA)
    return np.round(_projected(world)).astype(int)


def _projected(points: FloatArray) -> FloatArray:
    ahead = _EYE / np.linalg.norm(_EYE)
    right = np.cross(_UP, ahead)
    right /= np.linalg.norm(right)
    down = -np.cross(ahead, right)
    return _SIZE * np.stack([points @ right, points @ down], axis=-1)


def _passage(replayed: Replayed, errors: dict[str, FloatArray]) -> int:
    """Where the Euler angles go wrong most; where they were not run, where sight is most locked."""
    worst = errors.get("euler", errors.get("euler_unwrapped"))
    if worst is None:
        sight = replayed.true.rotor.apply(np.array([0.0, 0.0, 1.0]))
        return int(np.argmax(np.abs(sight[:, 0])))
    return int(np.argmax(worst))


def _columns(time_s: FloatArray, worst: int) -> list[int]:
    wanted = time_s[worst] + _APART_S * (np.arange(_MOMENTS) - _MOMENTS // 2)
    return [int(np.argmin(np.abs(time_s - one))) for one in wanted]


def _moment(
    points: dict[str, FloatArray], errors: dict[str, FloatArray], name: str, i: int
) -> dict[str, str]:
    return {
        "camera": _text(points[name][i]),
        "truth": _text(points["truth"][i]),
        "error": shown(errors[name][i], 2) + "°" if name != "truth" else "",
        "wrong": "wrong" if errors[name][i] > 5.0 else "",
    }


def _text(points: FloatArray) -> str:
    """Points as the script writes them: a path of sides, picture and mark."""
    p = [f"{x:g} {y:g}" for x, y in points]
    sides = "".join(f"M0 0L{corner}" for corner in p[:4])
    return f"{sides}M{p[0]}L{p[1]}L{p[2]}L{p[3]}ZM{p[0]}L{p[4]}L{p[1]}"


def _curve(time_s: FloatArray, errors_deg: FloatArray) -> str:
    x = _WIDTH * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    y = _height(errors_deg)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _height(degrees: FloatArray) -> FloatArray:
    """Logarithmic, within the picture."""
    logs = np.log(np.clip(degrees, _LOW_DEG, _HIGH_DEG) / _LOW_DEG)
    return np.asarray(_HEIGHT * (1.0 - logs / np.log(_HIGH_DEG / _LOW_DEG)))
