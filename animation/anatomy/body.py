"""A body told from a tree of joints: roles, what is up, and where it faces.

Tree and lengths tell the limbs, whatever the pose and the names; bends, feet, motion and at last
names tell which way it faces, and so the sides. Only where no two limbs are alike do names alone
tell.

Which limbs are legs: every choice gets the logarithm of a likelihood, up to a constant, by the
proportions of people and of four-legged animals (after Winter, Biomechanics and Motor Control of
Human Movement, 2009: thigh and shank 0.245 and 0.246 of the height, upper arm and forearm 0.186 and
0.146), by where on the middle line they hang, fingers, and names as hints. Widths are generous.

Knees bend forward, feet point forward, elbows bend backward, whatever the pose; a walker walks
forward. Where feet have no toes their mesh tells. Names of sides and what the format says count
as hints: exporters see some figures as a viewer does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from motorcade.animation.anatomy.tree import SIDES, JointTree, LimbPair, named_roles, named_sides
from motorcade.animation.vectors import unit
from motorcade.ga.arrays import FloatArray, IntArray

# What each kind of evidence counts, from -1 to 1 times this.
TOES, SKIN, KNEES, ELBOWS, NAMES, HABIT, WAY = 3.0, 3.0, 2.0, 0.7, 1.5, 0.5, 0.7
# Bends, as shares of a limb, from which on evidence counts in full.
CLEAR_BEND = 0.05
# Feet that point less forward, as a cosine, tell nothing.
CLEAR_FOOT = 0.2
# So much evidence is needed.
ENOUGH = 0.45


@dataclass(frozen=True, eq=False)
class Evidence:
    """Limbs of a body in some poses, one side a column.

    Fields:
        legs: hip, knee, ankle ``(3, 2)``, or None.
        arms: shoulder, elbow, wrist ``(3, 2)``, or None.
        toes: joints ``(2,)`` that feet point to, or None.
        trunk: joints whose means its line goes from and to.
    """

    legs: IntArray | None
    arms: IntArray | None
    toes: IntArray | None
    trunk: tuple[list[int], list[int]]

    def axes(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vectors ``(F, 3)``: from the second side to the first, and along the trunk."""
        across = np.zeros((len(at), 3))
        for limb in (self.legs, self.arms):
            if limb is not None:
                across += unit(at[:, limb[0, 0]] - at[:, limb[0, 1]])
        below, above = (at[:, joints].mean(axis=1) for joints in self.trunk)
        return unit(across), unit(above - below)

    def forward(self, at: FloatArray) -> dict[str, float]:
        """Evidence that the first side is the left one, by kind; against it where negative."""
        across, trunk = self.axes(at)
        signs: dict[str, float] = {}
        if self.legs is not None:
            hip, knee, ankle = (at[:, joints] for joints in self.legs)
            ahead = unit(np.cross(across[:, None], hip - ankle))
            signs["knees"] = KNEES * _bent(hip, knee, ankle, ahead)
            if self.toes is not None:
                step = unit(at[:, self.toes] - ankle)
                shin = unit(np.cross(across[:, None], knee - ankle))
                share = float(np.mean(np.sum(step * shin, axis=-1)))
                signs["toes"] = TOES * float(np.clip(share / 0.5, -1.0, 1.0))
                if abs(share) < CLEAR_FOOT:
                    signs["toes"] = 0.0
        if self.arms is not None:
            shoulder, elbow, wrist = (at[:, joints] for joints in self.arms)
            ahead = np.repeat(unit(np.cross(across, trunk))[:, None], 2, axis=1)
            signs["elbows"] = -ELBOWS * _bent(shoulder, elbow, wrist, ahead)
        return signs


def _bent(start: FloatArray, middle: FloatArray, end: FloatArray, ahead: FloatArray) -> float:
    """How far, from -1 to 1, limbs ``(F, 2, 3)`` are bent ahead on average."""
    line = end - start
    along = np.sum((middle - start) * line, axis=-1) / np.maximum(np.sum(line**2, axis=-1), 1e-18)
    off = middle - start - along[..., None] * line
    size = np.linalg.norm(middle - start, axis=-1) + np.linalg.norm(end - middle, axis=-1)
    share = np.sum(off * ahead, axis=-1) / np.maximum(size, 1e-12)
    return float(np.clip(np.mean(share) / CLEAR_BEND, -1.0, 1.0))


