"""Broken files by the thousand: every reader must give its own error or a valid character.

    python -m tests.animation.formats.fuzz --inputs 50000 --seed 1 [--data FOLDER]

Small files of every format are made here and mutated: bytes, words, JSON values. Where the real
rigs lie in the folder, some of them are mutated too. The program ends with 1 where anything but a
`FormatError` came out, a value is not finite, an input took more of a processor than it may, or
memory grew beyond bounds; it then names the input, which the same seed makes again. Broken inputs
are kept in the folder that FUZZ_KEEP names.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import struct
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from motorcade.animation import Character, Clip
from motorcade.animation.formats import FormatError, NoMeshError, read_character, read_motion
from tests.animation.formats import samples

SLOWEST_S = 10.0
MEMORY_BYTES = 3 << 30
WORDS = [
    b"-1",
    b"0",
    b"1e308",
    b"nan",
    b"inf",
    b"99999999",
    b"2147483648",
    b"",
    b"{",
    b"}",
    b"4294967295",
    b"-0.0",
    b"1e-320",
    b"x" * 300,
    b"\xff\xfe",
    b"<",
    b"]]>",
    b"&lt;",
    b"#",
]
VALUES: list[Any] = [
    None,
    -1,
    0,
    1,
    2**31,
    2**63,
    1e308,
    -1e-320,
    "",
    "x" * 300,
    [],
    {},
    True,
    [1, 2],
    {"a": 1},
    "../secret",
    "/etc/passwd",
    5,
    3,
    5126,
    5121,
    "VEC4",
]
REAL = [
    "astroboy/astro_maya_dae.glb",
    "md5/Bob.md5mesh",
    "md5/Bob.md5anim",
    "arnaud/run_fbx.glb",
    "bvh/jumping_jacks.bvh",
    "astroboy/astro_maya.dae",
]
REAL_SHARE = 0.01

Mutator = Callable[[bytes, np.random.Generator], bytes]


def sources(data: Path | None) -> tuple[list[tuple[str, bytes]], list[tuple[str, bytes]]]:
    """Small files made here and, where they lie in a folder, real ones; by suffix."""
    small = [
        (".glb", samples.gltf_tower().glb()),
        (".glb", samples.rich_gltf().glb()),
        (".gltf", samples.rich_gltf().gltf()),
        (".dae", samples.collada_tower("BEZIER")),
        (".dae", samples.collada_tower("STEP")),
        (".md5mesh", samples.md5_mesh_tower()),
        (".md5anim", samples.md5_motion_tower()),
        (".bvh", samples.BVH),
    ]
    rigs = [] if data is None else [data / "rigs" / name for name in REAL]
    return small, [(path.suffix, path.read_bytes()) for path in rigs if path.is_file()]


def mutated(suffix: str, data: bytes, rng: np.random.Generator) -> bytes:
    """The file with one to three faults, most often one."""
    for _ in range(int(rng.choice([1, 2, 3], p=[0.6, 0.25, 0.15]))):
        choices: list[Mutator] = [_bytes, _cut, _words, _words, _moved]
        if suffix in (".glb", ".gltf"):
            choices += [_json, _json, _json, _floats, _floats]
        if suffix == ".dae":
            choices = [_elements, _attributes, _numbers, _numbers, _bytes]
        data = choices[int(rng.integers(len(choices)))](data, rng)
    return data


def outcome(path: Path) -> str:
    """Read a file; how it ended. Anything but a FormatError comes through."""
    try:
        character = read_character(path)
    except NoMeshError:
        pass
    except FormatError:
        return "refused"
    else:
        _check(character)
        return "character"
    try:
        motion = read_motion(path)
    except FormatError:
        return "refused"
    for clip in motion.clips:
        _check_clip(clip)
    return "motion"


def run(
    inputs: int, seed: int, data: Path | None, tell: Callable[[str], None]
) -> tuple[Counter[str], list[str]]:
    """Read so many mutated files; how they ended, and what is wrong."""
    rng = np.random.default_rng(seed)
    small, real = sources(data)
    ended: Counter[str] = Counter()
    faults: list[str] = []
    slowest = (0.0, "none")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(inputs):
            pool = real if real and rng.random() < REAL_SHARE else small
            suffix, whole = pool[int(rng.integers(len(pool)))]
            path = Path(folder) / f"given{suffix}"
            path.write_bytes(mutated(suffix, whole, rng))
            start = time.process_time()
            try:
                ended[outcome(path)] += 1
            except Exception as fault:
                ended["FAULT"] += 1
                faults.append(f"input {number} ({suffix}): {type(fault).__name__}: {fault}")
                tell(faults[-1])
                kept = os.environ.get("FUZZ_KEEP")
                if kept:
                    (Path(kept) / f"{number}{suffix}").write_bytes(path.read_bytes())
            seconds = time.process_time() - start
            slowest = max(slowest, (seconds, f"input {number} ({suffix}, {path.stat().st_size} B)"))
            if seconds > SLOWEST_S:
                faults.append(f"input {number} ({suffix}) took {seconds:.1f} s")
                tell(faults[-1])
            if number % 5000 == 4999:
                tell(f"{number + 1} inputs: {dict(ended)}, {memory_bytes() >> 20} MiB at most")
    tell(f"slowest: {slowest[1]} in {slowest[0]:.2f} s")
    return ended, faults


def memory_bytes() -> int:
    """Most memory that this process has held."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main() -> int:
    """Run as the module says; 0 where every input ended well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=50_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--data", type=Path, default=None)
    arguments = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    start = time.perf_counter()
    ended, faults = run(arguments.inputs, arguments.seed, arguments.data, print)
    seconds = time.perf_counter() - start
    print(
        f"{arguments.inputs} inputs in {seconds:.0f} s: {dict(ended)}; {len(faults)} faults; "
        f"{memory_bytes() >> 20} MiB at most"
    )
    return 1 if faults else 0


def _check(character: Character) -> None:
    for name in ("vertices", "normals", "colors", "weights"):
        if not np.isfinite(getattr(character, name)).all():
            raise AssertionError(f"{name} are not finite")
    for clip in character.clips:
        _check_clip(clip)


def _check_clip(clip: Clip) -> None:
    middle = clip.at(0.5 * (clip.time_s[0] + clip.time_s[-1]))
    if not (np.isfinite(clip.poses.coefficients).all() and np.isfinite(middle.coefficients).all()):
        raise AssertionError(f"clip '{clip.name}' is not finite")


def _bytes(data: bytes, rng: np.random.Generator) -> bytes:
    made = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        if made:
            made[int(rng.integers(len(made)))] = int(rng.integers(256))
    return bytes(made)


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    start = int(rng.integers(len(data) + 1))
    if rng.random() < 0.5:
        return data[:start]
    return data[:start] + data[start + int(rng.integers(1, 64)) :]


def _words(data: bytes, rng: np.random.Generator) -> bytes:
    found = list(re.finditer(rb"[^\s<>(){}\[\],:\"]+", data[:200_000]))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    word = WORDS[int(rng.integers(len(WORDS)))]
    if rng.random() < 0.3:
        word = found[int(rng.integers(len(found)))][0]
    return data[: one.start()] + word + data[one.end() :]


def _moved(data: bytes, rng: np.random.Generator) -> bytes:
    start, end = np.sort(rng.integers(0, len(data) + 1, 2))
    part = data[start : min(end, start + 200)]
    to = int(rng.integers(len(data) + 1))
    return data[:to] + part + data[to:]


def _floats(data: bytes, rng: np.random.Generator) -> bytes:
    """One number of the binary part is replaced."""
    start = data.find(b"BIN\0")
    if start < 0 or len(data) < start + 12:
        return data
    at = start + 4 + 4 * int(rng.integers((len(data) - start - 4) // 4))
    value = float(rng.choice([np.nan, np.inf, -1.0, 0.0, 1e30, 1e-40, 1e9, 0.5]))
    return data[:at] + struct.pack("<f", value) + data[at + 4 :]


def _elements(data: bytes, rng: np.random.Generator) -> bytes:
    """One XML element is removed, or set beside itself or elsewhere."""
    found = list(re.finditer(rb"<(\w+)[^<>]*(?:/>|>[^<]*</\1>)", data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    if rng.random() < 0.5:
        return data[: one.start()] + data[one.end() :]
    other = found[int(rng.integers(len(found)))]
    return data[: other.end()] + one[0] + data[other.end() :]


def _attributes(data: bytes, rng: np.random.Generator) -> bytes:
    """The value of one XML attribute is replaced, often by another's."""
    return _replaced(data, rng, rb'(?<==")[^"<]*(?=")')


