"""Drawn clips with cuts, fades, frames that repeat and cameras that stand: is each named rightly?

    python -m tests.end_to_end.shots [KIND …] [--seeds 3] [--first-seed 0]

Scenes are textured layers at several depths seen by a camera whose motion is known, so that
parallax, turns and zooms are what they say. The table has a line a kind: how many seeds were named
rightly, and what was said of the first that was not. Ends with 1 where one was not.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np

from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.tracking.checks import GrayImage
from motorcade.tracking.shots import Shots, find_shots

SIZE = (480, 270)
FOCAL = 0.8 * SIZE[0]
_WALL = 1500
_NOISE = 1.5


@dataclass(frozen=True)
class Expected:
    """What is to be said: first and last frame and the camera's motion of every shot.

    Fields:
        shots: each `(first, last, motion)`.
        off: by so many frames an end may be off.
        repeated: about how many frames repeat the one before in the first shot; None for any.
        kinds: of breaks that have to be among those named.
    """

    shots: list[tuple[int, int, str]]
    off: int = 0
    repeated: int | None = None
    kinds: set[str] = field(default_factory=set)

    def fault(self, found: Shots) -> str:
        """What is wrong with what was found; empty where nothing is."""
        said = [(each.first, each.last, each.motion.kind) for each in found.shots]
        if len(said) != len(self.shots) or any(
            abs(one[0] - other[0]) > self.off
            or abs(one[1] - other[1]) > self.off
            or one[2] not in other[2].split("|")
            for one, other in zip(said, self.shots, strict=False)
        ):
            return f"{said} for {self.shots}"
        if not self.kinds <= {each.kind for each in found.breaks}:
            return f"breaks {found.breaks} for {self.kinds}"
        if self.repeated is not None and abs(found.shots[0].repeated - self.repeated) > 2:
            return f"{found.shots[0].repeated} repeated for {self.repeated}"
        return ""


class Scene:
    """Textured walls at three depths, of which the nearer ones have gaps."""

    def __init__(self, rng: np.random.Generator, depths: tuple[float, ...] = (6.0, 3.0, 1.8)):
        self.depths = depths
        self.walls = [_texture(rng) for _ in depths]
        self.masks = [np.ones((_WALL, _WALL), np.uint8)]
        for _ in depths[1:]:
            mask = np.zeros((_WALL, _WALL), np.uint8)
            for x, y in rng.uniform(0.0, _WALL, (26, 2)):
                half = rng.uniform(25.0, 75.0, 2)
                low, high = (
                    (int(x - half[0]), int(y - half[1])),
                    (int(x + half[0]), int(y + half[1])),
                )
                cv2.rectangle(mask, low, high, 1, -1)
            self.masks.append(mask)

    def seen(self, turn_rad: FloatArray, place: FloatArray, zoom: float = 1.0) -> FloatArray:
        """The image of a camera with that attitude (rotation vector) at that place."""
        middle = 0.5 * (np.array(SIZE) - 1.0)
        lens = np.array([[zoom * FOCAL, 0, middle[0]], [0, zoom * FOCAL, middle[1]], [0, 0, 1.0]])
        world = Rotor.from_rotation_vector(turn_rad).as_matrix().T
        image = np.zeros((SIZE[1], SIZE[0]), np.float32)
        for wall, mask, depth in zip(self.walls, self.masks, self.depths, strict=True):
            side = 2.6 * depth / _WALL  # a wall is 2.6 depths wide
            plane = np.array(
                [[side, 0, -0.5 * side * _WALL], [0, side, -0.5 * side * _WALL], [0, 0, depth]]
            )
            plane -= np.outer(place, [0, 0, 1.0])
            warp = lens @ world @ plane
            shown = cv2.warpPerspective(wall, warp, SIZE, borderMode=cv2.BORDER_REFLECT)
            covers = cv2.warpPerspective(mask, warp, SIZE, flags=cv2.INTER_NEAREST)
            image = np.where(covers > 0, shown, image)
        return image


def _texture(rng: np.random.Generator) -> FloatArray:
    """Patches, lines and some grain, as rooms have them."""
    wall = np.full((_WALL, _WALL), rng.uniform(60.0, 190.0), np.float32)
    for x, y in rng.uniform(0.0, _WALL, (260, 2)):
        half = rng.uniform(8.0, 70.0, 2)
        low, high = (int(x - half[0]), int(y - half[1])), (int(x + half[0]), int(y + half[1]))
        if rng.uniform() < 0.6:
            cv2.rectangle(wall, low, high, float(rng.uniform(10.0, 245.0)), -1)
        else:
            cv2.ellipse(
                wall,
                (int(x), int(y)),
                (int(half[0]), int(half[1])),
                float(rng.uniform(0, 180)),
                0,
                360,
                float(rng.uniform(10.0, 245.0)),
                -1,
            )
    grain = cv2.GaussianBlur(rng.normal(0.0, 40.0, wall.shape).astype(np.float32), (0, 0), 2.0)
    return cv2.GaussianBlur(wall, (0, 0), 1.0) + grain


def moving(rng: np.random.Generator, count: int, speed: float = 1.0) -> list[FloatArray]:
    """A hand-held camera that goes sideways and ahead past a scene with depth."""
    scene, way = Scene(rng), rng.uniform(-1.0, 1.0, 3) * [0.3, 0.15, 0.4]
    way[0] += np.sign(way[0]) * 0.35
    shake = _shake(rng, count, 0.004)
    return [
        scene.seen(shake[k], speed * way * k / 60.0 - 0.5 * speed * way * count / 60.0)
        for k in range(count)
    ]


def turning(rng: np.random.Generator, count: int, rad_a_frame: float = 0.005) -> list[FloatArray]:
    """A camera on a head that pans and tilts a little."""
    scene, sign = Scene(rng), rng.choice([-1.0, 1.0])
    yaw = sign * rad_a_frame * (np.arange(count) - 0.5 * count)
    return [
        scene.seen(np.array([0.06 * np.sin(k / 25.0), yaw[k], 0.0]), np.zeros(3))
        for k in range(count)
    ]


def standing(rng: np.random.Generator, count: int) -> list[FloatArray]:
    """A camera on a stand."""
    return [Scene(rng).seen(np.zeros(3), np.zeros(3))] * count


def with_object(
    rng: np.random.Generator, images: list[FloatArray], size: float
) -> list[FloatArray]:
    """A textured thing of that share of the image's height that wanders before the scene."""
    texture, side = _texture(rng), int(size * SIZE[1])
    patch = texture[:side, :side]
    phase = rng.uniform(0.0, 6.0)
    drawn = []
    for k, image in enumerate(images):
        x = int((0.5 + 0.3 * np.sin(0.06 * k + phase)) * (SIZE[0] - side))
        y = int((0.5 + 0.3 * np.cos(0.045 * k + phase)) * (SIZE[1] - side))
        other = image.copy()
        other[y : y + side, x : x + side] = patch
        drawn.append(other)
    return drawn


