"""Versors from their parts and back: matrices, quaternions, Euler angles, rotors and translations.

What is given is checked on the way. The last component of such a kernel's output, ``off``, is no
less than what the numbers given are off by; where squares of them overflow it is not finite.
"""
