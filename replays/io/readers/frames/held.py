"""A camera that was calibrated for some axes, brought together with images shown upright.

Images come upright. A calibration may have been made from images shown upright too, or from the
sensor's own axes; its width and height tell which, unless the image is square or stands on its
head. `rotation_deg` says it outright: by how many degrees clockwise the stored images were turned
to those that the camera was calibrated with (0: as stored).
"""

from __future__ import annotations

from dataclasses import dataclass

from motorcade.tracking.cameras.camera import Camera, ImageOrientation, turned_camera

ROTATIONS_DEG = (0, 90, 180, 270)
_TAKEN_AS_SHOWN = (
    "the images are turned to be shown, and the camera's size does not tell whether it was "
    "calibrated before that: it is taken to be of the images as shown; if it is of the images "
    "as stored, say rotation_deg = 0 in [camera]"
)


@dataclass(frozen=True)
class UprightCamera:
    """The camera of upright images.

    Fields:
        camera: with the images' size.
        quarter_turns: by so many, clockwise, the stated camera was turned.
        said: what was taken for granted or done, for people; empty where nothing was.
    """

    camera: Camera
    quarter_turns: int = 0
    said: str = ""


def upright_camera(
    stated: Camera,
    rotation_deg: int | None,
    stored_size: tuple[int, int],
    orientation: ImageOrientation,
) -> UprightCamera:
    """Turn a camera with the images, exactly, where it was not made for upright ones.

    Args:
        stated: as its calibration has it.
        rotation_deg: the axes that it is stated in, of `ROTATIONS_DEG`; None: its size tells.
        stored_size: width and height of the images as stored.
        orientation: how they are shown.

    Raises:
        ValueError: a size that the images have in no orientation, a rotation that contradicts it,
            or mirrored images with a camera for their mirror images.

    >>> from motorcade.tracking import Camera
    >>> from motorcade.tracking.cameras.camera import ImageOrientation
    >>> sensor = Camera(1920, 1080, 1500.0, 1500.0, 950.0, 540.0)
    >>> upright_camera(sensor, None, (1920, 1080), ImageOrientation(1)).camera.cy
    950.0
    """
    size, shown_size = (stated.width, stated.height), orientation.size(stored_size)
    if rotation_deg is not None:
        turns = _turns_from(size, rotation_deg, stored_size, orientation)
    elif size not in (shown_size, stored_size):
        raise ValueError(another_size(size, shown_size))
    elif size != shown_size:
        turns = orientation.quarter_turns
    else:
        turns = 0
    if turns and orientation.mirrored:
        raise ValueError(
            "expected a camera of the images as shown, since they are stored mirrored, got one "
            "of the images as stored; calibrate with images that are shown as these"
        )
    if turns:
        said = f"the camera is turned clockwise by {90 * turns} degrees, as the images are"
        return UprightCamera(turned_camera(stated, turns), turns, said)
    known = rotation_deg is not None or size != stored_size or not orientation.quarter_turns
    said = "" if known or turned_camera(stated, 2) == stated else _TAKEN_AS_SHOWN
    return UprightCamera(stated, 0, said)


def _turns_from(
    size: tuple[int, int],
    rotation_deg: int,
    stored_size: tuple[int, int],
    orientation: ImageOrientation,
) -> int:
    expected = ImageOrientation(rotation_deg // 90).size(stored_size)
    if size != expected:
        raise ValueError(
            f"expected width and height {expected[0]} x {expected[1]} with rotation_deg = "
            f"{rotation_deg}, as the images are stored {stored_size[0]} x {stored_size[1]}, got "
            f"{size[0]} x {size[1]}; leave rotation_deg out for a camera of the images as shown"
        )
    return (orientation.quarter_turns - rotation_deg // 90) % 4


def another_size(camera: tuple[int, int], images: tuple[int, int]) -> str:
    """Why a camera does not fit images, and what to do."""
    problem = (
        f"expected {camera[0]} x {camera[1]} pixels as the camera has, got "
        f"{images[0]} x {images[1]}"
    )
    return f"{problem}; {size_advice(camera, images)}"


def size_advice(camera: tuple[int, int], images: tuple[int, int]) -> str:
    """What to do about a camera of another size than the images'."""
    if camera == images[::-1]:
        return (
            "the camera was held the other way when it was calibrated: calibrate it held as here, "
            "or say in [camera] by how many degrees clockwise its images were turned from the "
            "sensor's axes, such as rotation_deg = 90 for a phone held upright"
        )
    return (
        f"a camera holds for one size of image: calibrate with images of {images[0]} x {images[1]}"
    )
