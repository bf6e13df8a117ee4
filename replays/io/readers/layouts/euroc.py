"""EuRoC MAV layout: `mav0/cam0`, `mav0/imu0`, ground truth of the body; camera 0 is read.

The body frame B is the one that `T_BS` in each `sensor.yaml` refers to; in EuRoC it is the IMU's.
Truth is `mav0/state_groundtruth_estimate0` or else a TUM or EuRoC trajectory file beside `mav0`;
both describe the body. Compared with the IMU of V1_01, such files do: the gyroscope's rates agree
with the body's of `V1_01_easy.txt` within 0.01 degrees of frame, while `V1_01_easy_original.txt`,
the set's first release, is off by about 1 degree of frame and 1.8 degrees of gravity. So where
`X.txt` and `X_original.txt` both stand, the former is taken; a manifest can say otherwise.

TUM-VI keeps the same folders without `sensor.yaml`: cameras and noise stand in Kalibr's files
in `dso` (`camchain.yaml`, `imu_config.yaml`), the ground truth, of the IMU, in `mav0/mocap0`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from motorcade.ga import Motor, Trajectory
from motorcade.replays.io.files import RecordingError, refusal
from motorcade.replays.io.imu import read_imu, read_noise
from motorcade.replays.io.readers import kalibr
from motorcade.replays.io.readers.calibration import yaml_camera, yaml_transform
from motorcade.replays.io.readers.frames.files import ImageFrames, inside
from motorcade.replays.io.readers.tables import read_listing
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import read_trajectory, trajectory_format

if TYPE_CHECKING:
    from motorcade.fusion.imu.noise import ImuNoise
    from motorcade.fusion.imu.stream import ImuStream
    from motorcade.tracking.cameras.camera import Camera


def recognise(root: Path) -> bool:
    """Whether this is a sequence folder (with `mav0`) or `mav0` itself."""
    return any((root / mav / "cam0" / "data.csv").is_file() for mav in ("mav0", "."))


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read an EuRoC or TUM-VI sequence.

    Images may be missing at the end of `data.csv` only (a sequence cut short).

    Raises:
        RecordingError: whatever is missing in the middle, does not fit or cannot be read.
    """
    mav = root / "mav0" if (root / "mav0").is_dir() else root
    reader = _from_chain if not (mav / "cam0" / "sensor.yaml").is_file() else _from_sensors
    known = reader(root, mav)
    imu, truth = read_own_imu(root), _truth(root, mav, known.body_T_camera) if own_truth else None
    if known.offset_ns and imu is not None:
        imu = replace(imu, time_ns=imu.time_ns - known.offset_ns)
    if known.offset_ns and truth is not None:
        truth = Trajectory(truth.time_ns - known.offset_ns, truth.poses, truth.parent, truth.child)
    return Recording(
        name=(root if mav != root else root.resolve().parent).resolve().name,
        root=root,
        layout="euroc",
        frames=_frames(mav / "cam0", (known.camera.width, known.camera.height)),
        camera=known.camera,
        imu=imu,
        imu_noise=known.noise,
        imu_T_camera=known.imu_T_camera,
        truth=truth,
    )


def read_images(root: Path) -> ImageFrames:
    """The images of `cam0` alone, whose camera need not be known: as they are before calibration.

    Raises:
        RecordingError: images that are missing, or a listing that cannot be read.
    """
    mav = root / "mav0" if (root / "mav0").is_dir() else root
    return _frames(mav / "cam0", None)


def read_own_imu(root: Path) -> ImuStream | None:
    """The readings of `imu0` as they are; None without.

    Raises:
        RecordingError: what `read_imu` refuses.
    """
    imu = (root / "mav0" if (root / "mav0").is_dir() else root) / "imu0" / "data.csv"
    return read_imu(imu) if imu.is_file() else None


@dataclass(frozen=True)
class _Calibration:
    """What is known of the sensors; of the IMU only where there is one.

    `offset_ns` is what its clock, which the truth shares, shows more than the camera's.
    """

    camera: Camera
    body_T_camera: Motor
    noise: ImuNoise | None
    imu_T_camera: Motor | None
    offset_ns: int = 0


