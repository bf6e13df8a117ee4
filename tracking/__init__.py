"""Cameras, printed boards and markers, and visual SLAM: images in, pose measurements out.

Conventions:

* **Frames.** A pose is named by what it maps: ``world_T_camera`` takes camera coordinates to the
  world's. Cameras have OpenCV's axes (x right, y down, z forward). A board's or marker's frame has
  its origin at its first corner, x to the right and y up as printed, z out of the printed face.
  Where one board or map is tracked, its frame is the world.
* **Pixels.** Pixel (0, 0) is the centre of the top-left pixel. Marker corners run clockwise from
  the printed top-left one.
* **Units.** Metres, radians, integer nanoseconds. SLAM with one camera alone has a free scale.
* **Covariances.** ``(6, 6)``, rotation (rad) then translation (m), of ``pose.retract(error)``.

Needs OpenCV. Names are imported when they are first used.

Draw a marker, look at it straight on from 0.6 m, and find it again:

>>> import cv2, numpy as np
>>> from motorcade.tracking import Camera, SingleMarker, detect_markers, pose_marker
>>> camera = Camera(width=640, height=480, fx=500.0, fy=500.0, cx=319.5, cy=239.5)
>>> drawing, origin_px = SingleMarker("tag36h11", 7, side_m=0.12).draw(pixels_per_m=1000.0)
>>> image = np.full((480, 640), 255, np.uint8)
>>> small = cv2.resize(drawing, None, fx=0.8, fy=0.8, interpolation=cv2.INTER_AREA)
>>> image[100 : 100 + len(small), 200 : 200 + small.shape[1]] = small
>>> [found] = detect_markers(image, "tag36h11", camera)
>>> found.marker_id
7
>>> marker = pose_marker(found, camera, side_m=0.12)
>>> np.round(marker.camera_T_marker[0].translation_m[2], 1)  # 500 px * 0.12 m / 96 px
np.float64(0.6)

Sub-packages: `boards`, `depth`, `markers` (`markers.disambiguate`, `markers.mapping`,
`markers.photometric`), `planes`, `slam`, `targets`.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
