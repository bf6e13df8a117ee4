"""Commands on trajectories: smoothing, errors, comparison, consistency."""
