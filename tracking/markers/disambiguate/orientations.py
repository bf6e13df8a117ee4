"""Orientations of cameras and markers in one world, from observations that may be either candidate.

Expectation-maximisation (Dempster, Laird & Rubin 1977): candidates are weighed by how well they fit
the orientations, orientations are averaged over candidates so weighed, each with its own
uncertainty. A marker keeps several orientations, since before the camera has moved two fit equally.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.markers.disambiguate.window import MODES, Memory, Window, influence, misfit

# Keeps what no observation says anything about where it is.
_SLACK = 1e-6


@dataclass(frozen=True, eq=False)
class Orientations:
    """Orientations of F frames and K markers, with H modes each.

    Args:
        world_R_camera: Rotor ``(F,)``.
        world_R_marker: Rotor ``(K, H)``.
        information: ``(K, H, 3, 3)`` of the markers' orientations, world axes.
    """

    world_R_camera: Rotor
    world_R_marker: Rotor
    information: FloatArray


def seeded(window: Window, world_R_camera: Rotor, memory: Memory) -> Orientations:
    """Begin with what is remembered; of new markers with candidates of two clear observations."""
    clearest = np.linalg.slogdet(window.information[:, 0])[1]
    order = np.lexsort((np.arange(len(clearest)), -clearest, window.marker))
    first = np.searchsorted(window.marker[order], np.arange(len(window.marker_ids)))
    count = np.bincount(window.marker, minlength=len(window.marker_ids))
    chosen = np.stack([order[first], order[first + np.minimum(count - 1, 1)]], axis=-1)
    seeds = world_R_camera[window.frame[chosen]][:, :, None] @ window.camera_R_marker[chosen]
    modes = np.array(seeds.reshape(-1, MODES).coefficients)
    information = np.zeros((*modes.shape[:2], 3, 3))
    known = memory.rows_of(window.marker_ids)
    modes[known >= 0] = memory.world_R_marker.coefficients[known[known >= 0]]
    information[known >= 0] = memory.information[known[known >= 0]]
    return Orientations(world_R_camera, Rotor(modes), information)


def settle(window: Window, begin: Orientations, memory: Memory, rounds: int) -> Orientations:
    """Alternate between candidates and orientations.

    Args:
        window: the observations.
        begin: where to begin; its information is what was known before.
        memory: gives how probable each remembered orientation is.
        rounds: how often.
    """
    cameras, markers = begin.world_R_camera, begin.world_R_marker
    known = memory.rows_of(window.marker_ids)
    prior = np.zeros(markers.shape)
    static = memory.message[known[known >= 0], : 2 * MODES].reshape(-1, MODES, 2)
    prior[known >= 0] = -static.min(axis=-1)
    information = begin.information
    for _ in range(rounds):
        vector, weight, mode = _expected(window, cameras, markers, prior)
        cameras = _turned_cameras(window, cameras, vector, weight * mode[:, :, None])
        vector, weight, _ = _expected(window, cameras, markers, prior)
        markers, information = _turned_markers(window, cameras, markers, begin, vector, weight)
    return Orientations(cameras, markers, information)


def _expected(
    window: Window, cameras: Rotor, markers: Rotor, prior: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turns, weights ``(N, H, 2)`` of candidates, and probabilities ``(N, H)`` of the modes."""
    vector, half = window.excess(cameras, markers)
    weight, fit = weighed(half, window.evidence)
    score = prior.copy()
    np.add.at(score, window.marker, fit)
    score -= score.max(axis=-1, keepdims=True)
    mode = np.exp(score) / np.exp(score).sum(axis=-1, keepdims=True)
    return vector, weight, mode[window.marker]


def weighed(half: FloatArray, evidence: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How much each candidate ``(n, H, 2)`` counts, and the log likelihood ``(n, H)`` of the modes.

    Far off the modes weights fade away.
    """
    likelihood = -misfit(half) - evidence[:, None, :]
    fit = np.logaddexp.reduce(likelihood, axis=-1)
    return np.exp(likelihood - fit[..., None]) * influence(half), fit


def _turned_cameras(
    window: Window, cameras: Rotor, vector: FloatArray, weight: FloatArray
) -> Rotor:
    """Cameras turned to where their markers' orientations agree best."""
    total = np.zeros((len(cameras), 3, 3))
    pull = np.zeros((len(cameras), 3))
    np.add.at(total, window.frame, np.einsum("nhc,ncij->nij", weight, window.information))
    np.add.at(
        pull, window.frame, np.einsum("nhc,ncij,nhcj->ni", weight, window.information, vector)
    )
    step = np.linalg.solve(total + _SLACK * np.eye(3), pull[..., None])[..., 0]
    return cameras @ Rotor.from_rotation_vector(step)


def _turned_markers(
    window: Window,
    cameras: Rotor,
    markers: Rotor,
    begin: Orientations,
    vector: FloatArray,
    weight: FloatArray,
) -> tuple[Rotor, FloatArray]:
    """Each mode turned to the mean of the candidates that it explains, and its information."""
    axes = cameras.as_matrix()[window.frame]
    seen = axes[:, None] @ window.information @ axes[:, None].swapaxes(-1, -2)
    turned = np.einsum("nij,nhcj->nhci", axes, vector)
    return updated(
        markers, begin.world_R_marker, begin.information, window.marker, weight, seen, turned
    )


def updated(
    markers: Rotor,
    known: Rotor,
    information: FloatArray,
    owner: IntArray,
    weight: FloatArray,
    seen: FloatArray,
    vector: FloatArray,
) -> tuple[Rotor, FloatArray]:
    """Orientations at the mean of what was known and of what observations add, and the information.

    Args:
        markers: Rotor ``(k, H)``, near the mean.
        known: Rotor ``(k, H)`` as they were known.
        information: ``(k, H, 3, 3)`` of that, world axes.
        owner: ``(n,)`` row of `markers` that each observation belongs to.
        weight: ``(n, H, 2)`` how much each candidate counts.
        seen: ``(n, 2, 3, 3)`` information of the candidates, world axes.
        vector: ``(n, H, 2, 3)`` turns from the candidates to the markers, world axes.
    """
    total = information.copy()
    apart = (markers @ known.inverse()).as_rotation_vector()
    pull = np.einsum("khij,khj->khi", information, apart)
    np.add.at(total, owner, np.einsum("nhc,ncij->nhij", weight, seen))
    np.add.at(pull, owner, np.einsum("nhc,ncij,nhcj->nhi", weight, seen, vector))
    step = -np.linalg.solve(total + _SLACK * np.eye(3), pull[..., None])[..., 0]
    return Rotor.from_rotation_vector(step) @ markers, total
