"""How far poses are from the truth: absolute, relative, and over lengths of path."""