# A trunk within this of what is said to be up stands; one farther from its legs lies on four.
STANDING_RAD, ALONG_RAD, ACROSS_RAD = np.radians(60.0), np.radians(35.0), np.radians(50.0)
# What names of sides count for which arm is over which leg; how shoulders lie over hips counts 1.
SAME_NAMES = 0.75


@dataclass(frozen=True, eq=False)
class Body:
    """What the joints of a figure are, and how it lies in the frame of its places.

    Fields:
        roles: joints by role: "hips", "left_thigh", "spine_1", "right_index_2", …
        up: unit vector (3,), or None where limbs do not tell.
        ahead: unit vector (3,) across `up`, or None where nothing tells the front.
        told_by: what told the front most.
        four_legged: whether its arms are forelegs.
        evidence: joints by which motions can be judged, or None without a pair of limbs.
    """

    roles: Mapping[str, int]
    up: FloatArray | None = None
    ahead: FloatArray | None = None
    told_by: str = ""
    four_legged: bool = False
    evidence: Evidence | None = None


def body_from(
    tree: JointTree,
    up: FloatArray | None = None,
    ahead: FloatArray | None = None,
    *,
    habit: float = HABIT,
    motion: FloatArray | None = None,
    skin: FloatArray | None = None,
) -> Body:
    """The body of a figure in its rest pose.

    Args:
        tree: joints at rest.
        up: unit vector (3,) that is said to be up, or None.
        ahead: unit vector (3,) that figures are said to face, or None.
        habit: what `ahead` counts beside other evidence, of which toes count 3.
        motion: places ``(F, J, 3)`` in poses of motions.
        skin: centre ``(J, 3)`` of the vertices that follow each joint, NaN where there are none.

    >>> import numpy as np
    >>> from motorcade.animation.anatomy.body import body_from
    >>> from motorcade.animation.anatomy.tree import JointTree
    >>> leg = np.array([[0.1, 0, 0.9], [0.11, 0, 0.5], [0.1, 0, 0.1], [0.1, -0.1, 0.0]])
    >>> at = np.concatenate([[[0, 0, 1.0]], leg, leg * [-1, 1, 1]])  # a figure that faces -y
    >>> tree = JointTree(tuple("abcdefghi"), np.array([-1, 0, 1, 2, 3, 0, 5, 6, 7]), at)
    >>> body = body_from(tree, up=np.array([0, 0, 1.0]))
    >>> body.roles["left_calf"], body.told_by, body.ahead.round(2) + 0.0
    (2, 'toes', array([ 0., -1.,  0.]))
    """
    named = named_roles(tree.names)
    legs, arms = legs_and_arms(tree, named, up)
    if legs is None and arms is None:
        return Body(_by_names(tree, named))
    if legs is not None and arms is not None and _crossed(tree, legs, arms):
        arms = arms.swapped()
    middle = _middle(tree, legs, arms, named)
    evidence = _evidence(tree, legs, arms, middle, named)
    at = tree.at[None]
    across, trunk = (one[0] for one in evidence.axes(at))
    four_legged, own_up = _stance(tree, evidence, trunk, up)
    if not np.any(own_up):  # arms that begin where all begins: sides and up only by names
        return Body(_by_names(tree, named))
    front = unit(np.cross(across, own_up))
    if four_legged:
        signs = {"trunk": float(np.sign(np.cross(across, own_up) @ trunk)) * TOES}
    else:
        signs = evidence.forward(at)
        for kind, value in ({} if motion is None else _moving(evidence, motion)).items():
            if abs(value) > abs(signs.get(kind, 0.0)):
                signs[kind] = value
        if skin is not None and not signs.get("toes"):
            signs["skin"] = _by_skin(evidence, tree, skin, across)
        signs["names"] = _by_sides(tree, legs, arms)
        if ahead is not None:
            signs["habit"] = habit * float(front @ ahead)
    total = sum(signs.values())
    first = 0 if total >= 0.0 else 1
    strongest = max(signs, key=lambda kind: signs[kind] * (1.0 if total >= 0.0 else -1.0))
    sides = (SIDES[first], SIDES[1 - first])
    roles = middle | _roles(tree, legs, arms, sides, named)
    known = abs(total) >= ENOUGH
    signed = front if first == 0 else -front
    return Body(roles, own_up, signed if known else None, strongest, four_legged, evidence)


