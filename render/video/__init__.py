"""Videos in and out: H.264, lossless FFV1, numbered pictures, contact sheets, side by side."""

from motorcade.render.video.files import read_frames, write_video
from motorcade.render.video.sheets import contact_sheet, write_pictures
from motorcade.render.video.side_by_side import ErrorTraces, beside

__all__ = [
    "ErrorTraces",
    "beside",
    "contact_sheet",
    "read_frames",
    "write_pictures",
    "write_video",
]
