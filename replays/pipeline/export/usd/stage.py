"""A run as a USD stage: camera, paths, points, and characters with skeletons that move.

Metres, z up; time codes are frames at the recording's usual rate from the path's first stamp on, so
that frames at uneven times fall between whole codes. Sources: the schemas of UsdGeom and UsdSkel
(https://openusd.org/release/api).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.ga.arrays import FloatArray
from motorcade.replays.io.atomic import replacing
from motorcade.replays.pipeline.export.nerfstudio import OPENCV_T_OPENGL
from motorcade.replays.pipeline.export.usd.values import UsdClock, as_matrix, identifiers
from motorcade.replays.pipeline.runs import Shown, thinned
from motorcade.tracking.cameras.camera import Camera

if TYPE_CHECKING:
    from pxr import Usd

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
    from motorcade.replays.pipeline.export.usd.figures import add_figure

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
        for name, one in zip(identifiers(shown.paths), shown.paths.values(), strict=True):
            _add_line(stage, f"/World/Paths/{name}", one.poses.translation_m)
        if len(shown.points_m):
            _add_points(stage, thinned(shown.points_m))
        for name, who in zip(identifiers(shown.cast), shown.cast.values(), strict=True):
            add_figure(stage, Sdf.Path(f"/World/Cast/{name}"), who, clock)
        stage.GetRootLayer().Save()


def _add_camera(stage: Usd.Stage, shown: Shown, clock: UsdClock) -> None:
    from pxr import Gf, UsdGeom

    lens = shown.camera
    made = UsdGeom.Camera.Define(stage, "/World/Camera")
    set_lens(made, lens)
    made.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1000.0))
    move = made.AddTransformOp()
    poses = shown.path.motors_at(clock.time_ns).as_matrix() @ OPENCV_T_OPENGL
    for code, matrix in zip(clock.codes, poses, strict=True):
        move.Set(as_matrix(matrix), float(code))


def set_lens(made: Any, lens: Camera) -> None:
    """Give a USD camera the field of view of ours, its off-centre principal point included.

    USD knows lengths on a film: apertures and their offsets from the axis, over the focal length.
    """
    focal = _FILM_WIDTH * lens.fx / lens.width
    made.CreateFocalLengthAttr(focal)
    made.CreateHorizontalApertureAttr(_FILM_WIDTH)
    made.CreateVerticalApertureAttr(focal * lens.height / lens.fy)
    made.CreateHorizontalApertureOffsetAttr(focal * (0.5 * lens.width - 0.5 - lens.cx) / lens.fx)
    made.CreateVerticalApertureOffsetAttr(focal * (lens.cy + 0.5 - 0.5 * lens.height) / lens.fy)


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
