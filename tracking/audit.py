"""What an audit finds: whether what was told and what was measured agree, by how much, what to do.

A convention or a constant that came from elsewhere (extrinsics, focal lengths, sizes of tags, which
camera is the left one) is checked where it is used. Each check gives one value of this kind; a run
gathers them in its integrity, and shows them in `report.json`, on the page and in its last line.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from motorcade.tracking.cameras.camera import Camera

Verdict = Literal["consistent", "unknown", "doubtful", "contradicted"]
"""From best to worst; `unknown` where the recording cannot tell."""
_OFF_CENTRE, _LIKE, _CLEARLY = 0.5, 0.1, 2.0
"""Share of half an image that no lens's axis is off; share that lenses are off, or a factor of
sizes; and times that another hypothesis must be nearer."""
_ORDER: tuple[Verdict, ...] = ("consistent", "unknown", "doubtful", "contradicted")


@dataclass(frozen=True)
class AuditFinding:
    """One thing that was checked without a ground truth.

    Fields:
        name: what was checked, one or two words in snake_case: coverage, odometry_extrinsics.
        verdict: `consistent`; `doubtful` where it may be wrong or the result of little use;
            `contradicted` where measurements deny what was told; `unknown` where they say nothing.
        figure: what the verdict was made by; None where nothing could be computed.
        unit: of the figure: m, deg, px, share, …
        summary: what was found, in one clause with the figures behind it.
        advice: what mends it, in one clause; empty where there is nothing to do.

    Examples:
        >>> from motorcade.tracking.audit import AuditFinding
        >>> told = "T_body_odom is inverted: it fits by 119°, its inverse by 0.4°"
        >>> one = AuditFinding("odometry", "contradicted", 119.0, "deg", told, "give its inverse")
        >>> one.passed, one.sentence
        (False, 'T_body_odom is inverted: it fits by 119°, its inverse by 0.4°; give its inverse')
    """

    name: str
    verdict: Verdict
    figure: float | None
    unit: str
    summary: str
    advice: str = ""

    @property
    def passed(self) -> bool:
        """Whether nothing speaks against it."""
        return self.verdict in ("consistent", "unknown")

    @property
    def sentence(self) -> str:
        """What was found, and what to do."""
        return f"{self.summary}; {self.advice}" if self.advice and not self.passed else self.summary


DEPTH_ON_COLOUR_PX = 4.5
"""A structured-light sensor compares windows of 9 pixels: its edges are off by half of one."""


def scatter_px(camera: Camera, corner_px: float = 0.0) -> float:
    """Most that a corner is off where camera and print are as stated, pixels: fixed beforehand.

    Corner finders are right to a tenth of a pixel, prints and lens models to a thousandth of what
    they measure; a pixel of 640 is seen by nobody, and leaves room for both. Beside that stand
    three deviations of what noise, contrast and blur of these images let a corner scatter.

    Args:
        camera: whose images.
        corner_px: standard deviation of a corner in them, where it is known (`corner_noise_px`).
    """
    lens_px = max(camera.width, camera.height) / 640.0
    return float((lens_px**2 + (3.0 * corner_px) ** 2) ** 0.5)


def centre_finding(camera: Camera) -> AuditFinding | None:
    """Doubt a principal point far off the image's middle; None where it lies about there.

    Nearer off it is doubted where it is that of images turned by a quarter.

    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.audit import centre_finding
    >>> halved = Camera(640, 480, 1000.0, 1000.0, 640.0, 480.0)  # intrinsics of 1280 x 960
    >>> centre_finding(halved).advice.partition(';')[0]
    'divide fx, fy, cx and cy by 2: they look like those of images 2 times as large'
    """
    width, height = camera.width, camera.height
    ratios = (2.0 * camera.cx + 1.0) / width, (2.0 * camera.cy + 1.0) / height
    turned = (2.0 * camera.cx + 1.0) / height, (2.0 * camera.cy + 1.0) / width
    off, off_turned = (max(abs(ratio - 1.0) for ratio in pair) for pair in (ratios, turned))
    by_quarter = off > _CLEARLY * off_turned and off_turned <= _LIKE < off
    if off <= _OFF_CENTRE and not by_quarter:
        return None
    summary = (
        f"the camera's centre ({camera.cx:g}, {camera.cy:g}) lies far from the middle of images "
        f"of {width} x {height}"
    )
    factor = round(2.0 * sum(ratios) / 2.0) / 2.0
    advice = "state the intrinsics of these images, cx and cy in their pixels"
    if by_quarter:
        advice = (
            f"they are turned by a quarter from those of its calibration: say width = {height}, "
            f"height = {width}, rotation_deg = 90, or 270"
        )
    elif factor > 0.0 and all(abs(ratio / factor - 1.0) <= _LIKE for ratio in ratios):
        larger = f"{factor:g} times as large" if factor > 1.0 else f"{factor:g} times their size"
        whole = {key: getattr(camera, key) / factor for key in ("fx", "fy")}
        whole |= {key: (getattr(camera, key) + 0.5) / factor - 0.5 for key in ("cx", "cy")}
        advice = (
            f"divide fx, fy, cx and cy by {factor:g}: they look like those of images {larger}; "
            f"{said_camera(replace(camera, **whole), tuple(whole))}"
        )
    return AuditFinding("camera_centre", "doubtful", off, "share", summary, advice)


def said_camera(camera: Camera, keys: tuple[str, ...] = ()) -> str:
    """The keys of a manifest's `[camera]` that state a camera; all, or some."""
    keys = keys or ("model", "fx", "fy", "cx", "cy", "distortion")
    return "say " + ", ".join(f"{key} = {_value(getattr(camera, key))}" for key in keys)


def _value(value: str | float | tuple[float, ...]) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(f'{part:.4f}' for part in value)}]"
    return f'"{value}"' if isinstance(value, str) else f"{value:.2f}"


def worst(findings: Iterable[AuditFinding]) -> Verdict:
    """The verdict on all of them: of one that says nothing (`unknown`), only where all do.

    Examples:
        >>> from motorcade.tracking.audit import AuditFinding, worst
        >>> seen = AuditFinding("coverage", "consistent", 0.1, "share", "1 of 10 has no pose")
        >>> unseen = AuditFinding("inertial", "unknown", None, "", "the camera turns too little")
        >>> worst((seen, unseen))
        'consistent'
    """
    verdicts = {finding.verdict for finding in findings}
    known = verdicts - {"unknown"} or verdicts or {"unknown"}
    return max(known, key=_ORDER.index)
