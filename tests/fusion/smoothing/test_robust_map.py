"""The most probable path: gtsam's on the same graph, and unmoved by poses that are thrown off."""

import sys
from typing import Any

import numpy as np
import pytest

from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian, Outliers, PlanarFlips
from motorcade.fusion.smoothing import REPRESENTATIONS, smooth
from motorcade.fusion.smoothing.batch.inliers import Problem, Sizes, bridged, inlier_poses
from motorcade.fusion.smoothing.batch.robust_map import estimate_path, parts
from motorcade.ga import Motor, Similarity, Trajectory
from motorcade.ga.arrays import FloatArray

NOISE = Gaussian(0.005, np.deg2rad(0.5))
MODEL = {
    "noise_m": 0.005,
    "noise_rad": np.deg2rad(0.5),
    "acceleration_m_s2": 0.3,
    "angular_acceleration_rad_s2": 0.6,
}

SIZES = Sizes(MODEL["noise_rad"], 0.6), Sizes(MODEL["noise_m"], 0.3)


def measured(
    name: str, rng: np.random.Generator, outliers: bool = True, duration_s: float = 10.0
) -> tuple[Trajectory, Trajectory, Trajectory]:
    """The ground truth, and it with noise, and with wrong poses besides."""
    truth = MOTIONS[name].sampled(30.0, duration_s)
    noisy = NOISE.apply(truth, rng)
    if not outliers:
        return truth, noisy, noisy
    thrown = Outliers(0.05, 0.3, 0.5).apply(noisy, rng)
    return truth, noisy, PlanarFlips(0.02).apply(thrown, rng)


def errors(found: Trajectory, truth: Trajectory) -> FloatArray:
    between = found.poses.inverse() @ truth.poses
    shift = np.linalg.norm(found.poses.translation_m - truth.poses.translation_m, axis=1)
    turn = np.linalg.norm(between.rotor.as_rotation_vector(), axis=1)
    return np.sqrt(np.mean(np.stack([shift, turn]) ** 2, axis=1))


@pytest.mark.parametrize("name", REPRESENTATIONS)
@pytest.mark.parametrize("scaled", [False, True], ids=["rigid", "scaled"])
def test_derivatives_are_those_of_small_moves(
    name: str, scaled: bool, rng: np.random.Generator
) -> None:
    representation = REPRESENTATIONS[name]
    base: Any = Motor.random(rng, (40,))
    target: Any = base @ Motor.from_twist(rng.standard_normal((40, 6)))
    if scaled:
        base, target = (
            Similarity.from_motor_scale(m, np.exp(0.3 * rng.standard_normal(40)))
            for m in (base, target)
        )
    x, y = representation.coordinates(base), representation.coordinates(target)
    vector = representation.local(y, x)
    by_base, by_target = representation.local_jacobians(vector)
    if name not in ("motor", "rotor", "similarity"):
        return  # plain components are not moved along a curve: the derivative is 1
    for k in range(vector.shape[1]):
        move = 1e-5 * np.eye(vector.shape[1])[k]
        for by, pair in (
            (by_target, lambda m: (representation.retract(y, m), x)),
            (by_base, lambda m: (y, representation.retract(x, m))),
        ):
            ahead, back = (representation.local(*pair(m)) for m in (move, -move))
            np.testing.assert_allclose(by[:, :, k], (ahead - back) / 2e-5, atol=1e-7)


def twist_of(pose: Any) -> FloatArray:
    return Motor.from_matrix(pose.matrix()).as_twist()


