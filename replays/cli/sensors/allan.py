"""`motorcade allan`: noise of an IMU that stood still, from its Allan deviation."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorcade.replays.cli.arguments import Subparsers, new_command, print_json

if TYPE_CHECKING:
    from motorcade.fusion.imu import StreamNoise


def add_to(commands: Subparsers, shared: argparse.ArgumentParser) -> None:
    """Register the command."""
    parser = new_command(
        commands,
        shared,
        allan,
        name="allan",
        summary="noise densities and bias walks of an IMU that stood still, from its EuRoC CSV",
        example="motorcade allan static.csv --plot allan.svg",
    )
    parser.add_argument("stream", type=Path, metavar="STREAM")
    parser.add_argument("--json", action="store_true", help="machine-readable")
    parser.add_argument("--plot", type=Path, metavar="FILE.svg", help="draw the curves there")


def allan(arguments: argparse.Namespace) -> None:
    """Read the stream, estimate, print; draw where asked to."""
    from motorcade.fusion.imu import estimate_noise
    from motorcade.replays.files.imu import read_imu

    stream = read_imu(arguments.stream)
    found = estimate_noise(stream)
    if arguments.plot is not None:
        _draw(found, arguments.plot)
    if arguments.json:
        print_json({"duration_s": stream.duration_s, "rate_hz": stream.rate_hz} | _as_dict(found))
        return
    print(f"{stream.duration_s:.0f} s at {stream.rate_hz:.1f} Hz; each ± one standard deviation")
    print(f"{'':8}{'density':>26}{'walk of the bias':>26}{'flicker of the bias':>26}")
    for sensor, axes in (("gyro", found.gyro), ("accel", found.accel)):
        for name, axis in zip("xyz", axes, strict=True):
            values = (
                f"{value:.4g} ± {deviation:.1g}"
                for value, deviation in (
                    (axis.density, axis.density_deviation),
                    (axis.walk, axis.walk_deviation),
                    (axis.flicker, axis.flicker_deviation),
                )
            )
            print(f"{sensor:>6} {name}" + "".join(f"{value:>26}" for value in values))
    print("as Kalibr and EuRoC name them:")
    for name, value in _kalibr(found).items():
        print(f"{name}: {value:.6e}")


def _kalibr(found: StreamNoise) -> dict[str, float]:
    noise = found.noise
    return {
        "gyroscope_noise_density": noise.gyro_density_rad_s_rthz,
        "gyroscope_random_walk": noise.gyro_walk_rad_s2_rthz,
        "accelerometer_noise_density": noise.accel_density_m_s2_rthz,
        "accelerometer_random_walk": noise.accel_walk_m_s3_rthz,
    }


def _as_dict(found: StreamNoise) -> dict[str, Any]:
    described: dict[str, Any] = dict(_kalibr(found))
    for sensor, axes, units in (
        ("gyro", found.gyro, ("rad_s_rthz", "rad_s2_rthz", "rad_s")),
        ("accel", found.accel, ("m_s2_rthz", "m_s3_rthz", "m_s2")),
    ):
        for name, unit in zip(("density", "walk", "flicker"), units, strict=True):
            for suffix in ("", "_deviation"):
                key = f"{sensor}_{name}{suffix}_{unit}"
                described[key] = [getattr(axis, name + suffix) for axis in axes]
    return described


def _draw(found: StreamNoise, path: Path) -> None:
    import numpy as np

    from motorcade.render.plots import plot_allan, standing_alone
    from motorcade.replays.files.atomic import write_bytes

    curves = {}
    for name, curve, axes in (
        ("gyroscope", found.gyro_curve, found.gyro),
        ("accelerometer", found.accel_curve, found.accel),
    ):
        model = np.stack([axis.curve(curve.tau_s) for axis in axes], axis=-1)
        curves[name] = (curve.tau_s, curve.deviation, model)
    svg = plot_allan(curves, {"gyroscope": "rad/s", "accelerometer": "m/s²"})
    write_bytes(path, standing_alone(svg).encode())
