"""Versor types: rotations and rigid motions with one set of verbs."""
