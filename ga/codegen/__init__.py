"""From one symbolic definition to C and NumPy code: tracer, tape and emitters.

`kernel.Kernel` says what a kernel takes and gives, `trace` turns its definition into a `tape.Tape`
by way of CasADi, `emit_c` and `emit_numpy` print the tape. ``python -m motorcade.ga.codegen``
writes the library's own kernels again. Only this folder needs CasADi and mpmath; the kernels that
it wrote do not.
"""
