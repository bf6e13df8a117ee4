"""What objects look like: `reading` finds the `shape` of a multivector, a versor or points."""
