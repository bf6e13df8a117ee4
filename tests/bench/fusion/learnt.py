"""What noise that a flight's poses taught leaves of its consistency, over many draws of the poses.

`python -m tests.bench.fusion.learnt --seeds 10`: camera poses of recorded flights (20 Hz, 1 cm and
0.5° an axis, gaps of 2 s every 15 s); `learn_noise` from ten times the data sheet's white noise,
with the vertical and the camera's attitude estimated from 1°. NEES/6 of the smoothed path before
and after; over turns that were not learnt from, the log density of poses held out for 2 s and the
root mean square error of their positions. Constants were chosen on V1_02 and MH_05.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorcade.fusion.filter import FilterSettings, fuse, learn_noise
from motorcade.fusion.imu import ADIS16448
from motorcade.ga import Motor
from tests.bench.fusion.recorded import BLACKOUTS, Flight, flights_asked_for, measured, nees

__all__ = ["SHEET", "TILTED", "learnt_figures"]

SHEET = replace(
    ADIS16448,
    gyro_density_rad_s_rthz=10.0 * ADIS16448.gyro_density_rad_s_rthz,
    accel_density_m_s2_rthz=10.0 * ADIS16448.accel_density_m_s2_rthz,
)
TILTED = FilterSettings(
    gravity_sigma_rad=float(np.deg2rad(1.0)), extrinsics_sigma_rad=float(np.deg2rad(1.0))
)


def learnt_figures(one: Flight, seed: int) -> dict[str, float]:
    """Of one draw: NEES/6 before and after, and what changed of poses held out."""
    given = measured(one, seed, degraded=BLACKOUTS)
    found = learn_noise(given, one.imu, SHEET, Motor.identity(), settings=TILTED)
    assert found.before is not None
    assert found.after is not None
    made = {
        "learnt": float(found.learnt),
        "gain": 0.0,
        "error_ratio": 1.0,
    }
    if found.learnt:
        made["gain"] = found.after.held_out_log_density - found.before.held_out_log_density
        made["error_ratio"] = found.after.held_out_m / found.before.held_out_m
    for name, noise in (("before", SHEET), ("after", found.noise)):
        fused = fuse(given, one.imu, noise, Motor.identity(), settings=TILTED, fits_noise=False)
        made[f"nees_{name}"] = nees(one, fused)
    return made


def main() -> None:
    """Measure what is asked for, a line a draw and one a flight."""
    for one, seeds in flights_asked_for("tests.bench.fusion.learnt", 10):
        rows = []
        for seed in seeds:
            rows.append(learnt_figures(one, seed))
            print(f"{one.name}, seed {seed}: " + _line([rows[-1]]), flush=True)
        print(f"{one.name}, {len(rows)} seeds: " + _line(rows), flush=True)


def _line(rows: list[dict[str, float]]) -> str:
    def span(key: str, unit: float = 1.0) -> str:
        values = [unit * row[key] for row in rows]
        if len(values) == 1:
            return f"{values[0]:.2f}"
        return f"{np.mean(values):.2f} ({min(values):.2f} to {max(values):.2f})"

    return (
        f"NEES/6 {span('nees_before')}, learnt {span('nees_after')}; held out: log density "
        f"{span('gain')} more, error {span('error_ratio')} times; "
        f"learnt in {sum(row['learnt'] for row in rows):.0f} of {len(rows)}"
    )


if __name__ == "__main__":
    main()
