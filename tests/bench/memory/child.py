"""One job in a process of its own: what memory it had at most, told as JSON on its last line.

python -m tests.bench.memory.child run RECORDING --out DIR
python -m tests.bench.memory.child footage FOLDER FRAMES
python -m tests.bench.memory.child stream FOLDER SECONDS
python -m tests.bench.memory.child fuse FOLDER
"""

from __future__ import annotations

import json
import resource
import sys
import time
from pathlib import Path


def peak_bytes() -> int:
    """Most memory that this process has held.

    Linux tells it of the program alone; elsewhere it may begin with the parent's.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def main() -> int:
    """Do what the arguments say."""
    from motorcade.replays.cli.main import main as command_line

    what, *given = sys.argv[1:]
    if what == "run":
        import motorcade.replays.pipeline.job  # noqa: F401  # part of what stands before any data
    elif what == "fuse":
        from tests.bench.memory.fused import fuse_measured
    else:
        from tests.bench.memory.recordings import write_footage, write_long_stream
    start, imported = time.perf_counter(), peak_bytes()
    status = 0
    if what == "footage":
        write_footage(Path(given[0]), int(given[1]))
    elif what == "stream":
        write_long_stream(Path(given[0]), float(given[1]))
    elif what == "fuse":
        fuse_measured(Path(given[0]))
    else:
        status = command_line([what, *given])
    seconds = time.perf_counter() - start
    print(json.dumps({"imported": imported, "peak": peak_bytes(), "seconds": seconds}))
    return status


if __name__ == "__main__":
    sys.exit(main())
