"""The synthetic room: the recording that `motorcade demo` runs on, rendered in code."""

from motorcade.replays.demo.recording import write_recording

__all__ = ["write_recording"]
