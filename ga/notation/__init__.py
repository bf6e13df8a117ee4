"""How sums of blades are written: `plain` for terminals, `formulas` as LaTeX, `pages` as HTML.

They take pairs of a blade's name and its coefficient, and import nothing of ours, so that
multivectors and versors can show themselves by them.
"""

from __future__ import annotations
