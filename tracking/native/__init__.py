"""Corners followed from image to image, and equations of what is seen: the C++ beside this."""
