"""The built-in character: a small explorer, read from the glTF file beside this module.

`docs/making/figure` makes the file.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from importlib.resources import as_file, files

from motorcade.animation.character import Character
from motorcade.animation.skeleton import Skeleton
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import checked_positive
from motorcade.ga.files import off_record

REFERENCE_HEIGHT_M = 1.75


def mannequin(height_m: float = REFERENCE_HEIGHT_M) -> Character:
    """A small explorer with the clips "idle", "walk", "jog", "run", "wave" and "turn".

    Read once in a process from the file that comes with the package, and scaled.

    Args:
        height_m: of the rest pose. Everything scales with it; times stay.

    Returns:
        A character of 46 joints (trunk, head, arms, hands with a thumb and three fingers, legs,
        feet, toes) with a textured material and the morph targets "blink" and "smile".

    Raises:
        ValueError: a height that is not positive.
        ModuleNotFoundError: Pillow, which decodes its textures, is not installed.

    >>> from motorcade.animation import mannequin
    >>> figure = mannequin(height_m=0.2)  # a small one to stand on a table
    >>> len(figure.skeleton), [clip.name for clip in figure.clips]
    (46, ['idle', 'walk', 'jog', 'run', 'wave', 'turn'])
    """
    checked_positive(height_m, "mannequin(height_m)")
    figure = _figure()
    return _scaled(figure, height_m / figure.height_m)


@lru_cache(maxsize=1)
def _figure() -> Character:
    """The figure as its file has it, which counts as the program's own and is put on no record."""
    from motorcade.animation.formats import read_character

    with as_file(files(__package__) / "mannequin.glb") as path, off_record():
        return read_character(path)


def _scaled(figure: Character, scale: float) -> Character:
    """The same figure, larger; times stay."""
    skeleton = figure.skeleton
    return replace(
        figure,
        skeleton=Skeleton(skeleton.names, skeleton.parents, _larger(skeleton.rest, scale)),
        vertices=scale * figure.vertices,
        clips=tuple(replace(clip, poses=_larger(clip.poses, scale)) for clip in figure.clips),
        found_pose=None,
        morphs=tuple(replace(one, positions=scale * one.positions) for one in figure.morphs),
    )


def _larger(poses: Motor | Similarity, scale: float) -> Motor:
    """The same turns with all distances scaled."""
    return Motor.from_rotor_translation(poses.rotor, scale * poses.translation_m)
