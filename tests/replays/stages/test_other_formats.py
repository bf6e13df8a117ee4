"""Runs as COLMAP, nerfstudio and USD have them, read back by COLMAP's and USD's own libraries."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from motorcade.animation import skin
from motorcade.replays.cli import main
from motorcade.replays.demo import write_recording
from motorcade.replays.pipeline.export import write_colmap, write_nerfstudio, write_usd
from motorcade.replays.pipeline.job import Job, run_job
from motorcade.replays.pipeline.runs import Shown, open_run
from motorcade.tracking import Camera

pxr = pytest.importorskip("pxr", reason="usd-core is not installed")
pycolmap = pytest.importorskip("pycolmap", reason="pycolmap is not installed")
from pxr import Gf, Usd, UsdGeom, UsdSkel  # noqa: E402

LENSES = (
    Camera(640, 480, 500.0, 510.0, 300.0, 250.0, "pinhole"),
    Camera(640, 480, 500.0, 510.0, 300.0, 250.0, "radtan", (0.1, -0.05)),
    Camera(640, 480, 500.0, 510.0, 300.0, 250.0, "radtan", (0.1, -0.05, 0.001, -0.002)),
    Camera(640, 480, 500.0, 510.0, 300.0, 250.0, "radtan", (0.1, -0.05, 0.001, -0.002, 0.01)),
    Camera(640, 480, 300.0, 310.0, 310.0, 230.0, "equidistant", (0.01, -0.02, 0.003, -0.001)),
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, opengl: None) -> Path:
    root = tmp_path_factory.mktemp("run")
    write_recording(root / "room", frames=12)
    once = ("smoothed.representations=motor",)
    run_job(Job(recording=root / "room", out=root / "out", until="placed", settings=once))
    return root / "out"


@pytest.fixture(scope="module")
def shown(finished: Path) -> Shown:
    return open_run(finished)


def as_if(shown: Shown, camera: Camera, points: np.ndarray) -> Shown:
    """The run as if it had been filmed by another camera, and had mapped points."""
    from dataclasses import replace

    recording = replace(shown.recording, camera=camera)
    return replace(shown, recording=recording, camera=camera.undistorted(), points_m=points)


@pytest.mark.quick_every(3)
@pytest.mark.parametrize("camera", LENSES, ids=lambda one: f"{one.model}{len(one.distortion)}")
def test_colmap_projects_points_where_we_do(shown: Shown, camera: Camera, tmp_path: Path) -> None:
    points = np.random.default_rng(1).uniform(-0.4, 0.4, (30, 3))
    write_colmap(as_if(shown, camera, points), tmp_path / "model", every=5)
    model = pycolmap.Reconstruction(str(tmp_path / "model" / "sparse" / "0"))
    assert model.num_points3D() == 30
    read = np.array([one.xyz for _, one in sorted(model.points3D.items())])
    np.testing.assert_allclose(read, points, atol=1e-12)
    frames = shown.recording.frames
    names = {image.name: image for image in model.images.values()}
    assert sorted(names) == [f"frame_{number:06}.jpg" for number in range(0, len(frames), 5)]
    for name, image in names.items():
        number = int(name[6:12])
        written = cv2.imread(str(tmp_path / "model" / "images" / name))[..., ::-1]
        wanted = frames[number].image().astype(float)
        assert np.abs(written - wanted).mean() < 3.0
        pose = shown.path.motors_at(frames.time_ns[number])
        inside = pose.inverse().apply(points)
        seen = inside[:, 2] > 0.1
        places = camera.project(inside[seen])
        theirs = np.array([image.project_point(point) for point in points[seen]])
        np.testing.assert_allclose(theirs - 0.5, places, atol=1e-6)


@pytest.mark.parametrize("camera", LENSES, ids=lambda one: f"{one.model}{len(one.distortion)}")
def test_nerfstudios_numbers_project_points_where_we_do(
    shown: Shown, camera: Camera, tmp_path: Path
) -> None:
    """By OpenCV on the numbers of the file, axes turned as nerfstudio's documentation has them."""
    points = np.random.default_rng(2).uniform(-0.4, 0.4, (30, 3))
    write_nerfstudio(as_if(shown, camera, points), tmp_path / "data", every=4)
    told = json.loads((tmp_path / "data" / "transforms.json").read_text())
    assert (told["w"], told["h"]) == (camera.width, camera.height)
    matrix = np.array(
        [[told["fl_x"], 0, told["cx"] - 0.5], [0, told["fl_y"], told["cy"] - 0.5], [0, 0, 1]]
    )
    head, _, rows = (
        (tmp_path / "data" / told["ply_file_path"]).read_bytes().partition(b"end_header\n")
    )
    assert b"element vertex 30\n" in head
    assert len(rows) == 30 * 15
    for frame in told["frames"]:
        assert (tmp_path / "data" / frame["file_path"]).is_file()
        number = int(frame["file_path"][-10:-4])
        camera_T_world = np.diag([1.0, -1.0, -1.0, 1.0]) @ np.linalg.inv(frame["transform_matrix"])
        inside = points @ camera_T_world[:3, :3].T + camera_T_world[:3, 3]
        inside = inside[inside[:, 2] > 0.1]
        if told["camera_model"] == "OPENCV_FISHEYE":
            bends = np.array([told[name] for name in ("k1", "k2", "k3", "k4")])
            theirs, _ = cv2.fisheye.projectPoints(
                inside[:, None], np.zeros(3), np.zeros(3), matrix, bends
            )
        else:
            bends = np.array([told.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3")])
            theirs, _ = cv2.projectPoints(inside, np.zeros(3), np.zeros(3), matrix, bends)
        pose = shown.path.motors_at(shown.recording.frames.time_ns[number])
        ours = pose.inverse().apply(points)
        ours = camera.project(ours[ours[:, 2] > 0.1])
        np.testing.assert_allclose(theirs.reshape(-1, 2), ours, atol=1e-6)


def test_a_lens_that_nerfstudio_has_no_names_for_is_refused(shown: Shown, tmp_path: Path) -> None:
    eight = (0.1, -0.05, 0.001, -0.002, 0.01, 0.1, 0.02, 0.001)
    camera = Camera(640, 480, 500.0, 510.0, 300.0, 250.0, "radtan", eight)
    with pytest.raises(ValueError, match="export it with --colmap"):
        write_nerfstudio(as_if(shown, camera, np.empty((0, 3))), tmp_path / "data")
    write_colmap(as_if(shown, camera, np.empty((0, 3))), tmp_path / "model", every=6)
    assert pycolmap.Reconstruction(str(tmp_path / "model" / "sparse" / "0")).num_cameras() == 1


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_usd_skins_the_character_where_we_do(shown: Shown, tmp_path: Path, suffix: str) -> None:
    write_usd(shown, tmp_path / f"run{suffix}")
    stage = Usd.Stage.Open(str(tmp_path / f"run{suffix}"))
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    [name] = shown.cast
    who = shown.cast[name]
    root = UsdSkel.Root(stage.GetPrimAtPath(f"/World/Cast/{name}"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    skeleton = cache.GetSkelQuery(UsdSkel.Skeleton(root.GetPrim().GetChild("Skeleton")))
    mesh = UsdGeom.Mesh(root.GetPrim().GetChild("Mesh"))
    query = cache.GetSkinningQuery(mesh.GetPrim())
    frames = shown.recording.frames.time_ns
    rate = stage.GetTimeCodesPerSecond()
    for time_ns in frames[[0, len(frames) // 2, -1]]:
        code = 1e-9 * rate * (time_ns - shown.path.time_ns[0])
        moves = skeleton.ComputeSkinningTransforms(code)
        points = mesh.GetPointsAttr().Get(code)
        assert query.ComputeSkinnedPoints(moves, points, code)
        world = np.array(mesh.ComputeLocalToWorldTransform(code))
        theirs = np.array(points) @ world[:3, :3] + world[3, :3]
        time_s = 1e-9 * (time_ns - frames[0])
        vertices, _ = skin(who.character, who.clip.at(time_s), "linear")
        ours = who.world_T_character(time_ns).apply(vertices)
        assert np.abs(theirs - ours).max() < 1e-6


def test_usds_camera_sees_points_where_ours_does(shown: Shown, tmp_path: Path) -> None:
    lens = Camera(640, 480, 500.0, 540.0, 280.0, 262.0, "pinhole")
    write_usd(as_if(shown, lens, np.empty((0, 3))), tmp_path / "run.usda")
    stage = Usd.Stage.Open(str(tmp_path / "run.usda"))
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    rng = np.random.default_rng(4)
    time_ns = shown.recording.frames.time_ns[5]
    code = 1e-9 * stage.GetTimeCodesPerSecond() * (time_ns - shown.path.time_ns[0])
    frustum = camera.GetCamera(code).frustum
    see = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    pose = shown.path.motors_at(time_ns)
    inside = np.column_stack([rng.uniform(-0.3, 0.3, (20, 2)), rng.uniform(0.5, 2.0, 20)])
    for point, pixel in zip(pose.apply(inside), lens.project(inside), strict=True):
        clip = see.Transform(Gf.Vec3d(*point.tolist()))
        theirs = [
            0.5 * (1.0 + clip[0]) * lens.width - 0.5,
            0.5 * (1.0 - clip[1]) * lens.height - 0.5,
        ]
        np.testing.assert_allclose(theirs, pixel, atol=1e-3)


def test_usd_holds_paths_points_and_who_is_not_seen(shown: Shown, tmp_path: Path) -> None:
    from dataclasses import replace

    points = np.random.default_rng(7).uniform(-1, 1, (40, 3))
    [name] = shown.cast
    away = replace(shown.cast[name], visible_s=(0.1, 0.2))
    both = replace(shown, points_m=points, cast={"her own": shown.cast[name], "her-own": away})
    write_usd(both, tmp_path / "run.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    cloud = UsdGeom.Points(stage.GetPrimAtPath("/World/Map"))
    np.testing.assert_allclose(np.array(cloud.GetPointsAttr().Get()), points, atol=1e-6)
    lines = stage.GetPrimAtPath("/World/Paths").GetChildren()
    assert len(lines) == len(shown.paths)
    hidden = UsdGeom.Imageable(stage.GetPrimAtPath("/World/Cast/her_own_"))
    rate = stage.GetTimeCodesPerSecond()
    assert hidden.ComputeVisibility(0.0) == "invisible"
    assert hidden.ComputeVisibility(0.15 * rate) == "inherited"
    assert stage.GetPrimAtPath("/World/Cast/her_own").IsValid()


def test_export_writes_each_format_that_is_asked_for(
    finished: Path, tmp_path: Path, capsys
) -> None:
    asked = ["--usd", str(tmp_path / "run.usdc"), "--colmap", str(tmp_path / "colmap")]
    asked += ["--nerfstudio", str(tmp_path / "nerf"), "--every", "6"]
    assert main(["export", str(finished), *asked]) == 0
    assert len(list((tmp_path / "nerf" / "images").iterdir())) == 2
    capsys.readouterr()
    assert main(["export", str(finished), "--colmap", str(tmp_path / "colmap")]) == 1
    assert "holds files already; name a new folder" in capsys.readouterr().err
    assert main(["export", str(finished), "--usd", str(tmp_path / "run.fbx")]) == 1
    assert "expected .usda or .usdc" in capsys.readouterr().err
    assert main(["export", str(finished), "--nerfstudio", str(tmp_path / "n"), "--every", "0"]) == 1
    assert "every: expected 1 or more" in capsys.readouterr().err
