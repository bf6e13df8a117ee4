"""The paint: colour, roughness, metal and relief of every point, by where it lies.

A small explorer in a quilted jacket: mustard, navy and leather, a red scarf, brass goggles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from docs.making.figure.proportions import ANKLE_HEIGHT_M, HIP_HALF_WIDTH_M, SHIN_M
from docs.making.figure.shape.anatomy import (
    BOOT_Z,
    CUFF,
    ELBOW,
    HEM_Z,
    SHOULDER_M,
    arm_axes,
    over_rim,
)
from motorcade.animation.easing import smoothstep
from motorcade.ga.arrays import FloatArray

SKIN, BLUSH = (0.965, 0.780, 0.640), (0.92, 0.50, 0.42)
MUSTARD, CREAM, NAVY = (0.925, 0.665, 0.215), (0.945, 0.905, 0.815), (0.185, 0.265, 0.375)
LEATHER, DARK, RED = (0.545, 0.325, 0.205), (0.125, 0.105, 0.100), (0.790, 0.270, 0.215)
BRASS, GLASS, TEAL = (0.880, 0.690, 0.390), (0.120, 0.330, 0.385), (0.200, 0.455, 0.470)
SOFT_M = 0.0011
QUILT_M = 0.068


@dataclass(frozen=True, eq=False)
class Paint:
    """Of N points: colour (N, 3) sRGB, roughness, metal (N,), and relief (N,) in metres."""

    color: FloatArray
    rough: FloatArray
    metal: FloatArray
    relief_m: FloatArray

    @staticmethod
    def plain(count: int, color: tuple[float, float, float], rough: float) -> Paint:
        """One colour everywhere."""
        return Paint(
            np.tile(color, (count, 1)), np.full(count, rough), np.zeros(count), np.zeros(count)
        )

    def lay(
        self,
        share: FloatArray,
        color: tuple[float, float, float] | None = None,
        rough: float | None = None,
        relief_m: FloatArray | float | None = None,
    ) -> None:
        """Cover it in place by a share (N,) of something else."""
        if color is not None:
            self.color[:] += share[:, None] * (np.array(color) - self.color)
        if rough is not None:
            self.rough[:] += share * (rough - self.rough)
        if relief_m is not None:
            self.relief_m[:] += share * (relief_m - self.relief_m)


def above(value: FloatArray, limit: FloatArray | float, soft: float = SOFT_M) -> FloatArray:
    """0 below, 1 above a limit, a smooth step between."""
    return smoothstep(0.5 + 0.5 * (np.asarray(value) - limit) / soft)


def within(value: FloatArray, low: float, high: float, soft: float = SOFT_M) -> FloatArray:
    """1 between two limits."""
    return np.asarray(above(value, low, soft) - above(value, high, soft))


def spot(points: FloatArray, centre: tuple[float, ...], half: tuple[float, ...]) -> FloatArray:
    """Distance from a centre in units of half-axes; infinite half-axes do not count."""
    return np.asarray(np.linalg.norm((points - np.array(centre)) / np.array(half), axis=1))


def painted(name: str, points: FloatArray, flat_m: FloatArray) -> Paint:
    """Paint of points (N, 3) of the body or of a piece, unrolled at (N, 2)."""
    if name == "body":
        return _body(points * [1.0, np.sign(points[:, 1].mean()) or 1.0, 1.0])
    return _piece(name, points, flat_m)


def _body(points: FloatArray) -> Paint:
    x, y, z = points.T
    arm_at = (np.stack([x, y, z], axis=1) - SHOULDER_M) @ arm_axes().T
    along, out = arm_at[:, 2], arm_at[:, 1]
    on_arm = (along > 0.02) & (y > 0.150 + 0.12 * np.clip(1.1 - z, 0.0, 1.0)) & (z > 0.60)
    on_arm &= np.abs(out) < 0.09
    paint = Paint.plain(len(points), MUSTARD, 0.78)
    _jacket(paint, points, along, out, on_arm)
    body = ~on_arm
    legs = body * above(-z, -HEM_Z)
    _trousers(paint, points, legs)
    _boots(paint, points, body * above(-z, -BOOT_Z))
    paint.lay(on_arm * above(along, CUFF), LEATHER, 0.55, 0.0)
    _elbow(paint, along, out, on_arm)
    _head(paint, points, body * above(z, 1.20))
    return paint


def _jacket(
    paint: Paint, points: FloatArray, along: FloatArray, out: FloatArray, on_arm: FloatArray
) -> None:
    """Quilted across, a yoke of cream over chest and shoulders, a zip, pockets."""
    x, y, z = points.T
    height = np.where(on_arm, along + 0.020, z - HEM_Z - 0.012 + 0.02 * np.abs(y))
    fold = np.abs(np.mod(height / QUILT_M + 0.5, 1.0) - 0.5) * QUILT_M  # from the nearest seam
    puff = 0.0055 * np.sqrt(np.clip(fold / (0.5 * QUILT_M), 0.0, 1.0))
    paint.relief_m[:] = puff
    seam = 1.0 - above(fold, 0.0026, 0.0022)
    yoke_z = 1.068 - 0.30 * np.clip(y - 0.10, 0.0, 1.0)
    yoke = np.where(on_arm, 1.0 - above(along, 0.062), above(z, yoke_z))
    edge = np.where(on_arm, np.abs(along - 0.062), np.abs(z - yoke_z))
    paint.lay(yoke, CREAM, 0.80)
    piping = 1.0 - above(edge, 0.0042)
    paint.lay(piping, RED, 0.70, 0.004)
    dim = np.where(
        yoke[:, None] > 0.5, np.array([[0.80, 0.74, 0.63]]), np.array([[0.74, 0.48, 0.11]])
    )
    share = (0.75 * seam * (1.0 - piping))[:, None]
    paint.color[:] += share * (dim - paint.color)
    front = (x > 0.0) & ~on_arm
    zip_share = front * (1.0 - above(np.abs(y), 0.0085))
    paint.lay(zip_share, CREAM, 0.60, 0.006)
    teeth = front * (1.0 - above(np.abs(y), 0.0036)) * (np.mod(z, 0.010) < 0.006)
    paint.lay(teeth, LEATHER, 0.40, 0.004)
    rounded = np.linalg.norm(
        np.maximum(np.abs(np.stack([y - 0.098, z - 0.775])) - [[0.026], [0.030]], 0.0), axis=0
    )
    paint.lay(front * (1.0 - above(rounded, 0.014)), MUSTARD, 0.78, 0.008)
    paint.lay(front * within(rounded, 0.0112, 0.0136), (0.70, 0.45, 0.10), 0.78)
    flap = front * (1.0 - above(rounded, 0.014)) * above(z, 0.797)
    paint.lay(flap, LEATHER, 0.55, 0.011)
    # the pack's straps turn under the arms
    aside = np.abs(y - 0.086 - 3.0 * np.clip(0.97 - z, 0.0, 0.2) ** 1.5)
    strap = ~on_arm * (1.0 - above(aside, 0.0150)) * np.where(x > -0.02, 1.0, above(z, 1.02))
    strap = strap * above(z, 0.80)
    paint.lay(strap, TEAL, 0.70, 0.009)
    paint.lay(strap * within(aside, 0.0105, 0.0125) * (np.mod(z, 0.012) < 0.007), CREAM)


def _trousers(paint: Paint, points: FloatArray, share: FloatArray) -> None:
    """Navy with a seam down the side and a patch on the knee."""
    x, y, z = points.T
    paint.lay(share, NAVY, 0.85, 0.0)
    knee_z = ANKLE_HEIGHT_M + SHIN_M
    aside = y - HIP_HALF_WIDTH_M
    seam = share * (1.0 - above(np.abs(x), 0.0022)) * above(aside, 0.03)
    paint.lay(seam, (0.12, 0.18, 0.27), 0.85, -0.002)
    patch = np.linalg.norm(
        np.maximum(np.abs(np.stack([aside, z - knee_z])) - [[0.022], [0.026]], 0.0), axis=0
    )
    front = share * (x > 0.0)
    paint.lay(front * (1.0 - above(patch, 0.024)), (0.235, 0.330, 0.450), 0.85, 0.004)
    dashes = np.mod(np.arctan2(z - knee_z, aside) * 6.5 / np.pi * 2.0, 1.0) < 0.6
    paint.lay(front * within(patch, 0.0195, 0.0212) * dashes, CREAM)


def _boots(paint: Paint, points: FloatArray, share: FloatArray) -> None:
    """Leather with a darker toe cap, laces and a pale sole."""
    x, y, z = points.T
    paint.lay(share, LEATHER, 0.50, 0.0)
    cap = above(x + 0.12 * np.abs(y - HIP_HALF_WIDTH_M), 0.122)
    paint.lay(share * cap, (0.405, 0.225, 0.140), 0.42, 0.004)
    line = share * (1.0 - above(np.abs(x + 0.12 * np.abs(y - HIP_HALF_WIDTH_M) - 0.117), 0.0016))
    paint.lay(line, CREAM)
    aside = np.abs(y - HIP_HALF_WIDTH_M)
    tongue = share * (x > 0.03) * (1.0 - above(aside, 0.021)) * within(z, 0.095, 0.182)
    paint.lay(tongue, (0.44, 0.25, 0.155), 0.6, -0.002)
    lace = np.abs(np.mod(z / 0.021 + 0.35 * aside / 0.021, 1.0) - 0.5) * 0.021
    paint.lay(tongue * (1.0 - above(lace, 0.0040)), CREAM, 0.8, 0.004)
    back = share * (1.0 - above(x, -0.055, 0.002)) * within(z, 0.04, 0.14)
    paint.lay(back, (0.405, 0.225, 0.140), 0.42, 0.002)
    paint.lay(above(-z, -0.012), CREAM, 0.8, 0.0)


def _elbow(paint: Paint, along: FloatArray, out: FloatArray, on_arm: FloatArray) -> None:
    """A patch on the elbow."""
    elbow = np.hypot((along - ELBOW) / 0.044, (out - 0.060) / 0.040)
    share = on_arm * (1.0 - above(elbow, 1.0, 0.03))
    paint.lay(share, LEATHER, 0.60, 0.006)
    paint.lay(on_arm * within(elbow, 0.82, 0.87, 0.02), CREAM)


def _head(paint: Paint, points: FloatArray, share: FloatArray) -> None:
    """A face, and a leather cap with seams and the goggles' strap."""
    x, y, z = points.T
    paint.lay(share, SKIN, 0.62, 0.0)
    blush = np.exp(-(spot(points, (0.2, 0.142, 1.392), (0.3, 0.040, 0.030)) ** 2)) * (x > 0.0)
    paint.lay(0.55 * share * blush, BLUSH)
    nose = np.exp(-(spot(points, (0.24, 0.0, 1.437), (0.05, 0.026, 0.022)) ** 2))
    paint.lay(0.35 * share * nose, BLUSH)
    for at in ((0.098, 1.412), (0.118, 1.402), (0.108, 1.388)):
        freckle = np.hypot(y - at[0], z - at[1])
        paint.lay(
            0.5 * share * (x > 0.0) * (1.0 - above(freckle, 0.0034, 0.001)), (0.72, 0.47, 0.33)
        )
    cap = share * above(over_rim(points), 0.0)
    paint.lay(cap, LEATHER, 0.52, 0.0)
    middle = np.abs(y)
    side = np.abs(y - 0.118 + 0.10 * np.clip(1.58 - z, 0.0, 1.0))
    for seam in (middle, side):
        paint.lay(cap * (1.0 - above(seam, 0.0022)), (0.36, 0.20, 0.125), 0.6, -0.003)
        stitch = cap * within(seam, 0.0068, 0.0088) * (np.mod(x * 0.6 + z, 0.013) < 0.008)
        paint.lay(stitch, (0.82, 0.66, 0.45))
    strap = np.abs(z - 1.585 - 0.16 * x)
    paint.lay(cap * (1.0 - above(strap, 0.019)), DARK, 0.75, 0.006)
    paint.lay(cap * within(strap, 0.0125, 0.0150), (0.28, 0.245, 0.23))