def _numbers(data: bytes, rng: np.random.Generator) -> bytes:
    """One word between tags is replaced, often by another."""
    return _replaced(data, rng, rb"(?<=[>\s])[-\w.]+(?=[\s<])")


def _replaced(data: bytes, rng: np.random.Generator, pattern: bytes) -> bytes:
    found = list(re.finditer(pattern, data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    words = [word for word in WORDS if b"<" not in word and b"\xff" not in word]
    word = words[int(rng.integers(len(words)))]
    if rng.random() < 0.5:
        word = found[int(rng.integers(len(found)))][0]
    return data[: one.start()] + word + data[one.end() :]


def _json(data: bytes, rng: np.random.Generator) -> bytes:
    """One value of the JSON document is replaced, removed or repeated."""
    body = data
    if data[:4] == b"glTF" and len(data) > 20:
        (size,) = struct.unpack_from("<I", data, 12)
        body = data[20 : 20 + size]
    try:
        document = json.loads(body)
    except (ValueError, RecursionError):
        return data
    places: list[tuple[Any, Any]] = []
    waiting = [document]
    while waiting:
        one = waiting.pop()
        keys = list(one) if isinstance(one, dict) else range(len(one))
        for key in keys:
            places.append((one, key))
            if isinstance(one[key], dict | list):
                waiting.append(one[key])
    if not places:
        return data
    holder, key = places[int(rng.integers(len(places)))]
    kind = rng.random()
    if kind < 0.6:
        holder[key] = VALUES[int(rng.integers(len(VALUES)))]
    elif kind < 0.8:
        del holder[key]
    else:
        other, where = places[int(rng.integers(len(places)))]
        copied = json.loads(json.dumps(other[where])) if where in _keys(other) else 0
        holder[key] = copied
    text = json.dumps(document).encode()
    if body is data:
        return text
    return samples.packed(text, data[28 + size :])


def _keys(holder: Any) -> Any:
    return holder if isinstance(holder, dict) else range(len(holder))


if __name__ == "__main__":
    sys.exit(main())
