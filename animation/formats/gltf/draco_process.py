"""A program that decodes Draco meshes within bounds of memory and time; `compression.py` runs it.

Some fifty bytes of Draco's may stand for gigabytes, and its decoder does not say so beforehand. A
process of its own is ended by the system where it goes beyond the bounds, or by a fault.

It reads meshes, each behind its length as eight bytes, and writes an `.npz`: faces and attributes
by the mesh's number and the attribute's.
"""

from __future__ import annotations

import io
import os
import resource
import struct
import sys
from typing import Any


def main(memory_bytes: int, seconds: int, most_values: int) -> None:
    """Decode standard input to standard output; `most_values` numbers in all."""
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # threads take addresses
    import DracoPy
    import numpy as np

    decoded: dict[str, Any] = {}
    number, left = 0, most_values
    while head := sys.stdin.buffer.read(8):
        (size,) = struct.unpack("<Q", head)
        mesh = DracoPy.decode(sys.stdin.buffer.read(size))
        arrays = {f"{number}/{one['unique_id']}": one["data"] for one in mesh.attributes}
        arrays[f"{number}/faces"] = mesh.faces
        left -= sum(array.size for array in arrays.values())
        if left < 0:
            sys.exit(f"expected at most {most_values} numbers, got more")
        decoded |= arrays
        number += 1
    whole = io.BytesIO()
    np.savez(whole, **decoded)
    sys.stdout.buffer.write(whole.getbuffer())


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