def plain_wall(rng: np.random.Generator, count: int) -> list[FloatArray]:
    """A held camera before a nearly plain wall with faint marks."""
    wall = np.full((SIZE[1] + 20, SIZE[0] + 20), 190.0, np.float32)
    for x, y in rng.uniform(0, 1, (40, 2)) * [SIZE[0], SIZE[1]]:
        cv2.circle(
            wall, (int(x), int(y)), int(rng.integers(3, 9)), float(rng.uniform(150, 180)), -1
        )
    shake = 400.0 * _shake(rng, count, 0.002)
    views = []
    for k in range(count):
        shift = np.array([[1.0, 0.0, shake[k, 0] - 10], [0.0, 1.0, shake[k, 1] - 10]])
        views.append(cv2.warpAffine(wall, shift, SIZE, borderMode=cv2.BORDER_REFLECT))
    return views


def _shake(rng: np.random.Generator, count: int, rad: float) -> FloatArray:
    """Rotation vectors ``(count, 3)`` of a hand: smooth and bounded."""
    noise = rng.normal(0.0, 1.0, (count + 40, 3))
    kernel = np.exp(-0.5 * (np.arange(-20, 21) / 6.0) ** 2)
    smooth = np.stack([np.convolve(noise[:, k], kernel, "valid") for k in range(3)], axis=-1)
    return np.asarray(rad * smooth / smooth.std())


