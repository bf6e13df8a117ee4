"""GoPro's telemetry in a video (GPMF): accelerometer and gyroscope as one IMU stream.

The metadata track holds a packet about every second (`gopro.items`). Only ACCL and GYRO are taken,
of the first device that has both.

Both sensors run at steady rates of their own and are stamped by packet only. Their stamps come
from a line through the packets' stamps over the count of samples before; where that line is more
than 20 ms off somewhere, samples were lost, and each packet's are spread over the packet alone. The
gyroscope's stamps are kept where the rates differ, and the force is interpolated to them.

Axes: columns are turned to x, y, z here. Their order and signs stand in ORIN since the HERO8, and
follow from the model before (`gopro.MODELS`). How the camera sits on them is for a manifest's
`imu_T_camera` to say.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from av.error import FFmpegError

from motorcade.fusion.imu.stream import ImuStream
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render.video import open_video
from motorcade.replays.io.errors import refusal
from motorcade.replays.io.files import refused
from motorcade.replays.io.imu import join_sensors
from motorcade.replays.io.readers.gopro import DEFAULT_ORDER, gopro_camera, items, numbers

_LOG = logging.getLogger("motorcade.replays")

_MOST_PACKETS = 100_000
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
    camera = gopro_camera(path)
    order = DEFAULT_ORDER if camera is None else camera.order
    for start_s, duration_s, data in _packets(path):
        for key, values in _sensors(data, path, order).items():
            gathered[key].append(_Packet(start_s, duration_s, values))
    if not (gathered[b"ACCL"] and gathered[b"GYRO"]):
        return None
    gyro_ns, rate = _joined(gathered[b"GYRO"], path)
    accel_ns, force = _joined(gathered[b"ACCL"], path)
    try:
        return join_sensors(gyro_ns, rate, accel_ns, force)
    except ValueError as fault:
        raise refusal(path, str(fault), field="telemetry") from fault


def _packets(path: Path) -> Iterator[tuple[float, float, bytes]]:
    """Start, duration (s) and bytes of the packets of the telemetry track."""
    size = 0
    try:
        with refused(), open_video(path) as container:
            tracks = [entry for entry in container.streams if entry.type == "data"]
            for count, packet in enumerate(container.demux(tracks) if tracks else ()):
                data = bytes(packet)
                if packet.pts is None or packet.time_base is None or data[:4] != b"DEVC":
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
