"""What versors of every kind do: products, exp and log, interpolation, and how twists act on them.

A twist is a rotation vector (rad), then a translational part (m), then the logarithm of a scale,
as many of these as the versors have. Each definition takes a `Versors` first, which says how those
of one kind are read, multiplied and written.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from motorcade.ga.codegen.library_kernels.kernel import Kernel
from motorcade.ga.codegen.precision import Precision
from motorcade.ga.codegen.tape import Operand
from motorcade.ga.kernels.definitions import elements as on

Numbers = list[Any]


class Versors(NamedTuple):
    """One kind of versor; its values have ``*`` and ``~``, `read` and `write` their coefficients.

    Kernels are called `prefix` and their verb; summaries name the versor, several, and the `path`
    from one to another. `exp` takes a bivector's coefficients, and `log`, told whether to go the
    short way round, gives them; `of_twist` and `as_twist` turn twists into bivectors and back.
    """

    prefix: str
    name: str
    plural: str
    path: str
    versor: tuple[str, ...]
    bivector: tuple[str, ...]
    twist_size: int
    read: Callable[[Numbers], Any]
    write: Callable[[Any], Numbers]
    exp: Callable[[Precision, Numbers], Any]
    log: Callable[[Precision, Any, bool], Numbers]
    of_twist: Callable[[Numbers], Numbers]
    as_twist: Callable[[Numbers], Numbers]
    transform_twist: Callable[[Any, Numbers], Numbers]
    left_jacobian: Callable[[Precision, Numbers], Numbers]
    left_jacobian_inverse: Callable[[Precision, Numbers], Numbers]


def matrix_rows(column: Callable[[Numbers], Numbers], size: int) -> Numbers:
    """A linear function of twists as a matrix by rows."""
    columns = [column([float(i == k) for i in range(size)]) for k in range(size)]
    return [columns[j][i] for i in range(size) for j in range(size)]


def _compose(of: Versors, precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    return [of.write(of.read(a) * of.read(b))]


def _inverse(of: Versors, precision: Precision, m: Numbers) -> list[Numbers]:
    return [of.write(~of.read(m))]


def _exp(of: Versors, precision: Precision, log: Numbers) -> list[Numbers]:
    return [of.write(of.exp(precision, log))]


def _log(of: Versors, precision: Precision, m: Numbers, *, short_way: bool) -> list[Numbers]:
    return [of.log(precision, of.read(m), short_way)]


def _interpolate(
    of: Versors, precision: Precision, a: Numbers, b: Numbers, fraction: Numbers, *, short_way: bool
) -> list[Numbers]:
    first, second = of.read(a), of.read(b)
    log = of.log(precision, ~first * second, short_way)
    step = of.exp(precision, [value * fraction[0] for value in log])
    return [of.write(first * step)]


def _adjoint(of: Versors, precision: Precision, m: Numbers) -> list[Numbers]:
    versor = of.read(m)
    return [matrix_rows(lambda y: of.transform_twist(versor, y), of.twist_size)]


def _transform_twist(
    of: Versors, precision: Precision, m: Numbers, twist: Numbers
) -> list[Numbers]:
    return [of.transform_twist(of.read(m), twist)]


def _left_jacobian(of: Versors, precision: Precision, twist: Numbers) -> list[Numbers]:
    return [of.left_jacobian(precision, twist)]


def _left_jacobian_inverse(of: Versors, precision: Precision, twist: Numbers) -> list[Numbers]:
    return [of.left_jacobian_inverse(precision, twist)]


def _retract(of: Versors, precision: Precision, m: Numbers, twist: Numbers) -> list[Numbers]:
    return [of.write(of.read(m) * of.exp(precision, of.of_twist(twist)))]


def _local(of: Versors, precision: Precision, a: Numbers, b: Numbers) -> list[Numbers]:
    return [of.as_twist(of.log(precision, ~of.read(a) * of.read(b), True))]


def _of_twist(of: Versors, precision: Precision, twist: Numbers) -> list[Numbers]:
    return [of.write(of.exp(precision, of.of_twist(twist)))]


def _as_twist(of: Versors, precision: Precision, m: Numbers) -> list[Numbers]:
    return [of.as_twist(of.log(precision, of.read(m), True))]


def versor_kernels(of: Versors, groups: tuple[str, str, str, str]) -> tuple[Kernel, ...]:
    """Products, exp and log, interpolation; `groups` are the files of products, logs and paths."""
    products, logs, paths, long_paths = groups
    a, b, m, out = (Operand(name, of.versor) for name in ("a", "b", "m", "out"))
    log, log_out = Operand("log", of.bivector), Operand("out", of.bivector)
    ends = a, b, on.numbers("fraction")
    path = f"{of.path} a exp(fraction log(~a b)),"
    short, long = partial(_log, short_way=True), partial(_log, short_way=False)
    short_path, long_path = (partial(_interpolate, short_way=way) for way in (True, False))
    return _named(
        of,
        ("compose", products, (a, b), out, _compose, f"Geometric product a b of {of.plural}"),
        ("inverse", products, (m,), out, _inverse, f"Reverse of a {of.name}: its inverse"),
        ("exp", logs, (log,), out, _exp, f"{of.name.title()} of a bivector of any angle"),
        ("log", logs, (m,), log_out, short,
         f"Bivector of a {of.name}, by the sign that turns by at most π"),
        ("log_long", logs, (m,), log_out, long,
         f"Bivector of a {of.name} by its own sign, turning by up to 2π"),
        ("interpolate", paths, ends, out, short_path, f"{path} the short way round"),
        ("interpolate_long", long_paths, ends, out, long_path, f"{path} by the signs of a and b"),
    )  # fmt: skip


def twist_kernels(of: Versors) -> tuple[Kernel, ...]:
    """Adjoint, Jacobians of exp, retract and local, and versors as twists."""
    size, kind = of.twist_size, of.name
    a, b, m, out = (Operand(name, of.versor) for name in ("a", "b", "m", "out"))
    twist, twist_out = on.twist("twist", size), on.twist("out", size)
    square = on.components("out", size, size)
    tangents, jacobians = f"{of.prefix}tangents", f"{of.prefix}jacobians"
    twists = f"{of.prefix}twists"
    return _named(
        of,
        ("adjoint", tangents, (m,), square, _adjoint, f"Adjoint matrix of a {kind} on twists"),
        ("transform_twist", tangents, (m, twist), twist_out, _transform_twist,
         f"A twist seen from the other side of a {kind}"),
        ("left_jacobian", jacobians, (twist,), square, _left_jacobian,
         f"Left Jacobian of a {kind}'s exponential at a twist"),
        ("left_jacobian_inverse", jacobians, (twist,), square, _left_jacobian_inverse,
         f"Inverse left Jacobian of a {kind}'s exponential, singular at full turns"),
        ("retract", tangents, (m, twist), out, _retract,
         f"A {kind} moved by a twist in its own frame"),
        ("local", tangents, (a, b), twist_out, _local,
         f"The twist, turning by at most π, that takes {kind} a to b"),
        ("of_twist", twists, (twist,), out, _of_twist, f"{kind.title()} of a twist of any angle"),
        ("as_twist", twists, (m,), twist_out, _as_twist,
         f"Twist of a {kind}, by the sign that turns by at most π"),
    )  # fmt: skip


Row = tuple[str, str, tuple[Operand, ...], Operand, Callable[..., list[Numbers]], str]


def _named(of: Versors, *rows: Row) -> tuple[Kernel, ...]:
    return tuple(
        Kernel(of.prefix + verb, group, inputs, (output,), partial(define, of), summary)
        for verb, group, inputs, output, define, summary in rows
    )
