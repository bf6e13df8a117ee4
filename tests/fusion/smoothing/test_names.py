"""The one line that people come for: `fusion.smooth` is the function, and its room stays a room."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

import motorcade.fusion.smoothing.checks  # noqa: F401  (a module of the room does not displace it)
from motorcade import fusion
from motorcade.fusion import smooth
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.smoothing import METHODS
from motorcade.fusion.smoothing import smooth as from_the_room
from motorcade.ga import Trajectory


def test_smooth_is_the_function_wherever_it_is_imported_from() -> None:
    assert fusion.smooth is smooth is from_the_room
    assert pickle.loads(pickle.dumps(smooth)) is smooth
    path = MOTIONS["screw"].sampled(30.0, 1.0)
    assert len(fusion.smooth(path, method="gaussian", representation="motor")) == len(path)
    assert "gaussian" in METHODS


@pytest.mark.parametrize("method", METHODS)
def test_poses_in_single_precision_are_smoothed_in_double(method: str) -> None:
    path = MOTIONS["handheld"].sampled(30.0, 2.0)
    single = Trajectory(path.time_ns, path.poses.astype(np.float32))
    for representation in ("motor", "similarity", "euler_unwrapped"):
        found = smooth(single, method, representation)
        wide = Trajectory(path.time_ns, single.poses.astype(np.float64))
        apart = (
            found.poses.astype(np.float64).inverse() @ smooth(wide, method, representation).poses
        )
        assert np.abs(apart.as_twist()).max() < 1e-5


def test_the_room_is_light_to_import() -> None:
    code = (
        "import sys, motorcade.fusion; "
        "heavy = {'scipy', 'casadi', 'gtsam', 'cv2', 'matplotlib'} & set(sys.modules); "
        "sys.exit(f'imported {sorted(heavy)}' if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
