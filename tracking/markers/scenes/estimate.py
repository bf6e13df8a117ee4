"""Where markers, cameras and bodies were, by all that was stated, measured and seen of them.

Whether what was stated of a scene agrees with what was seen of it.

Nothing here needs a ground truth. What no observation speaks of is called unknown: one marker alone
tells nothing of its size, and a rig that turns about one axis little of where its odometry sits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorcade.ga import Motor, Rotor
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.tracking.audit import AuditFinding, Verdict
from motorcade.tracking.markers.corner_stream import CornerStream
from motorcade.tracking.markers.families import marker_points_m
from motorcade.tracking.markers.scenes.graph import adjust_scene
from motorcade.tracking.markers.scenes.mapped import MappedScene
from motorcade.tracking.markers.scenes.scene import BodyOdometry, MarkerScene
from motorcade.tracking.markers.scenes.start import Start, stated_rows
from motorcade.tracking.markers.scenes.table import (
    BODY,
    CAMERA,
    CARRIER,
    MARKER,
    SceneObservations,
    gather_scene,
)
from motorcade.tracking.pose import TrackingError

_GATE = 37.7
"""χ² with six degrees of freedom exceeds it once in a million: there are thousands of markers."""
_UNMOVED = 1e-6
"""χ² up to which nothing that was seen pulls at a stated pose: it only says where the world is."""
_MOST_NAMED = 3
_LONGEST_NS = 1_000_000_000
_MISSTATED_RAD, _MISSTATED_SHARE = np.radians(2.0), 0.02
"""A calibration that is surer of itself than it should be is off by less, the second as a share of
the median distance; a wrong unit, sign or order of axes, and what was moved since, by more."""
_FEWEST_STEPS = 20
_LEAST_TURN_RAD = 0.01
_SECOND_AXIS = 0.02
"""Share of the turning about its main axis that there must be about another one."""
_OFF_RAD = np.radians(10.0)
"""No extrinsics are stated so badly; a sign, an order of axes or an inverse is off by more."""
_SEPARABLE, _MOST_SHOWN = 9.2, 999.0
"""Log likelihood ratio of 10,000 to 1, beyond which other axes and the inverse are out."""
_QUARTERS = [Rotor.from_rotation_vector(0.5 * np.pi * axis).as_matrix() for axis in np.eye(3)]
_OTHER_AXES = np.unique(
    [
        np.rint(np.linalg.matrix_power(_QUARTERS[i], j) @ np.linalg.matrix_power(_QUARTERS[k], m))
        for i, j, k, m in np.ndindex(3, 4, 3, 4)
    ],
    axis=0,
)
"""The rotations that take axes to axes, 24 of them."""
_DEVIATIONS = 6.0
_SIZE_SHARE = 0.03
"""A print is off by less than this, and so is a size that was measured with a ruler."""
_CONTAMINATION = 0.1
_SIGMAS = 3.0


@dataclass(frozen=True)
class HandEye:
    """How well a body's steps and those of its odometry fit together.

    Fields:
        stated_rad: how far the stated rotation of the one on the other is from what fits best.
        inverse_rad: how far its inverse is.
        body_R_odometry: rotation vector of what fits best, radians.
        sigma_rad: its deviation about the axis that is known least; infinite where one is unknown.
        log_ratio: of the likelihoods of the stated rotation and of the best of its inverse and its
            other orders and signs of axes.
    """

    stated_rad: float
    inverse_rad: float
    body_R_odometry: tuple[float, float, float]
    sigma_rad: float
    log_ratio: float


def hand_eye(odometry: BodyOdometry, time_ns: IntArray, world_T_body: Motor) -> HandEye | None:
    """Compare rotations from frame to frame; None where there are too few.

    Both readings of the stated pose are judged: a name like `T_body_odom` is read both ways.
    Steps that do not fit count less and less (Geman-McClure's weights).

    Args:
        odometry: of the body.
        time_ns: ``(n,)``.
        world_T_body: Motor ``(n,)``, without the odometry's help.
    """
    path = odometry.trajectory
    inside = (time_ns >= path.time_ns[0]) & (time_ns <= path.time_ns[-1])
    time_ns, world_T_body = time_ns[inside], world_T_body[inside]
    if len(time_ns) < _FEWEST_STEPS:
        return None
    near = np.diff(time_ns) <= _LONGEST_NS
    there = path.motors_at(time_ns)
    body, odom = (
        (poses[:-1].inverse() @ poses[1:]).rotor.as_rotation_vector()[near]
        for poses in (world_T_body, there)
    )
    turns = np.linalg.norm(odom, axis=-1) > _LEAST_TURN_RAD
    body, odom = body[turns], odom[turns]
    if len(body) < _FEWEST_STEPS:
        return None
    weight = np.ones(len(body))
    for _ in range(10):
        matrix = _rotation(body, odom, weight)
        off = np.linalg.norm(body - odom @ matrix.T, axis=-1)
        scale = max(1.5 * float(np.median(off)), 1e-6)
        weight = 1.0 / (1.0 + (off / scale) ** 2) ** 2
    spread = np.linalg.eigvalsh(np.einsum("n,ni,nj->ij", weight, odom, odom))
    known = spread[1] > _SECOND_AXIS**2 * spread[2]
    sigma = scale / np.sqrt(max(spread[0] + spread[1], 1e-12)) if known else np.inf
    best = Rotor.from_matrix(matrix)
    stated = odometry.body_T_odometry.rotor
    own = stated.as_matrix()
    others = np.concatenate([own @ _OTHER_AXES, [own.T]])
    missed = [
        np.sum(np.minimum(np.linalg.norm(body - odom @ axes.T, axis=-1) / scale, _SIGMAS) ** 2)
        for axes in (own, *others)
        if axes is own or np.linalg.norm(axes - own) > _LEAST_TURN_RAD
    ]
    return HandEye(
        float((best.inverse() @ stated).angle()),
        float((best.inverse() @ stated.inverse()).angle()),
        tuple(best.as_rotation_vector().tolist()),
        float(sigma),
        float(0.5 * (min(missed[1:]) - missed[0])),
    )


def _rotation(body: FloatArray, odom: FloatArray, weight: FloatArray) -> FloatArray:
    """The rotation that takes vectors ``(n, 3)`` to others best (Kabsch 1976)."""
    left, _, right = np.linalg.svd(np.einsum("n,ni,nj->ij", weight, body, odom))
    keep = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ keep @ right, np.float64)


def odometry_finding(name: str, fit: HandEye | None) -> AuditFinding:
    """What hand and eye say of one body's odometry."""
    what = "odometry_extrinsics"
    if fit is None:
        return AuditFinding(what, "unknown", None, "deg", f"{name}: too few steps turn")
    if not np.isfinite(fit.sigma_rad):
        summary = f"{name} turns about one axis only: where its odometry sits is unknown"
        return AuditFinding(what, "unknown", None, "deg", summary)
    stated, inverse = np.rad2deg(fit.stated_rad), np.rad2deg(fit.inverse_rad)
    summary = (
        f"the odometry of {name} turns as its stated pose says to {stated:.1f}°, as the inverse "
        f"would to {inverse:.1f}°, and is e^{min(fit.log_ratio, _MOST_SHOWN):.0f} times as "
        "likely as any other order or sign of its axes"
    )
    reach_rad = max(_OFF_RAD, _DEVIATIONS * fit.sigma_rad)
    if fit.stated_rad <= _OFF_RAD and fit.log_ratio > _SEPARABLE:
        return AuditFinding(what, "consistent", float(stated), "deg", summary)
    if fit.stated_rad <= reach_rad:
        summary += f", and either is known to ± {np.rad2deg(fit.sigma_rad):.0f}° alone"
        return AuditFinding(what, "unknown", float(stated), "deg", summary)
    vector = ", ".join(f"{angle:.3f}" for angle in fit.body_R_odometry)
    mend = f"the odometry is left out; its rotation on the body is the vector ({vector}) rad"
    if fit.inverse_rad <= reach_rad:
        mend = "the odometry is left out; give the inverse"
    return AuditFinding(what, "contradicted", float(stated), "deg", summary, mend)


def misfit_finding(misfit: int, alone: int, limit_px: float) -> AuditFinding:
    """What is said of frames that were left without a pose, as their only observation misfits."""
    summary = (
        f"{misfit} of {alone} frames that one observation alone places have no pose: its corners "
        f"misfit by more than {limit_px:.2g} px"
    )
    verdict: Verdict = "doubtful" if misfit > _CONTAMINATION * alone else "consistent"
    advice = "check the camera's focal length and distortion, and the stated noise of corners"
    return AuditFinding("misfit_frames", verdict, float(misfit), "frames", summary, advice)


def scene_audit(mapped: MappedScene) -> tuple[AuditFinding, ...]:
    """Connection, stated poses, stated sizes and corners of a scene as it was mapped."""
    ignored = [
        AuditFinding("ignored_statement", "unknown", None, "", said)
        for said in mapped.scene.ignored
    ]
    return (_connection(mapped), _stated(mapped), _sizes(mapped), _corners(mapped), *ignored)


def _connection(mapped: MappedScene) -> AuditFinding:
    lost, count = mapped.left_out, len(mapped.seen.marker_ids)
    summary = f"{count - len(lost)} of {count} markers hang together"
    if not lost:
        return AuditFinding("marker_connection", "consistent", 0.0, "markers", summary)
    named = ", ".join(map(str, lost[:_MOST_NAMED])) + ("…" if len(lost) > _MOST_NAMED else "")
    advice = f"show marker {named} beside one of the others, or state its pose"
    return AuditFinding(
        "marker_connection", "doubtful", float(len(lost)), "markers", summary, advice
    )


def _stated(mapped: MappedScene) -> AuditFinding:
    """Poses that were stated, beside those that everything together asks for."""
    rows = [pair for pair in stated_rows(mapped.seen, mapped.scene) if mapped.known[pair[0]]]
    name = "stated_poses"
    if not rows:
        return AuditFinding(name, "unknown", None, "poses", "no pose was stated")
    at = np.array([row for row, _ in rows])
    apart = Motor.stack([pose.pose for _, pose in rows]).local(mapped.poses[at])
    information = np.linalg.inv(np.stack([pose.covariance for _, pose in rows]))
    chi2 = np.einsum("ni,nij,nj->n", apart, information, apart)
    far_m = float(np.median(np.linalg.norm(mapped.seen.camera_T_marker.translation_m, axis=-1)))
    turned = np.linalg.norm(apart[:, :3], axis=-1)
    moved_m = np.linalg.norm(apart[:, 3:], axis=-1)
    beyond = np.flatnonzero(
        _never_fits(mapped)[at]
        | (chi2 > _GATE) & ((turned > _MISSTATED_RAD) | (moved_m > _MISSTATED_SHARE * far_m))
    )
    summary = f"{len(beyond)} of {len(rows)} stated poses are denied by what was seen"
    alone = int(np.count_nonzero(chi2 <= _UNMOVED))
    if alone:
        summary += f", of {alone} of them nothing that was seen speaks"
    if not len(beyond):
        verdict: Verdict = "consistent" if alone < len(rows) else "unknown"
        return AuditFinding(name, verdict, 0.0, "poses", summary)
    first = beyond[np.argsort(-chi2[beyond])][:_MOST_NAMED]
    named = "; ".join(
        f"{_called(mapped.seen, mapped.scene, int(at[row]))}"
        + (
            f" by {1e3 * moved_m[row]:.0f} mm and {np.rad2deg(turned[row]):.1f}°"
            if chi2[row] > _GATE
            else ", where its corners never fit"
        )
        for row in first
    )
    advice = "measure them again, or state as much noise"
    figure = float(len(beyond))
    return AuditFinding(name, "contradicted", figure, "poses", f"{summary}: {named}", advice)


def _never_fits(mapped: MappedScene) -> NDArray[np.bool_]:
    """``(P,)``: cameras and markers most of whose observations lie far off: stated too surely."""
    seen = mapped.seen
    good = np.isfinite(mapped.error_px)
    far = (mapped.error_px > seen.limits_px(mapped.scene.sigma_px))[good]
    rows = np.zeros(seen.rows, bool)
    cameras, markers = len(seen.names), len(seen.marker_ids)
    for first, size, owner in ((0, cameras, seen.camera), (cameras, markers, seen.marker)):
        observations = np.bincount(owner[good], minlength=size)
        off = np.bincount(owner[good], far, minlength=size)
        rows[first : first + size] = (2.0 * off > observations) & (observations >= _FEWEST_FRAMES)
    return rows


def _called(seen: SceneObservations, scene: MarkerScene, row: int) -> str:
    if row < len(seen.names):
        return f"camera {seen.names[row]}"
    marker = row - len(seen.names)
    if marker < len(seen.marker_ids):
        return f"marker {seen.marker_ids[marker]}"
    return scene.bodies[int(np.searchsorted(seen.first_row, row, side="right")) - 1].name


def _sizes(mapped: MappedScene) -> AuditFinding:
    """Sizes that corners ask for where a frame shows other markers as well, all poses held."""
    seen, name = mapped.seen, "marker_sizes"
    used = np.flatnonzero(np.isfinite(mapped.error_px) & _in_company(seen))
    if not len(used):
        return AuditFinding(name, "unknown", None, "share", "no frame shows several markers")
    chain = [mapped.poses[seen.chain[used, k]] for k in range(4)]
    camera_T_marker = (chain[CARRIER] @ chain[CAMERA]).inverse() @ chain[BODY] @ chain[MARKER]
    side = seen.side_m[seen.marker[used]]
    centre = marker_points_m(side).mean(axis=-2, keepdims=True)
    pixels = []
    for factor in (1.0, 1.0 + _STEP):
        points = centre + factor * (marker_points_m(side) - centre)
        pixels.append(seen.residuals_px(used, camera_T_marker[:, None].apply(points)))
    slope = (pixels[1] - pixels[0]).reshape(-1, 8) / _STEP
    here = pixels[0].reshape(-1, 8)
    good = np.isfinite(slope).all(-1) & np.isfinite(here).all(-1)
    pull = np.where(good, np.sum(slope * here, axis=-1), 0.0)
    weight = np.where(good, np.sum(slope**2, axis=-1), 0.0)
    size = len(seen.marker_ids)
    information = np.bincount(seen.marker[used], weight, minlength=size)
    share = -np.bincount(seen.marker[used], pull, minlength=size) / np.maximum(information, 1e-9)
    frames = np.bincount(seen.marker[used], minlength=size)
    noise_px = mapped.scene.sigma_px / np.sqrt(np.maximum(information, 1e-9))
    judged = (frames >= _FEWEST_FRAMES) & (_DEVIATIONS * noise_px < _SIZE_SHARE)
    off = np.flatnonzero(judged & (np.abs(share) > _SIZE_SHARE))
    most = float(np.max(np.abs(share[judged]))) if judged.any() else None
    if not judged.any():
        return AuditFinding(name, "unknown", None, "share", "too few frames show several markers")
    if not len(off):
        summary = f"the sides of {np.count_nonzero(judged)} markers fit to {most:.1%}"
        return AuditFinding(name, "consistent", most, "share", summary)
    worst = off[np.argsort(-np.abs(share[off]))][:_MOST_NAMED]
    named = ", ".join(f"{seen.marker_ids[row]} ({share[row]:+.1%})" for row in worst)
    summary = f"{len(off)} markers look larger or smaller than stated: {named}"
    return AuditFinding(name, "contradicted", most, "share", summary, "measure their black squares")


_STEP = 1e-4
_FEWEST_FRAMES = 5


def _in_company(seen: SceneObservations) -> NDArray[np.bool_]:
    """Whether an observation's camera sees another marker in the same frame."""
    key = seen.frame * len(seen.cameras) + seen.camera
    return np.asarray(np.bincount(key)[key] > 1)


def _corners(mapped: MappedScene) -> AuditFinding:
    """MarkerObservations whose corners lie far from where everything else puts them."""
    good = np.isfinite(mapped.error_px)
    errors, limits = mapped.error_px[good], mapped.seen.limits_px(mapped.scene.sigma_px)[good]
    if not len(errors):
        return AuditFinding("marker_corners", "unknown", None, "px", "no marker hangs together")
    usual = float(np.median(errors))
    off = int(np.count_nonzero(errors > limits))
    summary = (
        f"corners of {off} of {len(errors)} observations lie more than {limits.max():.2g} px "
        f"off, of all {usual:.2g} px in the median"
    )
    verdict: Verdict = "doubtful" if off > _CONTAMINATION * len(errors) else "consistent"
    advice = "check the camera's focal length and distortion, and whether some marker moved"
    return AuditFinding("marker_corners", verdict, usual, "px", summary, advice)


_SYNC_S = 0.05
_ROUNDS = 2
_MISFIT = 13.8
"""χ² with two degrees of freedom, of eight residuals less six of the pose, exceeds it once in a
thousand: a wrong pose costs more than one frame of a thousand does."""


def map_scene(
    streams: Mapping[str, CornerStream], scene: MarkerScene, *, sync_s: float = _SYNC_S
) -> MappedScene:
    """Find all poses of a scene from the corners that its cameras saw.

    Poses are found one after another, then adjusted together on corners, stated poses, odometry
    and measured lengths. A frame that one observation alone places has no pose where this misfits.

    Args:
        streams: by camera.
        scene: what is known beforehand.
        sync_s: stamps of different cameras that are so near count as one frame.

    Raises:
        TrackingError: nothing seen.
        ValueError: no stream, or one of a camera that the scene does not know.

    Examples:
        >>> import numpy as np
        >>> from motorcade.ga import Motor, Rotor
        >>> from motorcade.tracking import Camera
        >>> from motorcade.tracking.markers.corner_stream import CornerStream
        >>> from motorcade.tracking.markers.families import marker_points_m
        >>> from motorcade.tracking.markers.scenes import FixedMarker, MarkerBody, MarkerScene
        >>> from motorcade.tracking.markers.scenes import StatedPose, map_scene
        >>> here = StatedPose(Motor.identity(), 1e-10 * np.eye(6))
        >>> table = MarkerBody("table", moves=False, stated=here,
        ...     markers={3: FixedMarker(0.1, here), 8: FixedMarker(0.1)})
        >>> scene = MarkerScene((table, MarkerBody("rig", moves=True)), {"camera": "rig"},
        ...     {"camera": here})
        >>> camera = Camera(640, 480, 500.0, 500.0, 319.5, 239.5)
        >>> turn = Rotor.from_rotation_vector([np.pi - 0.4, 0.0, 0.0])
        >>> camera_T_table = Motor.from_rotor_translation(turn, [-0.1, 0.0, 0.6])
        >>> table_T_marker = Motor.from_translation([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
        >>> points = (camera_T_table @ table_T_marker)[:, None].apply(marker_points_m(0.1))
        >>> stream = CornerStream(camera, [0], [0, 0], [3, 8], camera.project(points))
        >>> found = map_scene({"camera": stream}, scene)
        >>> found.seen_from("camera").marker_map.world_T_marker[1].translation_m.round(3) + 0.0
        array([0.2, 0. , 0. ])
    """
    seen = gather_scene(streams, scene, sync_s)
    if len(seen) == 0:
        raise TrackingError("streams: expected markers of the scene, got none")
    scene, findings = _with_good_odometry(seen, scene)
    start = Start(seen, scene)
    start.fill()
    poses, _ = adjust_scene(seen, scene, Motor(start.poses), start.known, bounded=False, last=False)
    for left in reversed(range(_ROUNDS)):
        start.place_again(poses)
        poses, equations = adjust_scene(
            seen, scene, Motor(start.poses), start.known, bounded=True, last=left == 0
        )
    covariance = equations.covariance(np.repeat([1.0, 10.0], 3))
    misfit, alone, limit_px = _misfits(seen, scene, poses, start.known)
    start.known[misfit] = False
    if len(misfit):
        findings.append(misfit_finding(len(misfit), alone, limit_px))
    errors = np.where(start.known[seen.chain].all(axis=1), seen.errors_px(poses), np.inf)
    mapped = MappedScene(scene, seen, poses, start.known, errors, covariance)
    return replace(mapped, audit=(*findings, *scene_audit(mapped)))


def _misfits(
    seen: SceneObservations, scene: MarkerScene, poses: Motor, known: NDArray[np.bool_]
) -> tuple[IntArray, int, float]:
    """Rows of frames whose only observation misfits, how many have but one, and the limit."""
    limit_px = float(np.sqrt(_MISFIT / 4.0)) * scene.sigma_px
    free = np.array(
        [body.moves and body.odometry is None and body.still is None for body in scene.bodies]
    )
    used = np.flatnonzero(known[seen.chain].all(axis=1))
    rows = seen.chain[used][:, [CARRIER, BODY]]
    single = np.bincount(rows.ravel(), minlength=seen.rows)[rows] == 1
    owner = np.searchsorted(seen.first_row, rows, side="right") - 1
    single &= (seen.frame_of[rows] >= 0) & free[owner]
    off = seen.errors_px(poses)[used] > limit_px
    return rows[single & off[:, None]], int(np.count_nonzero(single)), limit_px


def _with_good_odometry(
    seen: SceneObservations, scene: MarkerScene
) -> tuple[MarkerScene, list[AuditFinding]]:
    """The scene without odometry that turns otherwise than what is seen, and what was found."""
    if not any(body.odometry for body in scene.bodies):
        return scene, []
    bare = replace(scene, bodies=tuple(replace(body, odometry=None) for body in scene.bodies))
    start = Start(seen, bare)
    start.fill()
    findings, bodies = [], []
    for first, body in zip(seen.first_row.tolist(), scene.bodies, strict=True):
        if body.odometry is not None and body.moves:
            frames = np.flatnonzero(start.known[first : first + len(seen.time_ns)])
            poses = Motor(start.poses)[first + frames]
            findings.append(
                odometry_finding(body.name, hand_eye(body.odometry, seen.time_ns[frames], poses))
            )
            if not findings[-1].passed:
                body = replace(body, odometry=None)
        bodies.append(body)
    return replace(scene, bodies=tuple(bodies)), findings
