"""Rotors, motors and similarities as multivectors of CGA3, and back.

Their coefficients stay what they are; only ``e31 = -e1∧e3`` changes its sign. With
``E = e0∧e∞`` the products ``e23 E`` and so on are basis blades. ``of_versor(m).sandwich(p)`` moves
an object as ``m.apply`` moves a point. A similarity's sandwich also divides the weight of a
point by its scale.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from motorcade.ga.algebra.algebra import CGA3
from motorcade.ga.algebra.multivector import Multivector
from motorcade.ga.algebra.scalars import is_numeric
from motorcade.ga.versors.motor import Motor
from motorcade.ga.versors.rotor import Rotor
from motorcade.ga.versors.similarity import Similarity
from motorcade.ga.versors.versor import Versor

V = TypeVar("V", bound=Versor)

_ROTOR = ("1", "e2^e3", "e3^e1", "e1^e2")
_GROWTH = ("e0^einf", "e2^e3^e0^einf", "e3^e1^e0^einf", "e1^e2^e0^einf")
_MOVED = ("e1^einf", "e2^einf", "e3^einf", "e1^e2^e3^einf")
_BLADES: dict[type[Versor], tuple[str, ...]] = {
    Rotor: _ROTOR,
    Motor: (*_ROTOR, *_MOVED),
    Similarity: (*_ROTOR, *_GROWTH, *_MOVED),
}


def of_versor(versor: Versor) -> Multivector:
    """The multivector of a rotor, motor or similarity ``(*)``, coefficients over its batch.

    Raises:
        ValueError: another type.
    """
    names = _BLADES.get(type(versor))
    if names is None:
        raise ValueError(
            f"of_versor(versor): expected a Rotor, Motor or Similarity, got {type(versor).__name__}"
        )
    parts = np.moveaxis(versor.coefficients, -1, 0)
    return CGA3.multivector(dict(zip(names, parts, strict=True)))


def as_rotor(x: Multivector) -> Rotor:
    """The rotor ``(*)`` of a multivector on ``1, e23, e31, e12``.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or not unit.
    """
    return _versor(Rotor, x)


def as_motor(x: Multivector) -> Motor:
    """The motor ``(*)`` of a multivector on ``1, e23, e31, e12, e1∞, e2∞, e3∞, e123∞``.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or no rigid motion.
    """
    return _versor(Motor, x)


def as_similarity(x: Multivector) -> Similarity:
    """The similarity ``(*)`` of a multivector on its twelve blades.

    Raises:
        ValueError: other blades, coefficients that are no numbers, or no similarity.
    """
    return _versor(Similarity, x)


def _versor(kind: type[V], x: Multivector) -> V:
    name = f"as_{kind.__name__.lower()}(x)"
    if x.algebra != CGA3:
        raise ValueError(f"{name}: expected a multivector of {CGA3}, got one of {x.algebra}")
    names = _BLADES[kind]
    known = {blade for name in names for blade in CGA3.blade(name).blades}
    foreign = [blade for blade in x.blades if blade not in known]
    if foreign:
        raise ValueError(f"{name}: expected blades of a {kind.__name__}, got {' '.join(foreign)}")
    parts = [x.coefficient(blade) for blade in names]
    if not all(map(is_numeric, parts)):
        raise ValueError(f"{name}: expected coefficients that are numbers, got symbols")
    return kind(np.stack(np.broadcast_arrays(*parts), axis=-1))