@pytest.mark.parametrize("loss", ["squares", "huber", "cauchy"])
def test_the_path_is_gtsams_on_the_same_graph(loss: str, rng: np.random.Generator) -> None:
    gtsam = pytest.importorskip("gtsam")
    count = 25
    _, _, path = measured("handheld", rng, outliers=False, duration_s=(count - 1) / 30.0)
    path = path[np.sort(rng.choice(count, 20, replace=False))]
    wrong = Motor.from_twist(np.array([0.5, 0.0, 0.2, 0.3, -0.2, 0.1]))
    poses = [
        p @ wrong if i in (7, 13) and loss != "squares" else p for i, p in enumerate(path.poses)
    ]
    path = Trajectory(path.time_ns, Motor.stack(poses))
    ours = estimate_path(path, **MODEL, loss=loss)

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    noise = gtsam.noiseModel.Diagonal.Sigmas(np.repeat([MODEL["noise_rad"], MODEL["noise_m"]], 3))
    kinds = gtsam.noiseModel.mEstimator
    if loss != "squares":
        kind = kinds.Huber if loss == "huber" else kinds.Cauchy
        noise = gtsam.noiseModel.Robust.Create(kind.Create(3.5), noise)
    for i in range(20):
        pose = gtsam.Pose3(path.poses[i].as_matrix())
        values.insert(i, gtsam.Pose3(ours.trajectory.poses[i].as_matrix()))
        values.insert(100 + i, ours.velocity[i] + 0.001)
        graph.add(gtsam.PriorFactorPose3(i, pose, noise))
    interval = np.diff(path.time_s)
    density = np.repeat([MODEL["angular_acceleration_rad_s2"], MODEL["acceleration_m_s2"]], 3)
    for i, dt in enumerate(interval):
        q = np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.diag(density**2))
        model = gtsam.noiseModel.Gaussian.Covariance(q)

        def error(factor: Any, at: Any, jacobians: Any, i: int = i, dt: float = dt) -> FloatArray:
            here, there = at.atPose3(i), at.atPose3(i + 1)
            v, w = at.atVector(100 + i), at.atVector(101 + i)
            step = here.between(there)
            twist = gtsam.Pose3.Logmap(step)
            if jacobians is not None:
                by_last = gtsam.Pose3.LogmapDerivative(step)
                by_first = -by_last @ step.inverse().AdjointMap()
                zero, one = np.zeros((6, 6)), np.eye(6)
                parts = ((by_first, zero), (by_last, zero), (-dt * one, -one), (zero, one))
                for k, part in enumerate(parts):
                    jacobians[k] = np.asfortranarray(np.vstack(part))
            return np.concatenate([twist - dt * v, w - v])

        keys = [i, i + 1, 100 + i, 101 + i]
        graph.add(gtsam.CustomFactor(model, keys, error))
    settings = gtsam.LevenbergMarquardtParams()
    settings.setRelativeErrorTol(1e-15)
    settings.setAbsoluteErrorTol(1e-15)
    settings.setMaxIterations(200)
    best = gtsam.LevenbergMarquardtOptimizer(graph, values, settings).optimize()
    theirs = Motor.from_matrix(np.stack([best.atPose3(i).matrix() for i in range(20)]))
    apart = (theirs.inverse() @ ours.trajectory.poses).as_twist()
    assert np.abs(apart).max() < 1e-6
    velocity = np.stack([best.atVector(100 + i) for i in range(20)])
    np.testing.assert_allclose(ours.velocity, velocity, atol=1e-4)
    if loss == "cauchy":
        assert np.flatnonzero(ours.rejected).tolist() == [7, 13]


@pytest.mark.parametrize("name", ["gimbal_hover", "screw", "tumble", "walk_and_look", "handheld"])
def test_wrong_poses_do_no_more_harm_than_missing_ones(name: str, rng: np.random.Generator) -> None:
    truth, noisy, degraded = measured(name, rng)
    wrong = np.linalg.norm((noisy.poses.inverse() @ degraded.poses).as_twist(), axis=1) > 0.3
    assert 5 < np.count_nonzero(wrong) < 80
    found = estimate_path(degraded, **MODEL)
    assert np.all(found.rejected[wrong])
    assert np.count_nonzero(found.rejected[~wrong]) < 8
    clean = errors(estimate_path(noisy, **MODEL).trajectory, truth)
    assert np.all(errors(found.trajectory, truth) < 1.3 * clean)
    assert np.all(errors(smooth(degraded, "gaussian", sigma_s=0.1), truth) > 3.0 * clean)


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_every_representation_sheds_outliers(representation: str, rng: np.random.Generator) -> None:
    truth, noisy, degraded = measured("antipodal_crossing", rng, duration_s=6.0)
    found = estimate_path(degraded, representation, **MODEL)
    clean = estimate_path(noisy, representation, **MODEL)
    if representation == "euler":
        return  # angles leap where they are wrapped; that it ends is all there is to say
    assert np.all(errors(found.trajectory, truth) < 1.5 * errors(clean.trajectory, truth))


def test_similarities_keep_their_scale(rng: np.random.Generator) -> None:
    truth = MOTIONS["zoom"].sampled(30.0, 5.0)
    noisy = Gaussian(0.005, 0.01, 0.01).apply(truth, rng)
    degraded = Outliers(0.05, 0.3, 0.5).apply(noisy, rng)
    for representation in ("similarity", "motor"):
        found = smooth(degraded, "robust_map", representation, noise_scale=0.01)
        assert isinstance(found.poses, Similarity)
        error = np.log(found.poses.scale / truth.poses.scale)
        raw = np.log(degraded.poses.scale / truth.poses.scale)
        assert np.sqrt(np.mean(error**2)) < 0.8 * np.sqrt(np.mean(raw**2))


def test_a_run_of_wrong_poses_is_left_out_and_a_long_path_is_kept(
    rng: np.random.Generator,
) -> None:
    _, noisy, _ = measured("tumble", rng)
    sizes = Sizes(MODEL["noise_rad"], 1.0), Sizes(MODEL["noise_m"], 1.0)
    assert np.all(inlier_poses(noisy.time_s, noisy.poses, *sizes))
    thrown = np.array(noisy.poses.coefficients)
    thrown[100:115] = (noisy.poses[100:115] @ Motor.from_twist([0.8, 0, 0, 0, 0.5, 0])).coefficients
    kept = inlier_poses(noisy.time_s, Motor(thrown), *sizes)
    assert np.flatnonzero(~kept).tolist() == list(range(100, 115))


