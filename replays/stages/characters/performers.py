"""Who is drawn and exported: the placed character, or all of a cast or a scene, as they move."""

from __future__ import annotations

from motorcade.render import Performer
from motorcade.replays.stages.characters.acting import (
    character_named,
    clip_named,
    looking_at,
    standing_clip,
    walked,
)
from motorcade.replays.stages.values.view import PlacedCharacter


def performers(placed: PlacedCharacter, lasting_s: float = 0.0) -> list[Performer]:
    """Those that stand in the footage, one or more, with clips that begin at its first frame.

    Args:
        placed: what the stage of that name made.
        lasting_s: how long a clip shall last in all; one of a walk, that is.

    Raises:
        ValueError: a character or clip that is no longer there.
    """
    if placed.parts:
        return [
            Performer(
                character_named(part.character, part.up, part.front),
                part.clip,
                part.placement,
                part.motion,
                placed.ground_motion if part.motion is None else part.ground_motion,
                part.visible_s,
            )
            for part in placed.parts
        ]
    character = character_named(placed.character, placed.up, placed.front)
    clip = clip_named(character, placed.clip)
    if len(placed.path_m):
        scale, start = placed.placement.scale, placed.plane_T_character
        clip = walked(character, clip, placed.path_m, scale, start, lasting_s)
    else:
        clip, _ = standing_clip(character, clip)
        if placed.looks_at_m is not None:
            clip = looking_at(character, clip, placed.placement, placed.looks_at_m)
    return [Performer(character, clip, placed.placement, ground_motion=placed.ground_motion)]
