"""What a GoPro says of itself in a video: its model, its view, its telemetry (GPMF) as one stream.

Cameras note it in the user data of the film (``moov/udta``): ``FIRM`` is the firmware, whose first
letters name the model, ``GPMF`` holds settings since the HERO6. Its entries are a key, type, size
and repeat, then big-endian values, padded to 4 bytes; type 0 nests. Sources: gpmf-parser's README
(the order of the IMU's columns by model, SROT); telemetry-parser (where MINF and SROT stand);
exiftool's tables of GoPro tags (MINF, VFOV, ZFOV).

The metadata track holds a packet about every second (`gopro.items`). Only ACCL and GYRO are taken,
of the first device that has both.

Both sensors run at steady rates of their own and are stamped by packet only. Their stamps come
from a line through the packets' stamps over the count of samples before; where that line is more
than 20 ms off somewhere, samples were lost, and each packet's are spread over the packet alone. The
gyroscope's stamps are kept where the rates differ, and the force is interpolated to them.

Axes: columns are turned to x, y, z here. Their order and signs stand in ORIN since the HERO8, and
follow from the model before (`gopro.MODELS`). How the camera sits on them is for a manifest's
`imu_T_camera` to say.

Android's (CAMM: developers.google.com/streetview/publish/camm-spec) has a packet a sample, of type
2 (rad/s) or 3 (m/s²), in the camera's axes, which are turned to those of a GoPro's IMU.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from av.error import FFmpegError

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import LONGEST_READOUT_S
from motorcade.render.video import MAX_FILE_BYTES, open_video
from motorcade.replays.io.files import open_bounded, refusal, refused, refusing
from motorcade.replays.io.imu import join_sensors

# First letters of the firmware: model, and the order of its IMU's columns where no ORIN tells it.
MODELS = {
    "HD5": ("HERO5", "ZXY"),
    "HD6": ("HERO6", "YxZ"),
    "HD7": ("HERO7", "YxZ"),
    "FS1": ("Fusion", "yXZ"),
    "HD8": ("HERO8", None),
    "HD9": ("HERO9", None),
    "H21": ("HERO10", None),
    "H22": ("HERO11", None),
    "H23": ("HERO12", None),
    "H24": ("HERO13", None),
}
DEFAULT_ORDER = "ZXY"
_MOST_HEADER = 2**26


@dataclass(frozen=True)
class GoProCamera:
    """A GoPro by its own words; None where it says nothing.

    Fields:
        model: as people call it.
        order: of the IMU's columns where their stream does not say it; a small letter is the
            opposite of an axis.
        diagonal_fov_deg: how wide the images see from corner to corner.
        linear: whether the camera took the lens's distortion out itself.
        readout_s: from the first row of an image to the last.
    """

    model: str | None = None
    order: str = DEFAULT_ORDER
    diagonal_fov_deg: float | None = None
    linear: bool | None = None
    readout_s: float | None = None


def gopro_camera(path: Path) -> GoProCamera | None:
    """What a video says of the GoPro that took it; None where it was none.

    Damaged notes count as none: poses do not hang on them.
    """
    firmware, settings = "", {}
    for kind, body in _user_data(path):
        if kind == b"FIRM":
            firmware = body.split(b"\0")[0].decode("ascii", "replace")
        elif kind == b"GPMF":
            settings = _settings(body, path)
    named = MODELS.get(firmware[:3])
    model = _text(settings.get(b"MINF")) or (None if named is None else named[0])
    if model is None:
        return None
    order = DEFAULT_ORDER if named is None else named[1] or DEFAULT_ORDER
    view = _text(settings.get(b"VFOV"))
    readout_ms = _number(settings.get(b"SROT"))
    known = readout_ms is not None and 0.0 < readout_ms <= 1e3 * LONGEST_READOUT_S
    fov = _number(settings.get(b"ZFOV"))
    return GoProCamera(
        model,
        order,
        fov if fov is not None and 10.0 < fov < 180.0 else None,
        None if not view else view == "L",
        1e-3 * readout_ms if known and readout_ms is not None else None,
    )


def _settings(body: bytes, path: Path) -> dict[bytes, bytes | float | None]:
    """Values of the entries of all devices: text as bytes, numbers as their first."""
    settings: dict[bytes, bytes | float | None] = {}
    try:
        for device in items(body, path):
            for item in items(device.body, path) if not device.kind else ():
                if item.kind == "c":
                    settings[item.key] = item.body.split(b"\0")[0]
                elif item.kind and item.kind not in "?UFG":
                    settings[item.key] = float(numbers(item, path).ravel()[0])
    except (ValueError, IndexError):
        return settings
    return settings


def _text(value: bytes | float | None) -> str | None:
    return value.decode("ascii", "replace") if isinstance(value, bytes) else None


def _number(value: bytes | float | None) -> float | None:
    return value if isinstance(value, float) and np.isfinite(value) else None


def _user_data(path: Path) -> Iterator[tuple[bytes, bytes]]:
    """Boxes of ``moov/udta`` of an MP4 or MOV file (ISO 14496-12)."""
    if not path.is_file():
        return
    with open_bounded(path, MAX_FILE_BYTES) as file:
        at, end = 0, path.stat().st_size
        while at + 8 <= end:
            file.seek(at)
            header = file.read(16)
            size, kind = struct.unpack_from(">I4s", header)
            if size == 1 and len(header) == 16:
                (size,) = struct.unpack_from(">Q", header, 8)
            if at == 0 and kind != b"ftyp":
                return
            if kind == b"moov" and 8 < size <= _MOST_HEADER:
                file.seek(at + 8)
                for inner, body in _boxes(file.read(size - 8)):
                    if inner == b"udta":
                        yield from _boxes(body)
                return
            if size < 8:
                return
            at += size


def _boxes(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    while at + 8 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if size < 8 or at + size > len(data):
            return
        yield kind, data[at + 8 : at + size]
        at += size


_TYPES = {"s": ">i2", "S": ">u2", "l": ">i4", "L": ">u4", "f": ">f4", "d": ">f8", "b": "i1"}


@dataclass(frozen=True)
class Item:
    """One entry: its key, its type as a letter ("" nests), the size of a sample, its bytes."""

    key: bytes
    kind: str
    size: int
    body: bytes


def items(data: bytes, path: Path) -> Iterator[Item]:
    """Take a run of entries apart.

    Raises:
        RecordingError: an entry that does not end inside `data`.
    """
    at = 0
    while at + 8 <= len(data):
        key, kind, size, repeat = struct.unpack_from(">4sBBH", data, at)
        if key == b"\0\0\0\0":
            return  # padding at the end
        end = at + 8 + size * repeat
        if end > len(data):
            problem = f"expected {size * repeat} bytes of {key!r}, got {len(data) - at - 8}"
            raise refusal(path, problem, field="telemetry")
        yield Item(key, "" if kind == 0 else chr(kind), size, data[at + 8 : end])
        at = end + -(size * repeat) % 4


def numbers(item: Item, path: Path) -> FloatArray:
    """Values ``(samples, values a sample)``."""
    kind = np.dtype(_TYPES[item.kind]) if item.kind in _TYPES else None
    if kind is None or item.size == 0 or item.size % kind.itemsize:
        problem = f"expected numbers, got type {item.kind!r} of {item.size} bytes"
        raise refusal(path, problem, field=f"telemetry {item.key!r}")
    values = np.frombuffer(item.body, kind).astype(np.float64)
    return values.reshape(-1, item.size // kind.itemsize)


_LOG = logging.getLogger("motorcade.replays")

_MOST_PACKETS = 2_000_000
_MOST_BYTES = 2**28
_DEEPEST = 8
_WORST_FIT_S = 0.02


@dataclass(frozen=True)
class _Packet:
    """Samples ``(N, 3)`` in SI units that a packet holds, and the seconds that it covers."""

    start_s: float
    duration_s: float
    values: FloatArray


def read_telemetry(path: Path) -> ImuStream | None:
    """Read the IMU of a video's telemetry; None where it has none.

    Raises:
        RecordingError: telemetry that is damaged, in unknown units or types, or beyond bounds.
    """
    gathered: dict[bytes, list[_Packet]] = {b"ACCL": [], b"GYRO": []}
    camm: dict[bytes, list[tuple[float, bytes]]] = {_CAMM_GYRO: [], _CAMM_FORCE: []}
    camera = gopro_camera(path)
    order = DEFAULT_ORDER if camera is None else camera.order
    for start_s, duration_s, data in _packets(path):
        if data[:4] in camm:
            camm[data[:4]].append((start_s, data[4:]))
            continue
        for key, values in _sensors(data, path, order).items():
            gathered[key].append(_Packet(start_s, duration_s, values))
    if all(camm.values()):
        sensors = [_of_camm(samples, path) for samples in camm.values()]
    elif all(gathered.values()):
        sensors = [_joined(gathered[key], path) for key in (b"GYRO", b"ACCL")]
    else:
        return None
    with refusing(path, "telemetry"):
        return join_sensors(*sensors[0], *sensors[1])


_CAMM_GYRO, _CAMM_FORCE = b"\0\0\2\0", b"\0\0\3\0"


def _of_camm(samples: list[tuple[float, bytes]], path: Path) -> tuple[IntArray, FloatArray]:
    """Of stamps that are equal the first is kept."""
    stamps_ns = np.clip([1e9 * start_s for start_s, _ in samples], -(2.0**62), 2.0**62)
    values = np.frombuffer(b"".join(body for _, body in samples), "<f4").reshape(-1, 3)
    time_ns, rows = np.unique(np.rint(stamps_ns).astype(np.int64), return_index=True)
    return time_ns, _turned(values[rows].astype(np.float64), "xzy", path)


def _packets(path: Path) -> Iterator[tuple[float, float, bytes]]:
    """Start, duration (s) and bytes of the packets of the telemetry track."""
    size = 0
    try:
        with refused(), open_video(path) as container:
            tracks = [entry for entry in container.streams if entry.type == "data"]
            for count, packet in enumerate(container.demux(tracks) if tracks else ()):
                data = bytes(packet)
                is_camm = len(data) == 16 and data[:4] in (_CAMM_GYRO, _CAMM_FORCE)
                if packet.pts is None or not (
                    packet.time_base and (is_camm or data[:4] == b"DEVC")
                ):
                    continue
                size += len(data)
                if count >= _MOST_PACKETS or size > _MOST_BYTES:
                    problem = f"expected at most {_MOST_PACKETS} packets of {_MOST_BYTES} bytes"
                    raise refusal(path, f"{problem} in all, got more", field="telemetry")
                base: Fraction = packet.time_base
                yield float(packet.pts * base), float((packet.duration or 0) * base), data
    except FFmpegError as fault:
        raise refusal(path, f"its telemetry cannot be read: {fault}") from fault


def _sensors(data: bytes, path: Path, stored: str = DEFAULT_ORDER) -> dict[bytes, FloatArray]:
    """ACCL and GYRO of a packet, of the first device that has both; `stored`: their columns."""
    for device in items(data, path):
        if device.key != b"DEVC" or device.kind:
            continue
        sensors: dict[bytes, FloatArray] = {}
        for stream in items(device.body, path):
            if stream.key == b"STRM" and not stream.kind:
                sensors |= _stream(stream.body, path, stored)
        if len(sensors) == 2:
            return sensors
    return {}


def _stream(data: bytes, path: Path, stored: str) -> dict[bytes, FloatArray]:
    known = {item.key: item for item in items(data, path)}
    units = {b"ACCL": (b"m/s\xb2", b"m/s2"), b"GYRO": (b"rad/s",)}
    for key in units.keys() & known.keys():
        field = f"telemetry {key.decode()}"
        value = known.get(b"SIUN")
        unit = b"" if value is None else value.body[: value.size].rstrip(b"\0 ")
        if unit not in units[key]:
            raise refusal(path, f"expected {units[key][0]!r}, got {unit!r}", field=field)
        scale = numbers(known[b"SCAL"], path).ravel() if b"SCAL" in known else np.ones(1)
        values = numbers(known[key], path)
        if values.shape[1] != 3 or scale.size not in (1, 3) or not np.all(scale):
            raise refusal(path, "expected three axes and scales that are not 0", field=field)
        order = known[b"ORIN"].body.decode("ascii", "replace") if b"ORIN" in known else stored
        return {key: _turned(values / scale, order, path)}
    return {}


def _turned(values: FloatArray, order: str, path: Path) -> FloatArray:
    """Columns as x, y, z: `order` names the axis of each, a small letter its opposite."""
    if sorted(order.upper()) != ["X", "Y", "Z"]:
        problem = f"expected an order of x, y and z, got {order[:8]!r}"
        raise refusal(path, problem, field="telemetry ORIN")
    turned = np.empty_like(values)
    for column, letter in enumerate(order):
        turned[:, "XYZ".index(letter.upper())] = values[:, column] * (-1 if letter.islower() else 1)
    return turned


def _joined(packets: Sequence[_Packet], path: Path) -> tuple[IntArray, FloatArray]:
    """All samples of a sensor and their stamps."""
    filled = [entry for entry in packets if len(entry.values)]
    counts = np.array([len(entry.values) for entry in filled])
    starts_s = np.array([entry.start_s for entry in filled])
    before = np.concatenate([[0], np.cumsum(counts)[:-1]])
    values = np.concatenate([entry.values for entry in filled])
    # The last packet is often cut short, but its start is as good as any.
    if len(filled) > 1:
        period_s, first_s = np.polyfit(before, starts_s, 1)
        worst_s = float(np.abs(first_s + period_s * before - starts_s).max())
        if worst_s <= _WORST_FIT_S and period_s > 0.0:
            stamps_s = first_s + period_s * np.arange(len(values))
            return np.rint(1e9 * stamps_s).astype(np.int64), values
        _LOG.warning("%s: telemetry lost samples: %.0f ms off a steady rate", path, 1e3 * worst_s)
    spread = [
        packet.start_s + packet.duration_s * np.arange(len(packet.values)) / len(packet.values)
        for packet in filled
    ]
    time_ns = np.rint(1e9 * np.concatenate(spread)).astype(np.int64)
    if np.any(np.diff(time_ns) <= 0):
        raise refusal(path, "expected packets one after another", field="telemetry")
    return time_ns, values
