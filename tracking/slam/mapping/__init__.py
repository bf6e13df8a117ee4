"""The map of visual SLAM, and all that makes it larger and better: keyframes, adjustment, loops."""
