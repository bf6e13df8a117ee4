"""Passes over tapes: fewer operations, the same values."""
