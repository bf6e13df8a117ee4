"""What several targets share: statements, branches, text, and C and Python around statements."""
