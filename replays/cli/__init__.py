"""The command line: parses, calls one library function a command, and answers in one line.

Exit status: 0 done, 2 bad usage, 1 a job that failed (what, where, and what to do about it).
"""

from motorcade.replays.cli.main import main

__all__ = ["main"]
