"""The suites of `motorcade bench` and how their figures are printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from motorcade.replays.bench.blend import SIZES, bench_blend

__all__ = ["SUITES", "accuracy_table", "blend_table", "measure_accuracy"]


def blend_table(found: Mapping[str, Any]) -> str:
    """Nanoseconds a joint, a row a method and precision; floors, Python calls, what is missing."""
    sizes = "".join(f"{size:>10}" for size in SIZES)
    lines = [f"{'ns a joint, one core, to 3x4 matrices':<38}{sizes}"]
    for scalar in ("float32", "float64"):
        methods = dict.fromkeys(row["method"] for row in found["rows"])
        for method in methods:
            ns = {
                row["joints"]: row["ns"]
                for row in found["rows"]
                if (row["method"], row["scalar"]) == (method, scalar)
            }
            cells = "".join(f"{ns[size]:>10.2f}" for size in SIZES)
            lines.append(f"{method + ', ' + scalar:<38}{cells}")
        floors = {row["joints"]: row for row in found["floors"] if row["scalar"] == scalar}
        if floors:
            cells = "".join(f"{floors[size]['memory_ns']:>10.2f}" for size in SIZES)
            lines.append(f"{'memory floor, ' + scalar:<38}{cells}")
            gflops = max(row["gflops"] for row in floors.values())
            lines.append(f"{'arithmetic, ' + scalar:<38}{gflops:>10.0f} GFLOP/s")
    lines += ["", "times as fast as GLM (the linear blend: nlerp + mix; the screw: slerp + mix)"]
    rivals = {"motor linear": "over_nlerp_mix", "motor screw": "over_slerp_mix"}
    for row in found["rows"]:
        factor = row.get(rivals.get(row["method"], ""))
        if factor is not None:
            name = f"{row['method']}, {row['scalar']}, {row['joints']} joints"
            lines.append(f"{name:<38}{factor:>10.2f}")
    lines += ["", "called from Python, 54 joints where no other number stands: µs a call"]
    lines += [f"{name:<38}{us:>10.2f}" for name, us in found["python"].items()]
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)


def measure_accuracy() -> dict[str, dict[str, float]]:
    """Largest normwise error of every kernel over hard samples, by precision."""
    from motorcade.ga.kernels.accuracy import largest_errors
    from motorcade.ga.kernels.similarity_accuracy import similarity_errors

    return {
        dtype: largest_errors(dtype) | similarity_errors(dtype) for dtype in ("float32", "float64")
    }


def accuracy_table(found: Mapping[str, Mapping[str, float]]) -> str:
    """The largest errors, a row a kernel."""
    precisions = list(found)
    lines = [
        f"{'largest normwise error to 50 digits':<38}" + "".join(f"{p:>12}" for p in precisions)
    ]
    for name in found[precisions[0]]:
        lines.append(f"{name:<38}" + "".join(f"{found[p][name]:>12.2g}" for p in precisions))
    return "\n".join(lines)


def measure_table3() -> dict[str, Any]:
    """The paper's Table 3 again; writes and compiles C, for which CasADi is needed."""
    from motorcade.replays.bench.table3.measure import bench_table3

    return bench_table3()


def print_table3(found: Mapping[str, Any]) -> str:
    """Our figures beside the paper's."""
    from motorcade.replays.bench.table3.report import table3_table

    return table3_table(found)


def _bench_smooth() -> Any:
    from motorcade.replays.bench.smooth import bench_smooth

    return bench_smooth()


def _smooth_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.smooth import smooth_table

    return smooth_table(found)


def _bench_lag() -> Any:
    from motorcade.replays.bench.lag import bench_lag

    return bench_lag()


def _lag_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.lag import lag_table

    return lag_table(found)


def _bench_tracking() -> Any:
    from motorcade.replays.bench.tracking import bench_tracking

    return bench_tracking()


def _tracking_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.tracking import tracking_table

    return tracking_table(found)


def _bench_slam() -> Any:
    from motorcade.replays.bench.slam import bench_slam

    return bench_slam()


def _slam_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.slam import slam_table

    return slam_table(found)


def _bench_animation() -> Any:
    from motorcade.replays.bench.animation import bench_animation

    return bench_animation()


def _animation_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.animation import animation_table

    return animation_table(found)


def _bench_fusion() -> Any:
    from motorcade.replays.bench.fusion import bench_fusion

    return bench_fusion()


def _fusion_table(found: Mapping[str, Any]) -> str:
    from motorcade.replays.bench.fusion import fusion_table

    return fusion_table(found)


SUITES: Mapping[str, tuple[Callable[[], Any], Callable[[Any], str]]] = {
    "blend": (bench_blend, blend_table),
    "accuracy": (measure_accuracy, accuracy_table),
    "table3": (measure_table3, print_table3),
    "smooth": (_bench_smooth, _smooth_table),
    "lag": (_bench_lag, _lag_table),
    "slam": (_bench_slam, _slam_table),
    "fusion": (_bench_fusion, _fusion_table),
    "tracking": (_bench_tracking, _tracking_table),
    "animation": (_bench_animation, _animation_table),
}
"""Every suite by name: what measures it, and what prints it."""
