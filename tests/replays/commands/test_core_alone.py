"""What works with NumPy alone, as `pip install .` leaves it: help, doctor, smoothing."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.trajectories import read_trajectory, write_trajectory
from motorcade.replays.tasks.doctor import OPTIONAL

MODULES = sorted({module for packages in OPTIONAL.values() for module, _ in packages.values()})
CODE = (
    "import sys; sys.modules.update(dict.fromkeys(sys.argv.pop(1).split())); "
    "from motorcade.replays.cli import main; sys.exit(main())"
)


def core(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The command where no optional package can be imported."""
    command = [sys.executable, "-c", CODE, " ".join(MODULES), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_doctor_looks_and_help_helps() -> None:
    assert {"cv2", "scipy", "casadi", "matplotlib"} <= set(MODULES)
    assert core("--help").returncode == 0
    looked = core("doctor", "--json")
    assert looked.returncode == 0, looked.stderr
    told = json.loads(looked.stdout)
    assert told["works"]
    lacking = {one["name"] for one in told["findings"] if not one["works"]}
    assert {"opencv-contrib-python-headless", "H.264", "scipy", "casadi"} <= lacking
    opengl = {one["name"] for one in told["findings"] if one["group"] == "OpenGL"}
    assert opengl == {"EGL", "OSMesa"}, "looked for by NumPy and the system's libraries alone"


def test_the_room_lists_what_needs_no_more_than_numpy() -> None:
    code = (
        "import sys; sys.modules.update(dict.fromkeys(sys.argv.pop(1).split())); "
        "from motorcade.replays import Graph, read_trajectory, write_trajectory"
    )
    subprocess.run([sys.executable, "-c", code, " ".join(MODULES)], check=True)


def test_auto_smooths_runs_of_wrong_poses_too(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    truth = MOTIONS["screw"].sampled(30.0, 5.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, rng)
    write_trajectory(noisy, tmp_path / "noisy.tum")
    coefficients = noisy.motors.coefficients.copy()
    aside = Motor.from_translation([0.5, 0.0, 0.0])
    coefficients[60:68] = (aside @ noisy.motors[60:68]).coefficients
    thrown = Trajectory(noisy.time_ns, Motor(coefficients), noisy.parent, noisy.child)
    write_trajectory(thrown, tmp_path / "degraded.tum")
    for name in ("noisy", "degraded"):
        done = core("smooth", tmp_path / f"{name}.tum", "-o", tmp_path / "out.tum")
        assert done.returncode == 0, done.stderr
        assert done.stdout.startswith("auto: splines on ")
        assert not done.stderr
        assert len(read_trajectory(tmp_path / "out.tum")) == len(truth)


def test_what_cannot_run_names_the_package_and_the_extra(tmp_path: Path) -> None:
    path = tmp_path / "path.tum"
    write_trajectory(MOTIONS["screw"].sampled(30.0, 2.0), path)
    done = core("evaluate", path, path)
    assert done.returncode == 1
    assert "needs the Python package 'scipy', which is not installed" in done.stderr
    assert 'pip install "motorcade[pipeline]"' in done.stderr
