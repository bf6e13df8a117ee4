"""Which pairs of limbs are legs and which arms, and where in them hips, knees and ankles lie.

Every choice gets the logarithm of a likelihood, up to a constant: proportions of people and of
four-legged animals (after Winter, Biomechanics and Motor Control of Human Movement, 2009: thigh
and shank 0.245 and 0.246 of the height, upper arm and forearm 0.186 and 0.146), where on the
middle line the limbs hang, fingers, and names as hints. Widths are generous: figures are drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from motorcade.animation.anatomy.tree import JointTree, LimbPair
from motorcade.ga.arrays import FloatArray, IntArray

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
