"""A board tracked through a recording: corners from frame to frame, poses chosen, path kept."""
