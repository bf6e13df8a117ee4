"""The augmented view in figures: against rendered truth, on a real board, and its time.

The synthetic room needs OpenGL only; the board and the time need the recording `vamr_board`, and
are left out where it is absent.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from motorcade.ga import Trajectory
from motorcade.render import Lighting
from tests.bench.data import data_folder
from tests.bench.view import ground_truth as truth
from tests.bench.view.film import bench_film, film_lines
from tests.bench.view.registration import bench_registration, registration_lines

__all__ = ["bench_view", "view_table"]


def bench_view() -> dict[str, Any]:
    """Measure everything. Returns a JSON-ready tree.

    Raises:
        RenderUnavailable: this machine has no OpenGL.
    """
    found: dict[str, Any] = {"ground_truth": _ground_truth()}
    if (data_folder() / "replays" / "vamr_board").is_dir():
        found |= {"registration": bench_registration(), "film": bench_film()}
    return found


def view_table(found: Mapping[str, Any]) -> str:
    """A line a figure."""
    room = found["ground_truth"]
    lines = ["a character set into a room's images, against the room rendered with it"]
    for name, rows in room["by"].items():
        worst = max(row["mean_of_255"] for row in rows), min(row["similarity"] for row in rows)
        least = min(row["overlap"] for row in rows)
        lines.append(
            f"  {name:<30}{worst[0]:.2f} of 255, SSIM {worst[1]:.3f}, silhouettes overlap "
            f"{least:.4f} (worst of {len(rows)} frames)"
        )
    lines.append(f"  main direction of the light found {room['light_off_deg']:.1f}° off")
    if "registration" in found:
        lines.append("a board drawn on the real one, vamr_board")
        lines += registration_lines(found["registration"])
    if "film" in found:
        lines += film_lines(found["film"])
    return "\n".join(lines)


def _ground_truth() -> dict[str, Any]:
    shots = truth.take_shots()
    light = truth.found_light(shots)
    by = {
        "true pose and light": (shots.poses, truth.true_light()),
        "tracked pose, estimated light": (
            truth.tracked_path(shots),
            truth.found_lighting(shots, light),
        ),
    }
    rows = {}
    for name, (poses, lighting) in by.items():
        rows[name] = _compared(shots, poses, lighting)
    off = np.arccos(np.clip(light.towards_light @ truth.room_light(), -1.0, 1.0))
    return {"by": rows, "light_off_deg": float(np.rad2deg(off))}


def _compared(shots: truth.Shots, poses: Trajectory, lighting: Lighting) -> list[dict[str, float]]:
    """A row a frame."""
    rows = []
    made, drawn = truth.set_into(shots, poses, lighting), truth.drawn_silhouettes(shots, poses)
    for k, image in enumerate(made):
        found = truth.alike(shots.direct[k], image, shots.empty[k])
        rows.append(
            {
                "mean_of_255": found.mean_of_255,
                "similarity": found.similarity,
                "overlap": truth.overlap(shots.silhouette[k], drawn[k]),
            }
        )
    return rows
