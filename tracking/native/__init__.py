"""Follows corners from picture to picture, compiled from the C++ files beside this one."""
