"""Recordings and files in and out: readers, trajectories, inertial streams, atomic writing.

The lowest part of this room: it imports no other. `recording` is what readers give, `files` how
files of others are opened, and refused.
"""
