"""VRM files are read as glTF; their bones are told by VRM's names, whatever the authors' are."""

from pathlib import Path

import numpy as np
import pytest

from motorcade.animation import Character, read_character
from motorcade.animation.anatomy.tree import named_eyes
from motorcade.animation.formats import FormatError
from motorcade.animation.retarget.reference import body_of
from motorcade.replays.cli import main
from tests.animation.formats.samples import Gltf, Write, gltf_tower

BONES = {
    "hips": (0, 1, 0),
    "spine": (0, 1.2, 0),
    "head": (0, 1.6, 0),
    "leftUpperLeg": (0.1, 0.9, 0),
    "leftLowerLeg": (0.1, 0.5, 0),
    "leftFoot": (0.1, 0.1, 0),
    "rightUpperLeg": (-0.1, 0.9, 0),
    "rightLowerLeg": (-0.1, 0.5, 0),
    "rightFoot": (-0.1, 0.1, 0),
}
PARENTS = {"spine": "hips", "head": "spine"} | {
    f"{side}{bone}": above.format(side)
    for side in ("left", "right")
    for bone, above in (("UpperLeg", "hips"), ("LowerLeg", "{}UpperLeg"), ("Foot", "{}LowerLeg"))
}


def humanoid(version: int) -> Gltf:
    """A skinned tower whose joints are called by numbers; left is +x where it faces +z."""
    made = gltf_tower()
    sign = 1.0 if version else -1.0  # VRM 0 faces −z
    at = {name: sign * np.array(place) * [1, sign, 1] for name, place in BONES.items()}
    names = list(BONES)
    nodes = [
        {
            "name": f"J_{number}",
            "translation": (at[name] - at.get(PARENTS.get(name, ""), np.zeros(3))).tolist(),
            "children": [names.index(one) for one in names if PARENTS.get(one) == name],
        }
        for number, name in enumerate(names)
    ]
    for node in nodes:
        if not node["children"]:
            del node["children"]
    nodes.append({"name": "body", "mesh": 0, "skin": 0})
    binds = np.tile(np.eye(4), (len(names), 1, 1))
    binds[:, :3, 3] = [-at[name] for name in names]
    made.document |= {
        "nodes": nodes,
        "scenes": [{"nodes": [0, len(names)]}],
        "animations": [],
        "skins": [{
            "joints": list(range(len(names))),
            "inverseBindMatrices": made.add(binds.swapaxes(1, 2).reshape(-1, 16)),
        }],
        "materials": [{"name": "skin"}],
    }  # fmt: skip
    if version:
        bones: object = {name: {"node": k} for k, name in enumerate(names)}
        given = {"VRMC_vrm": {"specVersion": "1.0", "humanoid": {"humanBones": bones}}}
        given["VRMC_springBone"] = {}
        made.document["materials"][0]["extensions"] = {"VRMC_materials_mtoon": {}}
        made.document["meshes"][0]["primitives"][0]["material"] = 0
    else:
        bones = [{"bone": name, "node": k} for k, name in enumerate(names)]
        given = {"VRM": {
            "humanoid": {"humanBones": bones},
            "materialProperties": [{"shader": "VRM/MToon"}],
            "secondaryAnimation": {"boneGroups": [{}]},
        }}  # fmt: skip
    made.document |= {"extensions": given, "extensionsUsed": list(given)}
    return made


def read(write: Write, made: Gltf) -> Character:
    return read_character(write("figure.vrm", made.glb()))


@pytest.mark.parametrize("version", [0, 1])
def test_bones_are_called_by_what_they_are_and_the_figure_faces_x(
    write: Write, version: int
) -> None:
    found = read(write, humanoid(version))
    assert set(found.skeleton.names) == set(BONES)
    at = found.skeleton.rest_world.translation_m
    for name, (left, up, _) in BONES.items():
        wanted = [0.0, left, up]
        np.testing.assert_allclose(at[found.skeleton.index(name)], wanted, atol=1e-9)
    roles = body_of(found.skeleton)
    assert roles["left_thigh"] == found.skeleton.index("leftUpperLeg")
    assert roles["right_foot"] == found.skeleton.index("rightFoot")


@pytest.mark.parametrize(
    ("version", "thumb"),
    [(0, ("Proximal", "Intermediate", "Distal")), (1, ("Metacarpal", "Proximal", "Distal"))],
)
def test_fingers_and_eyes_are_told(
    write: Write, monkeypatch: pytest.MonkeyPatch, version: int, thumb: tuple[str, str, str]
) -> None:
    bones: dict[str, tuple[float, float, float]] = dict(BONES)
    parents, wanted = dict(PARENTS), {}
    fingers = dict.fromkeys(("Index", "Ring", "Little"), ("Proximal", "Intermediate", "Distal"))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for number, part in enumerate(("UpperArm", "LowerArm", "Hand")):
            bones[f"{side}{part}"] = (sign * (0.2 + 0.25 * number), 1.4, 0.0)
            parents[f"{side}{part}"] = (
                f"{side}{('UpperArm', 'LowerArm')[number - 1]}" if number else "spine"
            )
        for row, (name, parts) in enumerate({"Thumb": thumb, **fingers}.items()):
            above = f"{side}Hand"
            for number, part in enumerate(parts):
                bone = f"{side}{name}{part}"
                place = sign * (0.75 + 0.03 * number), 1.4, 0.04 - 0.02 * row
                bones[bone], parents[bone] = place, above
                wanted[f"{side}_{name.lower()}_{number + 1}"] = above = bone
        bones[f"{side}Eye"], parents[f"{side}Eye"] = (sign * 0.03, 1.7, 0.08), "head"
    monkeypatch.setitem(globals(), "BONES", bones)
    monkeypatch.setitem(globals(), "PARENTS", parents)
    skeleton = read(write, humanoid(version)).skeleton
    roles = body_of(skeleton)
    told = {role: skeleton.names[joint] for role, joint in roles.items() if role in wanted}
    assert told == wanted
    assert [skeleton.names[joint] for joint in named_eyes(skeleton.names)] == [
        "leftEye",
        "rightEye",
    ]


@pytest.mark.parametrize(("version", "looks"), [(0, "VRM/MToon"), (1, "VRMC_materials_mtoon")])
def test_what_is_left_out_is_named_once(write: Write, version: int, looks: str) -> None:
    notices = read(write, humanoid(version)).notices
    assert f"materials are drawn without {looks}" in notices
    assert "springs of hair and clothes stand still" in notices
    assert not any("extensions that are not read" in one for one in notices)


@pytest.mark.parametrize("node", [-1, 99, "hips", None])
def test_bones_that_are_no_nodes_are_refused(write: Write, node: object) -> None:
    made = humanoid(1)
    made.document["extensions"]["VRMC_vrm"]["humanoid"]["humanBones"]["head"]["node"] = node
    with pytest.raises(FormatError, match="VRM bone 'head': expected a whole number"):
        read(write, made)
    made.document["extensions"]["VRMC_vrm"]["humanoid"]["humanBones"]["head"]["node"] = 0
    with pytest.raises(FormatError, match="VRM bone 'head': expected a node of its own"):
        read(write, made)


def test_the_command_line_takes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "figure.vrm"
    path.write_bytes(humanoid(0).glb())
    assert main(["inspect", str(path)]) == 0
    assert "leftUpperLeg" in capsys.readouterr().out
