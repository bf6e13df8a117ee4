"""`python -m tests.end_to_end.phones.kinds FOLDER`: other kinds of clips, made of the written ones.

FOLDER is that of `python -m tests.end_to_end.phones`, which writes the clips. Each kind is run with
nothing but its name, to its film. Exit status 1 where one does not come out as it must.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from tests.end_to_end.phones.kinds.judging import judge
from tests.end_to_end.phones.kinds.kinds import KINDS, Kind
from tests.end_to_end.phones.kinds.writing import write_kind


def main() -> int:
    """Make, run, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.phones.kinds")
    parser.add_argument("folder", type=Path, help="where the twelve clips lie")
    parser.add_argument("--into", type=Path, help="for the kinds and their runs (FOLDER/kinds)")
    parser.add_argument("--only", nargs="*", choices=[one.name for one in KINDS], metavar="KIND")
    parser.add_argument("--until", default="overlay", help="the last stage (overlay)")
    arguments = parser.parse_args()
    clips = arguments.folder / "judging"
    into = arguments.into or arguments.folder / "kinds"
    into.mkdir(parents=True, exist_ok=True)
    chosen = [one for one in KINDS if not arguments.only or one.name in arguments.only]
    print("| kind | as it must be | focal length | registration, px | frames | film | seconds |")
    print("|---|---|---|---|---|---|---|")
    right = sum(_row(one, clips, into, arguments.until) for one in chosen)
    print(f"{right} of {len(chosen)} kinds as they must be")
    return int(right < len(chosen))


def _row(kind: Kind, clips: Path, into: Path, until: str) -> bool:
    """Print a kind's row; whether it is as it must be."""
    file = into / f"{kind.name}{kind.coded.suffix}"
    if not file.exists():
        write_kind(clips, into, kind)
    out = into / "runs" / kind.name
    shutil.rmtree(out, ignore_errors=True)
    found = judge(file, kind, out, until)
    print(found.line(), flush=True)
    return found.right


if __name__ == "__main__":
    sys.exit(main())
