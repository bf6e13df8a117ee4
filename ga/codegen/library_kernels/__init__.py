"""The library's own kernels: their C and NumPy code, and what only their definitions need.

A `kernel` has a name and a definition; ``python -m motorcade.ga.codegen`` writes the files.
scale with `powers_of_two`; as they are written with their operations in mind, adding up like terms
is all that is simplified.
"""