def _stance(
    tree: JointTree, evidence: Evidence, trunk: FloatArray, up: FloatArray | None
) -> tuple[bool, FloatArray]:
    """Whether it stands on four legs, and what is up for it at rest."""
    if evidence.legs is not None and evidence.arms is not None:
        limbs = [
            unit((tree.at[limb[0]] - tree.at[limb[2]]).mean(axis=0))
            for limb in (evidence.legs, evidence.arms)
        ]
        alike = _angle(*limbs) < ALONG_RAD
        lies = all(abs(_angle(limb, trunk) - 0.5 * np.pi) < ACROSS_RAD for limb in limbs)
        stands = up is not None and _angle(trunk, up) < STANDING_RAD
        fingers = any(len(tree.children[int(hand)]) >= FEWEST_FINGERS for hand in evidence.arms[2])
        if alike and lies and not stands and not fingers:
            own = unit(limbs[0] + limbs[1])
            return True, own if up is None or _angle(own, up) > STANDING_RAD else up
    stands = up is not None and (_angle(trunk, up) < STANDING_RAD or not np.any(trunk))
    return False, up if up is not None and stands else trunk


def _evidence(
    tree: JointTree,
    legs: Limbs | None,
    arms: Limbs | None,
    middle: Mapping[str, int],
    named: Mapping[int, str],
) -> Evidence:
    below = [middle["hips"]] if "hips" in middle else [tree.line(_any(legs or arms))[-1]]
    above = [middle[role] for role in ("neck", "head") if role in middle][:1]
    if legs is not None:
        below = [int(joint) for joint in legs.joints[0]]
    if arms is not None:
        above = [int(joint) for joint in arms.joints[0]]
    elif legs is not None and not above:  # of legs alone the trunk goes on as they do
        below, above = ([int(joint) for joint in legs.joints[part]] for part in (2, 0))
    toes = None if legs is None else _toes(tree, legs, named)
    return Evidence(
        None if legs is None else legs.joints,
        None if arms is None else arms.joints,
        None if toes is None else np.array(toes),
        (below, above or below),
    )


def _crossed(tree: JointTree, legs: Limbs, arms: Limbs) -> bool:
    """Whether the arms' first side is the legs' second: by how they lie, and by names of sides."""
    lies = [
        unit(tree.at[limbs.joints[0, 0]] - tree.at[limbs.joints[0, 1]]) for limbs in (legs, arms)
    ]
    named = [_by_sides(tree, limbs, None) / NAMES for limbs in (legs, arms)]
    return float(lies[0] @ lies[1]) + SAME_NAMES * named[0] * named[1] < 0.0


def _any(limbs: Limbs | None) -> int:
    assert limbs is not None  # one of the two pairs there is
    return int(limbs.joints[0, 0])


def _toes(tree: JointTree, legs: Limbs, named: Mapping[int, str]) -> list[int] | None:
    """What follows the ankles: what names call toes, or else the joints that follow."""
    ankles = [int(joint) for joint in legs.joints[2]]
    called = [
        next((k for k, r in named.items() if r.endswith("_toes") and tree.is_below(k, ankle)), -1)
        for ankle in ankles
    ]
    if min(called) >= 0:
        return called
    size = float(tree.bone[legs.joints[1:]].sum())
    after = legs.pair.chains[legs.parts[2] + 1 :]
    long = [row for row in after if tree.bone[row].min() > 0.01 * size]
    return [int(joint) for joint in long[0]] if long else None


def _moving(evidence: Evidence, motion: FloatArray) -> dict[str, float]:
    """Evidence of motions, and the way that is gone."""
    moving = evidence.forward(motion)
    across, trunk = evidence.axes(motion)
    below = evidence.trunk[0]
    step = np.diff(motion[:, below].mean(axis=1), axis=0)
    size = np.linalg.norm(np.diff(motion[:, evidence.trunk[1]].mean(axis=1), axis=0), axis=1)
    if len(step) and float(size.sum()) > 0.0:
        front = unit(np.cross(across, trunk))[:-1]
        moving["way"] = WAY * float(
            np.sum(step * front) / max(np.linalg.norm(step, axis=1).sum(), 1e-12)
        )
    return moving


def _by_skin(evidence: Evidence, tree: JointTree, skin: FloatArray, across: FloatArray) -> float:
    """Where the mesh of the feet lies before and behind the ankles."""
    if evidence.legs is None:
        return 0.0
    _, knee, ankle = (tree.at[joints] for joints in evidence.legs)
    step = skin[evidence.legs[2]] - ankle
    if not np.isfinite(step).all():
        return 0.0
    shin = knee - ankle
    ahead = unit(np.cross(across, shin))
    share = np.sum(step * ahead, axis=-1) / np.linalg.norm(shin, axis=-1)
    return SKIN * float(np.clip(np.mean(share) / 0.1, -1.0, 1.0))


