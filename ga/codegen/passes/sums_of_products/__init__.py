"""Passes that see nodes as sums of products (`forms`) and write these with fewer operations.

`expand` multiplies out where like terms join or cancel; `factor` takes out and shares common
factors; `divisions` shares reciprocals.
"""
