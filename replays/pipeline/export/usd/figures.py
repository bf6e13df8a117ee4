"""Characters of a run in a USD stage: meshes skinned by UsdSkel, moved by time samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from motorcade.animation import Character, Skeleton
from motorcade.animation.srgb import to_linear
from motorcade.ga import Similarity
from motorcade.ga.arrays import FloatArray
from motorcade.render import Performer
from motorcade.replays.pipeline.export.usd.values import UsdClock, as_matrix

if TYPE_CHECKING:
    from pxr import Sdf, Usd


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
    >>> from motorcade.replays.pipeline.export.usd.figures import joint_paths
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

    made = UsdSkel.Skeleton.Define(stage, place)
    made.CreateJointsAttr(joint_paths(skeleton))
    made.CreateBindTransformsAttr([as_matrix(one) for one in skeleton.rest_world.as_matrix()])
    made.CreateRestTransformsAttr([as_matrix(one) for one in skeleton.rest.as_matrix()])
    return made


def _add_motion(stage: Usd.Stage, place: Sdf.Path, who: Performer, clock: UsdClock) -> Any:
    """The joints' poses, and weights of morph targets, at each frame."""
    from pxr import UsdSkel, Vt

    made = UsdSkel.Animation.Define(stage, place)
    made.CreateJointsAttr(joint_paths(who.character.skeleton))
    moves, turns = made.CreateTranslationsAttr(), made.CreateRotationsAttr()
    scales, weights = made.CreateScalesAttr(), None
    if who.character.morphs:
        made.CreateBlendShapesAttr(_morph_names(who.character))
        weights = made.CreateBlendShapeWeightsAttr()
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
    return made


def _morph_names(character: Character) -> list[str]:
    """Names of morph targets, told apart by their numbers: names may repeat."""
    from pxr import Tf

    return [
        Tf.MakeValidIdentifier(f"{one.name}_{number}")
        for number, one in enumerate(character.morphs)
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
        for name, one in zip(names, character.morphs, strict=True):
            shape = UsdSkel.BlendShape.Define(stage, place.AppendChild(name))
            shape.CreateOffsetsAttr(_floats(one.positions))
            shape.CreateNormalOffsetsAttr(_floats(one.normals))
            shape.CreatePointIndicesAttr(Vt.IntArray(one.rows.tolist()))
            targets.AddTarget(shape.GetPath())
    return mesh.GetPrim()


def _floats(rows: FloatArray) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows.astype(np.float32)))
