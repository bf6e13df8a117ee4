"""The library's own kernels: their C and NumPy code, and what only their definitions need.

A `kernel` has a name and a definition; `library` writes the files with `emit_c`, `emit_numpy` and
`emit_glsl`.
Definitions approximate with `fit` and scale with `powers_of_two`; as they are written with their
operations in mind, `like_terms` is all that is simplified.
"""
