"""Smoothers of paths: speed, memory and lag, beside other libraries."""
