"""The C header is current, compiles without a warning, and gives Python's numbers in C and wasm."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS, screw
from motorcade.fusion.smoothing import ConstantAccelerationFilter, ConstantVelocityFilter, OneEuro
from motorcade.fusion.smoothing.causal import smoothed_states
from motorcade.fusion.smoothing.header import get_include, header_text
from motorcade.ga import Motor, Trajectory
from tests.fusion.smoothing.c_header import Header, compiled

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"
EXPORTED = '-DMOTORCADE_API=__attribute__((visibility("default")))'
FILTERS = {"velocity": ConstantVelocityFilter, "acceleration": ConstantAccelerationFilter}
ROUNDING = 1e-14
WITH_ZIG = importlib.util.find_spec("ziglang") is not None

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Header:
    return Header(tmp_path_factory.mktemp("header"))


def noisy(count: int = 10_000) -> Trajectory:
    """Uneven stamps, noise, tumbling that at some steps turns by more than a radian, a gap."""
    rng = np.random.default_rng(7)
    steps_ns = rng.integers(4_000_000, 60_000_000, count)
    steps_ns[rng.integers(0, count, 20)] += 400_000_000
    steps_ns[count // 2] += 8_000_000_000
    time_ns = np.cumsum(steps_ns)
    drawn = MOTIONS["tumble"].sampled(rate_hz=50.0, duration_s=20.0)
    within = drawn.time_ns[0] + (time_ns - time_ns[0]) % (drawn.time_ns[-1] - drawn.time_ns[0])
    errors = rng.standard_normal((count, 6)) * np.repeat([0.01, 0.02], 3)
    poses = drawn.motors_at(within) @ Motor.from_twist(errors)
    return Trajectory(time_ns, poses, "world", "camera")


def test_the_header_is_what_the_definitions_say() -> None:
    pytest.importorskip("casadi")
    pytest.importorskip("mpmath")
    committed = (Path(get_include()) / "motorcade" / "smooth.h").read_text(encoding="utf-8")
    assert committed == header_text(), "run `python -m motorcade.fusion.smoothing.header`"
    assert committed.isascii()


@needs_gcc
@pytest.mark.parametrize(
    ("language", "standard"), [("c", "c99"), ("c", "c17"), ("c++", "c++11"), ("c++", "c++20")]
)
def test_it_compiles_without_a_warning(tmp_path: Path, language: str, standard: str) -> None:
    source = tmp_path / "only.c"
    source.write_text('#include "motorcade/smooth.h"\n')
    compiled(source, tmp_path / "none", f"-x{language}", f"-std={standard}", "-fsyntax-only")


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("order", FILTERS)
@pytest.mark.parametrize("noise", ["one for all", "one each"])
def test_kalman_and_rts_give_pythons_numbers(header: Header, order: str, noise: str) -> None:
    path = noisy()
    time_ns, motors = path.time_ns, np.ascontiguousarray(path.motors.coefficients)
    model = getattr(header.c, f"motorcade_constant_{order}")()
    live, rows = FILTERS[order](), None
    if noise == "one each":
        rows = np.random.default_rng(2).uniform(0.002, 0.05, (len(path), 2))
        live = FILTERS[order](noise_rad=rows[:, 0], noise_m=rows[:, 1])
    expected = smoothed_states(path, live)
    found, log_likelihood = header.rts(model, motors, time_ns, rows)
    turned = np.linalg.norm(path.motors[:-1].local(path.motors[1:])[:, :3], axis=-1)
    assert np.any(turned > 1.0)  # the way back over long steps is another
    assert np.abs(found - expected.trajectory.motors.coefficients).max() < ROUNDING
    assert log_likelihood == pytest.approx(expected.log_likelihood, rel=1e-12)
    if rows is None:
        stream = header.kalman(model)
        filtered = [stream.update(*one) for one in zip(motors, time_ns.tolist(), strict=True)]
        assert np.abs(filtered - live.smooth(path).motors.coefficients).max() < ROUNDING


@needs_gcc
@pytest.mark.slow
def test_one_euro_gives_pythons_numbers(header: Header) -> None:
    path = noisy()
    motors = np.ascontiguousarray(path.motors.coefficients)
    stream = header.one_euro(1.0, 3.0, 5.0, 1.5)
    found = [stream.update(*one) for one in zip(motors, path.time_ns.tolist(), strict=True)]
    expected = OneEuro(1.0, 3.0, 5.0, derivative_cutoff_hz=1.5).smooth(path)
    assert np.abs(found - expected.motors.coefficients).max() < ROUNDING


@needs_gcc
@pytest.mark.slow
def test_a_steady_screw_is_predicted_to_the_displays_time(header: Header) -> None:
    path = screw().sampled(rate_hz=60.0, duration_s=4.0)
    stream = header.kalman(header.c.motorcade_constant_velocity())
    for motor, time_ns in zip(path.motors.coefficients, path.time_ns.tolist(), strict=True):
        stream.update(np.ascontiguousarray(motor), time_ns)
    ahead_ns = int(path.time_ns[-1]) + 50_000_000
    step = path.motors[-2].local(path.motors[-1])
    expected = path.motors[-1] @ Motor.from_twist(step * (50_000_000 / np.diff(path.time_ns)[-1]))
    assert np.abs(expected.local(Motor(stream.predict(ahead_ns)))).max() < 1e-4
    with pytest.raises(ValueError, match="stamp after"):
        stream.predict(int(path.time_ns[-1]) - 1)


@needs_gcc
@pytest.mark.slow
def test_what_is_refused_leaves_a_filter_as_it_was(header: Header) -> None:
    path = noisy(50)
    motors = np.ascontiguousarray(path.motors.coefficients)
    model = header.c.motorcade_constant_velocity()
    for stream in (header.kalman(model), header.one_euro(0.5, 10.0, 10.0, 2.0)):
        for motor, time_ns in zip(motors[:20], path.time_ns[:20].tolist(), strict=True):
            stream.update(motor, time_ns)
        before, last = stream.memory.raw, int(path.time_ns[19])
        for motor, time_ns, problem in (
            (motors[20], last, "stamp after"),
            (motors[20], last - 1, "stamp after"),
            (np.zeros(8), last + 1, "finite"),
            (motors[20] * np.nan, last + 1, "finite"),
        ):
            with pytest.raises(ValueError, match=problem):
                stream.update(motor, time_ns)
            assert stream.memory.raw == before
    for name, value in (("order", 3), ("noise_m", 0.0), ("density_rad", np.inf)):
        wrong = header.c.motorcade_constant_velocity()
        setattr(wrong, name, value)
        with pytest.raises(ValueError, match="order 1 or 2"):
            header.kalman(wrong)
    endless = header.c.motorcade_constant_velocity()
    endless.noise_m = 1e200  # whose square is infinite
    with pytest.raises(ValueError, match="finite"):
        header.kalman(endless).update(motors[0], 0)
    with pytest.raises(ValueError, match="positive"):
        header.one_euro(0.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="stamp after"):
        header.rts(model, motors, np.sort(path.time_ns)[::-1].copy())


@needs_gcc
@pytest.mark.slow
def test_short_paths_and_those_at_the_ends_of_segments(header: Header) -> None:
    model = header.c.motorcade_constant_velocity()
    for count in (1, 2, 3, 255, 256, 257, 258, 512, 513):
        path = noisy(600)[:count]
        motors = np.ascontiguousarray(path.motors.coefficients)
        expected = smoothed_states(path, ConstantVelocityFilter()).trajectory
        found, _ = header.rts(model, motors, path.time_ns)
        assert np.abs(found - expected.motors.coefficients).max() < ROUNDING, count
    assert header.rts(model, np.empty((0, 8)), np.empty(0, np.int64))[0].shape == (0, 8)


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The noisy path as EuRoC's columns."""
    path = noisy()
    rotor, positions = path.motors.rotor.coefficients, path.motors.translation_m
    lines = ["#timestamp [ns], p_x [m], p_y [m], p_z [m], q_w [], q_x [], q_y [], q_z []"]
    for time_ns, p, r in zip(path.time_ns, positions, rotor, strict=True):
        numbers = (*p.tolist(), r[0], -r[1], -r[2], -r[3])
        lines.append(",".join([str(time_ns), *(repr(float(one)) for one in numbers)]))
    made = tmp_path_factory.mktemp("rows") / "noisy.csv"
    made.write_text("\n".join(lines) + "\n")
    return made


