"""The library's kernels, each defined once over multivectors; all compiled code is written from it.

`library` lists them. After an edit, ``python -m motorcade.ga.codegen`` writes the C and NumPy
kernels again. That needs CasADi and mpmath; using the kernels does not.
"""
