"""The stages of the pipeline: typed functions that can be called alone.

A stage's file is named after it (`STAGES` in `pipeline/job.py`); the other files help one of them.
"""
