"""Recordings in and out, the stage graph and pipeline, reports and the command line."""
