"""MD5, BVH, FBX and the door: what they allow, and what they refuse by name."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from motorcade.animation.formats import FormatError, fbx, read_character, read_motion
from motorcade.animation.formats.limits import beside
from motorcade.animation.formats.rig.values import NodeTree, Transforms
from tests.animation.formats import samples
from tests.animation.formats.samples import Write


def mesh(*changes: tuple[str, str]) -> bytes:
    return changed(samples.md5_mesh_tower(), *changes)


def motion(*changes: tuple[str, str]) -> bytes:
    return changed(samples.md5_motion_tower(), *changes)


def bvh(*changes: tuple[str, str]) -> bytes:
    return changed(samples.BVH, *changes)


def changed(data: bytes, *changes: tuple[str, str]) -> bytes:
    """A text with parts replaced, each found once or more."""
    text = data.decode()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text.encode()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("numJoints 2", "numJoints 3"), "expected"),
        (("MD5Version 10", "MD5Version 6"), "from 10 to 10, got 6"),
        (('"top" 0', '"top" 1'), "parent of joint 1: expected a whole number from -1 to 0"),
        (("weight 0 0", "weight 0 7"), "joints below 2, got 7"),
        (("tri 0 0", "tri 0 77"), "vertices below 12, got 77"),
        (("numJoints 2", "numJoints 0"), "numJoints: expected a whole number from 1"),
        (("joints {", "joints ["), r"file: expected '{', got \["),
        (("( 0 0 1 ) ( 0 0 0 )", "( 0 0 1 ) ( 0 0 9 )"), "parts of a unit quaternion"),
        (("( 0 0 1 ) ( 0 0 0 )", "( 0 0 1 ) ( 0 0 )"), "joint 'top': expected numbers"),
        (("( 0 0 1 ) ( 0 0 0 )", "( 0 0 1e10 ) ( 0 0 0 )"), "finite numbers up to 1e9"),
        (("tri 1 ", "tri 5 "), "tri 1: expected number 1, got 5"),
        (("tri 0 0", "tri 0 0.5"), "mesh 0: expected whole numbers"),
        (("vert 0 ( 0.5 0.5 ) 0 1", "vert 0 ( 0.5 0.5 ) 0 0"), "1 to 64 weights a vertex, got"),
        (("vert 0 ( 0.5 0.5 ) 0 1", "vert 0 ( 0.5 0.5 ) 99 1"), "weights below 16, got 100"),
        (("weight 0 0 1.0", "weight 0 0 -1.0"), "weights of 0 or more with a sum above 0"),
        (("weight 0 0 1.0", "weight 0 0 0.0"), "weights of 0 or more with a sum above 0"),
        (("\n}\n", "\n"), "file: expected '}', got mesh"),
    ],
)
def test_meshes_of_md5_that_are_not_consistent_are_refused(
    write: Write, change: tuple[str, str], message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_character(write("bad.md5mesh", mesh(change)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("numFrames 3", "numFrames 4"), "expected"),
        (("frameRate 2", "frameRate 0"), "frameRate: expected a whole number from 1"),
        (("numAnimatedComponents 1", "numAnimatedComponents 99"), "from 0 to 12, got 99"),
        (('"top" 0 32 0', '"top" 0 64 0'), "flags of 'top': expected a whole number from 0 to 63"),
        (('"top" 0 32 0', '"top" 0 48 0'), "start of 'top': expected at most -1, got 0"),
        (('"top" 0 32 0', '"top" 1 32 0'), "parent of 'top': expected a whole number from -1 to 0"),
        (("frame 1 {", "frame 2 {"), "frame: expected a whole number from 1 to 1, got 2"),
        (("( 0 0 1 ) ( 0 0 0 )", "( 0 0 1 ) ( 0 0 x )"), "baseframe: expected numbers"),
        (("bounds {", "bounds ("), "expected '{'"),
    ],
)
def test_motions_of_md5_that_are_not_consistent_are_refused(
    write: Write, change: tuple[str, str], message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_motion(write("bad.md5anim", motion(change)))
    write("tower.md5anim", motion(change))
    with pytest.raises(FormatError, match=r"tower\.md5anim: "):
        read_character(write("tower.md5mesh", mesh()))


def test_a_mesh_of_md5_without_a_motion_stands(write: Write) -> None:
    found = read_character(write("alone.md5mesh", mesh()))
    assert found.clips == ()
    assert found.height_m > 0.0


def test_empty_meshes_of_md5_are_passed_over(write: Write) -> None:
    empty = "mesh {\nnumverts 0\nnumtris 0\nnumweights 0\n}\n"
    data = mesh(("numMeshes 1", "numMeshes 2"), ("mesh {", empty + "mesh {"))
    found = read_character(write("two.md5mesh", data))
    assert len(found.vertices) == 12
    bare = mesh(('shader "tower"\n', ""))
    assert not any("texture" in note for note in read_character(write("b.md5mesh", bare)).notices)


def test_roots_of_md5_stand_in_the_world(write: Write) -> None:
    """Two joints without parents lie where a joint and its child would."""
    data = mesh(('"top" 0 ( 0 0 1 )', '"top" -1 ( 0 0 1 )'))
    apart, below = (
        read_character(write(name, one))
        for name, one in (("roots.md5mesh", data), ("chain.md5mesh", mesh()))
    )
    assert apart.skeleton.parents.tolist() == [-1, -1]
    np.testing.assert_allclose(
        apart.skeleton.rest_world.as_matrix(), below.skeleton.rest_world.as_matrix(), atol=1e-12
    )


def test_an_image_beside_paints_the_mesh_of_md5(write: Write, tmp_path: Path) -> None:
    Image.new("RGB", (1, 1), (255, 0, 0)).save(tmp_path / "tower.png")
    found = read_character(write("red.md5mesh", mesh(('"tower"', '"tower.png"'))))
    np.testing.assert_allclose(found.colors, np.tile([1.0, 0.0, 0.0], (12, 1)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("Frames: 3", "Frames: 4"), "4 frames of 15 numbers, got 45"),
        (("Zrotation", "Wrotation"), "names such as Xrotation"),
        (("0 5 1 10", "0 5 x 10"), "expected numbers"),
        (("}\nMOTION", "MOTION"), "closed braces"),
        (("HIERARCHY", "HIERARCHIES"), "file: expected HIERARCHY, got HIERARCHIES"),
        (("MOTION", "MOTIONS: "), "MOTION: expected Frames: and Frame Time:"),
        (("MOTION", "MOTIO"), "expected a section MOTION, got none"),
        (("ROOT", "JOINT"), "ROOT outside and JOINT inside of joints, got JOINT"),
        (("JOINT Head", "ROOT Head"), "ROOT outside and JOINT inside of joints, got ROOT"),
        (("JOINT Head", "BONE Head"), "a joint, OFFSET, CHANNELS, End or a brace, got BONE"),
        (("CHANNELS 3", "CHANNELS 7"), "CHANNELS: expected 0 to 6, got 7"),
        (("OFFSET 0 5 0", "OFFSET 0 up 0"), "expected a number, got up"),
        (("OFFSET 0 5 0", "OFFSET 0 inf 0"), "a finite number up to 1e9, got inf"),
        (
            ("End Site\n    {\n      OFFSET 0 1", "End Site\n    {\n      LENGTH 0 1"),
            "End Site: expected OFFSET, got LENGTH",
        ),
        (("OFFSET 0 1 0\n    }", "OFFSET 0 1 0\n    JOINT"), "a closing brace, got JOINT"),
        (("Frames: 3", "Frames: 0"), "a count of frames"),
        (("Frames: 3", "Frames: 2.5"), "a count of frames"),
        (("Frame Time: 0.5", "Frame Time: 0"), "a time of 1e-6 s or more"),
    ],
)
def test_files_of_bvh_that_are_not_consistent_are_refused(
    write: Write, change: tuple[str, str], message: str
) -> None:
    with pytest.raises(FormatError, match=message):
        read_motion(write("bad.bvh", bvh(change)))


@pytest.mark.parametrize("end", ["ROOT Hips", "ROOT Hips\n{\nOFFSET 0 0", ""])
def test_files_of_bvh_that_end_early_are_refused(write: Write, end: str) -> None:
    with pytest.raises(FormatError, match=r"closed braces|the end of the section"):
        read_motion(write("cut.bvh", f"HIERARCHY\n{end}\nMOTION\nFrames: 1".encode()))


def test_rows_of_bvh_beyond_its_frames_are_told(write: Write) -> None:
    whole = samples.BVH.decode()
    last = whole.rstrip().splitlines()[-1]
    longer = write("longer.bvh", f"{whole.rstrip()}\n{last}\n".encode())
    found = read_motion(longer, unit_m=1.0)
    told = [notice for notice in found.notices if "left out" in notice]
    assert len(told) == 1
    assert "1 rows more than its" in told[0]
    plain = read_motion(write("plain.bvh", samples.BVH), unit_m=1.0)
    assert not any("left out" in notice for notice in plain.notices)
    np.testing.assert_array_equal(found.clips[0].time_s, plain.clips[0].time_s)


def test_bvh_knows_names_of_many_words_and_joints_that_do_not_turn(write: Write) -> None:
    data = bvh(
        ("JOINT Head", "JOINT  My  Head"),
        ("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 0"),
        ("0 5 0 0 0 0 0 0 0 0 0 0 0 0 0", "0 5 0 0 0 0 0 0 0 0 0 0"),
        ("0 5 1 10 20 30 0 0 0 0 0 0 0 0 0", "0 5 1 10 20 30 0 0 0 0 0 0"),
        ("0 5 2 -90 45 60 30 20 10 0 0 0 0 0 0", "0 5 2 -90 45 60 0 0 0 0 0 0"),
    )
    found = read_motion(write("named.bvh", data), unit_m=1.0)
    assert found.skeleton.names == ("Hips", "My Head", "LeftFoot", "LeftToe")
    hips = Rotation.from_euler("ZYX", [-90, 45, 60], degrees=True)
    world = found.skeleton.world(found.clips[0].at(1.0)).translation_m
    turned = hips.apply([0, 5, 0])[[2, 0, 1]]
    np.testing.assert_allclose(world[1] - world[0], turned, atol=1e-9)


@pytest.mark.parametrize(
    ("module", "name", "limit", "suffix", "message"),
    [
        ("bvh", "MAX_DEPTH", 1, ".bvh", "1 levels, 20000 joints, got more"),
        ("bvh", "MAX_NODES", 1, ".bvh", "expected .*1 joints, got more"),
        ("bvh", "MAX_POSES", 5, ".bvh", "at most 40 numbers, got 3 x 15"),
        ("limits", "MAX_VALUES", 5, ".bvh", "MOTION: expected at most 5 numbers, got more"),
        ("md5", "MAX_POSES", 5, ".md5anim", "numFrames: expected at most 5 poses, got 6"),
        ("md5", "MOST", 5, ".md5mesh", "numverts: expected a whole number from 0 to 5"),
        ("md5", "MOST_INFLUENCES", 1, ".md5mesh", "1 to 1 weights a vertex, got 2"),
        ("rig.sampling", "MAX_POSES", 5, ".bvh", "at most 5 samples times nodes, got 3 times 4"),
        ("rig.values", "MAX_DEPTH", 2, ".bvh", "nodes: expected at most 2 levels, got 3"),
        ("rig.values", "MAX_NODES", 3, ".bvh", "nodes: expected at most 3, got 4"),
    ],
)
def test_files_beyond_the_limits_are_refused(
    write: Write,
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    name: str,
    limit: int,
    suffix: str,
    message: str,
) -> None:
    """Limits are lowered for the test rather than files made that large."""
    monkeypatch.setattr(f"motorcade.animation.formats.{module}.{name}", limit)
    data = {".bvh": bvh(), ".md5anim": motion(), ".md5mesh": mesh()}[suffix]
    with pytest.raises(FormatError, match=message):
        read_motion(write(f"large{suffix}", data))


def test_long_texts_of_numbers_are_read_a_piece_at_a_time(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever a piece ends, between words and in long gaps, the numbers are the same."""
    data = bvh(("0 5 1 10", "0 5 1" + " " * 50 + "10"))
    whole = read_motion(write("whole.bvh", data))
    for piece in (1, 2, 7):
        monkeypatch.setattr("motorcade.animation.formats.limits.PIECE", piece)
        found = read_motion(write("parts.bvh", data))
        np.testing.assert_array_equal(
            found.clips[0].poses.coefficients, whole.clips[0].poses.coefficients
        )


