"""Visual SLAM: one camera, a camera with depth, or a rectified pair; images to poses and map.

Sources: ORB-SLAM2 (Mur-Artal & Tardos 2017) for keyframes, adjustment and relocalisation;
VINS-Mono (Qin et al. 2018) for corners tracked between them.
"""

from __future__ import annotations

from motorcade.tracking.frame_history import SlamEvent, SlamHistory
from motorcade.tracking.slam.mapping.map import MapSnapshot
from motorcade.tracking.slam.results import SlamFrame, SlamResult
from motorcade.tracking.slam.settings import SlamSettings
from motorcade.tracking.slam.slam import VisualSlam

__all__ = [
    "MapSnapshot",
    "SlamEvent",
    "SlamFrame",
    "SlamHistory",
    "SlamResult",
    "SlamSettings",
    "VisualSlam",
]