def _piece(name: str, points: FloatArray, flat_m: FloatArray) -> Paint:
    count = len(points)
    plain = {
        "hem": (NAVY, 0.85),
        "boot rim": (CREAM, 0.85),
        "glove rim": (CREAM, 0.85),
        "sole": (CREAM, 0.70),
        "scarf": (RED, 0.88),
        "cap rim": ((0.40, 0.225, 0.140), 0.5),
        "ear pad": (CREAM, 0.85),
        "ear cap": (RED, 0.40),
        "brow": ((0.33, 0.20, 0.135), 0.8),
        "mouth": ((0.52, 0.215, 0.185), 0.55),
        "pack": (TEAL, 0.75),
        "goggle": (BRASS, 0.34),
        "lens": (GLASS, 0.10),
        "eye": ((0.115, 0.075, 0.060), 0.12),
    }
    paint = Paint.plain(count, *plain[name])
    far = flat_m[:, 0]
    if name == "goggle":
        paint.metal[:] = 1.0
    elif name in ("hem", "boot rim", "glove rim", "scarf"):
        step = 0.011 if name != "scarf" else 0.016
        rib = 0.5 + 0.5 * np.cos(2.0 * np.pi * far / step)
        paint.relief_m[:] = 0.0022 * rib
        paint.color[:] *= (0.86 + 0.14 * rib)[:, None]
    elif name == "lens":
        middle = flat_m.mean(axis=0)
        at = (flat_m - middle) @ np.array([[0.8, -0.6], [0.6, 0.8]])
        sheen = within(at[:, 0], -0.024, -0.006, 0.002) + within(at[:, 0], 0.002, 0.008, 0.002)
        paint.lay(0.40 * sheen, (0.62, 0.80, 0.82))
    elif name == "eye":
        _eye(paint, flat_m)
    elif name == "pack":
        _pack(paint, points)
    return paint


