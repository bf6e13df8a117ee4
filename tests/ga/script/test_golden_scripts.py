"""Scripts whose results are known in closed form, over numbers, batches and symbols."""

import numpy as np
import pytest

from motorcade.ga.algebra import CGA3, EGA3, PGA3, Algebra, Multivector
from motorcade.ga.algebra import conformal as cga
from motorcade.ga.script import ScriptError, evaluate, parse

CIRCLE = """
    // the circle through three points, as an inner form
    a = createPoint(ax, ay, 0); b = createPoint(0 - r, 0, 0); c = createPoint(0, r, 0);
    ?circle = *(a ^ b ^ c);
    plane = *(a ^ b ^ c ^ einf);
    ?weight = plane . plane;
    ?radius = sqrt(abs((circle . circle) / (plane . plane)));
"""


def numbers(x: Multivector, names: str) -> list[float]:
    return [float(x.coefficient(name)) for name in names.split()]


def test_a_circle_through_three_points_has_their_radius() -> None:
    made = evaluate(parse(CIRCLE), ax=2.5 * np.cos(0.3), ay=2.5 * np.sin(0.3), r=2.5)
    assert made["radius"].scalar_part() == pytest.approx(2.5, rel=1e-12)
    for point in ((-2.5, 0, 0), (0, 2.5, 0), (2.5, 0, 0)):
        outer = made["circle"].undual() ^ cga.point(point)
        assert max(abs(v) for v in outer.values) < 1e-12


def test_two_spheres_meet_in_the_circle_between_them() -> None:
    script = parse("""
        one = VecN3(0, 0, 0) - 0.5*r*r*einf;
        two = *SphereN3(d, 0, 0, s);
        ?meet = one ^ two;
        ?size = meet . meet;
    """)
    d, r, s = 3.0, 2.0, 2.5
    made = evaluate(script, d=d, r=r, s=s)
    along = (d * d + r * r - s * s) / (2 * d)
    expected = cga.circle((along, 0, 0), (1, 0, 0), np.sqrt(r * r - along * along))
    # SphereN3 is an outer form: its dual is the inner one with the sign of I² = -1.
    ratio = made["meet"].coefficient("e1^e0") / expected.coefficient("e1^e0")
    difference = made["meet"] - expected * ratio
    assert max(abs(v) for v in difference.values) < 1e-12
    assert abs(ratio) == pytest.approx(d)


def test_a_point_has_the_distance_from_a_line_of_the_cross_product() -> None:
    script = parse("""
        a = VecN3(0, 1, 2); b = VecN3(2, 1, 3); p = VecN3(x, y, z);
        line = a ^ b ^ einf;
        plane = line ^ p;
        ?distance = abs(plane) / abs(line);
    """)
    rng = np.random.default_rng(5)
    x, y, z = rng.uniform(-3, 3, (3, 20))
    made = evaluate(script, x=x, y=y, z=z)["distance"].scalar_part()
    way, away = np.array([2, 0, 1.0]), np.stack([x, y - 1, z - 2], axis=-1)
    expected = np.linalg.norm(np.cross(away, way), axis=-1) / np.linalg.norm(way)
    np.testing.assert_allclose(made, expected, rtol=1e-10)


def test_reflection_in_a_plane_is_the_householder_matrix() -> None:
    script = parse("""
        //#pragma algebra ega3
        n = 1*e1 + 2*e2 - 2*e3;
        v = x*e1 + y*e2 + z*e3;
        ?image = -n * v / n;
        //#pragma output image e1 e2 e3
    """)
    image = evaluate(script, x=0.3, y=-1.0, z=2.0)["image"]
    n, v = np.array([1.0, 2.0, -2.0]) / 3, np.array([0.3, -1.0, 2.0])
    assert image.blades == ("e1", "e2", "e3")
    np.testing.assert_allclose(image.values, v - 2 * (n @ v) * n, rtol=1e-12)


def test_a_motor_of_the_macros_turns_then_moves_as_the_right_hand_does() -> None:
    script = parse("""
        M = TranslatorN3(1, 2, 3) * RotorN3(0, 0, 5, angle);
        ?image = M * VecN3(x, 0, 0) * ~M;
    """)
    image = evaluate(script, angle=np.pi / 2, x=2.0)["image"]
    found = numbers(image, "e1 e2 e3 e0 einf")
    np.testing.assert_allclose(found, [1, 4, 3, 1, 0.5 * 26], atol=1e-12)


