"""`python -m tests.end_to_end.phones FOLDER`: write the phone clips, run the command on each.

Each clip is run with nothing but its name, to its film. Clips that the folder holds already are not
written again. Exit status 1 where fewer than eleven of twelve come out as they must.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from tests.end_to_end.phones.cases import CASES, SEEDS
from tests.end_to_end.phones.clips import write_clip
from tests.end_to_end.phones.recorded import recorded_lines
from tests.end_to_end.phones.scores import score

_MUST = 11


def main() -> int:
    """Write, run, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.phones")
    parser.add_argument("folder", type=Path, help="where clips and runs lie or are written")
    parser.add_argument("--set", choices=tuple(SEEDS), default="judging", help="seeds (judging)")
    parser.add_argument("--only", nargs="*", choices=[case.name for case in CASES])
    parser.add_argument("--write", action="store_true", help="write the clips and no more")
    parser.add_argument("--until", default="overlay", help="the last stage (overlay)")
    parser.add_argument("--recorded", action="store_true", help="self-calibrate recordings as well")
    arguments = parser.parse_args()
    folder = arguments.folder / arguments.set
    folder.mkdir(parents=True, exist_ok=True)
    chosen = [case for case in CASES if not arguments.only or case.name in arguments.only]
    for case in chosen:
        if not (folder / f"{case.name}.truth.npz").exists():
            write_clip(folder, case, SEEDS[arguments.set])
    if arguments.write:
        return 0
    print("| clip | as it must be | focal length | registration, px | frames | film | seconds |")
    print("|---|---|---|---|---|---|---|")
    right = 0
    for case in chosen:
        out = folder / "runs" / case.name
        shutil.rmtree(out, ignore_errors=True)
        one = score(folder / f"{case.name}.mp4", case, out, arguments.until)
        right += one.right
        print(one.line(), flush=True)
        print(f"    {one.camera}", flush=True)
    print(f"{right} of {len(chosen)} clips as they must be")
    for line in recorded_lines() if arguments.recorded else ():
        print(line, flush=True)
    return int(len(chosen) == len(CASES) and right < _MUST)


if __name__ == "__main__":
    sys.exit(main())
