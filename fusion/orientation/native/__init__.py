"""The orientation filter, compiled from the C++ headers beside this file."""
