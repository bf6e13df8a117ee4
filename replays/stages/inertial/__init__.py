"""Stages around the inertial stream: read or simulated, and fused with the poses."""