def test_the_macros_have_their_published_meaning() -> None:
    script = parse("""
        ?point = createPoint(1, 2, 3); ?vector = VecN3(1, 2, 3);
        ?sphere = SphereN3(point, 2); ?same = SphereN3(1, 2, 3, 2);
        ?dual = Dual(vector); ?unit = normalize(3*e1 + 4*e2);
    """)
    made = evaluate(script)
    assert numbers(made["point"], "e1 e2 e3 e0 einf") == [1, 2, 3, 1, 7]
    assert made["point"].items() == made["vector"].items()
    inner = cga.sphere((1, 2, 3), 2.0)
    for name in ("sphere", "same"):
        assert max(abs(v) for v in (made[name] - inner.dual()).values) == 0.0
    by_hand = CGA3.vector([1, 2, 3, 1, 7]) * CGA3.multivector({"e1^e2^e3^einf^e0": -1.0})
    assert max(abs(v) for v in (made["dual"] - by_hand).values) == 0.0
    np.testing.assert_allclose(numbers(made["unit"], "e1 e2"), [0.6, 0.8], rtol=1e-15)


@pytest.mark.parametrize("text", [CIRCLE, "?x = fact(3)*sin(ax) + exp(ay)/(r*e1 + ax*e2 + 3);"])
def test_batches_and_symbols_mean_what_numbers_mean(text: str) -> None:
    ca = pytest.importorskip("casadi")
    rng, script = np.random.default_rng(8), parse(text)
    batch = {name: rng.uniform(0.5, 2, 6) for name in ("ax", "ay", "r")}
    symbols = {name: ca.SX.sym(name) for name in batch}
    whole, symbolic = evaluate(script, **batch), evaluate(script, **symbols)
    for k in range(6):
        at = {name: float(values[k]) for name, values in batch.items()}
        for name, x in evaluate(script, **at).items():
            for blade, value in x.items():
                row = np.broadcast_to(whole[name].coefficient(blade), (6,))[k]
                made = ca.SX(symbolic[name].coefficient(blade))
                number = float(ca.Function("f", list(symbols.values()), [made])(*at.values()))
                assert row == pytest.approx(value, rel=1e-11, abs=1e-11)
                assert number == pytest.approx(value, rel=1e-11, abs=1e-11)


def test_float32_batches_stay_float32() -> None:
    x = np.linspace(0, 1, 4, dtype=np.float32)
    made = evaluate(parse("?y = sin(0.5)*x + sqrt(2)*abs(3*e1 + 4*e2)*cos(x);"), x=x)
    assert made["y"].scalar_part().dtype == np.float32


def test_outputs_come_in_the_order_of_the_script_with_the_value_at_the_mark() -> None:
    script = parse("""
        //#pragma output w e1 e2^e1
        //#pragma return v
        ?z = 1; ?a = 2; z = 3; b = z; ?b; ; !b; :b;
        w = e1 + 2*e2 + 3*e1^e2; v = 4;
    """)
    made = evaluate(script)
    assert list(made) == ["z", "a", "b", "w", "v"]
    assert [made[name].scalar_part() for name in "zab"] == [1.0, 2.0, 3.0]
    assert made["w"].items() == (("e1", 1.0), ("e1^e2", 3.0))


def test_the_range_of_a_variable_is_kept() -> None:
    script = parse("//#pragma range -1 <= t <= 1.5\n?x = t;")
    assert evaluate(script, t=1.5)["x"].scalar_part() == 1.5
    with pytest.raises(ScriptError, match="got values from 0 to 2"):
        evaluate(script, t=np.array([0.0, 2.0]))


@pytest.mark.parametrize(
    ("written", "algebra"),
    [("ega3", EGA3), ("pga3", PGA3), ("CGA3", CGA3), ("2 3 0", Algebra(2, 3))],
)
def test_the_algebra_is_the_scripts(written: str, algebra: Algebra) -> None:
    script = parse(f"//#pragma algebra {written}\n?x = e1*e2;")
    assert evaluate(script)["x"].algebra == algebra
    with pytest.raises(ScriptError, match="expected one algebra"):
        evaluate(script, algebra=Algebra(4))


def test_any_invertible_multivector_divides() -> None:
    made = evaluate(parse("a = 1 + 2*e1 + 3*e1^e2 + e0 - e3^einf; ?x = (e2 + 4)/a; ?y = x*a;"))
    rest = made["y"] - CGA3.multivector({"1": 4, "e2": 1})
    assert max(abs(v) for v in rest.values) < 1e-11


def test_macros_share_a_name_by_their_number_of_arguments() -> None:
    made = evaluate(parse("f = { _P(1)*2 } f = { f(_P(1)) + _P(2); } ?x = f(3, f(1));"))
    assert made["x"].scalar_part() == 8.0


def test_a_macro_reads_the_scripts_names_and_keeps_its_own() -> None:
    made = evaluate(
        parse("k = 5; f = { j = k + _P(1); k = 1; j + k } ?x = f(1); ?k; k = 7; ?y = f(1);")
    )
    assert [made[name].scalar_part() for name in "xky"] == [7.0, 5.0, 9.0]