def _black(count: int) -> list[FloatArray]:
    return [np.full((SIZE[1], SIZE[0]), 4.0, np.float32)] * count


def _ramp(images: list[FloatArray], shares: FloatArray) -> list[FloatArray]:
    """Images times shares of their light, those beyond the shares as they are."""
    faded = [share * image for share, image in zip(shares, images, strict=False)]
    return faded + images[len(shares) :]


def _dissolved(first: list[FloatArray], second: list[FloatArray], count: int) -> list[FloatArray]:
    shares = (np.arange(count) + 1.0) / (count + 1.0)
    mixed = [
        (1.0 - share) * one + share * other
        for share, one, other in zip(shares, first[-count:], second[:count], strict=True)
    ]
    return first[:-count] + mixed + second[count:]


def _zooming(rng: np.random.Generator, count: int) -> list[FloatArray]:
    scene = Scene(rng)
    return [scene.seen(np.zeros(3), np.zeros(3), 1.0 + 0.006 * k) for k in range(count)]


Drawn = tuple[list[FloatArray], Expected]
KINDS: dict[str, Callable[[np.random.Generator], Drawn]] = {}


def _kind(name: str) -> Callable[[Callable[[np.random.Generator], Drawn]], None]:
    def keep(draw: Callable[[np.random.Generator], Drawn]) -> None:
        KINDS[name] = draw

    return keep


def _simple(
    name: str,
    draw: Callable[[np.random.Generator], list[FloatArray]],
    *shots: tuple[int, int, str],
    off: int = 0,
    repeated: int | None = None,
    kinds: tuple[str, ...] = (),
) -> None:
    _kind(name)(lambda rng: (draw(rng), Expected(list(shots), off, repeated, set(kinds))))


_M, _S, _T = "moves", "stands", "turns"
_simple("moves", lambda r: moving(r, 90), (0, 89, _M), repeated=0)
_simple("slow travel", lambda r: moving(r, 120, 0.35), (0, 119, _M))
_simple("a cut", lambda r: moving(r, 50) + moving(r, 60), (0, 49, _M), (50, 109, _M))
_simple(
    "three shots",
    lambda r: standing(r, 30) + moving(r, 45) + turning(r, 60),
    *((0, 29, _S), (30, 74, _M), (75, 134, _T)),
)
_simple("black first", lambda r: _black(12) + moving(r, 60), (12, 71, _M), kinds=("black",))
_simple(
    "fades in",
    lambda r: _black(6) + _ramp(moving(r, 80), np.linspace(0.02, 1.0, 20)),
    (18, 85, _M),
    off=9,
    kinds=("black",),
)
_simple(
    "fades out and in",
    lambda r: (
        _ramp(moving(r, 60)[::-1], np.linspace(0.02, 1.0, 12))[::-1]
        + _black(5)
        + _ramp(turning(r, 60), np.linspace(0.02, 1.0, 12))
    ),
    *((0, 54, _M), (72, 124, _T)),
    off=8,
    kinds=("black",),
)
_simple(
    "ends white",
    lambda r: moving(r, 60) + [np.full(SIZE[::-1], 250.0, np.float32)] * 10,
    (0, 59, _M),
    kinds=("plain",),
)
_simple(
    "dissolve of stills",
    lambda r: _dissolved(standing(r, 50), standing(r, 50), 16),
    (0, 33, _S),
    (50, 83, _S),
    off=12,
    kinds=("dissolve",),
)
_simple(
    "dissolve of travels",
    lambda r: _dissolved(moving(r, 60, 0.3), moving(r, 60, 0.3), 16),
    (0, 43, "moves|stands|turns"),
    (60, 103, "moves|stands|turns"),
    off=14,
    kinds=("dissolve",),
)
_simple("fast pan", lambda r: turning(r, 60, 0.03), (0, 59, _T))
_simple("turns", lambda r: turning(r, 90), (0, 89, _T))
_simple("stands", lambda r: standing(r, 60), (0, 59, _S), repeated=0)
_simple("stands, a thing moves", lambda r: with_object(r, standing(r, 80), 0.45), (0, 79, _S))
_simple("stands, a large thing moves", lambda r: with_object(r, standing(r, 80), 0.65), (0, 79, _S))
_simple(
    "held before a plain wall, a thing moves",
    lambda r: with_object(r, plain_wall(r, 90), 0.4),
    (0, 89, _S),
)
_simple("turns, a thing moves", lambda r: with_object(r, turning(r, 90), 0.25), (0, 89, _T))
_simple("zooms", lambda r: _zooming(r, 70), (0, 69, "zooms"))


