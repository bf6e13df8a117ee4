"""The scripts of docs/scripts against closed forms in vectors and matrices, over many inputs.

Nothing here uses the algebra: the witnesses are cross products, quaternions and matrices of SciPy.
"""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation, Slerp

from motorcade.ga.script import Script, evaluate, parse
from motorcade.ga.script.meaning import algebra_of, free_variables

Array = np.ndarray[Any, np.dtype[np.float64]]
Values = dict[str, Array]
Made = dict[str, Any]
SCRIPTS = Path(__file__).parents[3] / "docs" / "scripts"
COUNT = 60


def script_named(name: str) -> Script:
    return parse((SCRIPTS / f"{name}.clu").read_text(), f"{name}.clu")


def of(values: Values, names: str) -> Array:
    return np.stack([values[name] for name in names.split()], axis=-1)


def parts(made: Made, output: str, blades: str) -> Array:
    """Coefficients of an output ``(n, k)``."""
    found = [np.asarray(made[output].coefficient(blade)) for blade in blades.split()]
    return np.stack(np.broadcast_arrays(*found, np.zeros(COUNT))[:-1], axis=-1)


def near(found: Any, expected: Any, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance)


def given(rng: np.random.Generator, **ranges: tuple[float, float]) -> Values:
    """Values of all variables; a name with spaces stands for several."""
    return {name: rng.uniform(low, high, COUNT) for name, (low, high) in ranges.items()}


def uniform(rng: np.random.Generator, names: str, low: float = -2, high: float = 2) -> Values:
    return {name: rng.uniform(low, high, COUNT) for name in names.split()}


def rotors(rng: np.random.Generator, suffix: str) -> Values:
    """Unit coefficients on 1, e23, e31, e12: those of the quaternion (w, -x, -y, -z)."""
    raw = rng.normal(size=(COUNT, 4))
    raw /= np.linalg.norm(raw, axis=-1, keepdims=True)
    return {f"{axis}{suffix}": raw[:, k] for k, axis in enumerate("wxyz")}


def rotation(values: Values, suffix: str) -> Rotation:
    w, x, y, z = (values[f"{axis}{suffix}"] for axis in "wxyz")
    return Rotation.from_quat(np.stack([-x, -y, -z, w], axis=-1))


def rotation_of(made: Made, output: str, blades: str = "1 e2^e3 e3^e1 e1^e2") -> Rotation:
    w, x, y, z = np.moveaxis(parts(made, output, blades), -1, 0)
    return Rotation.from_quat(np.stack([-x, -y, -z, w], axis=-1))


def turned_short(first: Rotation, second: Rotation, t: Array) -> Rotation:
    """The short way from one rotation to another, by SciPy."""
    rows = zip(first, second, t, strict=True)
    return Rotation.concatenate(
        [Slerp([0, 1], Rotation.concatenate([a, b]))(f) for a, b, f in rows]
    )


def circle_values(rng: np.random.Generator) -> Values:
    return uniform(rng, "ax ay az bx by bz cx cy cz")


def circle_check(values: Values, made: Made) -> None:
    a, b, c = (of(values, f"{p}x {p}y {p}z") for p in "abc")
    u, v = b - a, c - a
    n = np.cross(u, v)
    nn = np.sum(n * n, axis=-1, keepdims=True)
    uu, vv = (np.sum(s * s, axis=-1, keepdims=True) for s in (u, v))
    to_centre = (uu * np.cross(v, n) + vv * np.cross(n, u)) / (2 * nn)
    centre, radius = a + to_centre, np.linalg.norm(to_centre, axis=-1)
    scale = (1 + radius**3)[:, None]
    near(parts(made, "normal", "e1 e2 e3"), n / np.sqrt(nn), 1e-8)
    near(parts(made, "centre", "e1 e2 e3 e0") / scale, np.c_[centre, np.ones(COUNT)] / scale, 1e-8)
    near(made["radius"].scalar_part() / scale[:, 0], radius / scale[:, 0], 1e-8)
    for point in (a, b, c):
        near((np.linalg.norm(point - centre, axis=-1) - radius) / scale[:, 0], 0.0, 1e-8)


