"""Twelve everyday tasks with poses: the same text in this library, SciPy and pytransform3d.

    python -m tests.bench.algebra.everyday > docs/everyday.md

Each task is a few lines that leave `result`; all that are given must agree to 1e-9 before they are
timed, by the processor's clock, the least of seven rounds. What a library has no call for is said
so, and what is not installed is named. jaxlie, clifford and kingdon are measured where they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from types import CodeType
from typing import Any

import numpy as np

OWN, SCIPY, PYTRANSFORM = "motorcade", "scipy", "pytransform3d"
IMPORTS = {
    OWN: "from motorcade.ga import Motor",
    SCIPY: "from scipy.spatial.transform import RigidTransform, Rotation",
    PYTRANSFORM: "import pytransform3d.transformations as pt\nimport pytransform3d.rotations as pr",
}
OTHERS = ("jaxlie", "clifford", "kingdon")
GIVEN = """
from motorcade.ga import Motor
a, b = Motor.random(rng), Motor.random(rng)
A, B = a.as_matrix(), b.as_matrix()
many = Motor.random(rng, (1000,))
MANY = many.as_matrix()
points = rng.normal(size=(1000, 3))
q, t = a.as_quaternion_translation()
noisy = A.copy()
noisy[:3, :3] += 1e-3 * rng.normal(size=(3, 3))
"""
# What each library holds a pose in, before it is timed.
HELD = {
    OWN: "",
    SCIPY: "sa, sb = RigidTransform.from_matrix(A), RigidTransform.from_matrix(B)\n"
    "smany = RigidTransform.from_matrix(MANY)",
    PYTRANSFORM: "ones = np.c_[points, np.ones(len(points))]",
}


@dataclass(frozen=True)
class Task:
    """What is done, and the lines of each library; without lines it has no call for it."""

    what: str
    own: str
    scipy: str = ""
    pytransform3d: str = ""

    def ways(self) -> dict[str, str]:
        """Lines by library."""
        return {OWN: self.own, SCIPY: self.scipy, PYTRANSFORM: self.pytransform3d}


_SCIPY_POSE = (
    "RigidTransform.from_components(t, Rotation.from_quat(q, scalar_first=True)).as_matrix()"
)
TASKS = (
    Task(
        "a pose from quaternion and translation, as a matrix",
        "result = Motor.from_quaternion_translation(q, t).as_matrix()",
        f"result = {_SCIPY_POSE}",
        "result = pt.transform_from_pq(np.r_[t, q])",
    ),
    Task(
        "quaternion and translation of a matrix",
        "q2, t2 = Motor.from_matrix(A).as_quaternion_translation()\nresult = np.r_[t2, q2]",
        "pose = RigidTransform.from_matrix(A)\n"
        "q2 = pose.rotation.as_quat(canonical=True, scalar_first=True)\n"
        "result = np.r_[pose.translation, q2]",
        "result = pt.pq_from_transform(A)",
    ),
    Task(
        "one pose after another",
        "result = (a @ b).as_matrix()",
        "result = (sa * sb).as_matrix()",
        "result = pt.concat(B, A)",
    ),
    Task(
        "the way back",
        "result = a.inverse().as_matrix()",
        "result = sa.inv().as_matrix()",
        "result = pt.invert_transform(A)",
    ),
    Task(
        "one pose seen from another",
        "result = (a.inverse() @ b).as_matrix()",
        "result = (sa.inv() * sb).as_matrix()",
        "result = pt.concat(B, pt.invert_transform(A))",
    ),
    Task(
        "1,000 points moved",
        "result = a.apply(points)",
        "result = sa.apply(points)",
        "result = pt.transform(A, ones)[:, :3]",
    ),
    Task(
        "1,000 poses after one",
        "result = (a @ many).as_matrix()",
        "result = (sa * smany).as_matrix()",
        "result = np.array([pt.concat(pose, A) for pose in MANY])",
    ),
    Task(
        "a third of the way along the screw",
        "result = a.interpolate(b, 1/3).as_matrix()",
        "step = (sa.inv() * sb).as_exp_coords()\n"
        "result = (sa * RigidTransform.from_exp_coords(step / 3)).as_matrix()",
        "result = pt.transform_sclerp(A, B, 1/3)",
    ),
    Task(
        "the twist of a pose: rotation vector, then translation part",
        "result = a.as_twist()",
        "result = sa.as_exp_coords()",
        "result = pt.exponential_coordinates_from_transform(A)",
    ),
    Task(
        "a pose from its twist",
        "result = Motor.from_twist(a.as_twist()).as_matrix()",
        "result = RigidTransform.from_exp_coords(sa.as_exp_coords()).as_matrix()",
        "twist = pt.exponential_coordinates_from_transform(A)\n"
        "result = pt.transform_from_exponential_coordinates(twist)",
    ),
    Task(
        "the pose nearest to a noisy matrix",
        "result = Motor.nearest(noisy).as_matrix()",
        "result = RigidTransform.from_matrix(noisy).as_matrix()",
        "result = noisy.copy()\nu, _, v = np.linalg.svd(noisy[:3, :3])\nresult[:3, :3] = u @ v",
    ),
    Task(
        "the matrix that carries twists from the body to the world",
        "result = a.adjoint()",
        "",
        "result = pt.adjoint_from_transform(A)",
    ),
)


@dataclass(frozen=True)
class Row:
    """A task: lines and microseconds by library, and whether it agrees with ours."""

    what: str
    lines: dict[str, int]
    us: dict[str, float]
    apart: dict[str, float]


def measure(rounds: int = 7, calls: int = 200) -> tuple[list[Row], list[str]]:
    """All tasks in all libraries that are installed, and what was left out."""
    left_out = [name for name in OTHERS if not _installed(name)]
    libraries = [name for name in IMPORTS if name == OWN or _installed(name)]
    left_out += [name for name in IMPORTS if name not in libraries]
    shared: dict[str, Any] = {"np": np, "rng": np.random.default_rng(5)}
    exec(GIVEN, shared)
    rows = []
    for task in TASKS:
        lines, us, apart = {}, {}, {}
        expected: Any = None
        for library in libraries:
            text = task.ways()[library]
            if not text:
                continue
            names = dict(shared)
            exec(f"{IMPORTS[library]}\n{HELD[library]}", names)
            code = compile(text, library, "exec")
            exec(code, names)
            expected = names["result"] if library == OWN else expected
            apart[library] = _apart(names["result"], expected)
            lines[library] = text.count("\n") + 1
            us[library] = _least_us(code, names, rounds, calls)
        rows.append(Row(task.what, lines, us, apart))
    return rows, left_out


def _installed(name: str) -> bool:
    try:
        __import__(name)
    except ImportError:
        return False
    return True


def _apart(result: Any, expected: Any) -> float:
    """The largest difference; quaternions have two signs."""
    return float(min(np.abs(result - expected).max(), np.abs(_flipped(result) - expected).max()))


def _flipped(result: Any) -> Any:
    return np.r_[result[:3], -result[3:]] if np.shape(result) == (7,) else result


def _least_us(code: CodeType, names: dict[str, Any], rounds: int, calls: int) -> float:
    least = float("inf")
    for _ in range(rounds):
        start = process_time()
        for _ in range(calls):
            exec(code, names)
        least = min(least, (process_time() - start) / calls)
    return 1e6 * least


def page(rows: list[Row], left_out: list[str]) -> str:
    """The page: a table, then the lines of each task."""
    parts = [_INTRODUCTION, "| task | " + " | ".join(IMPORTS) + " |", "|---" * 4 + "|"]
    for row in rows:
        cells = [
            f"{row.us[name]:.1f} ({row.lines[name]})" if name in row.us else "–" for name in IMPORTS
        ]
        parts.append(f"| {row.what} | " + " | ".join(cells) + " |")
    parts.append(f"\nNot installed here: {', '.join(left_out) or 'nothing'}.\n\n## The lines")
    for task in TASKS:
        parts.append(f"\n**{task.what}**\n")
        for library, text in task.ways().items():
            shown = text or "# no call for it"
            parts.append(f"```text\n# {library}\n{shown}\n```")
    return "\n".join(parts) + "\n"


_INTRODUCTION = """# Twelve everyday tasks

Written by `python -m tests.bench.algebra.everyday`: microseconds of the processor a task, in one
run, and in brackets how many lines it takes. All results agree to 1e-9. Poses are what each library
holds them in: motors, `RigidTransform`, 4 × 4 matrices. Where ours is not the fastest, the nearest
pose of a noisy matrix, it checks its input and takes batches, which three lines of NumPy do not.
"""


if __name__ == "__main__":
    print(page(*measure()), end="")
