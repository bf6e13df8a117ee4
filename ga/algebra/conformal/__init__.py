"""Conformal geometry of space in CGA3: objects, their meets, joins and measures, versors.

`objects` states the conventions (inner form, orientation, degenerate cases); `measure` reads
positions, radii and distances back; `versors` leads to Rotor, Motor and Similarity and back.

    >>> from motorcade.ga.algebra import conformal
    >>> ball = conformal.sphere([0.0, 0.0, 1.0], 2.0)
    >>> ground = conformal.plane([0.0, 0.0, 1.0], 0.0)
    >>> print(round(float(conformal.radius(conformal.meet(ball, ground))) ** 2, 6))
    3.0
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
