"""The gimbal table: one drag about an object's own axes near ±90° of pitch, by rotors and by Euler
angles, as an editor holds either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorcade.animation.authoring.drags import Drag
from motorcade.animation.authoring.editor import SceneEditor
from motorcade.animation.authoring.poses import EulerObjectPose, ObjectPose, VersorObjectPose
from motorcade.animation.authoring.scene import Scene
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class GimbalRow:
    """One drag about one of an object's own axes.

    Fields:
        pitch_deg: of the object before; its other angles are 0.
        axis: of the object: x, y or z.
        asked_deg: by how much it was dragged.
        rotor_off_deg, euler_off_deg: by how much it stands otherwise than it was asked to, held as
            a rotor and as Euler angles.
        euler_axis_off_deg: between the axis that was asked for and the one about which it turned.
        angles_run_deg: by how much one of the three angles changes for a tenth of a degree of the
            turn that was asked for: what a person sees who reads them, and has to type.
    """

    pitch_deg: float
    axis: str
    asked_deg: float
    rotor_off_deg: float
    euler_off_deg: float
    euler_axis_off_deg: float
    angles_run_deg: float


def gimbal_rows(
    pitches_deg: Sequence[float] = (85.0, 89.0, 89.9), asked_deg: float = 30.0
) -> list[GimbalRow]:
    """The table, three rows a pitch.

    Args:
        pitches_deg: middle angles of x-y'-z'', within ±90°.
        asked_deg: by how much is dragged, up to 180°.

    Raises:
        ValueError: a pitch of ±90° or beyond, a drag of 0 or beyond 180°.

    >>> from motorcade.animation.authoring.gimbal import gimbal_rows
    >>> for row in gimbal_rows([89.0]):
    ...     print(row.axis, f"{row.rotor_off_deg:.1f} {row.euler_off_deg:.1f}")
    x 0.0 41.8
    y 0.0 0.0
    z 0.0 0.0
    """
    if not all(abs(one) < 90.0 for one in pitches_deg):
        raise ValueError(f"gimbal_rows(pitches_deg): expected within ±90°, got {pitches_deg}")
    if not 0.0 < abs(asked_deg) <= 180.0:
        raise ValueError(f"gimbal_rows(asked_deg): expected up to 180°, not 0, got {asked_deg}")
    return [_row(pitch, name, asked_deg) for pitch in pitches_deg for name in _AXES]


def _row(pitch_deg: float, name: str, asked_deg: float) -> GimbalRow:
    axis, asked = np.array(_AXES[name]), float(np.radians(asked_deg))
    held = EulerObjectPose(np.radians([0.0, pitch_deg, 0.0]), np.zeros(3))
    before = held.as_similarity().rotor
    wanted = before @ Rotor.from_rotation_vector(asked * axis)
    by_euler = _dragged(held, axis, asked)
    by_rotor = _dragged(VersorObjectPose(held.as_similarity()), axis, asked)
    rotation = (before.inverse() @ by_euler).as_rotation_vector()
    across = np.cross(axis, rotation)
    little = before @ Rotor.from_rotation_vector(np.radians(0.1) * axis)
    run = little.as_euler() - before.as_euler()
    run = np.abs((run + np.pi) % (2.0 * np.pi) - np.pi)
    return GimbalRow(
        pitch_deg,
        name,
        asked_deg,
        _between_deg(wanted, by_rotor),
        _between_deg(wanted, by_euler),
        float(np.degrees(np.arctan2(np.linalg.norm(across), np.sign(asked) * axis @ rotation))),
        float(np.degrees(run.max())),
    )


def _dragged(pose: ObjectPose, axis: FloatArray, angle_rad: float) -> Rotor:
    """How an object is turned after one drag about an axis of its own."""
    editor = SceneEditor(Scene({"it": None}, {"it": pose}))
    after = editor.apply(Drag("it", "rotate", axis, "local"), angle_rad)
    return after.pose("it").as_similarity().rotor


def _between_deg(rotor: Rotor, other: Rotor) -> float:
    return float(np.degrees((rotor.inverse() @ other).angle()))
