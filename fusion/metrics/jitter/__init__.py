"""How much a trajectory jitters: jitter, spectral energy, log dimensionless jerk."""
