"""A run as a USD stage: camera, paths, points, and characters with skeletons that move.

Metres, z up; time codes are frames at the recording's usual rate from the path's first stamp on, so
that frames at uneven times fall between whole codes. Sources: the schemas of UsdGeom and UsdSkel
(https://openusd.org/release/api).
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.animation import Character, Skeleton
from motorcade.animation.appearance import to_linear
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render import Performer
from motorcade.replays.io.files import replacing
from motorcade.replays.pipeline.export.images import OPENCV_T_OPENGL
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

if TYPE_CHECKING:
    from pxr import Sdf, Usd


SUFFIXES = (".usda", ".usdc")
_FILM_WIDTH = 0.36  # tenths of a metre: a full frame of 36 mm
_LINE_WIDTH_M = 0.005
_POINT_WIDTH_M = 0.01


def write_usd(shown: Shown, path: Path) -> None:
    """Write a run as one USD file, text (`.usda`) or binary (`.usdc`).

    The camera is without distortion, principal point and uneven pixels kept; characters carry
    their colours by vertex, not their textures. What is seen for a while is hidden otherwise.

    Raises:
        RuntimeError: the package `usd-core` is missing; the extra `usd` brings it.
        ValueError: another suffix.
        OSError: the file cannot be written.
    """
    if path.suffix not in SUFFIXES:
        raise ValueError(f"write_usd(path): expected .usda or .usdc, got '{path.name}'")
    try:
        from pxr import Sdf, Usd, UsdGeom
    except ModuleNotFoundError as missing:
        raise RuntimeError(
            "writing USD needs the Python package usd-core, which is not installed; "
            'pip install "motorcade[usd]" brings it'
        ) from missing

    clock = UsdClock(shown)
    with replacing(path) as building:
        stage = Usd.Stage.CreateNew(str(building))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(clock.rate_hz)
        stage.SetFramesPerSecond(clock.rate_hz)
        stage.SetStartTimeCode(0.0)
        stage.SetEndTimeCode(float(clock.codes[-1]))
        root = UsdGeom.Xform.Define(stage, "/World")
        stage.SetDefaultPrim(root.GetPrim())
        _add_camera(stage, shown, clock)
        UsdGeom.Scope.Define(stage, "/World/Paths")
        UsdGeom.Scope.Define(stage, "/World/Cast")
        for name, path_shown in zip(identifiers(shown.paths), shown.paths.values(), strict=True):
            _add_line(stage, f"/World/Paths/{name}", path_shown.poses.translation_m)
        if len(shown.points_m):
            _add_points(stage, thinned(shown.points_m))
        for name, who in zip(identifiers(shown.cast), shown.cast.values(), strict=True):
            add_figure(stage, Sdf.Path(f"/World/Cast/{name}"), who, clock)
        stage.GetRootLayer().Save()


def _add_camera(stage: Usd.Stage, shown: Shown, clock: UsdClock) -> None:
    from pxr import Gf, UsdGeom

    lens = shown.camera
    prim = UsdGeom.Camera.Define(stage, "/World/Camera")
    set_lens(prim, lens)
    prim.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1000.0))
    move = prim.AddTransformOp()
    poses = shown.path.motors_at(clock.time_ns).as_matrix() @ OPENCV_T_OPENGL
    for code, matrix in zip(clock.codes, poses, strict=True):
        move.Set(as_matrix(matrix), float(code))


def set_lens(prim: Any, lens: Camera) -> None:
    """Give a USD camera the field of view of ours, its off-centre principal point included.

    USD knows lengths on a film: apertures and their offsets from the axis, over the focal length.
    """
    focal = _FILM_WIDTH * lens.fx / lens.width
    prim.CreateFocalLengthAttr(focal)
    prim.CreateHorizontalApertureAttr(_FILM_WIDTH)
    prim.CreateVerticalApertureAttr(focal * lens.height / lens.fy)
    prim.CreateHorizontalApertureOffsetAttr(focal * (0.5 * lens.width - 0.5 - lens.cx) / lens.fx)
    prim.CreateVerticalApertureOffsetAttr(focal * (lens.cy + 0.5 - 0.5 * lens.height) / lens.fy)


def _add_line(stage: Usd.Stage, path: str, places_m: FloatArray) -> None:
    from pxr import UsdGeom, Vt

    line = UsdGeom.BasisCurves.Define(stage, path)
    places = places_m.astype(np.float32)
    line.CreateTypeAttr(UsdGeom.Tokens.linear)
    line.CreateCurveVertexCountsAttr([len(places)])
    line.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(places))
    line.CreateWidthsAttr([_LINE_WIDTH_M])
    line.SetWidthsInterpolation(UsdGeom.Tokens.constant)


def _add_points(stage: Usd.Stage, points_m: FloatArray) -> None:
    from pxr import UsdGeom, Vt

    cloud = UsdGeom.Points.Define(stage, "/World/Map")
    cloud.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points_m.astype(np.float32)))
    cloud.CreateWidthsAttr([_POINT_WIDTH_M])
    cloud.SetWidthsInterpolation(UsdGeom.Tokens.constant)


class UsdClock:
    """Stamps of a run's frames as time codes.

    Attributes:
        time_ns: (N,) of the frames with poses.
        codes: (N,) what USD calls these times.
        rate_hz: codes a second.
        since_start_s: (N,) on the characters' clock, which begins with the first frame.
    """

    def __init__(self, shown: Shown) -> None:
        every: IntArray = shown.recording.frames.time_ns
        self.time_ns = every[shown.frames_posed]
        usual_s = 1e-9 * float(np.median(np.diff(every))) if len(every) > 1 else 1.0
        self.rate_hz = float(round(1.0 / usual_s)) or 1.0 / usual_s
        self.codes: FloatArray = 1e-9 * self.rate_hz * (self.time_ns - self.time_ns[0])
        self.since_start_s: FloatArray = 1e-9 * (self.time_ns - every[0])


def as_matrix(matrix: FloatArray) -> Any:
    """A transform ``(4, 4)`` as USD has it: rows for columns."""
    from pxr import Gf

    return Gf.Matrix4d(matrix.T.tolist())


def identifiers(names: Iterable[str]) -> list[str]:
    """What USD may call things of these names, each once."""
    from pxr import Tf

    unique: list[str] = []
    for name in names:
        own = Tf.MakeValidIdentifier(name)
        while own in unique:
            own += "_"
        unique.append(own)
    return unique


def add_figure(stage: Usd.Stage, place: Sdf.Path, who: Performer, clock: UsdClock) -> None:
    """Add a character that stands, moves and is seen as the run says, skinned as in its film."""
    from pxr import UsdGeom, UsdSkel

    root = UsdSkel.Root.Define(stage, place)
    move = root.AddTransformOp()
    stands = who.world_T_character(clock.time_ns).as_matrix()
    for code, matrix in zip(clock.codes, stands, strict=True):
        move.Set(as_matrix(matrix), float(code))
    if who.visible_s is not None:
        seen = root.CreateVisibilityAttr()
        for code, time_s in zip(clock.codes, clock.since_start_s, strict=True):
            known = (
                UsdGeom.Tokens.inherited if who.seen(float(time_s)) else UsdGeom.Tokens.invisible
            )
            seen.Set(known, float(code))
    skeleton = _add_skeleton(stage, place.AppendChild("Skeleton"), who.character.skeleton)
    animation = _add_motion(stage, place.AppendChild("Motion"), who, clock)
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    mesh = _add_mesh(stage, place.AppendChild("Mesh"), who.character)
    UsdSkel.BindingAPI(mesh).CreateSkeletonRel().SetTargets([skeleton.GetPath()])


def joint_paths(skeleton: Skeleton) -> list[str]:
    """What USD calls joints: their ancestors' names and theirs, each unlike its siblings'.

    >>> from motorcade.animation import mannequin
    >>> from motorcade.replays.pipeline.export.usd import joint_paths
    >>> joint_paths(mannequin().skeleton)[1].count("/")
    1
    """
    from pxr import Tf

    paths: list[str] = []
    for name, parent in zip(skeleton.names, skeleton.parents.tolist(), strict=True):
        above = f"{paths[parent]}/" if parent >= 0 else ""
        own = above + Tf.MakeValidIdentifier(name)
        while own in paths:
            own += "_"
        paths.append(own)
    return paths


def _add_skeleton(stage: Usd.Stage, place: Sdf.Path, skeleton: Skeleton) -> Any:
    from pxr import UsdSkel

    skeleton_prim = UsdSkel.Skeleton.Define(stage, place)
    skeleton_prim.CreateJointsAttr(joint_paths(skeleton))
    skeleton_prim.CreateBindTransformsAttr(
        [as_matrix(one) for one in skeleton.rest_world.as_matrix()]
    )
    skeleton_prim.CreateRestTransformsAttr([as_matrix(one) for one in skeleton.rest.as_matrix()])
    return skeleton_prim


def _add_motion(stage: Usd.Stage, place: Sdf.Path, who: Performer, clock: UsdClock) -> Any:
    """The joints' poses, and weights of morph targets, at each frame."""
    from pxr import UsdSkel, Vt

    animation = UsdSkel.Animation.Define(stage, place)
    animation.CreateJointsAttr(joint_paths(who.character.skeleton))
    moves, turns = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    scales, weights = animation.CreateScalesAttr(), None
    if who.character.morphs:
        animation.CreateBlendShapesAttr(_morph_names(who.character))
        weights = animation.CreateBlendShapeWeightsAttr()
    for code, time_s in zip(clock.codes.tolist(), clock.since_start_s.tolist(), strict=True):
        pose = who.clip.at(time_s)
        wxyz = pose.rotor.as_quaternion().astype(np.float32)
        moves.Set(Vt.Vec3fArray.FromNumpy(pose.translation_m.astype(np.float32)), code)
        turns.Set(Vt.QuatfArray.FromNumpy(np.ascontiguousarray(wxyz[:, [1, 2, 3, 0]])), code)
        size = pose.scale if isinstance(pose, Similarity) else np.ones(len(wxyz))
        scales.Set(Vt.Vec3hArray.FromNumpy(np.repeat(size[:, None], 3, 1).astype(np.float16)), code)
        if weights is not None:
            shares = who.clip.morph_weights(time_s)
            at_rest = [one.weight for one in who.character.morphs]
            weights.Set(
                Vt.FloatArray(list(map(float, at_rest if shares is None else shares))), code
            )
    return animation


