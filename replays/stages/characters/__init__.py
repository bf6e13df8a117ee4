"""Who stands in the footage and how they move: characters, casts, authored scenes."""
