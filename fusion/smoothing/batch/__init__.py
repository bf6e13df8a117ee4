"""Smoothers that see the whole path at once: least-squares splines and robust estimation."""
