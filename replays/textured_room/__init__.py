"""A textured room drawn as a depth camera or a stereo pair sees it, with exact truth.

Where `synthetic_room` shows a board to a colour camera, this one is for tracking without boards:
grey pictures, depth, and the right picture of a rectified pair along any path. It is drawn by warps
of flat panels, without OpenGL, fast enough to be drawn where it is used.
"""

from motorcade.replays.textured_room.inertial import IMU_T_CAMERA, simulated_imu
from motorcade.replays.textured_room.paths import handheld, loop, turning
from motorcade.replays.textured_room.recording import write_recording
from motorcade.replays.textured_room.renderer import Renderer, Sensor, View
from motorcade.replays.textured_room.scenarios import SCENARIOS, Scenario, scenario
from motorcade.replays.textured_room.scene import Panel, Room, furnished_room

__all__ = [
    "IMU_T_CAMERA",
    "SCENARIOS",
    "Panel",
    "Renderer",
    "Room",
    "Scenario",
    "Sensor",
    "View",
    "furnished_room",
    "handheld",
    "loop",
    "scenario",
    "simulated_imu",
    "turning",
    "write_recording",
]
