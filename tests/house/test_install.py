"""The README's first line takes the wheel that fits this Python, and says what it does."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / ".ci" / "install"

if not SCRIPT.exists():
    pytest.skip("no script here: an installed wheel is tested", allow_module_level=True)


@pytest.mark.slow
@pytest.mark.parametrize("wheel", [True, False])
def test_a_wheel_is_taken_where_one_lies_in_dist(wheel: bool, tmp_path: Path) -> None:
    (tmp_path / ".ci").mkdir()
    (tmp_path / "dist").mkdir()
    shutil.copy(SCRIPT, tmp_path / ".ci")
    minor = sys.version_info.minor
    names = [f"motorcade-9.9-cp3{minor}-cp3{minor}-linux_x86_64.whl"] if wheel else []
    for name in (*names, "motorcade-9.9-cp27-cp27m-linux_x86_64.whl"):
        (tmp_path / "dist" / name).touch()  # empty: pip refuses what is chosen
    (tmp_path / "constraints.txt").touch()
    done = subprocess.run(
        [sys.executable, tmp_path / ".ci" / "install"], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    chosen = f"dist/{names[0]}" if wheel else "."
    assert done.stdout.startswith(f"installing {chosen} with [pipeline]: ")
