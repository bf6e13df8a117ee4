"""``python -m motorcade.fusion.filter.model``: write the generated C again."""

from __future__ import annotations

import sys

from motorcade.fusion.filter.model.emit import GENERATED, write_model

if __name__ == "__main__":
    written = write_model(GENERATED)
    sys.stdout.write(f"{GENERATED}: {len(written)} files\n")
