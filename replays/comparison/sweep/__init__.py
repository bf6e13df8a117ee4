"""Many runs at once: recordings times knobs times seeds, one table and one comparative report."""

from motorcade.replays.comparison.sweep.plan import PlannedRun, Sweep, read_sweep
from motorcade.replays.comparison.sweep.run import Summary, run_sweep

__all__ = ["PlannedRun", "Summary", "Sweep", "read_sweep", "run_sweep"]
