"""Words in names of joints: hints on what they are.

Rigs name joints by the words of Mixamo, Biped, Unreal and MakeHuman, Blender, motion capture, or
their own; sides stand before or after, whole or as a letter. What all names begin with, and
numbers with which all of them end, says nothing.
"""

from __future__ import annotations

import re
from collections import Counter

SIDES = ("left", "right")
# Words for parts, where several name joints of one limb the one nearest to the trunk is taken.
CENTRAL = {
    "hips": "hips",
    "pelvis": "hips",
    "hip": "hips",
    "neck": "neck",
    "neck1": "neck",
    "head": "head",
}
SIDED = {
    "thigh": ("thigh", "upleg", "upperleg", "femur"),
    "calf": ("calf", "leg", "lowerleg", "lowleg", "shin", "knee", "knee1", "tibia"),
    "foot": ("foot", "ankle"),
    "toes": ("toe", "toes", "toebase", "toeball", "ball", "toe0", "footthumb1"),
    "clavicle": ("clavicle", "collar"),
    "upper_arm": ("arm", "upperarm", "uparm", "humerus", "bicep", "shldr"),
    "forearm": ("forearm", "lowerarm", "lowarm", "ulna", "elbow"),
    "hand": ("hand", "wrist"),
}
PART_OF = {word: part for part, words in SIDED.items() for word in words}
FINGER = re.compile(
    r"(?:hand)?(thumb|index|middle|ringpinky|ring|pinky|little)(?:finger)?"
    r"(1|2|3|prox|med|dist|metacarpal|proximal|intermediate|distal)"
)
FINGERS = {"ringpinky": "little", "pinky": "little"}
PHALANX = {"prox": "1", "med": "2", "dist": "3"}
PHALANX |= {"proximal": "1", "intermediate": "2", "distal": "3"}
# A thumb has no intermediate phalanx: VRM 1 calls its first joint so, and its second proximal.
THUMB = {"metacarpal": "1", "proximal": "2"}
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
CONTROL = re.compile(r"(?<![A-Za-z])ik|IK|ik(?![a-z])|[Cc]ontrol|[Rr]oll|[Pp]ole|[Tt]arget")
# Of so many names most must begin or end alike, for that to say nothing.
FEWEST_NAMES, MOST_ALIKE = 6, 0.9


def named_roles(names: tuple[str, ...]) -> dict[int, str]:
    """Roles by joint, as far as names tell them; several joints may have one."""
    words = [_side_and_part(name) for name in _bare(names)]
    roles = {}
    for joint, (side, part) in enumerate(words):
        role = _role(side, part, words)
        if role and not CONTROL.search(names[joint]):
            roles[joint] = role
    return roles


def named_sides(names: tuple[str, ...]) -> list[str]:
    """The side that each name tells; "" for none."""
    return [_side_and_part(name)[0] for name in _bare(names)]


def named_eyes(names: tuple[str, ...]) -> list[int]:
    """Joints of eyes, as far as names tell them."""
    parts = [_side_and_part(name)[1] for name in _bare(names)]
    return [joint for joint, part in enumerate(parts) if part in ("eye", "eyeball")]


def _bare(names: tuple[str, ...]) -> list[str]:
    """Names without what most of them begin with, and without numbers that end most of them."""
    bare_names = [name.rsplit(":", 1)[-1] for name in names]
    if len(names) < FEWEST_NAMES:
        return bare_names
    while True:
        starts = Counter(name.split("_", 1)[0] for name in bare_names if "_" in name)
        start, times = starts.most_common(1)[0] if starts else ("", 0)
        if times < MOST_ALIKE * len(names) or start.lower() in (*SIDES, "l", "r"):
            break
        bare_names = [name.removeprefix(start + "_") for name in bare_names]
    ends = [re.fullmatch(r"(.+)_\d+", name) for name in bare_names]
    if sum(end is not None for end in ends) >= MOST_ALIKE * len(names):
        bare_names = [end[1] if end else name for end, name in zip(ends, bare_names, strict=True)]
    return bare_names


def _role(side: str, part: str, words: list[tuple[str, str]]) -> str:
    if not side:
        return CENTRAL.get(part, "")
    finger = FINGER.fullmatch(part)
    if finger:
        name, phalanx = finger.groups()
        if name == "thumb" and (side, "thumbmetacarpal") in words:
            phalanx = THUMB.get(phalanx, phalanx)
        if phalanx == "metacarpal":  # of other fingers it lies in the palm
            return ""
        return f"{side}_{FINGERS.get(name, name)}_{PHALANX.get(phalanx, phalanx)}"
    known = {PART_OF.get(word, "") for at, word in words if at == side}
    if part == "shoulder":  # the collarbone where the upper arm has a word of its own
        part = "clavicle" if known >= {"upper_arm"} and "clavicle" not in known else "arm"
    if part == "hip" and "thigh" not in known:
        part = "thigh"
    return f"{side}_{PART_OF[part]}" if part in PART_OF else ""


def _side_and_part(name: str) -> tuple[str, str]:
    """("left", "upleg") of ``mixamorig:LeftUpLeg``; a side of "" where there is none."""
    words = [word.lower() for word in WORD.findall(name.rsplit(":", 1)[-1])]
    words = [str(int(word)) if word.isdigit() else word for word in words]
    if words and words[0] in ("bip", "mixamorig"):
        words = words[2:] if len(words) > 1 and words[1].isdigit() else words[1:]
    side = ""
    for at in (0, -1, 1):
        if len(words) <= max(at, 0) or side:
            continue
        for whole in SIDES:
            if words[at] in (whole, whole[0]):
                side = whole
                del words[at]
                break
            if words[at].startswith(whole):
                side, words[at] = whole, words[at][len(whole) :]
                break
    return side, "".join(words)