def _from_sensors(root: Path, mav: Path) -> _Calibration:
    """EuRoC's way: a `sensor.yaml` in the folder of each sensor."""
    sensor, imu = mav / "cam0" / "sensor.yaml", mav / "imu0" / "sensor.yaml"
    camera, body_T_camera = yaml_camera(sensor), yaml_transform(sensor)
    if not (mav / "imu0" / "data.csv").is_file():
        return _Calibration(camera, body_T_camera, None, None)
    imu_T_camera = yaml_transform(imu).inverse() @ body_T_camera
    return _Calibration(camera, body_T_camera, read_noise(imu), imu_T_camera)


def _from_chain(root: Path, mav: Path) -> _Calibration:
    """TUM-VI's way: Kalibr's files; the body is the IMU."""
    folders = (root / "dso", mav.parent / "dso", root)
    chain = next((c for f in folders if (c := kalibr.find(f, kalibr.CHAIN_NAMES))), None)
    if chain is None:
        raise refusal(mav / "cam0" / "sensor.yaml", "expected this file, or dso/camchain.yaml")
    known = kalibr.read_chain(chain)[0]
    if known.imu_T_camera is None:
        raise refusal(chain, "the key is missing", field="cam0 T_cam_imu")
    noise = kalibr.find(chain.parent, kalibr.IMU_NAMES)
    densities = None if noise is None else read_noise(noise)
    place, offset_ns = known.imu_T_camera, round(1e9 * (known.offset_s or 0.0))
    return _Calibration(known.camera, place, densities, place, offset_ns)


def _frames(folder: Path, size: tuple[int, int] | None) -> ImageFrames:
    listing = read_listing(folder / "data.csv", separator=b",", unit="ns")
    files = [
        inside(folder / "data", name, listing.path, int(line))
        for name, line in zip(listing.names, listing.lines, strict=True)
    ]
    present = [file.is_file() for file in files]
    if not any(present):
        raise refusal(folder / "data", f"expected the images that {listing.path} lists, got none")
    count = len(files) - present[::-1].index(True)
    if not all(present[:count]):
        missing = present.index(False)
        raise refusal(
            files[missing],
            f"the image is missing, but later ones of {listing.path} are there",
            field=f"frame {missing}",
            advice="copy it again, or remove its row",
        )
    return ImageFrames(tuple(files[:count]), listing.time_ns[:count], size)


def _truth(root: Path, mav: Path, body_T_camera: Motor) -> Trajectory | None:
    estimate = mav / "state_groundtruth_estimate0"
    if (mav / "mocap0" / "data.csv").is_file():
        estimate = mav / "mocap0"
    body_T_truth = Motor.identity()
    path: Path | None = estimate / "data.csv"
    if path is None or not path.is_file():
        path = _truth_beside(root if mav != root else root.parent)
    elif (estimate / "sensor.yaml").is_file():
        body_T_truth = yaml_transform(estimate / "sensor.yaml")
    if path is None:
        return None
    poses = read_trajectory(path, child="body")
    truth_T_camera = body_T_truth.inverse() @ body_T_camera
    return poses.transformed_by(right=truth_T_camera, child="camera")


def _truth_beside(folder: Path) -> Path | None:
    """The one trajectory file beside `mav0`; superseded `X_original` files are left out."""
    rows = []
    for path in sorted([*folder.glob("*.txt"), *folder.glob("*.csv")]):
        try:
            if trajectory_format(path) in ("tum", "euroc"):
                rows.append(path)
        except RecordingError:
            continue
    stems = {path.stem for path in rows}
    kept = [p for p in rows if p.stem.removesuffix("_original") not in stems - {p.stem}]
    if len(kept) > 1:
        names = ", ".join(path.name for path in kept)
        raise refusal(
            folder,
            f"expected one truth file beside mav0, got {names}",
            advice="choose one in a manifest: [truth] file",
        )
    return kept[0] if kept else None
