"""What is refused of a multivector: changes, and tests that would always go one way."""

from __future__ import annotations


class Value:
    """Attributes are set once, by ``object.__setattr__``; only coefficients can be compared.

    Without that ``if x:`` and ``x == 0`` would pass unseen over symbols, and mean little over
    batches.
    """

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a multivector is frozen: {name} cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a multivector is frozen: {name} cannot be deleted")

    def __bool__(self) -> bool:
        raise TypeError("a multivector has no truth value: test its coefficients")

    def __eq__(self, other: object) -> bool:
        raise TypeError(
            "multivectors: == is not defined; isclose compares numbers, coefficients compare alone"
        )

    def __hash__(self) -> int:
        raise TypeError(f"unhashable type: {type(self).__name__}")
