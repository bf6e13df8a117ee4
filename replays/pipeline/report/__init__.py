"""The error report: a dictionary with units in its keys, and one self-contained page."""