@_kind("a flash")
def _flash(rng: np.random.Generator) -> Drawn:
    images = moving(rng, 80)
    for k in (40, 41):
        images[k] = np.minimum(0.3 * images[k] + 230.0, 255.0)
    return images, Expected([(0, 79, _M)])


@_kind("a step of exposure")
def _step(rng: np.random.Generator) -> Drawn:
    images = moving(rng, 80)
    return images[:40] + [0.55 * one for one in images[40:]], Expected([(0, 79, _M)])


@_kind("a broken image")
def _broken(rng: np.random.Generator) -> Drawn:
    images = moving(rng, 80)
    images[37] = np.repeat(images[37][130:131], SIZE[1], axis=0)
    return images, Expected([(0, 79, _M)])


@_kind("frozen for a while")
def _frozen(rng: np.random.Generator) -> Drawn:
    images = moving(rng, 80)
    return images[:40] + [images[40]] * 21 + images[41:], Expected([(0, 99, _M)], 0, 20)


@_kind("every fifth repeated")
def _pulled(rng: np.random.Generator) -> Drawn:
    images = moving(rng, 80)
    repeated = [images[k - k // 5 - (k % 5 == 4)] for k in range(95)]
    return repeated, Expected([(0, 94, _M)], 0, 18)


def draw(kind: str, seed: int) -> tuple[list[GrayImage], Expected]:
    """The images of a kind, with a sensor's noise, and what is to be said of them."""
    rng = np.random.default_rng([seed, *kind.encode()])
    images, expected = KINDS[kind](rng)
    last, grain, taken = None, np.zeros(SIZE[::-1]), []
    for image in images:
        if image is not last or expected.repeated is None or kind == "stands":
            grain = rng.normal(0.0, _NOISE, SIZE[::-1])
        last = image
        taken.append(np.clip(image + grain, 0, 255).astype(np.uint8))
    return taken, expected


def main(arguments: list[str]) -> int:
    """Print the table; 1 where a clip was not named rightly."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=0)
    asked = parser.parse_args(arguments)
    wrong = 0
    for kind in asked.kinds:
        faults = []
        for seed in range(asked.first_seed, asked.first_seed + asked.seeds):
            images, expected = draw(kind, seed)
            fault = expected.fault(find_shots(images))
            faults += [f"seed {seed}: {fault}"] if fault else []
        wrong += len(faults)
        print(
            f"{kind:40} {asked.seeds - len(faults)} of {asked.seeds} {''.join(faults[:1])}",
            flush=True,
        )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
