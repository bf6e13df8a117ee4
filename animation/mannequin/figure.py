"""The mannequin itself: a figure in a racing suit with skeleton, skinned mesh and clips."""

from __future__ import annotations

from functools import lru_cache

from motorcade.animation.character import Character
from motorcade.animation.clip import Clip
from motorcade.animation.mannequin.motions.gait import GAITS, gait_clip
from motorcade.animation.mannequin.motions.standing import idle, turning, waving
from motorcade.animation.mannequin.proportions import REFERENCE_HEIGHT_M, mannequin_skeleton
from motorcade.animation.mannequin.shape.anatomy import body_field
from motorcade.animation.mannequin.shape.surface import colors, meshed
from motorcade.animation.mannequin.shape.weights import influences
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import checked_positive

FEWEST, MOST = 5_000, 140_000


def mannequin(height_m: float = REFERENCE_HEIGHT_M, triangles: int = 27_000) -> Character:
    """A human figure made in code, with the clips "idle", "walk", "jog", "run", "wave" and "turn".

    Its surface is the zero of signed distances, one closed mesh. Made once for each number of
    triangles in a process, and scaled.

    Args:
        height_m: of the rest pose. Everything scales with it; times stay.
        triangles: about how many, within 15 %.

    Returns:
        A character of 52 joints: trunk, head, arms, hands with five fingers, legs, feet, toes.

    Raises:
        ValueError: a height that is not positive, or a number of triangles outside 5,000 to
            140,000.
        ModuleNotFoundError: scikit-image, which makes the surface, is not installed.

    >>> from motorcade.animation import mannequin
    >>> figure = mannequin(height_m=0.2, triangles=5000)  # a small one to stand on a table
    >>> len(figure.skeleton), [clip.name for clip in figure.clips]
    (52, ['idle', 'walk', 'jog', 'run', 'wave', 'turn'])
    """
    checked_positive(height_m, "mannequin(height_m)")
    if not FEWEST <= triangles <= MOST:
        raise ValueError(
            f"mannequin(triangles): expected {FEWEST:,} to {MOST:,}, got {triangles:,}"
        )
    return _scaled(_figure(int(triangles)), height_m)


def ground_speed_m_s(clip: str, height_m: float = REFERENCE_HEIGHT_M) -> float:
    """The speed ahead at which the feet of one of its clips do not slide; 0 for those on the spot.

    Args:
        clip: its name.
        height_m: of the mannequin; speeds grow with it.

    >>> from motorcade.animation.mannequin import ground_speed_m_s
    >>> ground_speed_m_s("walk"), ground_speed_m_s("idle")
    (1.25, 0.0)
    """
    speed = GAITS[clip].speed_m_s if clip in GAITS else 0.0
    return speed * height_m / REFERENCE_HEIGHT_M


@lru_cache(maxsize=2)
def _figure(triangles: int) -> Character:
    """The figure at the reference height."""
    skeleton = mannequin_skeleton()
    mesh = meshed(body_field(), triangles)
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    # what a coarse mesh lacks at crown and soles
    vertices = (mesh.vertices - [0.0, 0.0, low]) * (REFERENCE_HEIGHT_M / (high - low))
    joints, weights = influences(mesh, skeleton)
    return Character(
        skeleton,
        vertices,
        mesh.normals,
        mesh.triangles,
        colors(mesh.vertices, mesh.step_m),
        joints,
        weights,
        _clips(skeleton),
    )


def _clips(skeleton: Skeleton) -> tuple[Clip, ...]:
    gaits = (gait_clip(name, skeleton) for name in GAITS)
    return (idle(skeleton), *gaits, waving(skeleton), turning(skeleton))


def _scaled(figure: Character, height_m: float) -> Character:
    """The same figure as tall as asked."""
    scale = height_m / REFERENCE_HEIGHT_M
    skeleton = figure.skeleton
    clips = tuple(
        Clip(clip.name, clip.time_s, _larger(clip.poses, scale), clip.looped)
        for clip in figure.clips
    )
    return Character(
        Skeleton(skeleton.names, skeleton.parents, _larger(skeleton.rest, scale)),
        scale * figure.vertices,
        figure.normals,
        figure.triangles,
        figure.colors,
        figure.joints,
        figure.weights,
        clips,
    )


def _larger(poses: Motor | Similarity, scale: float) -> Motor:
    """The same turns with all distances scaled."""
    return Motor.from_rotor_translation(poses.rotor, scale * poses.translation_m)
