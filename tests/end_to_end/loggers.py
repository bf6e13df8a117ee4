"""Logs of a known motion as many kinds of apps and devices write them: is it found as well?

    python -m tests.end_to_end.loggers [--seed N] [KIND …]

Each kind is written by its published format (names of columns, units, stamps, rates of its sensors)
and read by the one recognition that every command uses; its orientation is compared with what the
same readings give as EuRoC's CSV. Prints mean inclination errors; ends with 1 above 1.2 times.
"""

from __future__ import annotations

import argparse
import struct
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorcade.fusion.imu import ADIS16448, ContinuousPath, ImuStream, simulate_imu
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.orientation import estimate_orientation
from motorcade.ga import Rotor
from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.imu import read_imu, write_imu
from motorcade.replays.io.readers.readings import read_readings
from tests.replays.readers.bag_poses import Messages, write_messages

MOST_TIMES = 1.2
START_NS = 1_700_000_000_123_000_000
G = 9.80665


@dataclass(frozen=True)
class Motion:
    """Readings of a known motion: stamps from 0, rate, force, field (µT), and how it stood."""

    imu: ImuStream
    field: FloatArray
    truth: Rotor

    @property
    def rows(self) -> list[list[float]]:
        """Rate, force and field a row."""
        columns = (self.imu.angular_rate_rad_s, self.imu.specific_force_m_s2, self.field)
        return [[float(value) for value in row] for row in np.concatenate(columns, axis=1)]

    @property
    def stamped(self) -> list[tuple[int, list[float]]]:
        """A stamp (ns) beside each row."""
        return list(zip(self.imu.time_ns.tolist(), self.rows, strict=True))

    @property
    def time_s(self) -> list[float]:
        return [float(one) for one in 1e-9 * self.imu.time_ns]


def draw(rng: np.random.Generator, duration_s: float = 20.0) -> Motion:
    """Walking and looking about."""
    path = ContinuousPath.along(MOTIONS["walk_and_look"], duration_s)
    simulated = simulate_imu(path, 100.0, ADIS16448, rng)
    truth: Rotor = simulated.path.poses.rotor
    count = len(simulated.stream)
    field = truth.inverse().apply(np.broadcast_to([0.0, 17.0, -42.0], (count, 3)))
    field = field + rng.normal(0.0, 0.5, field.shape)
    imu = simulated.stream
    shifted = ImuStream(
        imu.time_ns - imu.time_ns[0], imu.angular_rate_rad_s, imu.specific_force_m_s2
    )
    return Motion(shifted, np.asarray(field), truth)


def _lines(path: Path, header: list[str], rows: list[str], encoding: str = "utf-8") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*header, *rows]) + "\n", encoding=encoding)
    return path


def sensor_logger(folder: Path, motion: Motion, *, apple: bool = False) -> Path:
    """`time` in ns since 1970, axes backwards; Android's forces whole, Apple's in two files."""
    where = folder / "log"
    columns = {"Gyroscope": slice(0, 3), "Magnetometer": slice(6, 9)}
    values = np.array(motion.rows)
    sets = {name: values[:, columns[name]] for name in columns}
    gravity = motion.truth.inverse().apply(np.broadcast_to([0.0, 0.0, G], (len(values), 3)))
    sign = -1.0 if apple else 1.0
    sets["Accelerometer"] = sign * (values[:, 3:6] - gravity)
    sets["Gravity"] = sign * gravity
    if not apple:
        sets["TotalAcceleration"] = values[:, 3:6]
    for shift_ns, (name, readings) in enumerate(sets.items()):
        rows = [
            f"{START_NS + stamp + 100_000 * shift_ns},{1e-9 * stamp:.7f},{z!r},{y!r},{x!r}"
            for stamp, (x, y, z) in zip(motion.imu.time_ns.tolist(), readings.tolist(), strict=True)
        ]
        _lines(where / f"{name}.csv", ["time,seconds_elapsed,z,y,x"], rows)
    said = "ios,false" if apple else "android,false"
    _lines(where / "Metadata.csv", ["version,platform,standardisation"], [f"3,{said}"])
    return where


