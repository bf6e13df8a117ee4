"""Numbers far out of range are refused in one line, never by an overflow or for want of memory."""

from contextlib import suppress
from dataclasses import fields, replace

import numpy as np
import pytest

from motorcade.fusion import (
    ADIS16448,
    ContinuousPath,
    differentiated,
    evaluate,
    fuse,
    preintegrate,
    simulate_camera_poses,
    simulate_imu,
    smooth,
)
from motorcade.fusion.filter import FilterSettings
from motorcade.fusion.imu import ImuFaults, ImuNoise
from motorcade.fusion.metrics import angular_rate_lag_s, associate, jitter_above, position_lag_s
from motorcade.fusion.motions import MOTIONS, handheld
from motorcade.fusion.motions.degradations import (
    Blackouts,
    DroppedFrames,
    Gaussian,
    Latency,
    Outliers,
    StampJitter,
)
from motorcade.fusion.motions.motion import even_stamps
from motorcade.fusion.smoothing import METHODS, method_parameters
from motorcade.ga import CumulativeBSpline, Motor

NUMBERS = (1e300, 1e-300, 1e30, 1e18, 1e-9, 0.0, -1.0, np.inf, np.nan, -1e300)
PATH = MOTIONS["handheld"].sampled(30.0, 2.0)
NOISY = Gaussian(0.005, 0.01).apply(PATH, np.random.default_rng(0))
RNG = np.random.default_rng(1)
SENSOR = simulate_imu(ContinuousPath.along(handheld(RNG), 2.0), 100.0, ADIS16448, RNG)
MEASURED = simulate_camera_poses(SENSOR.path, 20.0, 0.01, 0.01, RNG)
KEYS = SENSOR.stream.time_ns[[0, 50, 100]]


def fused(**given):
    return fuse(MEASURED, SENSOR.stream, ADIS16448, Motor.identity(), **given)


def degraded(kind, **given):
    return kind(**given).apply(PATH, np.random.default_rng(0))


CALLS = {
    **{
        f"smooth {method} {name}": lambda x, m=method, n=name: smooth(NOISY, m, **{n: x})
        for method in METHODS
        for name, default in method_parameters(method).items()
        if isinstance(default, int | float)
    },
    **{
        f"FilterSettings.{one.name}": lambda x, n=one.name: fused(settings=FilterSettings(**{n: x}))
        for one in fields(FilterSettings)
        if one.name != "rest"
    },
    **{
        f"ImuNoise.{one.name}": lambda x, n=one.name: preintegrate(
            SENSOR.stream, KEYS, replace(ADIS16448, **{n: x})
        )
        for one in fields(ImuNoise)
    },
    **{
        f"ImuFaults.{one.name}": lambda x, n=one.name: simulate_imu(
            PATH, 100.0, None, np.random.default_rng(0), faults=ImuFaults(**{n: x})
        )
        for one in fields(ImuFaults)
    },
    **{
        f"simulate_imu {name}": lambda x, n=name: simulate_imu(
            PATH, **({"rate_hz": 100.0, "noise": None, "rng": np.random.default_rng(0)} | {n: x})
        )
        for name in ("rate_hz", "gravity_m_s2", "knot_spacing_s", "time_offset_s")
    },
    **{
        f"simulate_camera_poses {n}": lambda x, n=n: simulate_camera_poses(
            PATH,
            **(
                {"rate_hz": 20.0, "sigma_m": 0.1, "sigma_rad": 0.1, "rng": np.random.default_rng(0)}
                | {n: x}
            ),
        )
        for n in ("rate_hz", "sigma_m", "sigma_rad")
    },
    **{
        f"evaluate {name}": lambda x, n=name: evaluate(NOISY, PATH, **{n: x})
        for name in ("max_difference_s", "rpe_length_m", "energy_above_hz")
    },
    "at_rate": PATH.at_rate,
    "knots": lambda x: CumulativeBSpline.fit(PATH, x),
    "even_stamps rate": lambda x: even_stamps(x, 1.0),
    "even_stamps duration": lambda x: even_stamps(10.0, x),
    "stop_and_go": MOTIONS["stop_and_go"].at,
    "jitter_above": lambda x: jitter_above(NOISY, x),
    "associate": lambda x: associate(NOISY, PATH, x),
    "position_lag_s": lambda x: position_lag_s(NOISY, PATH, x),
    "angular_rate_lag_s": lambda x: angular_rate_lag_s(NOISY, PATH, x),
    "differentiated": lambda x: differentiated(NOISY, x),
    "fuse time_offset_s": lambda x: fused(time_offset_s=x),
    "preintegrate gyro": lambda x: preintegrate(SENSOR.stream, KEYS, ADIS16448, (x, 0.0, 0.0)),
    "preintegrate accel": lambda x: preintegrate(
        SENSOR.stream, KEYS, ADIS16448, accel_bias_m_s2=(x, 0.0, 0.0)
    ),
    "Blackouts.spans_s": lambda x: Blackouts(1.0, 4.0).spans_s(x),
    "StampJitter": lambda x: degraded(StampJitter, sigma_s=x),
    "Latency": lambda x: degraded(Latency, delay_s=x),
    "Latency spread": lambda x: degraded(Latency, delay_s=0.01, spread_s=x),
    "Blackouts": lambda x: degraded(Blackouts, length_s=x, every_s=4.0),
    "Blackouts every": lambda x: degraded(Blackouts, length_s=1.0, every_s=x),
    "Outliers": lambda x: degraded(Outliers, share=x, scale_m=0.1, scale_rad=0.1),
    "Outliers scale": lambda x: degraded(Outliers, share=0.1, scale_m=x, scale_rad=0.1),
    "DroppedFrames": lambda x: degraded(DroppedFrames, share=0.2, mean_run=x),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("call", CALLS)
def test_whatever_the_number_there_is_a_result_or_a_refusal(call):
    for number in NUMBERS:
        with suppress(ValueError):
            CALLS[call](number)
