"""Corners followed from picture to picture, and equations of what is seen: the C++ beside this."""