def spheres_values(rng: np.random.Generator) -> Values:
    """Spheres through two common points."""
    values = uniform(rng, "c1x c1y c1z c2x c2y c2z c3x c3y c3z")
    common = rng.uniform(-1, 1, (COUNT, 3))
    for k in "123":
        centre = of(values, f"c{k}x c{k}y c{k}z")
        values[f"r{k}"] = np.linalg.norm(common - centre, axis=-1)
    return values


def spheres_check(values: Values, made: Made) -> None:
    for name in ("first", "second"):
        found = parts(made, name, "e1 e2 e3 e0")
        near(found[:, 3], 1.0, 1e-8)
        for k in "123":
            away = np.linalg.norm(found[:, :3] - of(values, f"c{k}x c{k}y c{k}z"), axis=-1)
            near(away / values[f"r{k}"], 1.0, 1e-6)
    first, second = (parts(made, name, "e1 e2 e3") for name in ("first", "second"))
    c1, c2, c3 = (of(values, f"c{k}x c{k}y c{k}z") for k in "123")
    across = np.sum(np.cross(c2 - c1, c3 - c1) * (first - second), axis=-1)
    assert (across > 0).all() or (across < 0).all()


def distance_values(rng: np.random.Generator) -> Values:
    return uniform(rng, "px py pz ax ay az bx by bz")


def distance_check(values: Values, made: Made) -> None:
    p, a, b = (of(values, f"{q}x {q}y {q}z") for q in "pab")
    way = (b - a) / np.linalg.norm(b - a, axis=-1, keepdims=True)
    foot = a + np.sum((p - a) * way, axis=-1, keepdims=True) * way
    near(made["distance"].scalar_part(), np.linalg.norm(np.cross(p - a, way), axis=-1))
    near(parts(made, "foot", "e1 e2 e3 e0"), np.c_[foot, np.ones(COUNT)])
    near(parts(made, "foot", "einf")[:, 0], 0.5 * np.sum(foot * foot, axis=-1))


def arm_values(rng: np.random.Generator) -> Values:
    upper, lower = rng.uniform(0.5, 1.5, (2, COUNT))
    angle, bend = rng.uniform(-3, 3, COUNT), rng.uniform(-3, -0.1, COUNT)
    x = upper * np.cos(angle) + lower * np.cos(angle + bend)
    y = upper * np.sin(angle) + lower * np.sin(angle + bend)
    return {"x": x, "y": y, "upper": upper, "lower": lower}


def arm_check(values: Values, made: Made) -> None:
    """The law of cosines, and the forward kinematics."""
    x, y, upper, lower = (values[name] for name in ("x", "y", "upper", "lower"))
    cosine = (x * x + y * y - upper**2 - lower**2) / (2 * upper * lower)
    bend = -np.arccos(np.clip(cosine, -1, 1))
    shoulder = np.arctan2(y, x) - np.arctan2(lower * np.sin(bend), upper + lower * np.cos(bend))
    found, turned = made["shoulder"].scalar_part(), made["bend"].scalar_part()
    near(turned, bend, 1e-6)
    near(np.exp(1j * found), np.exp(1j * shoulder), 1e-6)
    near(upper * np.cos(found) + lower * np.cos(found + turned), x, 1e-6)
    near(upper * np.sin(found) + lower * np.sin(found + turned), y, 1e-6)
    elbow = np.stack(
        [upper * np.cos(shoulder), upper * np.sin(shoulder), 0 * x, 1 + 0 * x], axis=-1
    )
    near(parts(made, "elbow", "e1 e2 e3 e0"), elbow, 1e-6)


def mirror_values(rng: np.random.Generator) -> Values:
    values = uniform(rng, "ax ay az bx by bz da db x y z")
    for p in "ab":
        size = np.linalg.norm(of(values, f"{p}x {p}y {p}z"), axis=-1)
        for axis in "xyz":
            values[p + axis] = values[p + axis] / size
    return values


