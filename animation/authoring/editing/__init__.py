"""Scenes edited: drags, edits, a history of steps, and the files that say what was done."""
