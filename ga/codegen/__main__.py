"""``python -m motorcade.ga.codegen``: write ``ga/kernels/generated`` again from the definitions."""

from __future__ import annotations

import sys

from motorcade.ga.codegen.library_kernels.library import GENERATED, write_library

if __name__ == "__main__":
    written = write_library(GENERATED)
    sys.stdout.write(f"{GENERATED}: {len(written)} files\n")
