"""The synthetic room: the recording that `motorcade demo` runs on, rendered in code."""

from motorcade.replays.demo.recording import (
    CAMERA,
    FRAMES,
    IMU_T_CAMERA,
    exposed,
    manifest,
    truth,
    write_recording,
)

__all__ = ["CAMERA", "FRAMES", "IMU_T_CAMERA", "exposed", "manifest", "truth", "write_recording"]
