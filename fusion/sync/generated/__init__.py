"""Code that `motorcade.fusion.sync.model` writes."""
