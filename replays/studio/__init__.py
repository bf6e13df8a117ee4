"""A run looked at in the browser, and a scene authored there."""
