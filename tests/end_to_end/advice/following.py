"""Does what a message of the command line says, word for word, as somebody who trusts it would.

Every rule reads the message alone: which word to replace, which option to add, which file to sort.
What only the user can know, such as the rate of a camera, comes from what the case says is `known`;
a message must then name the option or the key under which it is to be said.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

Words = list[str]
Known = Mapping[str, str | None]
Rule = Callable[[re.Match[str], Words, Known], "list[Words]"]

NEW_NAME = "elsewhere"


def followed(message: str, words: Words, known: Known) -> list[Words]:
    """The command lines to give next, in their order; files that the message names are changed.

    Raises:
        AssertionError: the message says nothing that could be done.
    """
    for pattern, rule in RULES:
        found = re.search(pattern, message)
        if found is not None:
            lines = rule(found, list(words), known)
            if lines:
                return lines
    raise AssertionError(f"nothing to be done about: {message}")


def _swapped(words: Words, wrong: str, right: str) -> list[Words]:
    """The word that is wrong, or the part of a word, replaced."""
    assert any(wrong in word for word in words), f"{wrong!r} is not in {words}"
    exact = wrong in words
    return [
        [(right if word == wrong else word) if exact else word.replace(wrong, right, 1)
         for word in words]
    ]  # fmt: skip


def _meant(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    before, right = found[1], found[2]
    quoted = re.findall(r"'([^']*)'", before)
    options = re.findall(r"(?:arguments:|no option) (--?[\w-]+)", before)
    wrong = options[-1] if options else quoted[-1].partition("=")[0]
    manifest = re.match(r"(?:motorcade: )?(\S+\.toml), ", before)
    if manifest is None:
        return _swapped(words, wrong, right)
    text = Path(manifest[1]).read_text()
    assert text.count(wrong) == 1
    Path(manifest[1]).write_text(text.replace(wrong, right))
    return [words]


def _option(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """The first option that the message offers and whose value is known; a flag has none."""
    for option in re.findall(r"(?<![\w-])--?[a-z][\w-]*", found[0]):
        if option in known:
            value = known[option]
            if option in words and value is not None:
                words[words.index(option) + 1] = value
                return [words]
            return [[*words, option, *([] if value is None else [value])]]
    return []


def _ending(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    (wrong,) = [word for word in words if word in found.string and Path(word).suffix]
    return _swapped(words, wrong, str(Path(wrong).with_suffix(found[1])))


def _example(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """What the message gives as an example, in the place of what it refuses."""
    refused = re.findall(r"got '([^']*)'|: (\S+) is one board", found.string)
    wrong = "".join(refused[-1])
    return _swapped(words, wrong, found[1])


def _key(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    file, table, key = found[1], found[2], found[3]
    value = known.get(key)
    if value is None:
        return []
    text = Path(file).read_text()
    Path(file).write_text(text.replace(f"[{table}]\n", f"[{table}]\n{key} = {value}\n"))
    return [words]


def _left_out(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    file, what = Path(found[1]), found[2]
    if what == "the image":
        file.unlink()
        return [words]
    kept = [line for line in file.read_text().splitlines() if not line.startswith(what)]
    file.write_text("\n".join(kept) + "\n")
    return [words]


def _sorted(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    file = Path(found[1])
    rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    file.write_text("\n".join(sorted(rows, key=lambda row: float(row.split()[0]))) + "\n")
    return [words]


def _copied(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    file = Path(found[1])
    source = known["copy"]
    assert source is not None
    file.write_bytes((Path(source) / file.name).read_bytes())
    return [words]


def _apart(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """Each of several recordings by itself, with an output folder of its own."""
    recordings = [word for word in words[1:] if Path(word).is_dir()]
    rest = [word for word in words[1:] if word not in recordings]
    return [
        [words[0], one, *rest, "--out", f"{NEW_NAME}{number}"]
        for number, one in enumerate(recordings)
    ]


def _instead(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """Another name where the message asks for one, without an ending for a folder."""
    option, taken = found[1], found[2]
    at = words.index("-o" if option == "--output" and "-o" in words else option)
    words[at + 1] = NEW_NAME if "folder for" in found[0] else f"{NEW_NAME}{Path(taken).suffix}"
    return [words]


def _at_least(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    words[words.index(found[1]) + 1] = found[2]
    return [words]


def _topic(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    bag, topic = found[1], found[2]
    return [[f"{bag}:{topic}" if word.split(":")[0] == bag else word for word in words]]


def _one_of_both(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    at = words.index(found[1])
    return [words[:at] + words[at + 2 :]]


def _once(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    twice = next(word for word in words if words.count(word) > 1)
    words.remove(twice)
    return [words]


def _one_file(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    del words[words.index(found[1]) + 2]
    return [words]


def _until(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    words[words.index("--until") + 1] = found[1]
    return [words]


def _smaller(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    smaller = known["smaller"]
    assert smaller is not None
    return _swapped(words, found[1], smaller)


def _paper(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    return [[*words, "--paper", found[1]]]


def _quoted(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """A command that the message quotes, then the same again; RECORDING is what the user has."""
    recording = known.get("RECORDING")
    quoted = found[1].replace("RECORDING", recording or "RECORDING")
    more = shlex.split(known.get("more") or "")
    return [[*shlex.split(quoted)[1:], *more], words]


def _said(found: re.Match[str], words: Words, known: Known) -> list[Words]:
    """Options as the message writes them, with their value."""
    return [[*words, *shlex.split(found[1])]]


RULES: tuple[tuple[str, Rule], ...] = (
    (r"^(.*)did you mean (\S+?)\?$", _meant),
    (r"name one of them as (\S+):NAME: '([^']+)'", _topic),
    (r"its recording has changed since; run it again: (motorcade .*)$", _quoted),
    (r"`(motorcade (?:run|inspect) [^`]*)`", _quoted),
    (r"\((--offset-s \S+)\) says so", _said),
    (r"(?:such as|metres as) ([^\s(),]+(?:,\d+)*)[ ,]", _example),
    (r"expected a name (?:that ends|ending) in (\.\w+)", _ending),
    (r"run them one at a time, each with its own --out", _apart),
    (r"(--output) (\S+): (?:this is one of the inputs|expected a folder for)", _instead),
    (r"print it on (\w+)", _paper),
    (r": (\w+): needs .* make it smaller", _smaller),
    (r"(--[\w-]+): expected (\d+) or more", _at_least),
    (r"(--[\w-]+): expected .*, got both", _one_of_both),
    (r"expected each file once", _once),
    (r"(--[\w-]+): expected one file", _one_file),
    (r"expected a run up to (\w+) or a later stage", _until),
    (r": (\S+), line \d+: .*; sort the file by its stamps", _sorted),
    (r": (\S+?),(?: \[.*)?.* leave (the image|\w+) out", _left_out),
    (r": ([^\s,]+\.\w+)[,:] .*copy the (?:file|image) again", _copied),
    (r": (\S+\.toml), \[(\w+)\] (\w+): the key is missing", _key),
    (r": (\S+\.toml), \[(\w+)\] .*? with (\w+), or give", _key),
    (r"(?:give|choose another|expected|--?\w[\w-]*: expected|; or) .*", _option),
)
"""What a message says, and what is done about it; the first that has something to do counts."""
