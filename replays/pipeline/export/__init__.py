"""Runs in other programs' formats: COLMAP's text model, nerfstudio's transforms, USD."""
