"""What this machine has and lacks: kernels, compiler, OpenGL, video, optional packages."""

from motorcade.replays.doctor.findings import Finding
from motorcade.replays.doctor.machine import examine

__all__ = ["Finding", "examine"]
