"""Text files in and out: trajectories, inertial streams, and writing that is never half done."""
