"""The paper's Table 3, and what can be said about it from its own figures."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "CHARACTERS",
    "COUNTERPARTS",
    "PAPER_MS",
    "Overhead",
    "overheads_ms",
    "paper_ns",
    "paper_ratio",
]

CHARACTERS = ("Character 1", "Character 2", "Character 3")
_JOINTS = 43
# Milliseconds a character, by the paper's names; "Versor" is libvsr.
PAPER_MS = {
    "Quaternions": (0.00044, 0.00179, 0.00108),
    "Dual-Quaternions": (0.00024, 0.0016, 0.00092),
    "GA Gaigen": (0.00131, 0.00250, 0.00162),
    "CGA Gaigen": (0.00182, 0.00289, 0.00229),
    "GA Gaalop": (0.00155, 0.00282, 0.00201),
    "CGA Gaalop": (0.00034, 0.00177, 0.00115),
    "GA Versor": (0.00076, 0.00201, 0.00157),
    "CGA Versor": (0.00085, 0.00209, 0.00174),
}
# Which of our methods does what a row of the paper does. Its CGA blends go through the logarithm
# with Gaigen and libvsr, and are linear with Gaalop alone.
COUNTERPARTS = {
    "quaternion": "Quaternions",
    "dual_quaternion": "Dual-Quaternions",
    "rotor_table_code": "GA Gaigen",
    "rotor_product": "GA Versor",
    "rotor_program": "GA Gaalop",
    "motor_table_code": "CGA Gaigen",
    "motor_product": "CGA Versor",
    "motor_linear_program": "CGA Gaalop",
}


@dataclass(frozen=True)
class Overhead:
    """What a character costs more than the first one, over all rows: least and most."""

    character: str
    least_ms: float
    most_ms: float


def paper_ns(row: str) -> float:
    """Nanoseconds a joint on the first character."""
    return 1e6 * PAPER_MS[row][0] / _JOINTS


def paper_ratio(row: str) -> float:
    """Times as long as dual quaternions on the first character."""
    return PAPER_MS[row][0] / PAPER_MS["Dual-Quaternions"][0]


def overheads_ms() -> list[Overhead]:
    """What the second and the third character cost more than the first one."""
    made = []
    for k, name in enumerate(CHARACTERS[1:], 1):
        more = [row[k] - row[0] for row in PAPER_MS.values()]
        made.append(Overhead(name, min(more), max(more)))
    return made