def test_what_values_refuse_is_told_as_an_error_of_the_file(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a reader overlooks, a caller has one kind of error to look for."""

    def refuse(*_: object) -> None:
        raise ValueError("Skeleton.rest: expected something else")

    for name in ("assemble_character", "assemble_motion"):
        monkeypatch.setattr(f"motorcade.animation.formats.{name}", refuse)
    path = write("odd.bvh", bvh())
    for read in (read_motion, read_character):
        with pytest.raises(FormatError, match=r"odd\.bvh: Skeleton\.rest: expected something else"):
            read(path)


@pytest.mark.parametrize("unit_m", [0.0, -1.0, np.nan, np.inf, 1e9])
def test_units_that_are_none_are_refused(write: Write, unit_m: float) -> None:
    path = write("tower.bvh", bvh())
    for read in (read_motion, read_character):
        with pytest.raises(FormatError, match=r"unit_m: expected metres from 1e-6 to 1e6"):
            read(path, unit_m=unit_m)


def test_folders_devices_and_large_files_are_no_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "folder.glb"
    folder.mkdir()
    pipe = tmp_path / "pipe.glb"
    os.mkfifo(pipe)
    for path in (folder, pipe):
        with pytest.raises(FormatError, match="expected a file, got a folder or a device"):
            read_character(path)
    large = tmp_path / "large.bvh"
    large.write_bytes(b"x" * 101)
    monkeypatch.setattr("motorcade.animation.formats.bvh.MAX_TEXT_BYTES", 100)
    with pytest.raises(FormatError, match="expected at most 100 bytes, got 101"):
        read_motion(large)


def test_links_in_a_circle_are_no_files_beside(tmp_path: Path) -> None:
    one, two = tmp_path / "one.bin", tmp_path / "two.bin"
    one.symlink_to(two)
    two.symlink_to(one)
    with pytest.raises(FormatError, match="uri: expected the name of a file beside this one"):
        beside(tmp_path, "one.bin", "uri")


def test_transforms_and_trees_beyond_all_bounds_are_refused() -> None:
    large = np.eye(4)
    large[0, 3] = 1e10
    for matrix in (large, large * np.nan):
        with pytest.raises(FormatError, match="matrix: expected finite numbers up to 1e9"):
            Transforms.from_matrices(matrix)
    with pytest.raises(FormatError, match="translation: expected finite numbers up to 1e9"):
        Transforms.from_parts(np.eye(4)[:1], np.full((1, 3), 1e10), np.ones((1, 3)))
    none = Transforms(np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0))
    with pytest.raises(FormatError, match="nodes: expected one or more, got none"):
        NodeTree((), np.zeros(0, dtype=np.int64), none)


@pytest.fixture
def assimp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program of assimp's name before all others, which the test writes."""
    folder = tmp_path / "programs"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    return folder / "assimp"


def _program(path: Path, text: str) -> None:
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_fbx_without_assimp_says_which_package_brings_it(
    write: Write, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FormatError, match="the package assimp-utils brings it"):
        read_character(write("a.fbx", b"Kaydara"))


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("#!/bin/sh\necho first; echo 'cannot read it' >&2; exit 3\n", "assimp: cannot read it"),
        ("#!/bin/sh\nexit 3\n", "assimp: failed"),
        ("#!/bin/sh\nexit 0\n", "assimp: failed"),
        ("#!/no/such/interpreter\n", "assimp: cannot be run: No such file"),
        ("#!/bin/sh\nsleep 30\n", "assimp: expected an end within 0.2 s, got none"),
        ('#!/bin/sh\necho broken > "$3"\n', r"a\.fbx: JSON: expected a document"),
    ],
)
def test_fbx_that_assimp_cannot_export_is_refused(
    write: Write, assimp: Path, monkeypatch: pytest.MonkeyPatch, script: str, message: str
) -> None:
    _program(assimp, script)
    if "sleep" in script:
        monkeypatch.setattr(fbx, "TIME_LIMIT_S", 0.2)
        monkeypatch.setattr(fbx, "_limit", lambda: None)
    with pytest.raises(FormatError, match=message):
        read_character(write("a.fbx", b"Kaydara"))