def sensor_logger_zip(folder: Path, motion: Motion) -> Path:
    """The same as the app shares it."""
    where = sensor_logger(folder, motion)
    path = folder / "log.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(where.iterdir()):
            archive.write(file, file.name)
    return path


def sensor_logger_ios(folder: Path, motion: Motion) -> Path:
    """An iPhone's, whose forces point downwards and whose gravity is apart."""
    return sensor_logger(folder, motion, apple=True)


def phyphox(folder: Path, motion: Motion) -> Path:
    """Semicolons and decimal commas, seconds since the start, sensors at rates of their own."""
    heads = {
        "Gyroscope": ("Gyroscope {} (rad/s)", "Absolute (rad/s)"),
        "Accelerometer": ("Acceleration {} (m/s^2)", "Absolute acceleration (m/s^2)"),
        "Magnetometer": ("Magnetic field {} (µT)", "Absolute field (µT)"),
    }
    values, path = np.array(motion.rows), folder / "phyphox.zip"
    for number, (name, (axis, whole)) in enumerate(heads.items()):
        header = ";".join([f'"{one}"' for one in ("Time (s)", *map(axis.format, "xyz"), whole)])
        rows = []
        for time_s, row in zip(motion.time_s, values[:, 3 * number : 3 * number + 3], strict=True):
            numbers = (time_s + 1e-3 * number, *row, np.linalg.norm(row))
            rows.append(";".join(f"{value:.9E}" for value in numbers).replace(".", ","))
        _lines(folder / "p" / f"{name}.csv", [header], rows)
    _lines(folder / "p" / "meta" / "time.csv", ['"event";"experiment time"'], ['"START";0,0'])
    with zipfile.ZipFile(path, "w") as archive:
        for file in sorted((folder / "p").rglob("*.csv")):
            archive.write(file, file.relative_to(folder / "p"))
    return path


def androsensor(folder: Path, motion: Motion) -> Path:
    """One file; readings without gravity and gravity itself stand beside those with it."""
    names = ("ACCELEROMETER", "GRAVITY", "LINEAR ACCELERATION")
    header = [f"{name} {axis} (m/s²)" for name in names for axis in "XYZ"]
    header += [f"GYROSCOPE {axis} (rad/s)" for axis in "XYZ"]
    header += [f"MAGNETIC FIELD {axis} (μT)" for axis in "XYZ"]
    header += ["LOCATION Latitude : ", "Time since start in ms ", "YYYY-MO-DD HH-MI-SS_SSS"]
    rows = []
    for time_s, row in zip(motion.time_s, motion.rows, strict=True):
        numbers = [*row[3:6], 0.1, 0.2, 9.8, 0.3, 0.2, 0.1, *row[:3], *row[6:9], 47.0]
        text = ";".join(f"{value:.6f}" for value in numbers)
        rows.append(f"{text};{round(1e3 * time_s)};2023-11-14 22:13:20:123")
    return _lines(folder / "Sensor_record.csv", [";".join(header)], rows)


def androsensor_damaged(folder: Path, motion: Motion) -> Path:
    """The same after a program that took its UTF-8 for Windows' Latin had saved it."""
    path = androsensor(folder, motion)
    text = "sep=;\n" + path.read_text(encoding="utf-8").replace("LINEAR", "Linear")
    path.write_bytes(text.encode().decode("cp1252").encode())
    return path