def mirror_check(values: Values, made: Made) -> None:
    def reflected(v: Array, p: str) -> Array:
        n = of(values, f"{p}x {p}y {p}z")
        return v - 2 * (np.sum(n * v, axis=-1) - values[f"d{p}"])[:, None] * n

    blades = "e0^e3^e2 e0^e1^e3 e0^e2^e1 e1^e2^e3"
    once = reflected(of(values, "x y z"), "a")
    near(parts(made, "mirrored", blades), np.c_[once, np.ones(COUNT)])
    near(parts(made, "moved", blades), np.c_[reflected(once, "b"), np.ones(COUNT)])
    assert set(made["motor"].grades) <= {0, 2, 4}


def rotor_values(rng: np.random.Generator) -> Values:
    return rotors(rng, "1") | rotors(rng, "2") | uniform(rng, "t", 0, 1)


def rotor_check(values: Values, made: Made) -> None:
    first, second = rotation(values, "1"), rotation(values, "2")
    way = turned_short(first, second, values["t"])
    near((rotation_of(made, "rotor").inv() * way).magnitude(), 0.0)
    half = turned_short(first, second, np.full(COUNT, 0.5))
    near((rotation_of(made, "half").inv() * half).magnitude(), 0.0)
    near(-2 * parts(made, "rate", "e2^e3 e3^e1 e1^e2"), (first.inv() * second).as_rotvec())


def table1_values(rng: np.random.Generator) -> Values:
    axes = uniform(rng, "srcX srcY srcZ dstX dstY dstZ")
    return axes | uniform(rng, "angle1 angle2", -6, 6) | uniform(rng, "factor", 0, 1)


def table1_check(values: Values, made: Made) -> None:
    ends = []
    for end, angle in (("src", "angle1"), ("dst", "angle2")):
        axis = of(values, f"{end}X {end}Y {end}Z")
        unit = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
        ends.append(Rotation.from_rotvec(unit * values[angle][:, None]))
    way = turned_short(*ends, values["factor"])
    near((rotation_of(made, "finalR").inv() * way).magnitude(), 0.0)


def table2_values(rng: np.random.Generator) -> Values:
    moves = uniform(rng, "tr1X tr1Y tr1Z tr2X tr2Y tr2Z")
    return rotors(rng, "1") | rotors(rng, "2") | moves | uniform(rng, "alpha", 0, 1)


def table2_check(values: Values, made: Made) -> None:
    """Dual quaternion linear blending (Kavan et al. 2008) in quaternions of SciPy's order."""

    def product(p: Array, q: Array) -> Array:
        pv, qv, pw, qw = p[:, :3], q[:, :3], p[:, 3:], q[:, 3:]
        vector = pw * qv + qw * pv + np.cross(pv, qv)
        return np.c_[vector, pw * qw - np.sum(pv * qv, axis=-1, keepdims=True)]

    blended = []
    for k in "12":
        q = np.stack(
            [-values[f"x{k}"], -values[f"y{k}"], -values[f"z{k}"], values[f"w{k}"]], axis=-1
        )
        t = np.c_[of(values, f"tr{k}X tr{k}Y tr{k}Z"), np.zeros(COUNT)]
        blended.append((q, 0.5 * product(t, q)))
    (q1, d1), (q2, d2) = blended
    flip = np.where(np.sum(q1 * q2, axis=-1) < 0, -1.0, 1.0)[:, None]
    alpha = values["alpha"][:, None]
    q, d = ((1 - alpha) * a + alpha * flip * b for a, b in ((q1, q2), (d1, d2)))
    size = np.sum(q * q, axis=-1, keepdims=True)
    moved = 2 * product(d, q * [-1, -1, -1, 1])[:, :3] / size
    matrices = Rotation.from_quat(q).as_matrix()
    for k, name in enumerate("xyz"):
        near(parts(made, name, "e1^einf e2^einf e3^einf"), matrices[:, :, k])
    near(parts(made, "t", "e1^einf e2^einf e3^einf e0^einf"), np.c_[moved, np.ones(COUNT)])


