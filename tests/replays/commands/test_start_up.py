"""What a command imports before it does anything: arguments are parsed without the rooms."""

import json
import subprocess
import sys
from pathlib import Path

CLI = "motorcade.replays.cli"
HELP = {
    "lazy_loader",
    "motorcade",
    "motorcade.replays",
    CLI,
    *(
        f"{CLI}.{name}"
        for name in (
            "arguments",
            "cameras",
            "evaluation",
            "fusion",
            "imu",
            "inspection",
            "main",
            "runs",
            "tools",
            "trajectories",
        )
    ),
}
"""All modules but Python's own that `motorcade --help` imports."""
SMOOTH = {"lazy_loader", "motorcade", "numpy"}
"""Top-level names likewise of `motorcade smooth` on a file of poses."""
INSIDE_NUMPY = {"__mp_main__", "_cython_3_2_4", "cython_runtime"}
RUN = """
import json, sys
before = set(sys.modules)
from motorcade.replays.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
new = set(sys.modules) - before
print()
print(json.dumps([name for name in new if name.split(".")[0] not in sys.stdlib_module_names]))
"""


def imported(*words: str) -> set[str]:
    """Modules that a command imports, Python's own left out."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words], capture_output=True, text=True, check=True
    )
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_help_imports_the_parsers_alone() -> None:
    assert imported("--help") == HELP


def test_a_few_poses_are_smoothed_with_numpy_alone(tmp_path: Path) -> None:
    poses = tmp_path / "poses.tum"
    rows = (f"{k / 30:.6f} {0.01 * k:.6f} {0.1 * (k % 3):.6f} 0 0 0 0 1" for k in range(100))
    poses.write_text("\n".join(rows) + "\n")
    names = imported("smooth", str(poses), "-o", str(tmp_path / "smooth.tum"))
    assert {name.partition(".")[0] for name in names} - INSIDE_NUMPY == SMOOTH
    assert (tmp_path / "smooth.tum").is_file()
