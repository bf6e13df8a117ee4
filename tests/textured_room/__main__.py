"""`python -m tests.textured_room SCENARIO FOLDER`: draw a recording for tracking."""

from __future__ import annotations

import argparse
from pathlib import Path

from motorcade.ga.progress import track
from tests.textured_room.recording import write_recording
from tests.textured_room.scenarios import SCENARIOS, scenario


def main() -> None:
    """Draw one scenario."""
    parser = argparse.ArgumentParser(prog="python -m tests.textured_room")
    parser.add_argument("scenario", choices=tuple(SCENARIOS))
    parser.add_argument("folder", type=Path, help="made where it is missing; it must be empty")
    parser.add_argument("--seed", type=int, default=0, help="of textures and noise (0)")
    parser.add_argument("--frames", type=int, help="(the scenario's own)")
    parser.add_argument("--imu", action="store_true", help="carry an IMU along (200 Hz, EuRoC's)")
    arguments = parser.parse_args()
    chosen = scenario(arguments.scenario, seed=arguments.seed, frames=arguments.frames)
    name = f"textured room, {arguments.scenario}"
    write_recording(arguments.folder, chosen, name=name, imu=arguments.imu, progress=track)


if __name__ == "__main__":
    main()
