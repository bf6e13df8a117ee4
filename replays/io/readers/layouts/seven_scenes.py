"""7-Scenes layout: `frame-000000.color.png`, `.depth.png` (mm), `.pose.txt` (camera to world).

Images at 30 Hz. What is published are the depth camera's fx = fy = 585, cx = 320, cy = 240, which
an optional `camera-intrinsics.txt` (3 by 3) repeats; and that depth is not registered to colour.
The sensor is the first Kinect: its colour camera has about 525 px and stands 25 to 27 mm to the
right of the depth camera, its axis parallel but for half a degree. With these values depth is
registered as it is read; runs then look whether it lies on colour. The published poses are
the depth camera's; here they are carried to the colour camera, which is the recording's. The world
is that of the set's first fusion volume; which way is up in it is unknown.

Sources: Shotton et al. 2013 (the set); Herrera, Kannala & Heikkila 2012 (the sensor's cameras).
"""

from __future__ import annotations

from pathlib import Path

from motorcade.ga import Motor, Trajectory
from motorcade.ga.arrays import IntArray
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.calibration import make_camera, read_matrix, read_numbers
from motorcade.replays.io.readers.frames.files import ImageFrames, image_glob
from motorcade.replays.io.readers.frames.names import refuse_gaps
from motorcade.replays.io.recording import Recording
from motorcade.replays.io.trajectories import even_stamps
from motorcade.replays.io.transforms import transform
from motorcade.tracking.depth.cameras import DepthCamera

RATE_HZ = 30.0
_DEPTH = (585.0, 585.0, 320.0, 240.0)
_COLOUR = (525.0, 525.0, 320.0, 240.0)
_WIDTH = 640
"""Of the images that these hold for; of resized ones they are scaled."""
_COLOUR_T_DEPTH = Motor.from_translation([-0.026, 0.0, 0.0])
_PATTERN = "frame-*.color.*"


def recognise(root: Path) -> bool:
    """Whether the folder, or a `seq-01` in it, holds `frame-….color.…` images."""
    return root.is_dir() and bool(_sequences(root))


def read(root: Path, *, own_truth: bool = True) -> Recording:
    """Read one 7-Scenes sequence; of a scene, its only one.

    Raises:
        RecordingError: several sequences, a gap in the numbers, a pose or depth that is missing
            for some frames only, or whatever cannot be read.
    """
    sequences = _sequences(root)
    if len(sequences) != 1:
        names = ", ".join(folder.name for folder in sequences)
        raise refusal(root, f"expected one sequence, got {names}", advice="name one of them")
    folder = sequences[0]
    files = image_glob(folder, _PATTERN)
    refuse_gaps(files, "7-Scenes stamps are made from 30 Hz: copy the missing image again")
    time_ns = even_stamps(len(files), RATE_HZ)
    depth = _beside(files, ".depth.png")
    stated_files = [base / "camera-intrinsics.txt" for base in (folder, root)]
    size = ImageFrames(files, time_ns).first_size()
    scale = size[0] / _WIDTH
    colour, nominal = (tuple(scale * value for value in camera) for camera in (_COLOUR, _DEPTH))
    intrinsics = next((read_matrix(path) for path in stated_files if path.is_file()), nominal)
    camera = make_camera(folder, size, colour, "pinhole", ())
    sensor = DepthCamera(make_camera(folder, size, intrinsics, "pinhole", ()), _COLOUR_T_DEPTH)
    poses = _beside(files, ".pose.txt") if own_truth else ()
    return Recording(
        name=folder.resolve().name,
        root=root,
        layout="seven_scenes",
        frames=ImageFrames(files, time_ns, size, depth, depth_camera=sensor, colour_camera=camera),
        camera=camera,
        truth=_truth(poses, time_ns) if poses else None,
    )


def _sequences(root: Path) -> list[Path]:
    if any(root.glob(_PATTERN)):
        return [root]
    return sorted({path.parent for path in root.glob(f"seq-*/{_PATTERN}")})


def _beside(files: tuple[Path, ...], suffix: str) -> tuple[Path, ...]:
    """The files of the same frames with another ending: all of them, or none."""
    names = [path.with_name(path.name.partition(".")[0] + suffix) for path in files]
    present = [path.is_file() for path in names]
    if not any(present):
        return ()
    if not all(present):
        index = present.index(False)
        raise refusal(
            names[index], "the file is missing, but other frames have one", field=f"frame {index}"
        )
    return tuple(names)


def _truth(files: tuple[Path, ...], time_ns: IntArray) -> Trajectory:
    poses = [transform(read_numbers(path, (16,)), path, "world_T_camera") for path in files]
    return Trajectory(time_ns, Motor.stack(poses) @ _COLOUR_T_DEPTH.inverse())
