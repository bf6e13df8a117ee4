"""How the filter recovered from a wrong start."""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.ga.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Convergence:
    """Tilt error ``(N,)`` in degrees over seconds after a start `initial_tilt_deg` wrong.

    `settled_s` is when it falls below a tenth of the start for good, None if it never does;
    `judged_by` names what the tilt was compared with. There are no errors where no filter ran.
    """

    initial_tilt_deg: float
    time_s: FloatArray
    tilt_error_deg: FloatArray
    settled_s: float | None
    judged_by: str