def screw_values(rng: np.random.Generator) -> Values:
    moves = uniform(rng, "t1x t1y t1z t2x t2y t2z px py pz")
    scales = uniform(rng, "scale1 scale2", 0.5, 2.0)
    return rotors(rng, "1") | rotors(rng, "2") | moves | scales | uniform(rng, "t", 0, 1)


def screw_check(values: Values, made: Made) -> None:
    """The same one-parameter group in 4x4 matrices."""

    def matrices(k: str) -> Array:
        made = np.tile(np.eye(4), (COUNT, 1, 1))
        made[:, :3, :3] = rotation(values, k).as_matrix() * values[f"scale{k}"][:, None, None]
        made[:, :3, 3] = of(values, f"t{k}x t{k}y t{k}z")
        return made

    first, second = matrices("1"), matrices("2")
    p = np.c_[of(values, "px py pz"), np.ones(COUNT)]
    image = parts(made, "image", "e1 e2 e3 e0")
    rows = zip(first, second, values["t"], p, image, strict=True)
    for a, b, t, point, found in islice(rows, 20):
        way = scipy.linalg.expm(t * scipy.linalg.logm(np.linalg.solve(a, b)))
        near(found, (a @ way @ point).real, 1e-6)


CASES: dict[str, tuple[Callable[..., Values], Callable[..., None]]] = {
    "table1": (table1_values, table1_check),
    "table2": (table2_values, table2_check),
    "circle_through_points": (circle_values, circle_check),
    "meet_of_spheres": (spheres_values, spheres_check),
    "point_line_distance": (distance_values, distance_check),
    "two_link_arm": (arm_values, arm_check),
    "mirror": (mirror_values, mirror_check),
    "rotor_interpolation": (rotor_values, rotor_check),
    "motor_interpolation": (screw_values, screw_check),
}


def test_every_script_has_its_closed_form() -> None:
    assert sorted(CASES) == sorted(path.stem for path in SCRIPTS.glob("*.clu"))


@pytest.mark.parametrize("name", CASES)
def test_a_script_computes_its_closed_form(name: str) -> None:
    values_of, check = CASES[name]
    values = values_of(np.random.default_rng(12))
    check(values, evaluate(script_named(name), **values))


@pytest.mark.parametrize("name", CASES)
def test_symbols_mean_what_numbers_mean(name: str) -> None:
    ca = pytest.importorskip("casadi")
    script, values = script_named(name), CASES[name][0](np.random.default_rng(13))
    free = list(free_variables(script, algebra_of(script)))
    assert sorted(free) == sorted(values)
    symbols = [ca.SX.sym(variable) for variable in free]
    made = evaluate(script, **dict(zip(free, symbols, strict=True)))
    batch = evaluate(script, **values)
    rows = np.stack([values[variable] for variable in free])
    for output, x in made.items():
        assert x.blades == batch[output].blades
        found = ca.Function("f", symbols, [ca.densify(ca.vertcat(*map(ca.SX, x.values)))])
        numbers = np.array(found.map(COUNT)(*rows[:, None, :]))
        for row, value in zip(numbers, batch[output].values, strict=True):
            near(row, np.broadcast_to(value, COUNT), 1e-9 * max(1.0, float(np.max(np.abs(row)))))


@pytest.mark.parametrize("name", ["table1", "rotor_interpolation"])
def test_equal_ends_are_kept(name: str) -> None:
    """No angle, nothing to divide by: the same rotation at every fraction."""
    rng = np.random.default_rng(14)
    if name == "table1":
        values = table1_values(rng)
        values |= {"angle2": values["angle1"]} | {f"dst{a}": values[f"src{a}"] for a in "XYZ"}
        output = "finalR"
    else:
        values = rotor_values(rng)
        values |= {f"{a}2": -values[f"{a}1"] for a in "wxyz"}
        output = "rotor"
    start = values | {"factor" if name == "table1" else "t": np.zeros(COUNT)}
    script = script_named(name)
    moved, first = (rotation_of(evaluate(script, **v), output) for v in (values, start))
    near((moved.inv() * first).magnitude(), 0.0, 1e-12)
