"""`python -m tests.end_to_end.looks [MODEL ...]`: glTF models beside three.js, a scoreboard.

Each image of `looks` in the folder that `MOTORCADE_DATA` names is drawn by the fast renderer,
from its own camera and in its own light, and laid over the same grey in linear light. Scores are
those of the set's own `score.py`: overlap of the silhouettes, and within the reference's the mean
difference in levels and SSIM. Beside each row stand the last figures kept here. `--out FOLDER`
writes images and masks, for `score.py` and the eye. Ends with 1 where an image cannot be drawn,
or lies farther off than it did by more than 0.05 levels, 0.001 of SSIM or of overlap.

    python -m tests.end_to_end.looks                    # all
    python -m tests.end_to_end.looks Fox Duck --keep    # two models, and their figures kept
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from skimage.metrics import structural_similarity

from motorcade.animation import Character, read_character, skin
from motorcade.animation.appearance import to_linear, to_srgb
from motorcade.animation.skeleton import with_joint
from motorcade.ga import Motor, Similarity
from motorcade.render.backends.fast import FastRenderer
from motorcade.render.scene import Layer, Lighting, Sun, Surface
from motorcade.tracking.cameras.camera import Camera
from tests.bench.data import data_folder

KEPT = Path(__file__).with_name("looks.json")
OVERLAP, DIFFERENCE, SSIM = 0.99, 5.0, 0.97
"""What an image must reach to count as the reference's."""

HALF = 127
"""Alpha of a pixel of which half the samples are covered: it counts, as in the reference."""

RgbImage = NDArray[np.uint8]


def looks_folder() -> Path:
    """Where models and reference images lie."""
    return data_folder() / "looks"


def entries(folder: Path, models: list[str]) -> Iterator[dict[str, Any]]:
    """The images that are wanted, as `looks.json` describes them; all without names."""
    listed = json.loads((folder / "looks.json").read_text(encoding="utf-8"))["pictures"]
    for one in listed:
        if not models or Path(one["model"]).parent.name in models:
            yield one


def posed(character: Character, clips: list[int], time_s: float) -> Motor | Similarity:
    """The pose in which the file stands, and over it what the clips move, all at once.

    As three.js plays them, clips begin anew when their last key is past.
    """
    assert character.found_pose is not None  # set when the character was made
    found = character.found_pose
    chosen = [character.clips[number] for number in clips]
    if any(isinstance(clip.poses, Similarity) for clip in chosen):
        found = _growing(found)
    still = found.as_matrix()
    for clip in chosen:
        end_s = float(clip.time_s[-1])
        at = clip.at(time_s % end_s if end_s > 0.0 else 0.0)
        every = clip.poses if isinstance(found, Motor) else _growing(clip.poses)
        moves = np.abs(every.as_matrix() - still).max(axis=(0, 2, 3)) > 1e-6
        now = at if isinstance(found, Motor) else _growing(at)
        for joint in np.flatnonzero(moves):
            found = with_joint(found, int(joint), now[joint])
    return found


def shaped_by(character: Character, clips: list[int], time_s: float) -> Character:
    """The character with its morph targets mixed in as the clips say, else as at rest."""
    weights = None
    for number in clips:
        track = character.clips[number].morphs
        if track is not None:
            weights = track.at(time_s % max(float(track.time_s[-1]), 1e-9))
    return character.shaped(weights)


def _growing(poses: Motor | Similarity) -> Similarity:
    return poses if isinstance(poses, Similarity) else Similarity.from_motor_scale(poses)


def drawn(character: Character, one: dict[str, Any]) -> Layer:
    """An image of a character as an entry of `looks.json` asks for it."""
    into = character.character_T_file
    given = np.array(one["world_T_camera"])
    pose = into.rigid @ Motor.from_matrix(_rigid(given))
    place = into.apply(given[:3, 3])
    camera = Camera(**one["camera"])
    shaped = shaped_by(character, one["clips"], one["time_s"])
    vertices, normals = skin(shaped, posed(character, one["clips"], one["time_s"]), "linear")
    surface = Surface(
        vertices,
        normals,
        character.triangles,
        character.colors,
        appearance=character.appearance,
    )
    x, y, z = into.rigid.rotor.apply(np.array(one["sun"]["direction"])).tolist()
    ambient = one["ambient"]["radiance"]
    # The reference has no shadows: here they are made far away.
    away = (float(place[0]), float(place[1]), float(place[2]) + 1e6)
    light = Lighting((ambient,) * 3, Sun((x, y, z), one["sun"]["irradiance"]), (), away, 1.0)
    with FastRenderer(camera.width, camera.height) as renderer:
        renderer.show([surface], light)
        return renderer.render(camera, Motor.from_rotor_translation(pose.rotor, place))