@pytest.mark.parametrize(
    ("what", "bound"), [("-v", fbx.MEMORY_LIMIT_BYTES // 1024), ("-t", int(fbx.TIME_LIMIT_S))]
)
def test_assimp_runs_within_bounds(write: Write, assimp: Path, what: str, bound: int) -> None:
    """Of memory, in KiB, and of seconds of a processor; as the program itself sees them."""
    _program(assimp, f"#!/bin/sh\nulimit {what} >&2; exit 3\n")
    with pytest.raises(FormatError, match=f"assimp: {bound}$"):
        read_character(write("a.fbx", b"Kaydara"))


def test_assimp_may_write_no_file_beyond_the_limit(
    write: Write, assimp: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fbx, "MAX_FILE_BYTES", 1000)
    _program(assimp, '#!/bin/sh\nhead -c 100000 /dev/zero > "$3" || exit 1\n')
    with pytest.raises(FormatError, match="assimp: "):
        read_character(write("a.fbx", b"Kaydara"))


BINARY = b"UnitScaleFactorS\x06\0\0\0doubleS\x06\0\0\0NumberS\0\0\0\0D"


@pytest.mark.parametrize(
    ("data", "metres"),
    [
        (BINARY + np.float64(2.54).tobytes(), 0.0254),
        (b'P: "UnitScaleFactor", "double", "Number", "",100.0', 1.0),
        (BINARY + np.float64(0.0).tobytes(), None),
        (BINARY + np.float64(np.nan).tobytes(), None),
        (b"nothing of the kind", None),
    ],
    ids=["binary", "text", "zero", "nan", "silent"],
)
def test_the_unit_of_fbx_is_read_from_the_file_in_centimetres(
    write: Write, assimp: Path, tmp_path: Path, data: bytes, metres: float | None
) -> None:
    """Assimp's export leaves it out; where the file does not say, glTF's metres stand."""
    (tmp_path / "tower.bin.glb").write_bytes(samples.gltf_tower().glb())
    _program(assimp, f'#!/bin/sh\ncp "{tmp_path}/tower.bin.glb" "$3"\n')
    found = read_character(write("tower.fbx", data))
    assert found.height_m == pytest.approx(2.0 * (metres or 1.0), rel=1e-6)


def test_a_unit_of_fbx_that_is_no_number_is_refused(
    write: Write, assimp: Path, tmp_path: Path
) -> None:
    (tmp_path / "tower.bin.glb").write_bytes(samples.gltf_tower().glb())
    _program(assimp, f'#!/bin/sh\ncp "{tmp_path}/tower.bin.glb" "$3"\n')
    with pytest.raises(FormatError, match="UnitScaleFactor: expected a number"):
        read_character(write("a.fbx", b'"UnitScaleFactor", "double", "Number", "",1e+-1'))
