"""Errors of poses against ground truth: pairs, alignment, projection, absolute and relative."""