def _by_sides(tree: JointTree, legs: Limbs | None, arms: Limbs | None) -> float:
    """What names of sides say about the first column."""
    sides = named_sides(tree.names)
    said = [
        (1.0 if sides[int(joint)] == SIDES[column] else -1.0)
        for limbs in (legs, arms)
        if limbs is not None
        for row in limbs.joints
        for column, joint in enumerate(row)
        if sides[int(joint)]
    ]
    return NAMES * float(np.mean(said)) if said else 0.0


def _middle(
    tree: JointTree, legs: Limbs | None, arms: Limbs | None, named: Mapping[int, str]
) -> dict[str, int]:
    """Hips, neck and head: as names say where these fit, else what limbs hang on and what goes on.

    Of hips that names say twice, one below the other, the lower.
    """
    pairs = [limbs.pair for limbs in (legs, arms) if limbs is not None]
    limb = {int(one[0, c]) for one in (pair.chains for pair in pairs) for c in (0, 1)}
    middle: dict[str, int] = {}
    for joint, role in named.items():
        if role not in ("hips", "neck", "head") or any(tree.is_below(joint, k) for k in limb):
            continue
        if role not in middle or (role == "hips" and middle["hips"] == tree.parents[joint]):
            middle[role] = joint
    if "hips" not in middle and legs is not None and legs.pair.above >= 0:
        middle["hips"] = legs.pair.above
    if "head" in middle or arms is None:
        return middle
    kept = {k for one in limb for k in tree.line(one)}
    chain: list[int] = []
    onward = [k for k in tree.children[arms.pair.above] if k not in kept]
    while onward:
        chain.append(
            max(onward, key=lambda joint_below: tree.bone[joint_below] + tree.reach[joint_below])
        )
        onward = tree.children[chain[-1]]
    if chain:
        middle["head"] = chain[_head(tree, chain)]
        if _head(tree, chain) > 0:
            middle.setdefault("neck", chain[0])
    return middle


def _head(tree: JointTree, chain: list[int]) -> int:
    """Which joint of a neck is the head: where it branches, or before the longest bone at its end.

    Skulls are longer than bones of necks; a neck of one bone has its head at the end.
    """
    for place, joint in enumerate(chain[1:], start=1):
        if len(tree.children[joint]) > 1:
            return place
    if len(chain) < 3:
        return len(chain) - 1
    return len(chain) - (2 if tree.bone[chain[-1]] > tree.bone[chain[-2]] else 1)


def _roles(
    tree: JointTree,
    legs: Limbs | None,
    arms: Limbs | None,
    sides: tuple[str, str],
    named: Mapping[int, str],
) -> dict[str, int]:
    roles: dict[str, int] = {}
    for kind, limbs in (("leg", legs), ("arm", arms)):
        if limbs is None:
            continue  # no two are alike: names tell, below
        toes = _toes(tree, limbs, named) if BEYOND[kind] else None
        for column, side in enumerate(sides):
            for part, row in zip(PARTS[kind], limbs.joints, strict=True):
                roles[f"{side}_{part}"] = int(row[column])
            if toes is not None:
                roles[f"{side}_toes"] = toes[column]
            if kind == "arm" and limbs.parts[0] > 0:
                roles[f"{side}_clavicle"] = int(limbs.pair.chains[limbs.parts[0] - 1, column])
            below = int(limbs.pair.chains[0, column])
            for joint, role in named.items():
                part = role.partition("_")[2]
                if part and tree.is_below(joint, below) and joint not in roles.values():
                    roles.setdefault(f"{side}_{part}", joint)
    astray = _by_sides(tree, legs, arms) * (1.0 if sides == SIDES else -1.0) < 0.0
    alone = {
        part
        for kind, limbs in (("leg", legs), ("arm", arms))
        for part in (*PARTS[kind], *BEYOND[kind])
        if limbs is None
    }
    for joint, role in named.items():
        if role.partition("_")[2] in alone and joint not in roles.values():
            roles.setdefault(_other(role) if astray else role, joint)
    return roles


def _by_names(tree: JointTree, named: Mapping[int, str]) -> dict[str, int]:
    """Roles of a tree in which no two limbs are alike."""
    chosen: dict[str, int] = {}
    for joint, role in named.items():
        if role == "hips" and chosen.get("hips", -1) == tree.parents[joint]:
            chosen["hips"] = joint
        chosen.setdefault(role, joint)
    if "hips" not in chosen and all(f"{side}_thigh" in chosen for side in SIDES):
        lines = [tree.line(chosen[f"{side}_thigh"]) for side in SIDES]
        chosen["hips"] = next((k for k in lines[0] if k in lines[1]), lines[0][-1])
    return (
        chosen if not _mirrored(tree, chosen) else {_other(role): k for role, k in chosen.items()}
    )


