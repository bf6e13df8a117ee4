"""Random scripts in six algebras against the library clifford: `python -m tests.ga.programs`."""
