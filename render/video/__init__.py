"""Videos in and out: H.264, lossless FFV1, numbered pictures, contact sheets."""

from motorcade.render.video.files import read_frames, write_video
from motorcade.render.video.sheets import contact_sheet, write_pictures

__all__ = [
    "contact_sheet",
    "read_frames",
    "write_pictures",
    "write_video",
]