def test_a_macro_that_replaces_one_of_ours_can_call_it() -> None:
    made = evaluate(parse("VecN3 = { 2*VecN3(_P(1), _P(2), _P(3)) } ?x = VecN3(1, 2, 3);"))
    assert numbers(made["x"], "e1 e2 e3 e0 einf") == [2, 4, 6, 2, 14]
    inner = evaluate(parse("VecN3 = { _P(1) + _P(2) + _P(3) } ?x = createPoint(1, 2, 3);"))
    assert numbers(inner["x"], "e1 e2 e3 e0 einf") == [1, 2, 3, 1, 7]


LEGACY = """
DefVarsN3();
:IPNS
:Red; _BGColor = White; :Color(0.5f, 0, .25d);
point = { !x = 2.0f*_P(1); :y = x; VecN3(x, y, 1e0d) }
:a = point(1); :a; :a^einf; :OPNS;
?b = a;
"""


def test_what_clucalc_writes_for_the_screen_changes_nothing() -> None:
    b = evaluate(parse(LEGACY))["b"]
    assert numbers(b, "e1 e2 e3 e0 einf") == [2, 2, 1, 1, 4.5]
    assert evaluate(parse("DefVarsE3(); ?x = e1*e2;"))["x"].algebra == EGA3
    with pytest.raises(ScriptError, match="expected one algebra"):
        evaluate(parse(LEGACY), algebra=EGA3)


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("sign(0 - 2)", -1),
        ("sign(0)", 0),
        ("sign(3)", 1),
        ("step(0 - 2)", 0),
        ("step(0)", 1),
        ("step(3)", 1),
        ("min(2, 1)", 1),
        ("max(2, 1)", 2),
        ("atan2(1, 0 - 1)", 0.75 * np.pi),
    ],
)
def test_values_are_chosen_without_branches(written: str, value: float) -> None:
    ca = pytest.importorskip("casadi")
    assert evaluate(parse(f"?x = {written};"))["x"].scalar_part() == pytest.approx(value)
    t = ca.SX.sym("t")
    made = evaluate(parse(f"?x = {written.replace('(', '(t+', 1)};"), t=t)["x"].scalar_part()
    assert float(ca.Function("f", [t], [made])(0.0)) == pytest.approx(value)
    batch = evaluate(parse(f"?x = {written.replace('(', '(t+', 1)};"), t=np.zeros(3))["x"]
    np.testing.assert_allclose(batch.scalar_part(), [value] * 3)


def test_complements_need_no_metric() -> None:
    made = evaluate(
        parse("""
        //#pragma algebra pga3
        join = { uncomplement(complement(_P(1)) ^ complement(_P(2))) }
        point = { e1^e2^e3 + e0^(_P(1)*e2^e3 + _P(2)*e3^e1 + _P(3)*e1^e2) }
        ?line = join(point(1, 2, 3), point(1, 2, 4));
    """)
    )
    line = made["line"]
    again = PGA3.multivector({"e1^e2^e3": 1, "e0^e2^e3": 1, "e0^e3^e1": 2, "e0^e1^e2": 3})
    assert line.grades == (2,)
    assert max((abs(v) for v in (line ^ (PGA3.blade("e0") * 1.0)).values), default=0.0) == 1.0
    assert max((abs(v) for v in (again & line).values), default=0.0) == 0.0


def test_log_exp_and_sqrt_of_multivectors() -> None:
    made = evaluate(
        parse("""
        B = 0.3*e1^e2 - 0.2*e2^e3 + e1^einf + t*e0^einf;
        ?M = exp(B); ?back = log(M) - B; ?R = sqrt(M); ?same = R*R - M;
        ?near = versor(5*M) - M; ?unit = abs(normalize(3*M));
    """),
        t=0.5,
    )
    for name in ("back", "same", "near"):
        assert max(abs(v) for v in made[name].values) < 1e-14
    assert made["unit"].scalar_part() == pytest.approx(1.0, abs=1e-15)


def test_rounding_beside_a_scalar_is_measured_by_the_batch() -> None:
    script = parse("?angle = acos(x + left*e1^e2);")
    cosines = np.array([1.0, 0.5, 1e-17])
    made = evaluate(script, x=cosines, left=np.full(3, 1e-16))
    np.testing.assert_allclose(made["angle"].scalar_part(), np.arccos(cosines), atol=1e-15)
    with pytest.raises(ScriptError, match="expected a scalar, got a multivector with"):
        evaluate(script, x=cosines, left=np.array([0.0, 0.0, 1e-11]))
