"""The sequential scans of the causal filters, compiled from the C++ headers beside this file."""
