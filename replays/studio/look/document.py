"""The look of a run: all that a page shows of it but the pictures of its film."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motorcade.ga.arrays import IntArray
from motorcade.render import Performer
from motorcade.replays.characters.performers import performers
from motorcade.replays.readers.frames.corners import CornerFrames
from motorcade.replays.recording import Recording
from motorcade.replays.report.findings import Findings, map_unit
from motorcade.replays.stages.camera.as_found import as_found
from motorcade.replays.stages.view.ground import prints_of
from motorcade.replays.studio.film import film_rate_hz
from motorcade.replays.studio.look.figures import shown_character
from motorcade.replays.studio.look.hiding import shown_hiding
from motorcade.replays.studio.look.packing import packed
from motorcade.replays.studio.look.paths import drawn_name, drawn_rows, shown_paths
from motorcade.replays.studio.look.plots import shown_plots, shown_states
from motorcade.replays.studio.look.surroundings import (
    shown_boards,
    shown_markers,
    shown_plane,
    shown_points,
)
from motorcade.tracking import Camera, MarkerMap

FORMAT, VERSION = "motorcade-look", 1


@dataclass(frozen=True)
class LookedAt:
    """What a look is made of: a run's findings, and the map of markers where it has one.

    `headline` says in a line what was measured and made.
    """

    findings: Findings
    marker_map: MarkerMap | None
    headline: str

    @property
    def recording(self) -> Recording:
        """The recording, with the camera as the run found it."""
        poses = self.findings.camera_poses
        return as_found(self.findings.recording, poses.camera, poses.depth_camera)

    @property
    def has_pictures(self) -> bool:
        """Whether there is footage, and not corners alone."""
        return not isinstance(self.recording.frames, CornerFrames)


def look_of(run: LookedAt, clips: list[dict[str, str]]) -> dict[str, Any]:
    """The document of a run, ready for JSON.

    Args:
        run: what is shown.
        clips: name ("overlay", "footage") and address of each film.

    Raises:
        ValueError: a recording without a camera.
    """
    findings, recording = run.findings, run.recording
    if recording.camera is None:
        raise ValueError(f"{recording.name}: no camera known; describe it in a manifest")
    stamps = recording.frames.time_ns
    start_ns = int(stamps[0])
    performing = performers(findings.placed, 1e-9 * float(np.ptp(stamps)))
    figures = _figures(findings, performing, stamps)
    height_m = max(one["height_m"] for one in figures)
    placed = findings.placed
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": recording.name,
        "headline": run.headline,
        "unit": map_unit(findings),
        "up": placed.placement.up.tolist(),
        "film": {
            "width": recording.camera.width,
            "height": recording.camera.height,
            "rate_hz": film_rate_hz(stamps),
            "time_s": packed((stamps - start_ns) * 1e-9, "f64"),
            "clips": clips,
        },
        "camera": shown_camera(recording.camera),
        "drawn": drawn_name(findings),
        "paths": shown_paths(findings, stamps),
        "boards": shown_boards(recording, findings.camera_poses),
        "markers": shown_markers(run.marker_map),
        "planes": [shown_plane(placed, height_m)],
        "points_m": shown_points(findings.camera_poses),
        "characters": figures,
        "hiding": shown_hiding(
            recording,
            performing,
            prints_of(recording, findings.camera_poses, run.marker_map),
            drawn_rows(findings, stamps),
        ),
        "plots": shown_plots(findings, start_ns),
        "states": shown_states(findings, start_ns),
    }


def shown_camera(camera: Camera) -> dict[str, Any]:
    """A camera for `camera.js`."""
    names = ("width", "height", "fx", "fy", "cx", "cy", "model")
    about = {name: getattr(camera, name) for name in names}
    return about | {"coefficients": list(camera.distortion)}


def _figures(
    findings: Findings, performing: list[Performer], time_ns: IntArray
) -> list[dict[str, Any]]:
    names = [part.name for part in findings.placed.parts] or ["character"]
    return [
        shown_character(name, one, time_ns) for name, one in zip(names, performing, strict=True)
    ]
