"""The named motions of the comparison: hard for some representation, or plain camera work.

All are ``world_T_camera``, worlds with z up, metres and radians. Gimbal lock is meant for intrinsic
x-y′-z″ angles: it lies where the camera looks along the world's ±x axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from motorcade.fusion.motions.motion import Factor, Motion, Polynomial, Signal, Sines, Stops
from motorcade.ga import Motor, Rotor, Similarity

_ONCE = Polynomial((1.0,))
_FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def _turn(axis: str, signal: Signal) -> Factor:
    return Factor(np.eye(6)["xyz".index(axis)], signal)


def _shift(axis: str, signal: Signal) -> Factor:
    return Factor(np.eye(6)[3 + "xyz".index(axis)], signal)


def _drift(size_m: float = 0.3) -> tuple[Factor, ...]:
    """Slow wandering in a ball of about `size_m`, for motions that are about rotation."""
    return (
        _shift("x", Sines.single(size_m, 0.21)),
        _shift("y", Sines.single(0.8 * size_m, 0.17, 0.9)),
        _shift("z", Sines.single(0.5 * size_m, 0.29, 2.1)),
    )


def _rigid(*factors: Factor) -> Motion[Motor]:
    return Motion(factors, Motor)


def _camera_axes() -> Factor:
    """Camera axes (x right, y down, z ahead) on a body that looks along x with z up."""
    level = Motor.from_rotor_translation(Rotor.from_matrix(_FORWARD), np.zeros(3))
    return Factor(level.as_twist(), _ONCE)


def gimbal_crossing(
    peak_rate_rad_s: float = 2.0,
    miss_rad: float = np.deg2rad(1.0),
    reach_rad: float = np.deg2rad(80.0),
) -> Motion[Motor]:
    """Swing through gimbal lock and back, passing it at `miss_rad`, fastest there.

    The pitch swings by `reach_rad` to either side of 90°; Euler angles turn about
    ``peak_rate / miss`` fast in the passage.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import gimbal_crossing
        >>> twist = gimbal_crossing(miss_rad=0.05).at(np.linspace(0.0, 5.0, 501)).body_twist
        >>> rate_rad_s = np.linalg.norm(twist[:, :3], axis=1)
        >>> print(f"up to {rate_rad_s.max():.2f} rad/s")
        up to 2.06 rad/s
    """
    frequency_hz = peak_rate_rad_s / (2.0 * np.pi * reach_rad)
    return _rigid(
        *_drift(),
        _turn("z", Polynomial((miss_rad,))),
        _turn("y", Polynomial((0.5 * np.pi,))),
        _turn("y", Sines.single(reach_rad, frequency_hz, -0.5 * np.pi)),
        _turn("z", Sines.single(0.25, 0.37)),
    )


def gimbal_hover(radius_rad: float = np.deg2rad(5.0)) -> Motion[Motor]:
    """Look about within some `radius_rad` of gimbal lock, and turn about the line of sight.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.standard import gimbal_hover
        >>> twist = gimbal_hover().at(np.linspace(0.0, 5.0, 501)).body_twist
        >>> rate_rad_s = np.linalg.norm(twist[:, :3], axis=1)
        >>> print(f"up to {rate_rad_s.max():.2f} rad/s")
        up to 1.06 rad/s
    """
    return _rigid(
        *_drift(),
        _turn("y", Polynomial((0.5 * np.pi,))),
        _turn("x", Sines((0.7 * radius_rad, 0.3 * radius_rad), (0.31, 0.83), (0.0, 1.1))),
        _turn("y", Sines((0.7 * radius_rad, 0.3 * radius_rad), (0.37, 0.71), (0.8, 2.3))),
        _turn("z", Sines.single(0.4, 0.41)),
    )


def tumble(
    precession_rad_s: float = 1.3, nutation_rad: float = 1.1, spin_rad_s: float = 2.1
) -> Motion[Motor]:
    """A free symmetric top: precession about a fixed axis, spin about its own, at one angle.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import tumble
        >>> twist = tumble().at(np.linspace(0.0, 5.0, 501)).body_twist
        >>> rate_rad_s = np.linalg.norm(twist[:, :3], axis=1)
        >>> print(f"up to {rate_rad_s.max():.2f} rad/s")
        up to 2.93 rad/s
    """
    return _rigid(
        *_drift(),
        _turn("x", Polynomial((0.0, precession_rad_s))),
        _turn("y", Polynomial((nutation_rad,))),
        _turn("x", Polynomial((0.0, spin_rad_s))),
    )


def screw(rate_rad_s: float = 1.0, pitch_m: float = 0.5, radius_m: float = 0.7) -> Motion[Motor]:
    """Turn about the vertical and rise by `pitch_m` a turn, `radius_m` away, looking ahead.

    The twist is constant, so motors follow it without error at any spacing.

    Examples:
        >>> from motorcade.fusion.motions import screw
        >>> path = screw().sampled(rate_hz=30.0, duration_s=10.0)  # world_T_camera
        >>> path.poses.translation_m.std(axis=0).round(2)  # metres
        array([0.47, 0.51, 0.23])
    """
    along = np.array([0.0, 0.0, 1.0, 0.0, 0.0, pitch_m / (2.0 * np.pi)])
    return _rigid(
        Factor(along, Polynomial((0.0, rate_rad_s))),
        _shift("y", Polynomial((-radius_m,))),
        _camera_axes(),
    )


def distant_circle(
    radius_m: float = 10.0, rate_rad_s: float = 0.15, sway_rad: float = 0.08
) -> Motion[Motor]:
    """Swing about a vertical axis `radius_m` away, nodding: small turns, large shifts.

    Examples:
        >>> from motorcade.fusion.motions.standard import distant_circle
        >>> path = distant_circle().sampled(rate_hz=30.0, duration_s=10.0)  # world_T_camera
        >>> path.poses.translation_m.std(axis=0).round(2)  # metres
        array([2.89, 2.99, 0.  ])
    """
    return _rigid(
        _turn("z", Polynomial((0.0, rate_rad_s))),
        _turn("z", Sines.single(sway_rad, 0.27)),
        _shift("x", Polynomial((radius_m,))),
        _turn("y", Sines.single(0.15, 0.43)),
        _camera_axes(),
    )


def handheld(
    rng: np.random.Generator,
    rms_m: float = 0.15,
    rms_rad: float = 0.2,
    band_hz: tuple[float, float] = (0.1, 2.0),
) -> Motion[Motor]:
    """A camera in the hand: every axis random in a band, amplitudes falling as 1/f.

    `rms_m` and `rms_rad` hold for each axis.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions import handheld
        >>> motion = handheld(np.random.default_rng(0))
        >>> path = motion.sampled(rate_hz=30.0, duration_s=10.0)  # world_T_camera
        >>> path.poses.translation_m.std(axis=0).round(2)  # metres
        array([0.16, 0.08, 0.16])
    """
    axes = "xyz"
    shifts = [_shift(axis, Sines.random(rng, rms_m, band_hz)) for axis in axes]
    turns = [_turn(axis, Sines.random(rng, rms_rad, band_hz)) for axis in axes]
    return _rigid(*shifts, *turns, _camera_axes())


def walk_and_look(
    speed_m_s: float = 1.3, step_hz: float = 1.8, look_rad: float = 0.8
) -> Motion[Motor]:
    """Walk ahead, bob at every step and sway at every second, look left, ahead, right and down.

    Examples:
        >>> from motorcade.fusion.motions.standard import walk_and_look
        >>> path = walk_and_look().sampled(rate_hz=30.0, duration_s=10.0)  # world_T_camera
        >>> path.poses.translation_m.std(axis=0).round(2)  # metres
        array([3.76, 0.02, 0.01])
    """
    return _rigid(
        _shift("x", Polynomial((0.0, speed_m_s))),
        _shift("x", Sines.single(0.015, step_hz, 0.6)),
        _shift("y", Sines.single(0.025, 0.5 * step_hz)),
        _shift("z", Sines.single(0.02, step_hz, 1.0)),
        _turn("z", Stops((0.0, look_rad, 0.1, -look_rad, 0.0, 0.3), 1.0, 0.7)),
        _turn("y", Stops((0.0, 0.3, -0.1, 0.2), 1.1, 1.3)),
        _turn("x", Sines.single(0.02, 0.5 * step_hz, 0.4)),
        _turn("y", Sines.single(0.012, step_hz, 2.0)),
        _camera_axes(),
    )


def stop_and_go(move_s: float = 1.2, rest_s: float = 0.8) -> Motion[Motor]:
    """Go from place to place and stand still at each; turns start and end with the shifts.

    Examples:
        >>> from motorcade.fusion.motions import stop_and_go
        >>> path = stop_and_go().sampled(rate_hz=30.0, duration_s=10.0)  # world_T_camera
        >>> path.poses.translation_m.std(axis=0).round(2)  # metres
        array([0.5 , 0.35, 0.11])
    """
    return _rigid(
        _shift("x", Stops((0.0, 0.6, 1.2, 0.5, -0.3), move_s, rest_s)),
        _shift("y", Stops((0.0, 0.5, -0.4), move_s, rest_s)),
        _shift("z", Stops((0.0, 0.2, 0.1, -0.1), move_s, rest_s)),
        _turn("z", Stops((0.0, 0.7, -0.2, 0.4, 1.2, 0.3), move_s, rest_s)),
        _turn("y", Stops((0.0, 0.3, -0.2), move_s, rest_s)),
        _camera_axes(),
    )


def fast_spin(rate_rad_s: float = 20.0, swing_rad: float = 0.8) -> Motion[Motor]:
    """Spin about a tilted axis, so fast that a stream at 5 Hz sees more than half a turn a step.

    At 30 Hz a step is 0.61 to 0.73 rad; at 5 Hz it is 3.6 to 4.4 rad, and the short way is wrong.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.standard import fast_spin
        >>> twist = fast_spin().at(np.linspace(0.0, 5.0, 501)).body_twist
        >>> rate_rad_s = np.linalg.norm(twist[:, :3], axis=1)
        >>> print(f"up to {rate_rad_s.max():.2f} rad/s")
        up to 21.76 rad/s
    """
    swing_hz = 0.35
    return _rigid(
        *_drift(),
        _turn("x", Polynomial((0.5,))),
        _turn("z", Polynomial((0.0, rate_rad_s))),
        _turn("z", Sines.single(swing_rad, swing_hz)),
        _camera_axes(),
    )


def antipodal_crossing(period_s: float = 8.0) -> Motion[Motor]:
    """Turn from the start to 270° from it and back, through half a turn each time.

    There quaternions of positive real part change sign, and rotation vectors fold.

    Examples:
        >>> import numpy as np
        >>> from motorcade.fusion.motions.standard import antipodal_crossing
        >>> twist = antipodal_crossing().at(np.linspace(0.0, 5.0, 501)).body_twist
        >>> rate_rad_s = np.linalg.norm(twist[:, :3], axis=1)
        >>> print(f"up to {rate_rad_s.max():.2f} rad/s")
        up to 1.85 rad/s
    """
    axis = np.array([0.36, 0.48, 0.8, 0.0, 0.0, 0.0])
    half = 0.75 * np.pi
    return _rigid(
        *_drift(),
        Factor(axis, Polynomial((half,))),
        Factor(axis, Sines.single(half, 1.0 / period_s, -0.5 * np.pi)),
    )


def zoom(log_scale: float = 0.7, period_s: float = 5.0) -> Motion[Similarity]:
    """Grow and shrink by ``exp(±log_scale)`` while turning and wandering: a similarity.

    Examples:
        >>> from motorcade.fusion.motions import zoom
        >>> zoom().sampled(rate_hz=1.0, duration_s=3.0).poses.scale.round(2)
        array([1.  , 1.95, 1.51, 0.66])
    """
    grow = np.eye(7)[6]
    widened = tuple(
        Factor(np.append(factor.twist, 0.0), factor.signal)
        for factor in (
            *_drift(),
            _turn("z", Sines.single(0.6, 0.19)),
            _turn("x", Sines.single(0.4, 0.26, 1.0)),
        )
    )
    return Motion((*widened, Factor(grow, Sines.single(log_scale, 1.0 / period_s))), Similarity)


MOTIONS: Mapping[str, Motion[Motor] | Motion[Similarity]] = MappingProxyType(
    {
        "gimbal_crossing_slow": gimbal_crossing(0.5),
        "gimbal_crossing": gimbal_crossing(2.0),
        "gimbal_crossing_fast": gimbal_crossing(4.0),
        "gimbal_hover": gimbal_hover(),
        "tumble": tumble(),
        "screw": screw(),
        "distant_circle": distant_circle(),
        "handheld": handheld(np.random.default_rng(20240229)),
        "walk_and_look": walk_and_look(),
        "stop_and_go": stop_and_go(),
        "fast_spin": fast_spin(),
        "antipodal_crossing": antipodal_crossing(),
        "zoom": zoom(),
    }
)
"""The standard motions with their default parameters; rigid but for "zoom"."""
