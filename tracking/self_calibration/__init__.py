"""Self-calibration: the camera of a clip from what the clip shows.

From a board of known layout or markers of unknown layout and size (`boards`), or from corners
tracked through a textured scene (`motion`). Lengths need not be known for any of them.
"""
