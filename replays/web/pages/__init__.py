"""The house style of pages: one frame, style and script for every report, each page one file."""

from motorcade.replays.web.pages.parts import page_environment

__all__ = ["page_environment"]