def sensorlog(folder: Path, motion: Motion, *, alone: bool = False) -> Path:
    """SensorLog of iOS: a stamp a sensor, forces of Core Motion in g and downwards; null at first.

    Columns as in SensorLog's files (`motionRotationRateX(rad/s)`); `alone`: without raw sensors.
    """
    gravity = motion.truth.inverse().apply(np.broadcast_to([0.0, 0.0, G], (len(motion.rows), 3)))
    groups = {
        "accelerometer": [
            "Timestamp_sinceReboot(s)",
            *(f"Acceleration{axis}(G)" for axis in "XYZ"),
        ],
        "gyro": ["Timestamp_sinceReboot(s)", *(f"Rotation{axis}(rad/s)" for axis in "XYZ")],
        "motion": [
            *("Timestamp_sinceReboot(s)", "Yaw(rad)"),
            *(f"RotationRate{axis}(rad/s)" for axis in "XYZ"),
            *(f"UserAcceleration{axis}(G)" for axis in "XYZ"),
            *(f"Gravity{axis}(G)" for axis in "XYZ"),
            *(f"MagneticField{axis}(µT)" for axis in "XYZ"),
        ],
    }
    names = ["loggingTime(txt)", "locationTimestamp_since1970(s)", "locationHeadingX(µT)"]
    kept = [name for name in groups if not alone or name == "motion"]
    names += [name + column for name in kept for column in groups[name]]
    rows = []
    for number, (time_s, row) in enumerate(zip(motion.time_s, motion.rows, strict=True)):
        down = [-value / G for value in row[3:6]]
        pull = (-gravity[number] / G).tolist()
        user = [whole - part for whole, part in zip(down, pull, strict=True)]
        at_s = 86_400.5 + time_s
        numbers = [] if alone else [at_s, *down, at_s + 0.001, *row[:3]]
        numbers += [at_s + 0.001, 0.1, *row[:3], *user, *pull, *row[6:9]]
        text = ",".join(f"{value:.9f}" if number else "null" for value in numbers)
        rows.append(f"2020-05-06 09:14:{time_s:06.3f} +0200,1588749240.1,-3.5,{text}")
    return _lines(folder / "sensorlog.csv", [",".join(names)], rows)


def sensorlog_motion(folder: Path, motion: Motion) -> Path:
    """The same, with what Core Motion made of the sensors alone."""
    return sensorlog(folder, motion, alone=True)


_XSENS = [
    "Acc_X",
    "Acc_Y",
    "Acc_Z",
    "FreeAcc_X",
    "FreeAcc_Y",
    "FreeAcc_Z",
    "Gyr_X",
    "Gyr_Y",
    "Gyr_Z",
]


