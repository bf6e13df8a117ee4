"""Kernels of the algebra: speed beside GLM and other libraries, Table 3, accuracy."""
