"""Table 3 printed: our figures beside the paper's, and what agrees, computed from the run."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

from tests.bench.algebra.table3.methods import METHODS
from tests.bench.algebra.table3.paper import (
    CHARACTERS,
    COUNTERPARTS,
    PAPER_MS,
    overheads_ms,
    paper_ns,
    paper_ratio,
)

__all__ = ["table3_table", "verdict"]

_RIVAL = "dual_quaternion"
_WIDTH = 100


def table3_table(found: Mapping[str, Any]) -> str:
    """Milliseconds a character, nanoseconds a joint with quartiles, and the paper's figures."""
    lines: list[str] = []
    for scalar in dict.fromkeys(row["scalar"] for row in found["rows"]):
        rows = [row for row in found["rows"] if row["scalar"] == scalar]
        lines += [*_characters(scalar, rows), ""]
    for scalar in dict.fromkeys(row["scalar"] for row in found["array_rows"]):
        rows = [row for row in found["array_rows"] if row["scalar"] == scalar]
        lines += [*_arrays(scalar, rows), ""]
    for one in found["characters"]:
        lines.append(f"{one['character']}: {one['joints']} joints, {one['poses']}")
    lines += ["", *textwrap.wrap(found["verdict"], _WIDTH)]
    lines += [f"left out: {reason}" for reason in found["left_out"]]
    return "\n".join(lines)


def _characters(scalar: str, rows: list[dict[str, Any]]) -> list[str]:
    shown = list(dict.fromkeys(row["character"] for row in rows))
    heads = "".join(f"{name:>13}" for name in shown)
    first = shown[0]
    lines = [
        f"{scalar + ', ms a character':<36}{heads}   ns a joint  quartiles      ratio"
        "   paper: ns ratio"
    ]
    rival = _ns(rows, _RIVAL, first)
    for method in METHODS:
        own = {row["character"]: row for row in rows if row["method"] == method.label}
        cells = "".join(f"{own[name]['ms_a_character']:>13.6f}" for name in shown)
        one = own[first]
        spread = f"{one['ns_a_joint_lower_quartile']:.1f}-{one['ns_a_joint_upper_quartile']:.1f}"
        lines.append(
            f"{method.label:<36}{cells}{one['ns_a_joint']:>13.1f}  {spread:<13}"
            f"{one['ns_a_joint'] / rival:>7.2f}   {_paper_cells(method.name)}".rstrip()
        )
    return lines


def _paper_cells(name: str) -> str:
    row = COUNTERPARTS.get(name)
    return "" if row is None else f"{paper_ns(row):>9.1f}{paper_ratio(row):>6.2f}  {row}"


def _arrays(scalar: str, rows: list[dict[str, Any]]) -> list[str]:
    joints = rows[0]["joints"]
    slerp = [row["ns_a_joint"] for row in rows if row["method"] == "GLM slerp + mix"]
    ratio = "times GLM slerp + mix" if slerp else ""
    lines = [f"{scalar + f', {joints} joints in one call':<42}ns a joint  quartiles     {ratio}"]
    for row in rows:
        spread = f"{row['ns_a_joint_lower_quartile']:.2f}-{row['ns_a_joint_upper_quartile']:.2f}"
        share = f"{row['ns_a_joint'] / slerp[0]:.3f}" if slerp else ""
        lines.append(f"{row['method']:<42}{row['ns_a_joint']:>10.2f}  {spread:<14}{share}".rstrip())
    return lines


def verdict(rows: list[dict[str, Any]]) -> str:
    """What agrees with the paper and what does not, in float32 on the first character.

    `rows` are those of `bench_table3`; the paper's own figures say the rest.
    """
    kept = [row for row in rows if row["scalar"] == "float32"]
    ns = {m.name: _ns(kept, m.name, CHARACTERS[0]) for m in METHODS}
    return " ".join([*_linear(ns), *_strategies(ns), *_euclidean(ns), *_overhead(kept)])


def _linear(ns: dict[str, float]) -> list[str]:
    program = ns["motor_linear_program"] / ns[_RIVAL]
    paper = paper_ratio("CGA Gaalop")
    agrees = "agrees: " if program <= paper * 1.1 else "does not agree: "
    return [
        f"That a whole-program CGA blend is nearly as fast as dual quaternions {agrees}linear and "
        f"`program` takes {program:.2f} times their time (paper: {paper:.2f})."
    ]


