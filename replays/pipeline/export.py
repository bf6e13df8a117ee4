"""Runs for other programs: as USD; images with poses for COLMAP and nerfstudio.

Metres, z up; time codes are frames at the recording's usual rate from the path's first stamp on, so
that frames at uneven times fall between whole codes. Sources: the schemas of UsdGeom and UsdSkel
(https://openusd.org/release/api).

COLMAP: https://colmap.github.io/format.html; pixel (0.5, 0.5) is the centre of the top-left pixel
there, and poses are camera_T_world.

nerfstudio: https://docs.nerf.studio/quickstart/data_conventions.html: camera axes as OpenGL has
them (x right, y up, z back), a world with z up, pixel (0.5, 0.5) the centre of the top-left pixel.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.animation import Character, Skeleton
from motorcade.animation.appearance import to_linear
from motorcade.ga import Motor, Similarity
from motorcade.ga.arrays import FloatArray, IntArray
from motorcade.render import Performer
from motorcade.replays.io.files import refusal, replacing, write_bytes
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

if TYPE_CHECKING:
    from pxr import Sdf, Usd


_QUALITY = 95


@dataclass(frozen=True, eq=False)
class PosedImages:
    """Images that were written, each with where the camera stood.

    Attributes:
        names: (N,) relative to the folder, such as ``images/frame_000012.jpg``.
        world_T_camera: (N,) along the path that the characters are drawn on.
        camera: as filmed, with its distortion.
    """

    names: tuple[str, ...]
    world_T_camera: Motor
    camera: Camera


def write_images(shown: Shown, folder: Path, every: int = 1) -> PosedImages:
    """Write each `every`-th frame that has a pose as a JPEG, as it was filmed.

    Raises:
        ValueError: a step below 1, or a folder that holds images already, which would be mixed.
        OSError: a file cannot be written.
    """
    import cv2

    if every < 1:
        raise ValueError(f"every: expected 1 or more, got {every}")
    place = folder / "images"
    if place.exists() and any(place.iterdir()):
        raise refusal(place, "holds files already", advice="name a new folder")
    place.mkdir(parents=True, exist_ok=True)
    names, stamps = [], []
    rows = shown.frames_posed
    for number in map(int, rows[rows % every == 0]):
        frame = shown.recording.frames[number]
        image = frame.image()
        ordered = image if image.ndim == 2 else image[..., ::-1]
        _, data = cv2.imencode(".jpg", ordered, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        names.append(f"images/frame_{number:06}.jpg")
        write_bytes(folder / names[-1], data.tobytes())
        stamps.append(frame.time_ns)
    camera = shown.recording.camera
    if camera is None:
        raise refusal(shown.recording.root, "expected a camera, got none")
    poses = shown.path.motors_at(np.array(stamps, dtype=np.int64))
    return PosedImages(tuple(names), poses, camera)


_GREY = 128


def write_colmap(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``images/`` and ``sparse/0/{cameras,images,points3D}.txt``, as `colmap gui` opens them.

    Mapped points have no tracks: the run keeps where they lie, not which images saw them.

    Args:
        shown: the run.
        folder: new, or without images.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, or a folder that holds images already.
        OSError: a file cannot be written.
    """
    images = write_images(shown, folder, every)
    model = folder / "sparse" / "0"
    model.mkdir(parents=True, exist_ok=True)
    write_bytes(model / "cameras.txt", _cameras(images.camera).encode())
    write_bytes(model / "images.txt", _images(images).encode())
    points = thinned(shown.points_m)
    rows = (
        f"{number} {x!r} {y!r} {z!r} {_GREY} {_GREY} {_GREY} 0"
        for number, (x, y, z) in enumerate(points.tolist(), 1)
    )
    head = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"
    write_bytes(model / "points3D.txt", "\n".join([head, *rows, ""]).encode())


def colmap_camera(camera: Camera) -> tuple[str, list[float]]:
    """Name and parameters of COLMAP's model of a camera.

    >>> from motorcade.replays.pipeline.export import colmap_camera
    >>> from motorcade.tracking import Camera
    >>> colmap_camera(Camera(640, 480, 500.0, 500.0, 319.5, 239.5))
    ('PINHOLE', [500.0, 500.0, 320.0, 240.0])
    """
    lens = [camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5]
    bends = list(camera.distortion)
    if camera.model == "equidistant":
        return "OPENCV_FISHEYE", lens + bends
    if not any(bends):
        return "PINHOLE", lens
    if len(bends) <= 4:
        return "OPENCV", lens + bends + [0.0] * (4 - len(bends))
    return "FULL_OPENCV", lens + bends + [0.0] * (8 - len(bends))


def _cameras(camera: Camera) -> str:
    model, numbers = colmap_camera(camera)
    text = " ".join(repr(float(one)) for one in numbers)
    head = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"
    return f"{head}\n1 {model} {camera.width} {camera.height} {text}\n"


def _images(images: PosedImages) -> str:
    """Two lines an image; the second, of what is seen in it, is empty."""
    camera_T_world = images.world_T_camera.inverse()
    wxyz = camera_T_world.rotor.as_quaternion()
    numbers = np.concatenate([wxyz, camera_T_world.translation_m], axis=-1).tolist()
    rows = (
        f"{number} {' '.join(map(repr, row))} 1 {name.removeprefix('images/')}\n\n"
        for number, (row, name) in enumerate(zip(numbers, images.names, strict=True), 1)
    )
    head = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME; then POINTS2D[]"
    return head + "\n" + "".join(rows)


OPENCV_T_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
"""From camera axes as OpenGL has them to OpenCV's."""


def write_nerfstudio(shown: Shown, folder: Path, every: int = 1) -> None:
    """Write ``transforms.json``, ``images/`` and, where points were mapped, ``points.ply``.

    Args:
        shown: the run.
        folder: new, or without images.
        every: of how many frames one is written.

    Raises:
        ValueError: a step below 1, a folder that holds images already, or a lens with more
            coefficients than nerfstudio knows.
        OSError: a file cannot be written.
    """
    camera = shown.recording.camera
    lens = _lens(camera, shown.recording.root) if camera is not None else {}
    images = write_images(shown, folder, every)
    matrices = images.world_T_camera.as_matrix() @ OPENCV_T_OPENGL
    content: dict[str, Any] = lens | {
        "frames": [
            {"file_path": name, "transform_matrix": matrix}
            for name, matrix in zip(images.names, matrices.tolist(), strict=True)
        ]
    }
    points = thinned(shown.points_m)
    if len(points):
        write_bytes(folder / "points.ply", _ply(points))
        content["ply_file_path"] = "points.ply"
    write_bytes(folder / "transforms.json", (json.dumps(content, indent=1) + "\n").encode())


def _lens(camera: Camera, root: Path) -> dict[str, Any]:
    fisheye = camera.model == "equidistant"
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3", "k4")
    bends = dict(zip(names, camera.distortion, strict=False))
    if len(camera.distortion) > (4 if fisheye else 5):
        raise refusal(
            root,
            f"a lens of {len(camera.distortion)} coefficients has no name in nerfstudio",
            advice="export it with --colmap, which knows eight",
        )
    return {
        "camera_model": "OPENCV_FISHEYE" if fisheye else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + 0.5,
        "cy": camera.cy + 0.5,
    } | bends


def _ply(points_m: FloatArray) -> bytes:
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points_m)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    rows = np.empty(len(points_m), [("place", "<f4", 3), ("grey", "u1", 3)])
    rows["place"], rows["grey"] = points_m, 128
    return head.encode() + rows.tobytes()


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
    >>> from motorcade.replays.pipeline.export import joint_paths
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
