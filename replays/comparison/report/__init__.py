"""The comparison's report: `report.html`, a page a motion, and nothing they need beside them.

Every figure and every sentence is computed from ``results.json`` and ``groups.csv``; the paths that
are drawn are smoothed again, with the parameters that were found, on the first test seed.
"""
