"""One pose goes straight to its kernel: with the bits, the types and the refusals of the method."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorcade.ga import Motor, Rotor, Similarity, Versor

KINDS = (Rotor, Motor, Similarity)
SHAPES = ((), (1,), (3,), (16,), (41,), (600,), (2, 3), (0,))


def _random(kind: Any, shape: tuple[int, ...], dtype: str, seed: int) -> Any:
    return kind.random(np.random.default_rng(seed), shape).astype(dtype)


def _numbers(shape: tuple[int, ...], dtype: str, *trailing: int) -> Any:
    return np.random.default_rng(17).standard_normal((*shape, *trailing)).astype(dtype)


# Verbs and what they are called with: a versor of the batch, the batch, and the precision.
Arguments = Callable[[Any, tuple[int, ...], str], tuple[Any, ...]]
VERBS: dict[str, Arguments] = {
    "__init__": lambda m, s, d: (m.coefficients,),
    "__matmul__": lambda m, s, d: (_random(type(m), s, d, 5),),
    "inverse": lambda m, s, d: (),
    "log": lambda m, s, d: (),
    "exp": lambda m, s, d: (m.log(),),
    "apply": lambda m, s, d: (_numbers(s, d, 3),),
    "interpolate": lambda m, s, d: (_random(type(m), s, d, 6), 0.3),
    "retract": lambda m, s, d: (_numbers(s, d, m._log_size),),
    "local": lambda m, s, d: (_random(type(m), s, d, 7),),
    "adjoint": lambda m, s, d: (),
    "transform_twist": lambda m, s, d: (_numbers(s, d, m._log_size),),
    "left_jacobian": lambda m, s, d: (_numbers(s, d, m._log_size),),
    "normalize": lambda m, s, d: (1.5 * m.coefficients,),
    "from_twist": lambda m, s, d: (m.as_twist(),),
    "as_twist": lambda m, s, d: (),
    "from_matrix": lambda m, s, d: (m.as_matrix(),),
    "as_matrix": lambda m, s, d: (),
    "from_quaternion": lambda m, s, d: (m.as_quaternion(),),
    "as_quaternion": lambda m, s, d: (),
    "from_rotation_vector": lambda m, s, d: (_numbers(s, d, 3),),
    "as_rotation_vector": lambda m, s, d: (),
    "from_euler": lambda m, s, d: (_numbers(s, d, 3), "zyx"),
    "as_euler": lambda m, s, d: ("yxz",),
    "from_translation": lambda m, s, d: (_numbers(s, d, 3),),
    "from_rotor_translation": lambda m, s, d: (m.rotor, _numbers(s, d, 3)),
    "from_quaternion_translation": lambda m, s, d: (m.rotor.as_quaternion(), _numbers(s, d, 3)),
    "from_dual_quaternion": lambda m, s, d: (m.as_dual_quaternion(),),
    "as_dual_quaternion": lambda m, s, d: (),
    "from_rotor_translation_scale": lambda m, s, d: (
        m.rotor,
        _numbers(s, d, 3),
        np.exp(_numbers(s, d)),
    ),
}


def _ways(kind: Any, verb: str) -> tuple[Any, Any] | None:
    """A verb as it is called, and its method alone."""
    for base in kind.__mro__:
        if verb in vars(base):
            path = vars(base)[verb]
            path = path.__func__ if isinstance(path, classmethod) else path
            # Attributes of a fast path are those of the method: this binds the method.
            return path, path.__get__
    return None


def _same(a: Any, b: Any) -> None:
    assert type(a) is type(b)
    if isinstance(a, Versor):
        assert a.coefficients.dtype == b.coefficients.dtype
        a, b = a.coefficients, b.coefficients
    a, b = np.asarray(a), np.asarray(b)
    assert (a.dtype, a.shape, a.flags.writeable) == (b.dtype, b.shape, b.flags.writeable)
    assert a.strides == b.strides or a.size == 0 or a.shape == (1, *a.shape[1:])
    assert a.tobytes() == b.tobytes()


def _outcome(function: Callable[..., Any], *given: Any) -> Any:
    try:
        return function(*given)
    except Exception as refused:
        return type(refused), str(refused)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("kind", KINDS)
def test_bits_and_types_are_those_of_the_method(kind: Any, verb: str, dtype: str) -> None:
    ways = _ways(kind, verb)
    if ways is None or getattr(ways[0], "__isabstractmethod__", False):
        pytest.skip(f"{kind.__name__} has no {verb}")
    path, bound = ways
    for shape in SHAPES:
        versor = _random(kind, shape, dtype, 4)
        given = VERBS[verb](versor, shape, dtype)
        first = versor
        if verb == "__init__":
            first, other = object.__new__(kind), object.__new__(kind)
            path(first, *given)
            bound(other)(*given)
            _same(first, other)
            assert not np.shares_memory(first.coefficients, given[0])
            continue
        if isinstance(next(vars(b)[verb] for b in kind.__mro__ if verb in vars(b)), classmethod):
            first = kind
        _same(path(first, *given), bound(first)(*given))


BAD: dict[str, list[Any]] = {
    "apply": [[0.0, np.nan, 1.0], [1.0, 2.0], "abc", [1, 2, 3], (1.0, 2, True), [10**400, 0, 0],
              np.zeros((3, 3, 3)), np.zeros(3, ">f8"), np.zeros(6)[::2], np.full(3, np.inf)],
    "retract": [np.full(6, np.nan), [0.0] * 6, np.zeros(6, np.float32)],
    "__matmul__": [3, None, Rotor.identity(), Motor.identity(dtype="float32"),
                   Motor.identity((2,)), Similarity.identity()],
    "local": [None, Rotor.identity((3,)), Motor.identity((4,))],
    "from_matrix": [np.eye(3), 2.0 * np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0]), np.eye(4).tolist(),
                    np.asfortranarray(np.diag([1.0, -1.0, -1.0, 1.0])), np.full((4, 4), np.nan)],
    "from_translation": [[np.inf, 0.0, 0.0], np.zeros((5, 3))[::2], np.zeros((3, 0))],
}  # fmt: skip


@pytest.mark.parametrize("verb", BAD)
def test_the_same_is_refused_and_taken(verb: str) -> None:
    path, bound = _ways(Motor, verb) or (None, None)
    for shape in ((), (3,)):
        first: Any = Motor if verb.startswith("from") else Motor.random(
            np.random.default_rng(2), shape
        )  # fmt: skip
        for given in BAD[verb]:
            a, b = _outcome(path, first, given), _outcome(bound(first), given)
            if isinstance(a, tuple):
                assert a == b
            elif a is not NotImplemented:
                _same(a, b)


@pytest.mark.parametrize(
    "sequence", [(), *((s,) for s in ("xyz", "zyx", "xzy", "zxz", "xxz", "XYZ", "xy", "xyw", ""))]
)
def test_angles_in_every_sequence_are_those_of_the_method(sequence: tuple[str, ...]) -> None:
    """Left out, of three axes or two, and what is no sequence."""
    write, bound = _ways(Rotor, "from_euler") or (None, None)
    read, bound_read = _ways(Rotor, "as_euler") or (None, None)
    assert None not in (write, bound, read, bound_read)
    rotor = Rotor.random(np.random.default_rng(8))
    for pair in (
        (_outcome(write, Rotor, [0.3, -0.2, 0.1], *sequence),
         _outcome(bound(Rotor), [0.3, -0.2, 0.1], *sequence)),
        (_outcome(read, rotor, *sequence), _outcome(bound_read(rotor), *sequence)),
    ):  # fmt: skip
        if isinstance(pair[1], tuple):
            assert pair[0] == pair[1]
        else:
            _same(*pair)
    assert _outcome(read, rotor, None) == _outcome(bound_read(rotor), None)


def test_a_type_of_the_users_stays_itself() -> None:
    class Pose(Motor):
        pass

    pose = Pose.from_translation([1.0, 2.0, 3.0])
    for result in (pose @ pose, pose.inverse(), Pose.exp(pose.log()), Pose(pose.coefficients)):
        assert type(result) is Pose
    assert (pose @ pose).translation_m.tolist() == [2.0, 4.0, 6.0]


def test_results_are_frozen_and_nothing_is_held_on_to() -> None:
    pose, twist = Motor.from_translation([1.0, 2.0, 3.0]), np.zeros(6)
    held = sys.getrefcount(pose), sys.getrefcount(twist), sys.getrefcount(pose.coefficients)
    for _ in range(100):
        moved = pose.retract(twist) @ pose
        pose.log()
        with pytest.raises(ValueError, match="expected"):
            pose.apply([0.0, 1.0])
    for frozen in (moved, Motor.random(np.random.default_rng(1), (20,)).inverse()):
        with pytest.raises(ValueError, match="WRITEABLE"):
            frozen.coefficients.flags.writeable = True
    assert held == (
        sys.getrefcount(pose), sys.getrefcount(twist), sys.getrefcount(pose.coefficients)
    )  # fmt: skip


def test_a_fast_path_reads_like_its_method() -> None:
    assert Motor.apply.__qualname__ == "Versor.apply"
    assert "Move points" in (Motor.apply.__doc__ or "")
    assert Motor.exp.__self__ is Motor  # type: ignore[attr-defined]
