"""``python -m docs.making.figure [OUT.glb]``: write the mannequin's file, or where one says."""

from __future__ import annotations

import sys
from pathlib import Path

from docs.making.figure.build import figure
from motorcade.animation import write_gltf

SHIPPED = Path(__file__).parents[3] / "animation" / "mannequin" / "mannequin.glb"


def main() -> None:
    """Make it and say how large it is."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else SHIPPED
    made = figure()
    write_gltf(out, made)
    print(
        f"{out}: {out.stat().st_size:,} bytes, {len(made.triangles):,} triangles, "
        f"{len(made.vertices):,} vertices"
    )


if __name__ == "__main__":
    main()
