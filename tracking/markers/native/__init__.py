"""Finds quads in pictures, compiled from the C++ files beside this one."""
