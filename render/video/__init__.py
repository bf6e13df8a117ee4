"""Videos in and out: H.264, lossless FFV1, pictures side by side, contact sheets."""

from motorcade.render.video.files import read_frames, write_video

__all__ = ["read_frames", "write_video"]
