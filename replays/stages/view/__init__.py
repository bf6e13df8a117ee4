"""Stages of the augmented view: the ground, who stands on it, and the video."""