def _mirrored(tree: JointTree, roles: Mapping[str, int]) -> bool:
    """Whether what names call left lies to the right of where toes point, z up."""
    ahead, across = np.zeros(3), np.zeros(3)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        if not {f"{side}_foot", f"{side}_toes"} <= set(roles):
            return False
        ahead += tree.at[roles[f"{side}_toes"]] - tree.at[roles[f"{side}_foot"]]
        for part in ("thigh", "upper_arm"):
            across += sign * tree.at[roles[f"{side}_{part}"]] if f"{side}_{part}" in roles else 0.0
    return float(np.cross(ahead, across)[2]) < 0.0


def _other(role: str) -> str:
    side, sign, part = role.partition("_")
    return SIDES[1 - SIDES.index(side)] + sign + part if side in SIDES else role


def _angle(a: FloatArray, b: FloatArray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


# Logarithm of upper over lower part, and its spread; what comes before the upper part and after
# the lower one, as shares of both, up to which it costs nothing, and spreads.
LEG = {"ratio": (0.0, 0.3), "before": (0.0, 0.25), "after": (0.6, 0.3)}
ARM = {"ratio": (0.1, 0.3), "before": (0.4, 0.25), "after": (0.7, 0.3)}
# Bones laid end to end make one part where the way along them is this little longer than straight.
STRAIGHT = 0.05
# Shoulders lie apart by at least this share of an arm, as far as they carry it.
SHOULDERS, SHOULDERS_SPREAD = 0.35, 0.12
LEAST = -12.0
FEWEST_FINGERS = 3
# What evidence of other kinds is worth beside proportions.
ORDER, HEAD, HAND, NAMED, LOWER, SMALL = 4.0, 1.5, 2.0, 3.0, 2.0, 1.0
# Limbs are at least so long, as a share of the longest.
SHORTEST = 0.3
PARTS = {"leg": ("thigh", "calf", "foot"), "arm": ("upper_arm", "forearm", "hand")}
BEYOND = {"leg": ("toes",), "arm": ()}


@dataclass(frozen=True, eq=False)
class Limbs:
    """A pair of limbs with its parts.

    Fields:
        parts: three places in the chains: hip, knee, ankle or shoulder, elbow, wrist.
        score: logarithm of a likelihood.
    """

    pair: LimbPair
    parts: tuple[int, int, int]
    score: float

    @property
    def joints(self) -> IntArray:
        """``(3, 2)``, one side a column."""
        return self.pair.chains[list(self.parts)]

    def swapped(self) -> Limbs:
        """The same with its sides in the other order."""
        return replace(self, pair=replace(self.pair, chains=self.pair.chains[:, ::-1]))


def fitted(tree: JointTree, pair: LimbPair, kind: str, named: Mapping[int, str]) -> Limbs | None:
    """The likeliest hip, knee and ankle (or shoulder, elbow and wrist) of a pair of limbs."""
    chains = pair.chains
    if len(chains) < 3:
        return None
    at = tree.at[chains]
    bones = np.linalg.norm(np.diff(at, axis=0), axis=-1).mean(axis=1)
    ends = np.concatenate([[0.0], np.cumsum(bones)])
    if ends[-1] <= 0.0:
        return None
    width = LEG if kind == "leg" else ARM
    best: Limbs | None = None
    for parts in combinations(range(len(chains)), 3):
        upper, lower = ends[parts[1]] - ends[parts[0]], ends[parts[2]] - ends[parts[1]]
        if min(upper, lower) <= 0.02 * ends[-1]:
            continue
        size = upper + lower
        score = 2.0 * float(np.log(size / ends[-1]))
        middle, spread = width["ratio"]
        score -= 0.5 * ((np.log(upper / lower) - middle) / spread) ** 2
        for name, share in (("before", ends[parts[0]]), ("after", ends[-1] - ends[parts[2]])):
            free, spread = width[name]
            score -= 0.5 * (max(0.0, share / size - free) / spread) ** 2
        for start, end in pairwise(parts):
            if end - start > 1:
                crow = float(np.linalg.norm(at[end] - at[start], axis=-1).mean())
                bent = 1.0 - crow / (ends[end] - ends[start])
                score -= min(0.5 * (bent / STRAIGHT) ** 2, -LEAST)
        if kind == "arm":
            score += _of_arm(tree, chains[parts[0]], chains[parts[2]], size)
        for place, part in zip(parts, PARTS[kind], strict=True):
            score += _hint(chains[place], part, named)
        if best is None or score > best.score:
            best = Limbs(pair, parts, float(score))
    return best


def _of_arm(tree: JointTree, shoulders: IntArray, hands: IntArray, size: float) -> float:
    """Shoulders apart, and fingers."""
    across = float(np.linalg.norm(tree.at[shoulders[0]] - tree.at[shoulders[1]])) / size
    fingers = min(sum(tree.bone[k] > 0.0 for k in tree.children[hand]) for hand in hands)
    near = 0.5 * (max(0.0, SHOULDERS - across) / SHOULDERS_SPREAD) ** 2
    return (HAND if fingers >= FEWEST_FINGERS else 0.0) - min(near, -LEAST)


def _hint(joints: IntArray, part: str, named: Mapping[int, str]) -> float:
    """What names say for and against a part, of both sides."""
    said = [named.get(int(joint), "").partition("_")[2] for joint in joints]
    return float(sum(0.5 * NAMED * ((one == part) - 0.5 * (one not in ("", part))) for one in said))


def legs_and_arms(
    tree: JointTree, named: Mapping[int, str], up: FloatArray | None
) -> tuple[Limbs | None, Limbs | None]:
    """The likeliest legs (hind legs of an animal) and arms (forelegs); None for what is not there.

    Args:
        tree: in its rest pose.
        named: roles that names tell, as hints.
        up: unit vector of what is up where the rest pose stands, or None.
    """
    pairs = [pair for pair in tree.limb_pairs if len(pair.chains) >= 3]
    longest = max((_length(tree, pair) for pair in pairs), default=0.0)
    pairs = [pair for pair in pairs if _length(tree, pair) >= SHORTEST * longest > 0.0]
    legs = [fit for pair in pairs if (fit := fitted(tree, pair, "leg", named)) is not None]
    arms = [fit for pair in pairs if (fit := fitted(tree, pair, "arm", named)) is not None]
    best: tuple[Limbs, Limbs] | None = None
    most = -np.inf
    for leg in legs:
        for arm in arms:
            if leg.pair is arm.pair:
                continue
            score = leg.score + arm.score + _apart(tree, leg.pair, arm.pair, up, longest)
            if score > most:
                best, most = (leg, arm), score
    if best is not None:
        return best
    if not legs or not arms:
        return legs[0] if legs else None, arms[0] if arms else None
    leg, arm = (max(fits, key=lambda fit: fit.score) for fits in (legs, arms))
    low = 0.0 if up is None else float(np.diff(tree.at[leg.joints].mean(axis=1) @ up)[0])
    return (leg, None) if leg.score - low / longest >= arm.score else (None, arm)


def _apart(
    tree: JointTree, legs: LimbPair, arms: LimbPair, up: FloatArray | None, longest: float
) -> float:
    """What tells legs from arms by where they hang and end."""
    score = 0.0
    if legs.above != arms.above:
        score += ORDER * (tree.is_below(arms.above, legs.above) if arms.above >= 0 else 0)
        score -= ORDER * (tree.is_below(legs.above, arms.above) if legs.above >= 0 else 0)
    if _goes_on(tree, arms):
        score += HEAD
    if _goes_on(tree, legs) and not tree.is_below(arms.above, legs.above):
        score -= HEAD
    lengths = [_length(tree, pair) for pair in (legs, arms)]
    score += SMALL * float(np.log(lengths[0] * lengths[1] / longest**2))
    if up is not None:
        ends = [tree.at[pair.chains[-1]].mean(axis=0) @ up for pair in (legs, arms)]
        score += LOWER * float(np.clip((ends[1] - ends[0]) / (0.3 * longest), -1.0, 1.0))
    return score


def _goes_on(tree: JointTree, pair: LimbPair) -> bool:
    """Whether what the limbs hang on has a bone more, as a neck or a spine."""
    others = [joint for joint in tree.children[pair.above] if joint not in pair.chains[0]]
    return any(tree.bone[joint] + tree.reach[joint] > 0.0 for joint in others)


def _length(tree: JointTree, pair: LimbPair) -> float:
    at = tree.at[pair.chains]
    return float(np.linalg.norm(np.diff(at, axis=0), axis=-1).mean(axis=1).sum())
