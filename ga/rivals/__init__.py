"""What motors are compared with: plain array code for quaternions, dual quaternions, Euler angles.

None of it is built on the versors of this room; the one thing shared is the check of inputs.
"""
