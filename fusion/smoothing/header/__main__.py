"""``python -m motorcade.fusion.smoothing.header``: write ``include/motorcade/smooth.h`` again."""

from __future__ import annotations

import sys
from pathlib import Path

from motorcade.fusion.smoothing.header import get_include, header_text

if __name__ == "__main__":
    path = Path(get_include()) / "motorcade" / "smooth.h"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(header_text(), encoding="utf-8")
    sys.stdout.write(f"{path}\n")
