"""A mark on fields of a stage's output that say how it came about, such as seconds."""

ASIDE = {"aside": True}
"""Metadata for `dataclasses.field`: the field is stored, but is not part of the value's content."""
