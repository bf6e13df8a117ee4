"""Small recordings of every layout, written by the tests themselves."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.ga import Motor
from tests.replays.tiny_recordings import write_tiny

WIDTH, HEIGHT = 24, 16
INTRINSICS = (20.0, 21.0, 11.5, 7.5)


def image(index: int, channels: int = 3) -> np.ndarray:
    """An image whose pixels tell which one it is, BGR or grey."""
    rng = np.random.default_rng(index)
    shape = (HEIGHT, WIDTH, 3) if channels == 3 else (HEIGHT, WIDTH)
    return rng.integers(0, 256, shape, dtype=np.uint8)


def write_images(folder: Path, names: list[str], channels: int = 3) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for index, name in enumerate(names):
        assert cv2.imwrite(str(folder / name), image(index, channels))


def poses(count: int, seed: int = 5) -> Motor:
    return Motor.random(np.random.default_rng(seed), (count,))


def yaml_matrix(matrix: np.ndarray) -> str:
    numbers = ", ".join(map(repr, matrix.ravel().tolist()))
    return f"T_BS:\n  cols: 4\n  rows: 4\n  data: [{numbers}]\n"


@dataclass(frozen=True)
class Made:
    """A made-up recording and what its reader must find."""

    root: Path
    time_ns: np.ndarray
    poses: Motor
    camera_in_body: Motor
    imu_in_body: Motor


def _euroc(root: Path, count: int = 6) -> Made:
    body_T_camera, body_T_imu = poses(2, seed=8)
    time_ns = 1_403_715_273_262_142_976 + 50_000_000 * np.arange(count)
    cam, imu = root / "mav0" / "cam0", root / "mav0" / "imu0"
    write_images(cam / "data", [f"{stamp}.png" for stamp in time_ns], channels=1)
    rows = [f"{stamp},{stamp}.png" for stamp in time_ns]
    (cam / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows, ""]))
    (cam / "sensor.yaml").write_text(
        "%YAML:1.0\nsensor_type: camera\n"
        + yaml_matrix(body_T_camera.as_matrix())
        + f"resolution: [{WIDTH}, {HEIGHT}]\nintrinsics: {list(INTRINSICS)}\n"
        "distortion_model: radial-tangential\n"
        "distortion_coefficients: [-0.28, 0.07, 0.0002, 1e-05]\n"
    )
    imu.mkdir()
    imu_ns = time_ns[0] + 5_000_000 * np.arange(10 * count)
    values = np.random.default_rng(0).standard_normal((len(imu_ns), 6))
    rows = [f"{s},{','.join(map(repr, v))}" for s, v in zip(imu_ns, values.tolist(), strict=True)]
    (imu / "data.csv").write_text("\n".join(["#timestamp [ns],w,w,w,a,a,a", *rows]))
    (imu / "sensor.yaml").write_text(
        "%YAML:1.0\n"
        + yaml_matrix(body_T_imu.as_matrix())
        + "gyroscope_noise_density: 1.6968e-04\n"
        "gyroscope_random_walk: 1.9393e-05\naccelerometer_noise_density: 2.0e-3\n"
        "accelerometer_random_walk: 3.0e-3\n"
    )
    world_T_body = poses(count)
    wxyz, t = world_T_body.as_quaternion_translation()
    numbers = np.concatenate([t, wxyz, np.ones((count, 3))], axis=1).tolist()
    rows = [f"{s},{','.join(map(repr, v))}" for s, v in zip(time_ns, numbers, strict=True)]
    truth = root / "mav0" / "state_groundtruth_estimate0"
    truth.mkdir()
    (truth / "data.csv").write_text("\n".join(["#timestamp,p,p,p,q,q,q,q,v,v,v", *rows]))
    return Made(root, time_ns, world_T_body, body_T_camera, body_T_imu)


def _seven_scenes(root: Path, count: int = 5) -> Made:
    names = [f"frame-{i:06d}" for i in range(count)]
    write_images(root, [f"{name}.color.png" for name in names])
    world_T_camera = poses(count)
    for index, (name, matrix) in enumerate(zip(names, world_T_camera.as_matrix(), strict=True)):
        depth = np.full((HEIGHT, WIDTH), 1000 + index, np.uint16)
        depth[0, :2] = 0, 65535
        cv2.imwrite(str(root / f"{name}.depth.png"), depth)
        np.savetxt(root / f"{name}.pose.txt", matrix)
    time_ns = np.rint(np.arange(count) * 1e9 / 30).astype(np.int64)
    return Made(root, time_ns, world_T_camera, Motor.identity(), Motor.identity())


def _tum_rgbd(root: Path, count: int = 5) -> Made:
    root.mkdir(parents=True, exist_ok=True)
    names = [f"rgb/{i}.png" for i in range(count)]
    write_images(root / "rgb", [f"{i}.png" for i in range(count)])
    (root / "depth").mkdir()
    depth = np.full((HEIGHT, WIDTH), 7500, np.uint16)
    seconds = [f"1305031102.{175304 + 33333 * i:06d}" for i in range(count)]
    offsets = [0.003, -0.004, 0.05, 0.019, -0.021]
    listing = []
    for index, offset in enumerate(offsets):
        cv2.imwrite(str(root / f"depth/{index}.png"), depth)
        listing.append(f"{float(seconds[index]) + offset:.6f} depth/{index}.png")
    rows = [f"{s} {name}" for s, name in zip(seconds, names, strict=True)]
    (root / "rgb.txt").write_text("\n".join(["# color images", *rows]))
    (root / "depth.txt").write_text("\n".join(sorted(listing)))
    world_T_camera = poses(count)
    wxyz, t = world_T_camera.as_quaternion_translation()
    rows = [
        f"{s} {' '.join(map(repr, [*p, *q[1:], q[0]]))}"
        for s, p, q in zip(seconds, t.tolist(), wxyz.tolist(), strict=True)
    ]
    (root / "groundtruth.txt").write_text("\n".join(["# ground truth", *rows]))
    time_ns = np.array([int(s.replace(".", "") + "000") for s in seconds])
    return Made(root, time_ns, world_T_camera, Motor.identity(), Motor.identity())


def _kitti(root: Path, count: int = 4) -> Made:
    write_images(root / "image_0", [f"{i:06d}.png" for i in range(count)], channels=1)
    write_images(root / "image_2", [f"{i:06d}.png" for i in range(count)])
    fx, fy, cx, cy = INTRINSICS
    rows = [
        f"P{i}: {fx} 0 {cx} {x} 0 {fy} {cy} 0 0 0 1 0" for i, x in enumerate([0.0, -7.0, 4.0, -3.0])
    ]
    (root / "calib.txt").write_text("\n".join([*rows, "Tr: 1 0 0 0 0 1 0 0 0 0 1 0"]))
    kitti_T_camera0 = poses(count)
    np.savetxt(root / "poses.txt", kitti_T_camera0.as_matrix()[:, :3].reshape(-1, 12))
    (root / "times.txt").write_text("".join(f"{0.1037 * i:.6e}\n" for i in range(count)))
    time_ns = np.array([103_700_000 * i for i in range(count)])
    return Made(root, time_ns, kitti_T_camera0, Motor.identity(), Motor.identity())


def _folder(root: Path, count: int = 12) -> Made:
    write_images(root / "images", [f"img_{i}.jpg" for i in range(1, count + 1)])
    world_T_camera = poses(count)
    np.savetxt(root / "poses.txt", world_T_camera.as_matrix().reshape(-1, 16))
    time_ns = np.rint(np.arange(count) * 1e9 / 25).astype(np.int64)
    return Made(root, time_ns, world_T_camera, Motor.identity(), Motor.identity())


MAKERS = {
    "euroc": _euroc,
    "seven_scenes": _seven_scenes,
    "tum_rgbd": _tum_rgbd,
    "kitti": _kitti,
    "folder": _folder,
}


@pytest.fixture
def make(tmp_path: Path) -> Callable[[str], Made]:
    """Write a recording of a layout into a fresh folder."""

    def made(layout: str, name: str = "recording") -> Made:
        (tmp_path / name).mkdir()
        return MAKERS[layout](tmp_path / name)

    return made


@pytest.fixture
def video_file(tmp_path: Path) -> Path:
    """Sixty images in H.264 with uneven stamps, B-frames and a keyframe every twelve."""
    from fractions import Fraction

    import av

    path = tmp_path / "clip.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "0", "g": "12"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv444p"
        stream.codec_context.time_base = stream.time_base = Fraction(1, 90000)
        for index in range(60):
            image = np.full((48, 64, 3), 4 * index, np.uint8)
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts = 3003 * index + (index % 3) * 100
            frame.time_base = Fraction(1, 90000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


@pytest.fixture
def config(tmp_path: Path) -> Callable[..., Path]:
    """Write two recordings and a file that sweeps over them."""

    def written(recordings: str = '["one", "two"]', knobs: str = "", seeds: str = "[0, 1]") -> Path:
        for name, phase in (("one", 0.1), ("two", 0.7)):
            if not (tmp_path / name).exists():
                write_tiny(tmp_path / name, phase)
        path = tmp_path / "sweep.toml"
        path.write_text(
            f"recordings = {recordings}\nseeds = {seeds}\n[knobs]\n"
            'tracked.by = "simulated"\nimu.source = "auto"\n'
            f"convergence.duration_s = 1.0\n{knobs}\n"
        )
        return path

    return written
