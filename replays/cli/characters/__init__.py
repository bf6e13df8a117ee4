"""Commands on characters and scenes."""