def xsens_mt(folder: Path, motion: Motion, *, ticks: bool = True) -> Path:
    """MT Manager's: tabs, ticks of 100 µs that wrap, free acceleration beside the whole one."""
    head = ["// Start Time: Unknown", "// Update Rate: 100.0Hz", "// Filter Profile: human (46.1)"]
    rows = []
    for number, (stamp, row) in enumerate(motion.stamped):
        fine = str((stamp // 100_000 + 2**32 - 5000) % 2**32) if ticks else ""
        numbers = [*row[3:6], 0.1, -0.2, 0.05, *row[:3]]
        text = "\t".join(f"{value:.9f}" for value in numbers)
        rows.append(f"{(65_000 + number) % 2**16:05}\t{fine}\t{text}\t")
    names = "\t".join(["PacketCounter", "SampleTimeFine", *_XSENS, ""])
    return _lines(folder / "MT_012005D6-000.txt", [*head, names], rows)


def xsens_mtw(folder: Path, motion: Motion) -> Path:
    """The same of an MTw, whose ticks are empty: packets are counted, in 16 bits."""
    return xsens_mt(folder, motion, ticks=False)


def xsens_dot(folder: Path, motion: Motion) -> Path:
    """Movella's exporter: lines of settings, ticks of 1 µs, rates in degrees without a unit."""
    head = ["sep=,", "DeviceTag:,1", "OutputRate:,100Hz", "Measurement Mode:,Sensor fusion Mode"]
    head += [
        "StartTime: ,2025-07-11_20:06:00_086 WEST",
        "© Movella Technologies B. V. 2005-2025",
        "",
    ]
    rows = []
    for number, (stamp, row) in enumerate(motion.stamped):
        numbers = [*row[3:6], 0.1, -0.2, 0.05, *np.degrees(row[:3])]
        text = ",".join(f"{value:.9f}" for value in numbers)
        rows.append(f"{number},{(stamp // 1000 + 2**32 - 10**6) % 2**32},{text},0,")
    names = ",".join(["PacketCounter", "SampleTimeFine", *_XSENS, "Status", ""])
    return _lines(folder / "1_20250711.csv", [*head, names], rows)


def physics_toolbox(folder: Path, motion: Motion) -> Path:
    """Forces in g (`gFx`) beside those without gravity (`ax`), seconds since the start."""
    header = "time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz,p,Bx,By,Bz,Azimuth,Pitch,Roll,Latitude,Longitude"
    rows = []
    for time_s, row in zip(motion.time_s, motion.rows, strict=True):
        force = [value / G for value in row[3:6]]
        numbers = [time_s, *force, 0.1, 0.1, 0.2, *row[:3], 1013.2, *row[6:9], 1, 2, 3, 47.1, 8.5]
        rows.append(",".join(f"{value:.6f}" for value in numbers))
    return _lines(folder / "toolbox.csv", [header], rows)


def repoimu(folder: Path, motion: Motion) -> Path:
    """Two rows of names, semicolons; the reference stands first."""
    groups = ["Time", "Vicon Orientation", "", "", "", "Acceleration", "", "", "Gyroscope", "", ""]
    axes = ["[s]", *"WXYZ", *"XYZ", *"XYZ", *"XYZ"]
    header = [";".join([*groups, "Magnetometer", "", ""]), ";".join(axes)]
    wxyz = motion.truth.as_quaternion().tolist()
    rows = [
        ";".join(f"{value:.8f}" for value in (time_s, *turn, *row[3:6], *row[:3], *row[6:9]))
        for time_s, turn, row in zip(motion.time_s, wxyz, motion.rows, strict=True)
    ]
    return _lines(folder / "TStick_Test01_Trial1.csv", header, rows)


def rostopic(folder: Path, motion: Motion) -> Path:
    """`rostopic echo -p`: the time of arrival first, in batches; that of the header after it."""
    parts = ("orientation.x", "orientation.y", "orientation.z", "orientation.w")
    parts += tuple(f"angular_velocity.{axis}" for axis in "xyz")
    parts += tuple(f"linear_acceleration.{axis}" for axis in "xyz")
    head = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    header = ",".join([*head, *(f"field.{part}" for part in parts)])
    rows = []
    for number, (stamp, row) in enumerate(motion.stamped):
        came = START_NS + stamp // 50_000_000 * 50_000_000
        numbers = ",".join(repr(value) for value in (0.0, 0.0, 0.0, 1.0, *row[:6]))
        rows.append(f"{came},{number},{START_NS + stamp},imu,{numbers}")
    return _lines(folder / "imu.csv", [header], rows)


def px4(folder: Path, motion: Motion) -> Path:
    """A ULog of `sensor_combined` and `vehicle_magnetometer`, in PX4's axes."""
    from pyulog import ULog

    path = folder / "flight.ulg"
    file = bytearray(ULog.HEADER_BYTES + b"\x01" + (0).to_bytes(8, "little"))
    kinds = (
        ("sensor_combined", "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;"),
        ("vehicle_magnetometer", "uint64_t timestamp;float[3] magnetometer_ga;"),
    )

    def message(kind: str, body: bytes) -> bytes:
        return len(body).to_bytes(2, "little") + kind.encode() + body

    file += message("B", bytes(40))
    for name, fields in kinds:
        file += message("F", f"{name}:{fields}".encode())
    for number, (name, _) in enumerate(kinds):
        file += message("A", b"\0" + number.to_bytes(2, "little") + name.encode())
    for stamp, row in motion.stamped:
        head = (stamp // 1000 + 5_000_000).to_bytes(8, "little")
        data = head + np.array(row[:6], "<f4").tobytes()
        file += message("D", (0).to_bytes(2, "little") + data)
        data = head + (np.array(row[6:9], "<f4") / 100).tobytes()
        file += message("D", (1).to_bytes(2, "little") + data)
    path.write_bytes(bytes(file))
    return path


_ARDUPILOT = (
    (129, "IMU", "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    (130, "MAG", "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S"),
    (131, "GPS", "QBBIHBcLLe", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt"),
    (132, "ATT", "Qcc", "TimeUS,Roll,Pitch"),
)
_PACKED = dict(zip("BhHIQfcLe", "BhHIQfhii", strict=True))


def ardupilot(folder: Path, motion: Motion) -> Path:
    """A DataFlash log: formats, then messages; two IMUs, and bytes that a full disk lost."""
    mark, formats = b"\xa3\x95", {}
    file = bytearray()
    fmt = (128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    for number, name, types, labels in (fmt, *_ARDUPILOT):
        packed = "<" + "".join(_PACKED.get(letter, "") for letter in types)
        formats[name] = (number, packed)
        length = 89 if number == 128 else 3 + struct.calcsize(packed)
        texts = (text.encode() for text in (name, types, labels))
        file += mark + b"\x80" + struct.pack("<BB4s16s64s", number, length, *texts)

    def message(name: str, *values: float) -> bytes:
        number, packed = formats[name]
        return mark + bytes([number]) + struct.pack(packed, *values)

    for count, (stamp, row) in enumerate(motion.stamped):
        time_us = stamp // 1000 + 5_000_000
        rest = (0, 0, 30.0, 1, 1, 100, 100)
        file += message("IMU", time_us, 0, *row[:6], *rest)
        file += message("IMU", time_us + 20, 1, *[9.0] * 6, *rest)
        if count % 10 == 0:
            field = [round(10 * value) for value in row[6:9]]
            file += message("MAG", time_us, 0, *field, *[0] * 6, 1, 0)
            place = (472_000_000 + count, 85_000_000, 41_250)
            file += message("GPS", time_us, 0, 3, 0, 2000, 9, 120, *place)
            file += message("ATT", time_us, 100, -100)
        if count == 1000:
            file += b"\xa3\x95\xff\0\xa3\x95"
    path = folder / "00000042.BIN"
    path.write_bytes(bytes(file) + mark + b"\x81half")
    return path


def oxts(folder: Path, motion: Motion) -> Path:
    """KITTI's raw drives: a file a packet, and their times."""
    where = folder / "drive" / "oxts"
    (where / "data").mkdir(parents=True)
    times = []
    for number, (stamp, row) in enumerate(motion.stamped):
        numbers = [49.0, 8.4, 110.0, *[0.0] * 8, *row[3:6], *[0.0] * 3, *row[:3], *[0.0] * 10]
        text = " ".join(f"{value:.9f}" for value in numbers)
        (where / "data" / f"{number:010}.txt").write_text(text + "\n")
        minutes, rest = divmod(stamp + 964_389_445, 60 * 10**9)
        times.append(f"2011-09-26 13:{minutes:02}:{rest // 10**9:02}.{rest % 10**9:09}")
    _lines(where / "timestamps.txt", times, [])
    return folder / "drive"


def ros_bag(folder: Path, motion: Motion) -> Path:
    """An Imu topic alone, without images."""
    messages, sent = Messages(ros1=True), []
    for stamp, row in motion.stamped:
        message = messages.make(
            "sensor_msgs/msg/Imu",
            header=messages.header(START_NS + stamp, "imu"),
            orientation=messages.turn((1, 0, 0, 0)),
            orientation_covariance=np.zeros(9),
            angular_velocity=messages.point(row[:3], "Vector3"),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=messages.point(row[3:6], "Vector3"),
            linear_acceleration_covariance=np.zeros(9),
        )
        sent.append(("/imu", START_NS + stamp + 1_000_000, message))
    return write_messages(folder, "bag", sent)


def two_topics(folder: Path, motion: Motion) -> Path:
    """RealSense's: gyroscope and accelerometer on topics of their own."""
    messages, sent = Messages(ros1=False), []
    for number, (stamp, row) in enumerate(motion.stamped):
        for name, rate, force in (("gyro", row[:3], [0.0] * 3), ("accel", [0.0] * 3, row[3:6])):
            if name == "accel" and number % 2:
                continue
            taken = START_NS + stamp + (0 if name == "gyro" else 300_000)
            message = messages.make(
                "sensor_msgs/msg/Imu",
                header=messages.header(taken, name),
                orientation=messages.turn((1, 0, 0, 0)),
                orientation_covariance=np.zeros(9),
                angular_velocity=messages.point(rate, "Vector3"),
                angular_velocity_covariance=np.zeros(9),
                linear_acceleration=messages.point(force, "Vector3"),
                linear_acceleration_covariance=np.zeros(9),
            )
            sent.append((f"/camera/{name}/sample", taken + 1_000_000, message))
    return write_messages(folder, "mcap", sorted(sent, key=lambda entry: entry[1]))


def milliseconds(folder: Path, motion: Motion) -> Path:
    """A microcontroller's: whole milliseconds without a unit, degrees and g by the header."""
    header = "t,gyro_x (deg/s),gyro_y (deg/s),gyro_z (deg/s),acc_x (g),acc_y (g),acc_z (g)"
    rows = []
    for time_s, row in zip(motion.time_s, motion.rows, strict=True):
        numbers = [*np.degrees(row[:3]), *(value / G for value in row[3:6])]
        rows.append(f"{round(1e3 * time_s)}," + ",".join(f"{value:.6f}" for value in numbers))
    return _lines(folder / "board.csv", [header], rows)


KINDS: dict[str, Callable[[Path, Motion], Path]] = {
    one.__name__: one
    for one in (
        *(sensor_logger, sensor_logger_zip, sensor_logger_ios, phyphox, androsensor),
        *(androsensor_damaged, sensorlog, sensorlog_motion, xsens_mt, xsens_mtw, xsens_dot),
        *(
            physics_toolbox,
            repoimu,
            rostopic,
            px4,
            ardupilot,
            oxts,
            ros_bag,
            two_topics,
            milliseconds,
        ),
    )
}


def inclination_deg(imu: ImuStream, motion: Motion) -> float:
    """Mean angle between the up that is found and the true one.

    Readings that were left out at the start are told by the rate of the first that was not.
    """
    found = estimate_orientation(imu)
    apart = motion.imu.angular_rate_rad_s[:20] - imu.angular_rate_rad_s[0]
    first_ns = int(motion.imu.time_ns[np.argmin(np.linalg.norm(apart, axis=1))])
    since = found.time_ns - imu.time_ns[0] + first_ns
    rows = np.clip(np.rint(since * 1e-7).astype(int), 0, len(motion.imu) - 1)
    up = [0.0, 0.0, 1.0]
    there, true = (
        turn.inverse().apply(np.broadcast_to(up, (len(rows), 3)))
        for turn in (found.world_R_imu, motion.truth[rows])
    )
    angle = np.arccos(np.clip(np.sum(there * true, axis=1), -1.0, 1.0))
    return float(np.degrees(angle.mean()))


def measure(kind: str, seed: int) -> tuple[float, float]:
    """Mean inclination error of a kind, and of the plain file."""
    motion = draw(np.random.default_rng(seed))
    with tempfile.TemporaryDirectory() as place:
        write_imu(motion.imu, Path(place) / "plain.csv")
        plain = inclination_deg(read_imu(Path(place) / "plain.csv"), motion)
        folder = Path(place) / kind
        folder.mkdir()
        imu = read_readings(KINDS[kind](folder, motion)).imu
    return inclination_deg(imu, motion), plain


def main() -> int:
    """Write, read, compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.end_to_end.loggers", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("kinds", nargs="*", metavar="KIND", default=list(KINDS))
    parser.add_argument("--seed", type=int, default=7)
    asked, worst = parser.parse_args(), 0.0
    for kind in asked.kinds:
        try:
            error, plain = measure(kind, asked.seed)
        except ValueError as fault:
            print(f"{kind:20} {fault}")
            worst = np.inf
            continue
        worst = max(worst, error / plain)
        print(f"{kind:20} {error:.3f} deg, plain {plain:.3f}: {error / plain:.2f} times")
    print(f"worst: {worst:.2f} times, at most {MOST_TIMES}")
    return int(worst > MOST_TIMES)


if __name__ == "__main__":
    sys.exit(main())
