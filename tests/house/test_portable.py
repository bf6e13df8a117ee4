"""What needs NumPy alone also imports and works where Python has no POSIX, as on Windows."""

import subprocess
import sys
from pathlib import Path

# The libraries are imported first, as themselves; then our own modules anew, bar the compiled ones,
# in an interpreter that lacks what Windows lacks.
CODE = """
import os, sys
from pathlib import Path
import motorcade.replays.cli
import motorcade.fusion
from motorcade.replays import read_trajectory, write_trajectory

for name in [one for one in sys.modules if one.startswith("motorcade")]:
    if not str(getattr(sys.modules[name], "__file__", "")).endswith((".so", ".pyd")):
        del sys.modules[name]
sys.modules.update(dict.fromkeys(("fcntl", "resource", "pwd", "grp", "termios"), None))
for name in ("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC", "uname", "fork"):
    delattr(os, name)
sys.platform = "win32"

from motorcade.ga.unfinished import locked, try_lock
from motorcade.fusion import LiveSmoother
from motorcade.replays.cli import main
import motorcade.animation.formats.fbx, motorcade.animation.formats.gltf

with locked(Path(".")) as ours:
    assert not ours
assert try_lock(0) is None
LiveSmoother().update(0.0, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
sys.exit(main(["smooth", "poses.tum", "-o", "smooth.tum"]))
"""


def test_the_core_works_without_posix(tmp_path: Path) -> None:
    rows = [f"{0.1 * k:.1f} {0.01 * k:.2f} 0 0 0 0 0 1" for k in range(40)]
    (tmp_path / "poses.tum").write_text("\n".join(rows) + "\n")
    command = [sys.executable, "-c", CODE]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    # a straight line is its own smoothed path
    last = (tmp_path / "smooth.tum").read_text().splitlines()[-1].split()
    assert abs(float(last[1]) - 0.39) < 1e-6
    assert [path.name for path in tmp_path.glob(".unfinished-*")] == []
