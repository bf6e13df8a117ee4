"""Coefficients of versors to and from torch tensors and CasADi matrices."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from motorcade.ga.versors.versor import Versor

__all__ = ["dm_from_versor", "tensor_from_versor", "versor_from_dm", "versor_from_tensor"]

V = TypeVar("V", bound=Versor)


def tensor_from_versor(versor: Versor, device: Any = None) -> Any:
    """Coefficients ``(*, n)`` as a torch tensor of the same precision, copied to `device`."""
    import torch

    return torch.tensor(versor.coefficients, device=device)


def versor_from_tensor(kind: type[V], tensor: Any) -> V:
    """Versors of coefficients ``(*, n)``, copied to the CPU and without gradients.

    Args:
        kind: Rotor, Motor or Similarity.
        tensor: what the class takes; what an optimiser has moved goes through `normalize` first.

    Raises:
        ValueError: wrong last dimension, NaN or infinity, or not unit (see the class).
    """
    return kind(tensor.detach().cpu().numpy().copy())


def dm_from_versor(versor: Versor) -> Any:
    """Coefficients as a CasADi ``DM``: a column a versor, as generated CasADi functions take them.

    Raises:
        ValueError: more than one batch dimension, which CasADi does not have.
    """
    import casadi

    if len(versor.shape) > 1:
        raise ValueError(
            f"dm_from_versor(versor): expected (N,) versors or one, got {versor.shape}; "
            "reshape them"
        )
    return casadi.DM(np.atleast_2d(versor.coefficients).T.astype(np.float64))


def versor_from_dm(kind: type[V], matrix: Any) -> V:
    """Versors of a CasADi ``DM`` ``(n, N)``: shape ``(N,)``, or one versor where N is 1.

    Args:
        kind: Rotor, Motor or Similarity.
        matrix: numbers; symbols have none.

    Raises:
        ValueError: symbols, wrong rows, NaN or infinity, or not unit (see the class).
    """
    import casadi

    if not isinstance(matrix, casadi.DM):
        raise ValueError(
            f"versor_from_dm(matrix): expected a DM of numbers, got {type(matrix).__name__}"
        )
    columns = np.array(matrix.full()).T
    return kind(columns[0] if len(columns) == 1 else columns)
