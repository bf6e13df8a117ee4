"""Mistakes in manifests: each gives one clear line that names it."""

from __future__ import annotations

import numpy as np
import pytest

from motorcade.replays.io.files import RecordingError
from tests.replays.readers.test_manifests import (
    BOARD,
    CAMERA,
    FRAMES,
    IDENTITY,
    TRUTH,
    Make,
    described,
)

MISTAKES = {
    "unknown table": ("[camra]\nfx = 1\n", r"'camra': unknown key; did you mean camera\?"),
    "unknown key": (
        FRAMES + CAMERA + "distorsion = [1]\n",
        r"\[camera\] 'distorsion': unknown key; did you mean distortion\?",
    ),
    "key of another board": (FRAMES + BOARD + "gap_m = 1\n", r"\[board\] 'gap_m': unknown key"),
    "not a table": ("frames = 3\n", r"\[frames\]: expected a table, got '3'"),
    "not TOML": ("[frames\n", "expected TOML"),
    "twice": (FRAMES + FRAMES, "expected TOML"),
    "deep": ("a = " + "[" * 5000, "expected TOML: nested too deeply"),
    "huge": ("#" * 70_000, "expected at most 65536 bytes, got 70000"),
    "no rate": ('[frames]\nimages = "images/*.jpg"\n', r"\[frames\] rate_hz: the key is missing"),
    "rate 0": (FRAMES.replace("25", "0"), r"rate_hz: expected a number from 0.001"),
    "rate text": (FRAMES.replace("25", '"25"'), r"rate_hz: expected a number .* got '25'"),
    "rate true": (FRAMES.replace("25", "true"), r"rate_hz: expected a number .* got 'True'"),
    "rate nan": (FRAMES.replace("25", "nan"), r"rate_hz: expected a number .* got 'nan'"),
    "two stamps": (FRAMES + 'stamps = "t.txt"\n', "expected either rate_hz or stamps, got both"),
    "unit": (
        '[frames]\nimages = "images/*.jpg"\nstamps = "t.txt"\nstamps_unit = "sec"\n',
        "stamps_unit: expected one of s, ms, 100 us, us, ns",
    ),
    "no images": (FRAMES.replace("images/*", "img/*"), "expected images 'img/.*', got none"),
    "no images but": (FRAMES.replace("images/*.jpg", "*.txt"), r"poses\.txt: expected images"),
    "pattern outside": (FRAMES.replace("images/*", "../*"), "expected a file name inside"),
    "bad pattern": (FRAMES.replace("images/*.jpg", "**x/*.jpg"), "cannot be used|got none"),
    "size": (FRAMES + CAMERA + "width = 24\n", r"\[camera\] height: the key is missing"),
    "wrong size": (
        FRAMES + CAMERA + "width = 24\nheight = 17\n",
        "frame 0: expected 24 x 17 pixels as the camera has, got 24 x 16",
    ),
    "view and fx": (FRAMES + CAMERA + "fov_deg = 60\n", "expected either fov_deg or fx, got both"),
    "view": (FRAMES + "[camera]\nfov_deg = 180\n", "fov_deg: expected a number from 1 to 170"),
    "readout": (FRAMES + CAMERA + "readout_s = 15\n", "readout_s: expected a number from 0 to 0.2"),
    "focal sigma": (FRAMES + CAMERA + "focal_sigma = 2\n", "focal_sigma: expected a number from 0"),
    "zoom without times": (FRAMES + CAMERA + "zoom = [1.0]\n", "zoom_s: the key is missing"),
    "zoom of another length": (
        FRAMES + CAMERA + "zoom_s = [0.0, 1.0]\nzoom = [1.0]\n",
        "expected 2 numbers above 0",
    ),
    "readout alone": (FRAMES + "[camera]\nreadout_s = 0.01\n", "fx: the key is missing"),
    "no fx": (FRAMES + CAMERA.replace("fx", "cx", 1), "expected TOML|fx"),
    "model": (
        FRAMES + CAMERA + 'model = "fisheye"\n',
        r"model: expected one of pinhole, radtan, equidistant, got 'fisheye'",
    ),
    "coefficients": (
        FRAMES + CAMERA + 'model = "radtan"\ndistortion = [0.1, 0.2, 0.3]\n',
        "distortion: radtan expects 2 or 4 or 5 or 8 coefficients, got 3",
    ),
    "no model": (FRAMES + CAMERA + "distortion = [0.1]\n", "model: the key is missing"),
    "distortion nan": (
        FRAMES + CAMERA + 'model = "radtan"\ndistortion = [0.1, nan]\n',
        "distortion: expected a number",
    ),
    "board kind": (FRAMES + '[board]\ntype = "chess"\n', "type: expected one of checkerboard"),
    "board size": (FRAMES + BOARD.replace("9", "0"), r"checkerboard: Checkerboard\.columns"),
    "board huge": (FRAMES + BOARD.replace("9", "90000"), "columns: expected a whole number from"),
    "board float": (FRAMES + BOARD.replace("9", "9.5"), "columns: expected a whole number"),
    "family": (
        FRAMES + '[board]\ntype="marker"\nfamily="tag36h1"\nmarker_id=0\nside_m=1\n',
        r"family: expected one of .* did you mean tag36h11\?",
    ),
    "board pose": (
        FRAMES + BOARD + "world_T_board = [[1, 0], [0, 1]]\n",
        r"\[board\] world_T_board: expected 4 rows of 4 numbers",
    ),
    "board scaled": (
        FRAMES + BOARD + f"world_T_board = {(2 * np.eye(4)).tolist()}\n",
        "world_T_board: expected a rotation",
    ),
    "markers' family": (
        FRAMES + '[markers]\nfamily = "tag36"\nside_m = 0.1\n',
        r"\[markers\] family: expected one of",
    ),
    "markers' side": (
        FRAMES + '[markers]\nfamily = "tag36h11"\nside_m = 0\n',
        r"\[markers\] side_m: expected a number from",
    ),
    "markers' map": (
        FRAMES + '[markers]\nfamily = "tag36h11"\nside_m = 0.1\nmap_file = "map.json"\n',
        r"\[markers\] map_file: .*map\.json",
    ),
    "map of slam": (FRAMES + '[slam]\nmap_file = "map.npz"\n', r"\[slam\] map_file: .*map\.npz"),
    "truth format": (FRAMES + TRUTH.replace("matrix4", "mat"), "format: expected one of tum"),
    "truth file": (FRAMES + TRUTH.replace("poses", "pose"), r"pose\.txt: the file is missing"),
    "no convention": (
        FRAMES + TRUTH.replace('convention = "world_T_camera"', ""),
        r"\[truth\] convention: the key is missing",
    ),
    "rows": (FRAMES + TRUTH + "rows = 13\n", "rows: expected a whole number from 1 to 12"),
    "imu extrinsics": (FRAMES + '[imu]\nfile = "imu.csv"\n', r"imu_T_camera: the key is missing"),
    "no imu": (FRAMES + f"[imu]\nimu_T_camera = {IDENTITY}\n", r"\[imu\] file: the key is missing"),
    "name": (FRAMES.replace("[frames]", "name = 3\n[frames]"), "name: expected text, got '3'"),
    "settings": ("settings = 'a.b=1'\n" + FRAMES, "settings: expected a list of texts"),
    "a setting": ("settings = ['a.b=1', 2]\n" + FRAMES, "settings: expected texts, got '2'"),
}


@pytest.mark.parametrize(("text", "message"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_gives_one_line_that_names_it(make: Make, text: str, message: str) -> None:
    made = make("folder")
    (made.root / "imu.csv").write_text("0,1,1,1,1,1,1\n5,1,1,1,1,1,1\n")
    with pytest.raises(RecordingError, match=message) as refused:
        described(made.root, text).check()
    assert "\n" not in str(refused.value)