def smoothed_by(command: list[str], rows: Path, method: str) -> None:
    """Run a program on the rows, and hold what it writes against Python."""
    with rows.open() as given:
        done = subprocess.run(
            [*command, method], stdin=given, capture_output=True, text=True, check=False
        )
    assert done.returncode == 0, done.stderr
    path = noisy()
    if method == "rts":
        expected = smoothed_states(path, ConstantVelocityFilter()).trajectory
    else:
        expected = {"velocity": ConstantVelocityFilter, "one_euro": OneEuro}[method]().smooth(path)
    found = np.array([line.split(",")[1:] for line in done.stdout.split()], dtype=float)
    rotor = expected.motors.rotor.coefficients * [1.0, -1.0, -1.0, -1.0]
    off = np.abs(found - np.hstack([expected.motors.translation_m, rotor]))
    assert off.max() < 10.0 * ROUNDING  # positions are metres of up to ten


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The example in C, which a wrong index or an overflow ends."""
    options = "-std=c99", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"
    made = tmp_path_factory.mktemp("example") / "smooth"
    return str(compiled(EXAMPLES / "smooth.c", made, *options))


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("method", ["rts", "velocity", "one_euro"])
def test_the_example_in_c_is_clean_and_gives_pythons_numbers(
    example: str, rows: Path, method: str
) -> None:
    smoothed_by([example], rows, method)
    for given, problem in (("1,2,3\n", "row 1: expected time_ns"), ("1,0,0,0,0,0,0,0\n", "finite")):
        done = subprocess.run([example, method], input=given, capture_output=True, text=True)
        assert done.returncode == 1
        assert problem in done.stderr
    if method == "rts":  # all poses are smoothed at once, and no row is named
        good = "2,0,0,0,1,0,0,0\n"
        done = subprocess.run([example, method], input=2 * good, capture_output=True, text=True)
        assert done.stderr == "smooth: time_ns: expected a stamp after the one before\n"


@pytest.fixture(scope="module")
def wasm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wasm")
    (folder / "smooth.c").write_text('#include "motorcade/smooth.h"\n')
    linked = "-Wl,--strip-all,--export-dynamic,--export=malloc,--export=free"
    target = "-target", "wasm32-wasi", "-mexec-model=reactor", "-O2"
    zig = sys.executable, "-m", "ziglang", "cc"
    return compiled(
        folder / "smooth.c", folder / "smooth.wasm", *target, EXPORTED, linked, compiler=zig
    )


@pytest.mark.slow
@pytest.mark.skipif(not WITH_ZIG, reason="needs the Python package ziglang, a C compiler for wasm")
@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
@pytest.mark.parametrize("method", ["rts", "velocity", "one_euro"])
def test_the_example_in_javascript_gives_pythons_numbers(
    wasm: Path, rows: Path, method: str
) -> None:
    smoothed_by(["node", str(EXAMPLES / "smooth.mjs"), str(wasm)], rows, method)