def _eye(paint: Paint, flat_m: FloatArray) -> None:
    """Dark, a little lighter below, with two lights that make it look at one."""
    low, high = flat_m.min(axis=0), flat_m.max(axis=0)
    at = (flat_m - 0.5 * (low + high)) / (0.5 * (high - low) / 1.25)
    glow = np.exp(-((at[:, 0] / 0.55) ** 2) - ((at[:, 1] - 0.62) / 0.42) ** 2)
    paint.lay(0.55 * glow, (0.47, 0.27, 0.15))
    for x, y, radius in ((-0.26, -0.40, 0.25), (0.30, 0.32, 0.12)):
        light = np.hypot(at[:, 0] - x, (at[:, 1] - y) * 1.36)
        paint.lay(1.0 - above(light, radius, 0.05), (0.98, 0.98, 0.97))


def _pack(paint: Paint, points: FloatArray) -> None:
    """A flap with two straps."""
    _, y, z = points.T
    aside = np.abs(y)
    flap = above(z, 0.985 - 0.6 * np.clip(aside - 0.06, 0.0, 1.0) + 4.0 * aside**2 * 0.5)
    paint.lay(flap, (0.165, 0.385, 0.400), 0.75, 0.006)
    strap = (1.0 - above(np.abs(aside - 0.055), 0.012)) * above(z, 0.885)
    paint.lay(strap, LEATHER, 0.55, 0.010)
    buckle = np.maximum(np.abs(aside - 0.055) / 0.016, np.abs(z - 0.93) / 0.013)
    ring = (1.0 - above(buckle, 1.0, 0.05)) * above(buckle, 0.55, 0.05)
    paint.lay(ring, BRASS, 0.35, 0.012)
    paint.metal[:] = np.maximum(paint.metal, ring)
