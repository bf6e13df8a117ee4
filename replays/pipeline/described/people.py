"""Stage `people`: masks of the people in a recording that brings none, before it is tracked."""

from __future__ import annotations

import hashlib
import logging
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
from scipy.special import expit

from motorcade.ga.arrays import FloatArray
from motorcade.ga.files import read_bounded
from motorcade.ga.progress import track
from motorcade.replays.engine.artifacts import new_file
from motorcade.replays.engine.graph import Graph
from motorcade.replays.io.files import refusal
from motorcade.replays.io.readers.frames.files import ImageFrames, MaskFiles
from motorcade.replays.io.recording import DecodedFrames, FrameSequence, Recording, with_masks
from motorcade.tracking.checks import GrayImage as Image
from motorcade.tracking.people import LEAST_SCORE, SeenPerson, find_people

log = logging.getLogger("motorcade.graph")

_NETS = ("pose_detection/pose_detection.tflite", "pose_landmark/pose_landmark_full.tflite")
_NET_LIMIT = 1 << 26
_LOOK_PX, _BODY_PX, _GRIDS = 224, 256, ((28, 2), (14, 2), (7, 6))
"""Anchors side by side, and how many at each place; of each it tells a box, hips and reach."""
_EACH, _SEEN = 8, 0.1
"""Of every so many images with people corners are counted; the share that masks must leave."""


def weights_folder() -> Path | None:
    """Where the nets of the wheel mediapipe lie, which is not imported; None where none can run."""
    wheel = find_spec("mediapipe") if find_spec("ai_edge_litert") else None
    folder = Path(wheel.origin).parent / "modules" if wheel and wheel.origin else None
    return folder if folder and all((folder / name).is_file() for name in _NETS) else None


class BlazePose:
    """The nets in a folder, on one thread."""

    def __init__(self, folder: Path) -> None:
        from ai_edge_litert.interpreter import Interpreter, OpResolverType

        content = [read_bounded(folder / name, _NET_LIMIT) for name in _NETS]
        quiet = OpResolverType.BUILTIN_WITHOUT_DEFAULT_DELEGATES  # the faster ones write to stderr
        self._nets = [Interpreter(None, net, None, 1, quiet) for net in content]
        anchors = [
            np.repeat(np.indices((k, k))[::-1].reshape(2, -1).T + 0.5, each, axis=0) / k
            for k, each in _GRIDS
        ]
        self._anchors_px = _LOOK_PX * np.concatenate(anchors)

    def detect(self, image: Image) -> list[tuple[float, FloatArray]]:
        """As `find_people` wants it, in the whole image and three squares of its shorter side."""
        (height, width), count = image.shape[:2], len(self._anchors_px)
        short, long = sorted((height, width))
        bodies: list[tuple[float, FloatArray]] = []
        for share, side in ((0.5, long), (0.0, short), (0.5, short), (1.0, short)):
            x, y, scale = share * (width - side), share * (height - side), _LOOK_PX / side
            part = np.array([[scale, 0.0, -scale * x], [0.0, scale, -scale * y]])
            shown = cv2.warpAffine(image, part, (_LOOK_PX, _LOOK_PX), flags=cv2.INTER_AREA)
            outputs = self._run(0, shown / 127.5 - 1.0)
            scores = expit(outputs[count])
            points = outputs[12 * count].reshape(-1, 6, 2)[:, 2:4] + self._anchors_px[:, None]
            points = points / scale + [x, y]
            for k in np.argsort(-scores)[: np.count_nonzero(scores >= LEAST_SCORE)]:
                near = 0.5 * np.hypot(*(points[k, 1] - points[k, 0]))
                if all(np.hypot(*(points[k, 0] - body[0])) > near for _, body in bodies):
                    bodies.append((float(scores[k]), points[k]))
        return bodies

    def segment(self, image: Image, body_px: FloatArray) -> SeenPerson:
        """As `find_people` wants it."""
        right, down = body_px[1] - body_px[0]
        scale = _BODY_PX / max(2.5 * (right**2 + down**2), 1.0)
        turn = scale * np.array([[-down, right], [-right, -down]])
        shown = np.column_stack([turn, 0.5 * _BODY_PX - turn @ body_px[0]])
        outputs = self._run(1, cv2.warpAffine(image, shown, (_BODY_PX, _BODY_PX)) / 255.0)
        inside = np.rint(255.0 * expit(outputs[_BODY_PX**2])).astype(np.uint8)
        back = cv2.invertAffineTransform(shown)
        mask = cv2.warpAffine(inside.reshape(_BODY_PX, _BODY_PX), back, image.shape[1::-1])
        points = outputs[195].reshape(39, 5)[33:35, :2] @ back[:, :2].T + back[:, 2]
        return SeenPerson(float(outputs[1][0]), np.asarray(mask), points)

    def _run(self, which: int, image: FloatArray) -> dict[int, FloatArray]:
        """What a net gives, flat, each by how many numbers it is."""
        net = self._nets[which]
        net.allocate_tensors()
        net.set_tensor(net.get_input_details()[0]["index"], image[None].astype(np.float32))
        net.invoke()
        outputs = [net.get_tensor(output["index"]) for output in net.get_output_details()]
        return {output.size: output.reshape(-1).astype(np.float64) for output in outputs}


