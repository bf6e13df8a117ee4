"""What the augmented picture is worth, in bytes, pixels and seconds: `motorcade bench view`."""