def _rigid(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same with a block that is a rotation to all digits; twelve are written."""
    u, _, vt = np.linalg.svd(matrix[:3, :3])
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = u @ vt, matrix[:3, 3]
    return made


def over_grey(layer: Layer, grey: int) -> RgbImage:
    """A layer over an even background, in linear light."""
    alpha = layer.rgba[..., 3:] / 255.0
    own = layer.rgba[..., :3] / 255.0 / np.maximum(alpha, 1e-9)
    mixed = to_linear(np.minimum(own, 1.0)) * alpha
    mixed += to_linear(np.array(grey / 255.0)) * (1.0 - alpha)
    return np.asarray(np.rint(255.0 * to_srgb(mixed)), dtype=np.uint8)


def scores(made: RgbImage, mask: NDArray[np.bool_], folder: Path, name: str) -> dict[str, float]:
    """Overlap, mean difference and SSIM, as `score.py` has them."""
    given = np.asarray(Image.open(folder / "reference" / f"{name}.png").convert("RGB"), float)
    held = np.asarray(Image.open(folder / "reference" / f"{name}_mask.png").convert("L")) > 127
    whole = structural_similarity(
        made.astype(float), given, channel_axis=2, data_range=255, full=True
    )
    return {
        "overlap": float((mask & held).sum() / (mask | held).sum()),
        "difference": float(np.abs(made - given)[held].mean()),
        "ssim": float(whole[1].mean(axis=2)[held].mean()),
    }


def passes(row: dict[str, float]) -> bool:
    """Whether an image counts as the reference's."""
    near = row["overlap"] >= OVERLAP and row["difference"] <= DIFFERENCE
    return near and row["ssim"] >= SSIM


def worse(row: dict[str, float], kept: dict[str, float]) -> bool:
    """Whether an image lies farther from the reference than it did."""
    return bool(kept) and (
        row["difference"] > kept["difference"] + 0.05
        or row["ssim"] < kept["ssim"] - 0.001
        or row["overlap"] < kept["overlap"] - 0.001
    )


def line(name: str, row: dict[str, float], kept: dict[str, float]) -> str:
    """A row of the table, with the last figures beside."""
    last = "          new"
    if kept:
        last = f"{kept['overlap']:.4f} {kept['difference']:6.2f} {kept['ssim']:.4f}"
    now = f"{row['overlap']:.4f} {row['difference']:6.2f} {row['ssim']:.4f}"
    return f"{name:<24}{now}   last {last}  {'near' if passes(row) else 'off'}"


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 1 where something failed or got worse."""
    parser = argparse.ArgumentParser(description="glTF models beside three.js's images of them")
    parser.add_argument("models", nargs="*", metavar="MODEL", help="names; all by default")
    parser.add_argument("--keep", action="store_true", help="keep these figures")
    parser.add_argument("--out", type=Path, help="folder for images and masks")
    given = parser.parse_args(arguments)
    folder = looks_folder()
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    made: dict[str, dict[str, float]] = {}
    failed = []
    print(f"{'':<24}overlap differ   ssim")
    for one in entries(folder, given.models):
        name = one["name"]
        try:
            layer = drawn(read_character(folder / one["model"]), one)
        except Exception as fault:  # a scoreboard tells of every image
            failed.append(f"{name}: {type(fault).__name__}: {fault}")
            print(failed[-1], flush=True)
            continue
        image, mask = over_grey(layer, one["background_srgb8"][0]), layer.rgba[..., 3] >= HALF
        row = scores(image, mask, folder, name)
        print(line(name, row, kept.get(name, {})), flush=True)
        if worse(row, kept.get(name, {})):
            failed.append(f"{name}: lies farther off than it did")
        made[name] = {key: round(value, 5) for key, value in row.items()}
        if given.out is not None:
            given.out.mkdir(parents=True, exist_ok=True)
            Image.fromarray(image).save(given.out / f"{name}.png")
            Image.fromarray(mask).save(given.out / f"{name}_mask.png")
    print(f"{sum(map(passes, made.values()))} of {len(made)} are near the reference")
    if given.keep:
        KEPT.write_text(json.dumps(kept | made, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    for fault in failed:
        print(f"FAILED {fault}", file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
