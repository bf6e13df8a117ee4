"""Recordings of which nothing was told: what their files and images tell, written as a manifest.

A recording whose camera is known needs none of this. Of any other, targets are looked for, the
camera is found by them or by the motion, telemetry is taken up where its axes are known, and the
manifest that says all this is what the run then reads: giving it again repeats the run.
"""

from __future__ import annotations