@dataclass(frozen=True, eq=False)
class SeenImages:
    """Images in which to look for people, by nets in a folder."""

    frames: FrameSequence
    weights: Path

    def digest(self) -> str:
        """SHA-256 of images and stamps; that of the nets is on the record of files."""
        digest = hashlib.sha256(self.frames.time_ns.tobytes())
        for block in self.frames.content():
            digest.update(block)
        return digest.hexdigest()


def people(images: SeenImages) -> MaskFiles:
    """Masks of people in images; none where they would hide nearly all that can be tracked."""
    nets, frames = BlazePose(images.weights), images.frames
    size = frames[0].image().shape[1::-1]
    shown = (frame.image() for frame in track(frames, "looking for people", len(frames)))
    files, left = dict[int, Path](), list[float]()
    for row, small in enumerate(find_people(shown, nets.detect, nets.segment)):
        if small is not None:
            mask, files[row] = cv2.resize(small, size), new_file("mask.png")
            files[row].write_bytes(cv2.imencode(".png", mask)[1].tobytes())
            if len(files) % _EACH == 1:
                corners = cv2.goodFeaturesToTrack(frames[row].gray(), 200, 0.01, 5)
                if corners is not None:
                    columns, rows = corners.reshape(-1, 2).T.astype(int)
                    left.append(float(np.mean(mask[rows, columns] < 128)))
    if left and np.median(left) < _SEEN:
        log.warning("people: left in, as masks of them would hide nearly all that can be tracked")
        files.clear()
    return MaskFiles(tuple(files.values()), frames.time_ns[list(files)], size)


def with_people(recording: Recording, cache: Path) -> Recording:
    """A recording, checked, with masks of the people in it, where nets are here and it has none.

    Raises RecordingError: people are asked for, and the nets are not here.
    """
    frames: FrameSequence = getattr(recording.frames, "taken", recording.frames)
    weights = weights_folder()
    bare = isinstance(frames, ImageFrames | DecodedFrames) and recording.masks is None
    if not bare or recording.people == "none" or (weights is None and recording.people == "auto"):
        return recording
    if weights is None:
        advice = "`motorcade doctor` says how to install them"
        raise refusal(recording.root, "no nets that find people", field="masks", advice=advice)
    graph, images = Graph([people], {"images": SeenImages}), SeenImages(frames, weights)
    masks: MaskFiles = graph.run("people", {"images": images}, cache, {}).outputs["people"]
    if not masks.files:
        return recording
    said = f"people in {len(masks.files)} of {len(frames)} frames hide the figure, untracked"
    log.info('%s; [frames] masks = "none" leaves them in', said)
    return replace(recording, frames=with_masks(recording.frames, masks), people=said)
