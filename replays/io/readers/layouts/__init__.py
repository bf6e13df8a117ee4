"""Folders in a layout that others know: one module a layout, and telling which one a folder has."""
