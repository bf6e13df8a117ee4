"""Spines of different numbers of joints, or of joints spaced otherwise: turns shared by length."""

from __future__ import annotations

import numpy as np

from motorcade.animation.retarget.match import Match, along_axes
from motorcade.animation.retarget.roles import body_of
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray

__all__ = ["spread_spine"]

# Joints whose bones lie nearer, as a share of the spine's length, are taken for alike.
ALIKE = 0.01


def spread_spine(match: Match) -> Match:
    """The match with a joint of the source's for each of the target's spine, where its bone lies.

    Each bone of a spine is taken to lie where its middle does, as a share of the way along the
    joints from the spine's first to neck or head. Between two bones of the source a joint is put in
    that turns from its rest by so much of both; beyond the first and the last there is none.
    """
    ours, theirs = _spine(match.target), _spine(match.source)
    if len(ours) < 2 or len(theirs) < 2 or not set(ours) <= set(match.joints):
        return match
    wanted, known = _shares(match.target, ours), _shares(match.source, theirs)
    names, parents = list(match.source.names), list(match.source.parents)
    rest, source_world = [match.source.rest], [match.source_world]
    joints = dict(match.joints)
    for joint, share in zip(ours, wanted, strict=True):
        after = int(np.clip(np.searchsorted(known, share), 1, len(known) - 1))
        a, b = theirs[after - 1], theirs[after]
        part = float(np.clip((share - known[after - 1]) / (known[after] - known[after - 1]), 0, 1))
        if min(part, 1.0 - part) * (known[after] - known[after - 1]) < ALIKE:
            joints[joint] = a if part < 0.5 else b
            continue
        joints[joint] = len(names)
        names.append(f"{match.source.names[a]} to {match.source.names[b]}, {joint}")
        parents.append(a)
        rest.append(Motor.identity((1,)))
        back = match.source.rest_world[b].rotor.inverse() @ match.source.rest_world[a].rotor
        if not match.comparable:  # at rest it is bent as well: frames are built along one another
            back = along_axes(back)
        start, end = match.source_world[:, a], match.source_world[:, b].rotor @ back
        turned = start.rotor.interpolate(end, part)
        between = Motor.from_rotor_translation(turned, start.translation_m)
        source_world.append(between.reshape(-1, 1))
    source = Skeleton(tuple(names), np.array(parents), _joined(rest))
    return Match(source, match.target, joints, _joined(source_world))


def _spine(skeleton: Skeleton) -> list[int]:
    body = body_of(skeleton)
    return [body[role] for role in sorted(body) if role.startswith("spine")]


def _shares(skeleton: Skeleton, spine: list[int]) -> FloatArray:
    """Where the bones' middles lie, rising from 0 to 1 ``(N,)``."""
    body, at = body_of(skeleton), skeleton.rest_world.translation_m
    top = body.get("neck", body.get("head", spine[-1]))
    steps = np.linalg.norm(np.diff(at[[*spine, top]], axis=0), axis=1)
    ends = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-9))])
    made: FloatArray = 0.5 * (ends[:-1] + ends[1:]) / ends[-1]
    return made


def _joined(parts: list[Motor]) -> Motor:
    return Motor(np.concatenate([one.coefficients for one in parts], axis=-2))
