"""Transforms in files of their own: JSON, text, `.npy`; with a scale, or broken."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.ga import Motor, Similarity
from motorcade.replays.cli.main import main
from motorcade.replays.io.trajectories import read_trajectory
from motorcade.replays.io.transforms import read_transform


def test_transforms_with_a_scale_move_positions(folder: Path) -> None:
    given = read_trajectory("true.txt")
    rigid = read_transform(Path("T.json"))
    assert isinstance(rigid, Motor)
    grown = Similarity.from_motor_scale(rigid, 2.0)
    told = json.loads(Path("T.json").read_text()) | {"scale": 2.0}
    Path("S.json").write_text(json.dumps(told))
    np.savetxt("S.txt", grown.as_matrix())
    np.save("S.npy", np.asfortranarray(grown.as_matrix()))
    for name in ("S.json", "S.txt", "S.npy"):
        assert main(["trajectory", "true.txt", "--transform-left", name, "-o", "o.tum"]) == 0
        found = read_trajectory("o.tum").motors
        expected = grown.apply(given.motors.translation_m)
        np.testing.assert_allclose(found.translation_m, expected, atol=1e-12)
        turns = (rigid.rotor @ given.motors.rotor).as_matrix()
        np.testing.assert_allclose(found.rotor.as_matrix(), turns, atol=1e-12)


def _npy(shape: str, kind: str = "<f8") -> bytes:
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head.encode() + bytes(128)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "the file is empty"),
        (b"1 2 3", "expected 16 numbers, got 3"),
        (b"a b", "expected 16 numbers or JSON"),
        (b" ".join([b"nan"] * 16), "expected a rotation times a scale"),
        (b" ".join([b"1"] * 16), "expected a rotation times a scale"),
        (b"1 0 0 0 0 2 0 0 0 0 1 0 0 0 0 1", "expected a rotation"),
        (b"1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1", "expected a rotation times a scale"),
        (b"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "expected the last row 0 0 0 1"),
        (b"{" * 60_000, "expected JSON of numbers"),
        (b'{"a":' * 10_000, "expected JSON of numbers"),
        (b'{"x": 1}', "expected JSON of numbers"),
        (b'{"x":1,"y":1,"z":NaN,"qx":0,"qy":0,"qz":0,"qw":1}', "expected a unit quaternion and"),
        (b'{"x":1,"y":1,"z":1,"qx":0,"qy":0,"qz":0,"qw":2}', "expected a unit quaternion"),
        (b'{"x":1,"y":1,"z":1,"qx":0,"qy":0,"qz":0,"qw":1,"scale":-1}', "expected a scale"),
        (_npy("(4, 4)", "|O"), "expected 4 by 4 numbers"),
        (_npy("(1000000000000,)"), "expected 4 by 4 numbers"),
        (_npy("(4, 4"), "expected 4 by 4 numbers"),
        (_npy("(4, 4)"), "expected a rotation times a scale"),
        (_npy("(4, 4)")[:200], "expected 4 by 4 numbers"),
        (b"\x93NUMPY\x09\x00", "expected 4 by 4 numbers"),
        (b"1 " * 40_000, "at most 65536 bytes"),
    ],
)
def test_transforms_that_are_none_are_refused(
    folder: Path, content: bytes, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("bad").write_bytes(content)
    assert main(["trajectory", "true.txt", "--transform-left", "bad"]) == 1
    told = capsys.readouterr().err
    assert problem in told
    assert told.startswith("motorcade: bad")
    assert told.count("\n") == 1
