"""Readers and writers of characters: laws, witnesses, refusals, a fuzzing program."""
