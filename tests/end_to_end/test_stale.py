"""Every kind of file that a run opens: one byte changes, and what was made of it is made again."""

from pathlib import Path

import pytest

from tests.end_to_end.stale.__main__ import STEADY, cases, row, swept
from tests.end_to_end.stale.kinds import CHARACTERS, Kind
from tests.replays.tiny_recordings import write_tiny

QUICK = {
    ".gltf",
    ".bin of a .gltf",
    "texture of a .gltf",
    ".md5anim of it",
    "texture that was missing",
}
CASES = [
    pytest.param(
        kind,
        way,
        id=f"{kind.name}, {way}",
        marks=[pytest.mark.slow] * (way == "sweep" or (way == "knob" and kind.name not in QUICK)),
    )
    for kind, way in cases()
]


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.mark.quick_every(3)
@pytest.mark.parametrize(("kind", "way"), CASES)
def test_what_read_a_changed_file_is_made_again_and_nothing_else(
    kind: Kind, way: str, tmp_path: Path, cache: Path
) -> None:
    made = row(kind, way, tmp_path, cache)
    assert made.faults == (), made


def test_a_sweep_means_the_files_beside_it_wherever_it_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    glb = next(kind for kind in CHARACTERS if kind.name == ".glb")
    write_tiny(tmp_path / "recording", 0.1)
    knobs = [f"{name} = {value!r}" for name, _, value in (one.partition("=") for one in STEADY)]
    knobs += ["placed.character = 'figures/hero.glb'", "placed.clip = 'bend'"]
    plan = tmp_path / "sweep.toml"
    plan.write_text(
        "\n".join(["recordings = ['recording']", "until = 'placed'", "[knobs]", *knobs])
    )
    (tmp_path / "figures").mkdir()
    (tmp_path / "elsewhere").mkdir()
    changing = glb.write(tmp_path / "figures")
    done = []
    for place in (tmp_path, tmp_path / "elsewhere"):
        monkeypatch.chdir(place)
        done.append(swept(plan, tmp_path).done)
    glb.change(changing)
    done.append(swept(plan, tmp_path).done)
    assert done == [1, 0, 1]
