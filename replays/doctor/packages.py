"""Optional packages: which are there, in which versions, what each enables, which extra brings it.

Nothing is imported: whether a package can be found is enough, and torch alone takes seconds.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

from motorcade.replays.doctor.findings import Finding

__all__ = ["OPTIONAL", "examine_packages"]

OPTIONAL: dict[str, dict[str, tuple[str, str]]] = {
    "pipeline": {
        "opencv-contrib-python-headless": ("cv2", "pictures, markers, boards, visual SLAM"),
        "pupil-apriltags": ("pupil_apriltags", "AprilTags that the first detector misses"),
        "gtsam": ("gtsam", "loops of visual SLAM, visual-inertial graphs"),
        "rosbags": ("rosbags", "recordings in ROS bags and MCAP, without ROS"),
        "scikit-image": ("skimage", "structural similarity, picture measures"),
        "scipy": ("scipy", "fits, statistics, comparisons of trajectories"),
        "pyrender": ("pyrender", "drawing characters into footage"),
        "av": ("av", "videos in and out"),
        "matplotlib": ("matplotlib", "plots of reports"),
        "Jinja2": ("jinja2", "report pages"),
        "PyYAML": ("yaml", "calibration files"),
        "pillow": ("PIL", "textures of characters"),
        "tqdm": ("tqdm", "progress bars"),
        "casadi": ("casadi", "symbolic code from scripts and kernels"),
        "moderngl": ("moderngl", "drawing characters fast, and skinning in shaders"),
    },
    "photometric": {
        "kornia": ("kornia", "markers refined on their whole print"),
        "torch": ("torch", "markers refined on their whole print; generated torch code"),
    },
    "viewer": {
        "rerun-sdk": ("rerun", "runs exported for the Rerun viewer"),
    },
    "scale": {
        "dask": ("dask", "sweeps on a cluster"),
        "distributed": ("distributed", "sweeps on a cluster"),
        "pyarrow": ("pyarrow", "sweep tables as Parquet"),
    },
}
"""Extra, distribution: the module it brings, and what that is for."""


def examine_packages() -> list[Finding]:
    """One finding a package."""
    return [
        _package(extra, distribution, module, enables)
        for extra, packages in OPTIONAL.items()
        for distribution, (module, enables) in packages.items()
    ]


def _package(extra: str, distribution: str, module: str, enables: str) -> Finding:
    remedy = f'pip install "motorcade[{extra}]"'
    try:
        found = version(distribution)
        works = find_spec(module) is not None
    except PackageNotFoundError:
        return Finding("packages", distribution, False, "not installed", enables, remedy)
    if not works:
        broken = f"{found} is recorded, but its module {module} is missing"
        again = f"pip install --force-reinstall {distribution}"
        return Finding("packages", distribution, False, broken, enables, again)
    return Finding("packages", distribution, True, found, enables)
