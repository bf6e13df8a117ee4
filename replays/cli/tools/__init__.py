"""Commands on the program and its machine: code generation, benchmarks, findings."""