def _strategies(ns: dict[str, float]) -> list[str]:
    """How far the strategies are apart for one and the same method."""
    log, line = (
        {s: ns[f"{m}_{s}"] for s in ("table", "table_code", "product", "program")}
        for m in ("motor", "motor_linear")
    )
    ordered = all(sorted(row.values(), reverse=True) == list(row.values()) for row in (log, line))
    gaigen, versor = paper_ratio("CGA Gaigen"), paper_ratio("CGA Versor")
    generator = line["product"] / line["program"]
    path = log["product"] / line["product"]
    cause = "the path" if path > generator else "the generator"
    gap = paper_ratio("CGA Versor") / paper_ratio("CGA Gaalop")
    logarithms = log["product"] / log["program"]
    verb = "holds" if ordered else "does not hold"
    return [
        f"The order table > table-code > product > program {verb} for both CGA blends: through "
        f"the logarithm {log['table']:.0f}, {log['table_code']:.0f}, {log['product']:.0f} and "
        f"{log['program']:.0f} ns a joint, linear {line['table']:.0f}, {line['table_code']:.0f}, "
        f"{line['product']:.1f} and {line['program']:.1f}.",
        f"A table interpreted at run time costs {log['table'] / ns[_RIVAL]:.0f} times dual "
        f"quaternions, written out as code {log['table_code'] / ns[_RIVAL]:.0f} times, the paper's "
        f"Gaigen {gaigen:.1f} times: Gaigen 2 has the code, and types of a profile besides, and so "
        "stands between our table-code and product "
        f"({log['product'] / ns[_RIVAL]:.1f}; the paper's libvsr {versor:.1f}).",
        f"The paper compares a linear blend by Gaalop with logarithms by libvsr, {gap:.1f} times "
        f"apart; here that is {log['product'] / line['program']:.1f} times. The generator makes "
        f"{generator:.2f} of this where both are linear and {logarithms:.2f} where both take the "
        f"logarithm, the path {path:.1f}: what tells them apart is {cause}.",
    ]


def _euclidean(ns: dict[str, float]) -> list[str]:
    gaigen, gaalop = (PAPER_MS[f"GA {name}"][0] for name in ("Gaigen", "Gaalop"))
    faster = ns["rotor_table_code"] / ns["rotor_program"]
    word = "faster" if faster > 1.0 else "slower"
    return [
        f"In the paper rotors by Gaalop are slower than by Gaigen ({gaalop:.5f} against "
        f"{gaigen:.5f} ms), against its own conclusion; here `program` is "
        f"{max(faster, 1 / faster):.1f} times {word} than `table-code`, and takes "
        f"{ns['rotor_program'] / ns['quaternion']:.1f} times quaternion slerp. A likely cause is "
        "in the listings: Gaalop's (Table 1) builds both rotors from axes and angles in every "
        "call, where the others take them ready made, as all methods do here."
    ]


def _overhead(rows: list[dict[str, Any]]) -> list[str]:
    """What the characters differ by a joint, and what they do in the paper."""
    spreads = []
    for method in METHODS:
        ns = [row["ns_a_joint"] for row in rows if row["method"] == method.label]
        spreads.append(max(ns) / min(ns) - 1.0)
    typical = sorted(spreads)[len(spreads) // 2]
    told = " and ".join(
        f"{one.least_ms:.4f} to {one.most_ms:.4f} ms for {one.character}" for one in overheads_ms()
    )
    return [
        "A joint costs the same whichever character it belongs to: here half of the methods stay "
        f"within {100 * typical:.0f} %. In the paper every row gains {told} over Character 1, "
        "which 43 to 54 joints cannot explain: an overhead outside blending. Only its ratios "
        "within Character 1 are comparable."
    ]


def _ns(rows: list[dict[str, Any]], name: str, character: str) -> float:
    (label,) = (method.label for method in METHODS if method.name == name)
    (found,) = (
        row["ns_a_joint"] for row in rows if (row["method"], row["character"]) == (label, character)
    )
    return float(found)
