"""Commands on trajectories: smoothing, editing, errors, comparison, consistency."""
