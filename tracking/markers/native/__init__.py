"""Finds quads in images, compiled from the C++ files beside this one."""
