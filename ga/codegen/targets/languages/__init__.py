"""Languages that take a program as one function of scalars, beside C, GLSL and Python.

Each module has ``write(program, precision)`` as the targets above it. `words` holds what the
languages keep for themselves, `typed` makes true and false of a tape's conditions.
"""
