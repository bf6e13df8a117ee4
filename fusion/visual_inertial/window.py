"""`InertialAdjuster`: keyframes and points of visual SLAM, adjusted with an IMU's samples.

Between two keyframes in a row stands what the samples add up to; each keyframe has a velocity and
biases besides its pose. Points are eliminated as they are without an IMU. Keyframes that stay fixed
keep their velocity and biases too; where that is the first one alone, its place and heading are
held and the rest is free, so that gravity may lean the map and accelerations scale it.

Sources: C. Forster et al., IEEE TRO 33(1), 2017 (the factor); R. Mur-Artal, J. Tardós,
Visual-inertial monocular SLAM with map reuse, IEEE RA-L 2(2), 2017 (the local adjustment).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from motorcade.fusion.filter.extended_pose import extended_pose
from motorcade.fusion.filter.settings import VELOCITY_SIGMA_M_S
from motorcade.fusion.imu.noise import ACCEL_BIAS_SIGMA_M_S2, GYRO_BIAS_SIGMA_RAD_S, ImuNoise
from motorcade.fusion.imu.stream import ImuStream
from motorcade.fusion.measurements.interface import skew
from motorcade.fusion.preintegration import Preintegrated, preintegrate
from motorcade.fusion.visual_inertial.readout import Readout, camera_twist_rate, rows_moved_px
from motorcade.ga import Motor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.ga.stamps import LONGEST_BRIDGE_S
from motorcade.tracking.optimise import BlockEquations, Stop, minimise
from motorcade.tracking.slam.mapping.adjustment import AdjustedBundle, Bundle, BundleReprojection

_GAIN = 1e-4
_HELD_SIGMA = 1e-5
_TILT_SIGMA_RAD = 0.3


@dataclass(frozen=True, eq=False)
class KeyframeMotion:
    """What is known of a keyframe besides its pose.

    Fields:
        velocity_m_s: ``(3,)`` of the IMU in the world.
        bias: ``(6,)`` of gyroscope (rad/s) and accelerometer (m/s²).

    >>> import numpy as np
    >>> from motorcade.fusion.visual_inertial.window import KeyframeMotion
    >>> KeyframeMotion(np.array([0.2, 0.0, 0.0]), np.zeros(6)).velocity_m_s
    array([0.2, 0. , 0. ])
    """

    velocity_m_s: FloatArray
    bias: FloatArray


_AT_REST = KeyframeMotion(np.zeros(3), np.zeros(6))


@dataclass(frozen=True, eq=False)
class _State:
    """Poses and points as the bundle has them; velocities ``(k, 3)`` and biases ``(k, 6)``."""

    world_T_camera: Motor
    points: FloatArray
    velocity_m_s: FloatArray
    bias: FloatArray


class InertialAdjuster:
    """Adjusts bundles of keyframes by pixels and inertial samples, and remembers their motion.

    Args:
        noise: the IMU's.
        imu_T_camera: pose of the camera on the IMU.
        gravity_m_s2: size of gravity, along -z of the world.
        sigma_px: noise of a pixel's coordinate.
        readout: of a rolling shutter; None for a global one.

    Fields:
        samples: of the IMU so far; they must cover the keyframes.
        motions: of each keyframe that was adjusted or that was told, by its stamp.
    """

    def __init__(
        self,
        noise: ImuNoise,
        imu_T_camera: Motor,
        gravity_m_s2: float,
        sigma_px: float,
        readout: Readout | None = None,
    ) -> None:
        self.readout = readout
        self.noise = noise
        self.imu_T_camera = imu_T_camera
        self.gravity_m_s2 = np.array([0.0, 0.0, -gravity_m_s2])
        self.sigma_px = sigma_px
        self.samples = GrowingImu()
        self.motions: dict[int, KeyframeMotion] = {}

    def __call__(self, bundle: Bundle, time_ns: IntArray, iterations: int) -> AdjustedBundle:
        """Minimise pixels and motion over poses, points, velocities and biases.

        Args:
            bundle: poses and points.
            time_ns: ``(k,)`` stamps of the poses.
            iterations: steps at most.
        """
        if np.count_nonzero(bundle.fixed) <= 1 and np.argmin(time_ns) == 0:
            bundle = replace(bundle, fixed=np.zeros_like(bundle.fixed))
        chain = _chained(bundle, time_ns)
        for row in chain:
            self.motions[int(time_ns[row])] = self._motion(bundle, time_ns, int(row), chain)
        motions = [self.motions.get(stamp, _AT_REST) for stamp in time_ns.tolist()]
        velocity = np.stack([motion.velocity_m_s for motion in motions])
        bias = np.stack([motion.bias for motion in motions])
        problem = _Problem(self, bundle, time_ns, chain, bias)
        start = _State(bundle.world_T_camera, bundle.points, velocity, bias)
        minimum = minimise(start, problem.evaluated, problem.retracted, Stop(iterations, _GAIN))
        state, end = minimum.state, minimum.evaluation
        for row in np.flatnonzero(~bundle.fixed):
            motion = KeyframeMotion(state.velocity_m_s[row], state.bias[row])
            self.motions[int(time_ns[row])] = motion
        return AdjustedBundle(
            state.world_T_camera, state.points, end.error_px, end.cost, minimum.start_cost
        )

    def _motion(
        self, bundle: Bundle, time_ns: IntArray, row: int, chain: IntArray
    ) -> KeyframeMotion:
        """What is known of a keyframe, or what the one before it and the samples say.

        Without either it is taken to be at rest; the adjustment finds how it moves.
        """
        known = self.motions.get(int(time_ns[row]))
        if known is not None:
            return known
        place = int(np.searchsorted(chain, row))
        if place == 0:
            return _AT_REST
        before = int(chain[place - 1])
        last = self.motions[int(time_ns[before])]
        span = time_ns[[before, row]]
        imu = self.samples.around(span)
        if len(bridged(imu.time_ns, span)) > 1:
            return KeyframeMotion(np.zeros(3), last.bias)
        summed = preintegrate(imu, span, self.noise, last.bias[:3], last.bias[3:])
        pose = bundle.world_T_camera[[before]] @ self.imu_T_camera.inverse()
        _, velocity = summed.propagate(pose, last.velocity_m_s, self.gravity_m_s2)
        return KeyframeMotion(velocity[0], last.bias)


def _chained(bundle: Bundle, time_ns: IntArray) -> IntArray:
    """Rows in order of time: those that are free, and the fixed one just before them."""
    free = np.flatnonzero(~bundle.fixed)
    earlier = np.flatnonzero(bundle.fixed & (time_ns < time_ns[free].min()))
    if len(earlier):
        free = np.append(free, earlier[np.argmax(time_ns[earlier])])
    return free[np.argsort(time_ns[free])]


class _Problem:
    """One adjustment: what does not change from step to step."""

    def __init__(
        self,
        adjuster: InertialAdjuster,
        bundle: Bundle,
        time_ns: IntArray,
        chain: IntArray,
        bias: FloatArray,
    ) -> None:
        self.bundle, self.chain = bundle, chain
        self.gravity_m_s2 = adjuster.gravity_m_s2
        self.camera_T_imu = adjuster.imu_T_camera.inverse()
        self.by_camera = adjuster.imu_T_camera.adjoint()
        imu = adjuster.samples.around(time_ns[chain])
        runs = [chain[run] for run in bridged(imu.time_ns, time_ns[chain])]
        # Rows of the bundle before and after each link.
        self.one = np.concatenate([run[:-1] for run in runs])
        self.other = np.concatenate([run[1:] for run in runs])
        self.summed = summed_links(
            imu, adjuster.noise, [time_ns[run] for run in runs], [bias[run] for run in runs]
        )
        # Pixels count as they are; what the IMU says is weighed against them.
        self.information = adjuster.sigma_px**2 * np.linalg.inv(self.summed.covariance)
        self.free = np.flatnonzero(~bundle.fixed)
        self.slot = np.full(len(time_ns), -1)
        self.slot[self.free] = np.arange(len(self.free))
        self.prior = _Prior.of(self, adjuster.sigma_px)
        self.later_s: FloatArray | None = None
        if adjuster.readout is not None:
            self.later_s = adjuster.readout.later_s(bundle.px)
            self.rate_rad_s = adjuster.samples.rates_at(time_ns)

    def evaluated(self, state: _State) -> _Evaluated:
        return _Evaluated(self, state)

    def retracted(self, state: _State, step: tuple[FloatArray, FloatArray]) -> _State:
        kept, points = step
        count = len(self.free)
        twists = np.zeros((len(self.slot), 6))
        twists[self.free] = kept[: 6 * count].reshape(-1, 6)
        rest = kept[6 * count :].reshape(-1, 9)
        velocity, bias = state.velocity_m_s.copy(), state.bias.copy()
        velocity[self.free] += rest[:, :3]
        bias[self.free] += rest[:, 3:]
        return _State(state.world_T_camera.retract(twists), state.points + points, velocity, bias)

    def columns(self, row: int) -> IntArray:
        """Where the fifteen numbers of a free pose stand: pose, velocity, biases."""
        slot = int(self.slot[row])
        rest = 6 * len(self.free) + 9 * slot
        return np.concatenate([np.arange(6 * slot, 6 * slot + 6), np.arange(rest, rest + 9)])


@dataclass(frozen=True, eq=False)
class _Prior:
    """What is known of the first pose of the chain, if it is free: place, heading, about its lean.

    Fields:
        row: of the bundle, -1 where the first pose is fixed.
        world_T_imu: about which pose.
        information: ``(15, 15)``, pose of the IMU, velocity, biases.
    """

    row: int
    world_T_imu: Motor
    information: FloatArray

    @classmethod
    def of(cls, problem: _Problem, sigma_px: float) -> _Prior:
        row = int(problem.chain[0])
        pose = problem.bundle.world_T_camera[row] @ problem.camera_T_imu
        if problem.bundle.fixed[row]:
            return cls(-1, pose, np.zeros((15, 15)))
        rest = VELOCITY_SIGMA_M_S, GYRO_BIAS_SIGMA_RAD_S, ACCEL_BIAS_SIGMA_M_S2
        spread = np.diag(np.repeat([0.0, 0.0, *rest], 3) ** 2)
        spread[:6, :6] = held_pose_covariance(pose)
        return cls(row, pose, sigma_px**2 * np.linalg.inv(spread))

    def residual(self, world_T_imu: Motor, velocity: FloatArray, bias: FloatArray) -> FloatArray:
        return np.concatenate([self.world_T_imu.local(world_T_imu), velocity, bias])


class _Evaluated:
    """Pixels and motion at one state."""

    def __init__(self, problem: _Problem, state: _State) -> None:
        self._problem, self._state = problem, state
        self._world_T_imu = state.world_T_camera @ problem.camera_T_imu
        self._seen = BundleReprojection(self._at_the_stamps(), (state.world_T_camera, state.points))
        self._residual = self._motion_residual()
        cost = np.einsum("ki,kij,kj->", self._residual, problem.information, self._residual)
        prior = problem.prior
        if prior.row >= 0:
            self._first = prior.residual(
                self._world_T_imu[prior.row], state.velocity_m_s[prior.row], state.bias[prior.row]
            )
            cost += self._first @ prior.information @ self._first
        self.cost = self._seen.cost + 0.5 * float(cost)

    @property
    def error_px(self) -> FloatArray:
        return self._seen.error_px

    def _at_the_stamps(self) -> Bundle:
        """The bundle with its pixels as a global shutter would have had them.

        How that depends on the state is left out of the derivatives: it is as much smaller than
        the rest as the readout is shorter than the motion.
        """
        problem, state = self._problem, self._state
        bundle = problem.bundle
        if problem.later_s is None:
            return bundle
        rate = problem.rate_rad_s - state.bias[:, :3]
        twist = camera_twist_rate(self._world_T_imu, state.velocity_m_s, rate, problem.camera_T_imu)
        seen = bundle.pose_of, state.points[bundle.point_of]
        moved = rows_moved_px(bundle.camera, problem.later_s, state.world_T_camera, twist, *seen)
        return replace(bundle, px=bundle.px - moved)

    def _motion_residual(self) -> FloatArray:
        """How far rotation, position, velocity and biases ``(m, 15)`` are from what was felt."""
        problem, state = self._problem, self._state
        bias, drift = state.bias[problem.one], state.bias[problem.other] - state.bias[problem.one]
        felt = problem.summed.with_biases(bias[:, :3], bias[:, 3:])
        self._gained = _gained(self._world_T_imu, state.velocity_m_s, problem)
        apart = felt.local(self._gained)
        return np.concatenate([apart[:, 0], apart[:, 1, 3:], drift], axis=-1)

    @cached_property
    def equations(self) -> _Equations:
        """Of free poses, points, velocities and biases."""
        problem, seen = self._problem, self._seen.equations
        size, poses = 15 * len(problem.free), 6 * len(problem.free)
        information, gradient = np.zeros((size, size)), np.zeros(size)
        information[:poses, :poses], gradient[:poses] = seen.information, seen.gradient
        before, after = self._derivatives()
        for k, (first, other) in enumerate(zip(problem.one, problem.other, strict=True)):
            parts = [
                (problem.columns(int(row)), by)
                for row, by in ((first, before[k]), (other, after[k]))
                if problem.slot[row] >= 0
            ]
            columns = np.concatenate([at for at, _ in parts])
            by = np.concatenate([by for _, by in parts], axis=1)
            weighed = by.T @ problem.information[k]
            information[np.ix_(columns, columns)] += weighed @ by
            gradient[columns] += weighed @ self._residual[k]
        if problem.prior.row >= 0:
            columns = problem.columns(problem.prior.row)
            by = np.eye(15)
            by[:6, :6] = problem.by_camera
            weighed = by.T @ problem.prior.information
            information[np.ix_(columns, columns)] += weighed @ by
            gradient[columns] += weighed @ self._first
        return _Equations(replace(seen, information=information, gradient=gradient))

    def _derivatives(self) -> tuple[FloatArray, FloatArray]:
        """Of the residuals ``(m, 15, 15)`` by the numbers of the pose before and of that after.

        To first order in the residuals, which are small: a step is checked by its cost.
        """
        problem = self._problem
        count = len(problem.one)
        dt = problem.summed.duration_s[:, None, None]
        back = np.swapaxes(self._world_T_imu[problem.one].rotor.as_matrix(), -1, -2)
        turned = np.swapaxes(self._gained[:, 0].rotor.as_matrix(), -1, -2)
        shift, speed = np.moveaxis(self._gained.translation_m, 1, 0)
        eye = np.eye(3)
        before, after = np.zeros((2, count, 15, 15))
        before[:, 0:3, 0:3] = -turned
        before[:, 3:6, 0:3] = turned @ skew(shift)
        before[:, 3:6, 3:6] = -turned
        before[:, 3:6, 6:9] = -turned @ back * dt
        before[:, 6:9, 0:3] = turned @ skew(speed)
        before[:, 6:9, 6:9] = -turned @ back
        before[:, :9, 9:] = -problem.summed.bias_jacobian
        before[:, 9:, 9:] = -np.eye(6)
        after[:, 0:3, 0:3] = after[:, 3:6, 3:6] = eye
        after[:, 6:9, 6:9] = turned @ back
        after[:, 9:, 9:] = np.eye(6)
        for by in (before, after):
            by[:, :, :6] = by[:, :, :6] @ problem.by_camera
        return before, after


@dataclass(frozen=True, eq=False)
class _Equations:
    blocks: BlockEquations

    def step(self, damping: float) -> tuple[FloatArray, FloatArray]:
        return self.blocks.solved(damping)


def _gained(world_T_imu: Motor, velocity_m_s: FloatArray, problem: _Problem) -> Motor:
    """What poses and velocities say the samples of each link should add up to, ``(m, 2)``."""
    dt, fall = problem.summed.duration_s[:, None], problem.gravity_m_s2
    start, end = world_T_imu[problem.one], world_T_imu[problem.other]
    speed = velocity_m_s[problem.one]
    shift = end.translation_m - start.translation_m - speed * dt - 0.5 * fall * dt**2
    gained = velocity_m_s[problem.other] - speed - fall * dt
    back = start.rotor.inverse()
    return extended_pose(back @ end.rotor, back.apply(shift), back.apply(gained))


_NO_LINKS = Preintegrated(
    np.zeros(0),
    Motor.identity((0, 2)),
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 15, 15)),
    np.zeros((0, 15, 15)),
)


def bridged(samples_ns: IntArray, keys_ns: IntArray) -> list[slice]:
    """Runs of keyframes between which samples are nowhere too far apart to be summed up."""
    wide = np.flatnonzero(np.diff(samples_ns) > LONGEST_BRIDGE_S * 1e9)
    spans = np.stack([samples_ns[wide], samples_ns[wide + 1]], axis=-1)
    # A link is broken by a gap that begins before its end and ends after its start.
    broken = (spans[:, :1] < keys_ns[1:]) & (spans[:, 1:] > keys_ns[:-1])
    edges = [0, *(np.flatnonzero(broken.any(axis=0)) + 1).tolist(), len(keys_ns)]
    return [slice(*edge) for edge in pairwise(edges)]


def summed_links(
    imu: ImuStream, noise: ImuNoise, stamps_ns: list[IntArray], biases: list[FloatArray]
) -> Preintegrated:
    """All links, about the mean of the biases at both ends."""
    parts = [_NO_LINKS]
    for keys_ns, bias in zip(stamps_ns, biases, strict=True):
        if len(keys_ns) > 1:
            mean = 0.5 * (bias[1:] + bias[:-1])
            parts.append(preintegrate(imu, keys_ns, noise, mean[:, :3], mean[:, 3:]))
    motion = np.concatenate([part.motion.coefficients for part in parts])
    rest = ("gyro_bias_rad_s", "accel_bias_m_s2", "transition", "covariance")
    return Preintegrated(
        np.concatenate([part.duration_s for part in parts]),
        Motor(motion),
        *(np.concatenate([getattr(part, name) for part in parts]) for name in rest),
    )


def held_pose_covariance(world_T_imu: Motor) -> FloatArray:
    """Of a first pose ``(6, 6)`` whose position and heading are held: what its tilt leaves free.

    The heading is the turn about the world's z in the IMU's axes.
    """
    up = world_T_imu.rotor.as_matrix()[2]
    covariance = np.diag(np.repeat([_TILT_SIGMA_RAD, _HELD_SIGMA], 3) ** 2)
    covariance[:3, :3] -= (_TILT_SIGMA_RAD**2 - _HELD_SIGMA**2) * np.outer(up, up)
    return covariance


class GrowingImu:
    """Samples in chunks; chunks of like length are joined, so that each is copied few times.

    >>> import numpy as np
    >>> from motorcade.fusion import ImuStream
    >>> from motorcade.fusion.visual_inertial.window import GrowingImu
    >>> still, samples = np.zeros((4, 3)), GrowingImu()
    >>> for start in (0, 4):
    ...     samples.add(ImuStream(5_000_000 * np.arange(start, start + 4), still, still))
    >>> samples.last_ns, len(samples.between(0, 25_000_000))
    (35000000, 8)
    """

    def __init__(self) -> None:
        self._chunks: list[ImuStream] = []

    def add(self, samples: ImuStream) -> None:
        """Take samples after those before.

        Raises:
            ValueError: samples that do not come after those before.
        """
        if self._chunks and samples.time_ns[0] <= self.last_ns:
            raise ValueError(
                f"samples: expected stamps after {self.last_ns}, got {samples.time_ns[0]}"
            )
        self._chunks.append(samples)
        while len(self._chunks) > 1 and len(self._chunks[-2]) <= 2 * len(self._chunks[-1]):
            self._chunks[-2:] = [_joined(self._chunks[-2:])]

    @property
    def first_ns(self) -> int:
        """Stamp of the first sample.

        Raises:
            ValueError: no samples so far. So `all` and `between`.
        """
        return int(self._some()[0].time_ns[0])

    @property
    def last_ns(self) -> int:
        """Stamp of the last sample; -1 without any."""
        return int(self._chunks[-1].time_ns[-1]) if self._chunks else -1

    def all(self) -> ImuStream:
        """Everything so far."""
        self._chunks = [_joined(self._some())]
        return self._chunks[0]

    def between(self, first_ns: int, last_ns: int) -> ImuStream:
        """Samples that cover a span, and more."""
        starts = [int(chunk.time_ns[0]) for chunk in self._some()]
        first = max(int(np.searchsorted(starts, first_ns, side="right")) - 1, 0)
        last = int(np.searchsorted(starts, last_ns, side="right"))
        return _joined(self._chunks[first : last + 1])

    def rates_at(self, time_ns: IntArray) -> FloatArray:
        """Angular rates ``(k, 3)``, rad/s, at two stamps ``(k,)`` or more in any order."""
        rising, place = np.unique(time_ns, return_inverse=True)
        return self.around(rising).at(rising).angular_rate_rad_s[place]

    def around(self, time_ns: IntArray) -> ImuStream:
        """Samples that cover stamps ``(k,)``, and more."""
        return self.between(int(time_ns.min()), int(time_ns.max()))

    def _some(self) -> list[ImuStream]:
        if not self._chunks:
            raise ValueError("GrowingImu: expected samples, got none")
        return self._chunks


def _joined(chunks: list[ImuStream]) -> ImuStream:
    if len(chunks) == 1:
        return chunks[0]
    return ImuStream(
        np.concatenate([one.time_ns for one in chunks]),
        np.concatenate([one.angular_rate_rad_s for one in chunks]),
        np.concatenate([one.specific_force_m_s2 for one in chunks]),
    )