def test_gaps_may_hold_whole_turns() -> None:
    time_s = np.arange(60) / 30.0
    spin = Motor.from_twist(np.outer(time_s, [0.0, 0.0, 20.0, 0.1, 0.0, 0.2]))
    kept = np.ones(60, dtype=np.bool_)
    kept[20:40] = kept[0] = kept[59] = False
    found = bridged(time_s, spin, kept)
    apart = (found.inverse() @ spin).as_twist()[1:-1]
    assert np.abs(apart).max() < 1e-9


def test_weights_fall_with_the_distance(rng: np.random.Generator) -> None:
    _, _, degraded = measured("screw", rng)
    found = estimate_path(degraded, **MODEL)
    order = np.argsort(found.normalised_residual)
    assert np.all(np.diff(found.weight[order]) <= 0.0)
    assert found.weight.max() <= 1.0


def test_motors_do_not_notice_in_which_world_they_are_written(rng: np.random.Generator) -> None:
    _, _, degraded = measured("handheld", rng, duration_s=4.0)
    found = estimate_path(degraded, **MODEL).trajectory
    change = Motor.random(rng, extent_m=3.0)
    moved = estimate_path(degraded.transformed_by(left=change), **MODEL).trajectory
    apart = (moved.poses.inverse() @ found.transformed_by(left=change).poses).as_twist()
    assert np.abs(apart).max() < 1e-6


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"loss": "tukey"}, r"loss: expected one of cauchy, huber, squares, got 'tukey'"),
        ({"noise_m": 0.0}, "noise_m: expected a positive number"),
        ({"width": -1.0}, "width: expected a positive number"),
        ({"acceleration_m_s2": float("inf")}, "acceleration_m_s2: expected a positive number"),
    ],
)
def test_bad_settings_are_refused(settings: dict[str, Any], message: str) -> None:
    path = MOTIONS["screw"].sampled(30.0, 1.0)
    with pytest.raises(ValueError, match=message):
        smooth(path, "robust_map", **settings)
    with pytest.raises(ValueError, match="at least 2 poses, got 1"):
        smooth(path[:1], "robust_map")


@pytest.mark.parametrize("loss", ["squares", "huber", "cauchy"])
@pytest.mark.parametrize("name", ["motor", "similarity", "rotor", "euler_unwrapped"])
@pytest.mark.parametrize("scaled", [False, True], ids=["rigid", "scaled"])
def test_no_small_move_is_charged_less(
    name: str, loss: str, scaled: bool, rng: np.random.Generator
) -> None:
    path = measured("antipodal_crossing", rng, duration_s=0.5)[2]
    poses: Any = path.poses
    if scaled:
        poses = Similarity.from_motor_scale(poses, np.exp(0.01 * rng.standard_normal(len(path))))
    everyone = np.ones(len(path), dtype=np.bool_)
    problem = Problem(
        REPRESENTATIONS[name], path.time_s, poses, everyone, (*SIZES, Sizes(0.01, 0.5))
    )
    found = problem.descended(problem.narrowed(loss, 3.5), loss, 3.5, everyone, 60)
    d = found.state.velocity.shape[1]
    for row in range(0, len(path), 3):
        for k in range(2 * d):
            move = np.zeros((len(path), 2 * d))
            move[row, k] = 1e-5
            ahead, back = (
                problem.charged(problem.retract(found.state, by), loss, 3.5, everyone).cost
                for by in (move, -move)
            )
            bend = ahead + back - 2.0 * found.cost
            assert bend > 0.0
            assert abs(ahead - back) < 0.02 * bend + 1e-9 * found.cost


def test_nothing_but_numpy_is_needed(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    for absent in ("scipy", "scipy.linalg", "scipy.optimize", "casadi"):
        monkeypatch.setitem(sys.modules, absent, None)
    plain = MOTIONS["screw"].sampled(30.0, 1.0)
    assert len(smooth(plain, "robust_map")) == 31
    flipped = PlanarFlips(0.2, 6.0).apply(Gaussian(0.005, 0.01).apply(plain, rng), rng)
    assert len(smooth(flipped, "robust_map")) == len(smooth(flipped)) == 31


# Components are put back onto the sphere after each step, and settle less sharply.
@pytest.mark.parametrize(("representation", "close"), [("motor", 1e-6), ("quaternion", 1e-5)])
def test_parts_of_a_long_path_are_what_the_whole_is(
    representation: str, close: float, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, _, degraded = measured("handheld", rng, duration_s=15.0)
    whole = estimate_path(degraded, representation, **MODEL)
    monkeypatch.setitem(parts.__globals__, "_FEWEST_KEPT", 150)
    monkeypatch.setitem(parts.__globals__, "_REJECTED_POSES", 40)
    cut = list(parts(degraded.time_s, SIZES))
    assert len(cut) == 2
    assert [row for part in cut for row in range(451)[part.rows][part.kept]] == list(range(451))
    joined = estimate_path(degraded, representation, **MODEL)
    apart = (whole.trajectory.poses.inverse() @ joined.trajectory.poses).as_twist()
    assert np.abs(apart).max() < close
    np.testing.assert_allclose(joined.velocity, whole.velocity, atol=1e3 * close)
    np.testing.assert_array_equal(joined.mirrored, whole.mirrored)
    np.testing.assert_allclose(joined.weight, whole.weight, atol=20.0 * close)