def _morph_names(character: Character) -> list[str]:
    """Names of morph targets, told apart by their numbers: names may repeat."""
    from pxr import Tf

    return [
        Tf.MakeValidIdentifier(f"{morph.name}_{number}")
        for number, morph in enumerate(character.morphs)
    ]


def _add_mesh(stage: Usd.Stage, place: Sdf.Path, character: Character) -> Any:
    from pxr import Gf, UsdGeom, UsdSkel, Vt

    mesh = UsdGeom.Mesh.Define(stage, place)
    mesh.CreatePointsAttr(_floats(character.vertices))
    mesh.CreateNormalsAttr(_floats(character.normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr(
        Vt.IntArray.FromNumpy(np.full(len(character.triangles), 3, "i4"))
    )
    corners = np.ascontiguousarray(character.triangles.ravel().astype(np.int32))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex).Set(_floats(to_linear(character.colors)))
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    joints = np.ascontiguousarray(character.joints.ravel().astype(np.int32))
    weights = np.ascontiguousarray(character.weights.ravel().astype(np.float32))
    held = character.joints.shape[1]
    binding.CreateJointIndicesPrimvar(False, held).Set(Vt.IntArray.FromNumpy(joints))
    binding.CreateJointWeightsPrimvar(False, held).Set(Vt.FloatArray.FromNumpy(weights))
    binding.CreateGeomBindTransformAttr().Set(Gf.Matrix4d(1.0))
    binding.CreateSkinningMethodAttr().Set(UsdSkel.Tokens.classicLinear)
    if character.morphs:
        names = _morph_names(character)
        binding.CreateBlendShapesAttr().Set(names)
        targets = binding.CreateBlendShapeTargetsRel()
        for name, morph in zip(names, character.morphs, strict=True):
            shape = UsdSkel.BlendShape.Define(stage, place.AppendChild(name))
            shape.CreateOffsetsAttr(_floats(morph.positions))
            shape.CreateNormalOffsetsAttr(_floats(morph.normals))
            shape.CreatePointIndicesAttr(Vt.IntArray(morph.rows.tolist()))
            targets.AddTarget(shape.GetPath())
    return mesh.GetPrim()


def _floats(rows: FloatArray) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows.astype(np.float32)))
