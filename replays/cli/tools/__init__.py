"""Commands on the program and its machine: code generation, and what the machine has."""
