"""What the film shows: in how many frames the figure is in view, how large, and on what it stands.

Where it stands still and the camera is known, that follows from where its soles and its crown come
to lie in the picture; what hides it is not looked at here. Else the frames are counted that drawing
changed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorcade.replays.pipeline.report.findings import Findings
from motorcade.replays.stages.characters.acting import character_named

_STEPS = 21  # points of the figure's axis, soles and crown among them
_SHARES = {2: "half", 3: "a third", 4: "a quarter", 5: "a fifth"}
_WHOLE = 0.8


@dataclass(frozen=True)
class FilmView:
    """The film in figures.

    Fields:
        frames: how many the film has.
        in_view: how many of them show something of the figure.
        height_px: how long it is in the picture from its soles to its crown, as far as the picture
            shows it, in the median over these; None where it moves.
        height_share: the same as a share of the picture's height.
        stands_on: what it stands on, in words.
    """

    frames: int
    in_view: int
    height_px: float | None
    height_share: float | None
    stands_on: str

    @property
    def sentence(self) -> str:
        """What somebody who opens the film will see.

        >>> from motorcade.replays.pipeline.report.film import FilmView
        >>> FilmView(180, 172, 216.0, 0.2, "the board").sentence
        'the figure stands on the board, in view in 172 of 180 frames, a fifth of the picture high'
        """
        text = f"the figure stands on {self.stands_on}, in view in {self._counted}"
        if self.height_share is None or not self.in_view:
            return text
        return f"{text}, {self._size} high"

    @property
    def _counted(self) -> str:
        if self.in_view in (0, self.frames):
            return f"{'none' if not self.in_view else 'all'} of {self.frames} frames"
        return f"{self.in_view} of {self.frames} frames"

    @property
    def _size(self) -> str:
        share = float(self.height_share or 0.0)
        if share > _WHOLE:
            return "as the picture is" if share <= 1.0 else "more than the picture is"
        near = round(1.0 / max(share, 1e-6))
        name = _SHARES.get(near)
        return f"{name} of the picture" if name else f"{100.0 * share:.0f} % of the picture"


def film_of(findings: Findings) -> FilmView | None:
    """What the film of a run shows; None where there is none."""
    film, placed = findings.overlay, findings.placed
    if film is None:
        return None
    camera = findings.camera_poses.camera or findings.recording.camera
    if camera is not None and film.footage != "original":
        camera = camera.undistorted()
    moves = len(placed.path_m) or placed.parts or placed.ground_motion is not None
    if moves or camera is None:
        return FilmView(film.frames, film.frames_with_character, None, None, film.stands_on)
    who = character_named(placed.character, placed.up, placed.front)
    axis = np.linspace([0.0, 0.0, 0.0], [0.0, 0.0, who.height_m], _STEPS)
    path = findings.integrity.drawn
    stamps = findings.recording.frames.time_ns
    posed = stamps[(stamps >= path.time_ns[0]) & (stamps <= path.time_ns[-1])]
    in_camera = path.motors_at(posed).inverse()[:, None].apply(placed.placement.apply(axis))
    px = camera.project(in_camera, allow_nan=True)
    with np.errstate(invalid="ignore"):
        inside = np.all((px > -0.5) & (px < np.array([camera.width, camera.height]) - 0.5), axis=-1)
    shown = inside.any(axis=-1)
    in_view = min(int(shown.sum()), film.frames_with_character)
    if not in_view:
        return FilmView(film.frames, 0, None, None, film.stands_on)
    first, last = inside.argmax(axis=-1), _STEPS - 1 - inside[:, ::-1].argmax(axis=-1)
    rows = np.flatnonzero(shown)
    lengths = np.linalg.norm(px[rows, last[rows]] - px[rows, first[rows]], axis=-1)
    height_px = float(np.median(lengths))
    return FilmView(film.frames, in_view, height_px, height_px / camera.height, film.stands_on)
