"""How much a trajectory shakes: jitter, spectral energy, log dimensionless jerk."""
