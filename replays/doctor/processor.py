"""Which of the kernels' SIMD versions this processor runs.

The kernels are compiled for x86-64-v4, x86-64-v3 and plain x86-64, and the loader picks the best
that the processor has. The same choice is made here from the flags that Linux tells. The levels are
those of the x86-64 psABI (gitlab.com/x86-psABIs/x86-64-ABI), each including the one below.
"""

from __future__ import annotations

import platform
from collections.abc import Set
from pathlib import Path

__all__ = ["flags", "simd"]

_V2 = frozenset(["cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3"])
_V3 = _V2 | {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"}
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}


def flags(cpuinfo: Path = Path("/proc/cpuinfo")) -> frozenset[str]:
    """What the processor can do, in Linux's names; empty where the system does not tell."""
    if not cpuinfo.is_file():
        return frozenset()
    for line in cpuinfo.read_text().splitlines():
        name, _, value = line.partition(":")
        if name.strip() in ("flags", "Features"):
            return frozenset(value.split())
    return frozenset()


def simd(known: Set[str], machine: str = platform.machine()) -> str:
    """The level of x86-64 whose kernels are picked with these flags; other machines' own name."""
    if machine not in ("x86_64", "AMD64"):
        return f"{machine}, one version of the kernels"
    if known >= _V4:
        return "x86-64-v4 (AVX-512)"
    if known >= _V3:
        return "x86-64-v3 (AVX2 and FMA)"
    return "x86-64 (SSE2)"
