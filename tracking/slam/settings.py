"""What can be chosen about visual SLAM; the defaults serve every recording."""

from __future__ import annotations

from dataclasses import dataclass, replace

from motorcade.tracking.checks import check_count, check_length

_USUAL_PIXELS = 640 * 480


@dataclass(frozen=True)
class SlamSettings:
    """How much is tracked and mapped.

    Fields:
        features: corners tracked in an image of 640 x 480 (more in a larger one), spread out.
        window: newest keyframes that each local adjustment moves.
        adjust: adjust the window at each keyframe, after a loop an older one beside it until the
            whole loop was, and the whole map at the end; off shows what that is worth.
        close_loops: recognise where the camera was before, and join maps; off shows its worth.
        cull_keyframes: drop keyframes whose points others see as well, where lengths are metres
            (one camera's unit would drift more); off shows its worth.
        new_maps: begin a new map, with a world of its own, where the camera stays lost; off leaves
            it lost until it is found.
        threads: map in a second thread, so that no frame waits for a keyframe to be worked in. What
            comes out then depends on how fast that goes; without, the same images give the same
            bytes.
        baseline_m: distance of the right camera of a rectified stereo pair; None without one.
        depth_sigma_px: noise of a depth, as disparity of a pair 8 cm apart (or of the stereo pair).

    Raises:
        ValueError: a count or length that is not above zero.

    >>> from motorcade.tracking import SlamSettings
    >>> SlamSettings(baseline_m=0.12).for_size(1280, 960).features  # as dense as in 640 x 480
    2000
    """

    features: int = 500
    window: int = 10
    adjust: bool = True
    close_loops: bool = True
    cull_keyframes: bool = True
    new_maps: bool = True
    threads: bool = False
    baseline_m: float | None = None
    depth_sigma_px: float = 0.5

    def __post_init__(self) -> None:
        check_count(self.features, "SlamSettings.features", 50)
        check_count(self.window, "SlamSettings.window", 3)
        check_length(self.depth_sigma_px, "SlamSettings.depth_sigma_px")
        if self.baseline_m is not None:
            check_length(self.baseline_m, "SlamSettings.baseline_m")

    def for_size(self, width: int, height: int) -> SlamSettings:
        """The same density of corners in larger images."""
        share = max(width * height / _USUAL_PIXELS, 1.0)
        return replace(self, features=round(self.features * share))
