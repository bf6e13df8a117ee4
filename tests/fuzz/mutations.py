"""Faults that a fuzzer puts into files: bytes, words, lines, XML, JSON, floats.

Each takes the content and random numbers, and gives the content with one fault.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.animation.formats import samples

__all__ = ["VALUES", "WORDS", "changed_tree", "mutated", "one_of", "reworded", "tokens"]

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
Mutator = Callable[[bytes, np.random.Generator], bytes]
_TOKEN = re.compile(rb"[-+]?\.?\d(?:[eE][-+]|[\w.])*|[A-Za-z_]\w*")
_NUMBERS = b"0 1 -1 2 3 0.5 1.0 -0.25 1e-3 1e3 10 24 90 255 65536 4294967296 1e-320 1e308".split()


def one_of(items: Any, rng: np.random.Generator) -> Any:
    """One of the items."""
    return items[int(rng.integers(len(items)))]


def mutated(suffix: str, data: bytes, rng: np.random.Generator) -> bytes:
    """The file with one to three faults, most often one."""
    for _ in range(int(rng.choice([1, 2, 3], p=[0.6, 0.25, 0.15]))):
        choices: list[Mutator] = [_bytes, _cut, _words, _words, _moved]
        if suffix in (".glb", ".gltf", ".json"):
            choices += [_json, _json, _json, _floats, _floats]
        if suffix == ".dae":
            choices = [_elements, _attributes, _numbers, _numbers, _bytes]
        data = one_of(choices, rng)(data, rng)
    return data


def tokens(text: bytes) -> tuple[list[bytes], list[bytes]]:
    """The numbers and the words of a text, each once; numbers that matter anywhere are added."""
    found = dict.fromkeys(_TOKEN.findall(text))
    numbers = [one for one in found if not one[:1].isalpha() and one[:1] != b"_"]
    words = [one for one in found if one not in set(numbers)]
    return [*numbers, *_NUMBERS], words


def reworded(
    data: bytes, known: tuple[list[bytes], list[bytes]], rng: np.random.Generator
) -> bytes:
    """One to three numbers or words are replaced by others of `tokens`, or a line by a line."""
    for _ in range(int(rng.choice([1, 2, 3], p=[0.6, 0.25, 0.15]))):
        if rng.random() < 0.15:
            data = _line_moved(data, rng)
            continue
        found = list(_TOKEN.finditer(data))
        if not found:
            return data
        one = one_of(found, rng)
        is_word = one[0][:1].isalpha() or one[0][:1] == b"_"
        if is_word and rng.random() < 0.7:  # more numbers than words may stand for another
            continue
        others = known[is_word]
        if others:
            data = data[: one.start()] + one_of(others, rng) + data[one.end() :]
    return data


def _line_moved(data: bytes, rng: np.random.Generator) -> bytes:
    """A line is lost, repeated, or set elsewhere."""
    lines = data.split(b"\n")
    line = lines.pop(int(rng.integers(len(lines))))
    for _ in range(int(rng.integers(3))):
        lines.insert(int(rng.integers(len(lines) + 1)), line)
    return b"\n".join(lines)


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
    changed_tree(document, rng)
    text = json.dumps(document).encode()
    if body is data:
        return text
    return samples.packed(text, data[28 + size :])


def changed_tree(document: Any, rng: np.random.Generator) -> None:
    """Replace, remove or repeat one value of a JSON tree, in place."""
    places: list[tuple[Any, Any]] = []
    waiting = [document]
    while waiting:
        one = waiting.pop()
        for key in _keys(one):
            places.append((one, key))
            if isinstance(one[key], dict | list):
                waiting.append(one[key])
    if not places:
        return
    holder, key = one_of(places, rng)
    kind = rng.random()
    if kind < 0.6:
        holder[key] = one_of(VALUES, rng)
    elif kind < 0.8:
        del holder[key]
    else:
        other, where = one_of(places, rng)
        holder[key] = json.loads(json.dumps(other[where])) if where in _keys(other) else 0


def _keys(holder: Any) -> Any:
    if isinstance(holder, dict):
        return list(holder)
    return range(len(holder)) if isinstance(holder, list) else ()
