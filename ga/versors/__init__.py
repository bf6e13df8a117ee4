"""Versor types: rotations, rigid motions, motions with dilation; one set of verbs."""
