"""From symbolic definitions to code: tracer, tape, optimiser, and what writes the tape out.

`program` compiles CLUScripts and `functions` Python functions: `trace` runs them on CasADi symbols
and reads a `tape` of scalar operations, `passes` makes it shorter, `targets` writes it in a
language, and `strategies` writes it as other generators would. `kernel` says what one of the
library's own kernels is; ``python -m motorcade.ga.codegen`` writes these again with
`library_kernels`. Only this folder needs CasADi and mpmath; what it wrote does not.
"""
