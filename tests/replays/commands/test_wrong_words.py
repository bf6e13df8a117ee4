"""Wrong options, commands and values: the nearest is proposed; shells complete the right ones."""

import argparse
import shutil
import subprocess

import pytest

from motorcade.replays.cli.main import NAMES, command_parser, main
from tests.replays.tiny_recordings import write_tiny


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    return write_tiny(tmp_path_factory.mktemp("recordings") / "tiny", 0.3)


def told(capsys, *words):
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    return capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("run", "clip", "--outt", "x"), "--out"),
        (("run", "clip", "--manfest=x.toml"), "--manifest"),
        (("smooth", "a.tum", "-o", "b.tum", "--metod", "kalman"), "--method"),
        (("evaluate", "a", "b", "--align", "sm3"), "sim3"),
        (("trajectory", "a", "--format", "tumm"), "tum"),
        (("evalute", "a", "b"), "evaluate"),
        (("completion", "zssh"), "zsh"),
        (("--verson",), "--version"),
        (("smooth", "a.tum", "--outputt", "b.tum"), "--output"),
        (("fuse", "--noisee", "n.yaml"), "--noise"),
    ],
)
def test_the_nearest_is_proposed(capsys, words, meant):
    assert told(capsys, *words).endswith(f"did you mean {meant}?")


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("run {} --until smothed", "smoothed"),
        ("run {} --set smothed.method=auto", "smoothed"),
        ("run {} --set smoothed.metod=auto", "method"),
        ("run {} --set placed.on=markr", "marker"),
        ("run {} --set smoothed.representations=moter", "motor"),
        ("run {} --set smoothed.method=gausian", "gaussian"),
        ("run {} --executor procesess", "processes"),
        ("smooth {}/truth.tum -o s.tum --representation moter", "motor"),
        ("smooth {}/truth.tum -o s.tum --method gausian", "gaussian"),
        ("smooth {}/truth.tum -o s.tum --method gaussian --set sigm_s=1", "sigma_s"),
        ("evaluate {0}/truth.tum {0}/truth.tum --relations trans_pat", "trans_part"),
        ("compare --noise gausian", "gaussian"),
        ("compare --trajectories handhold", "handheld"),
        ("detect {}/images/0.png --family tag36h12", "tag36h11"),
    ],
)
def test_the_nearest_stage_knob_and_value_is_proposed(words, meant, tiny, capsys, monkeypatch):
    monkeypatch.chdir(tiny.parent)
    words = words.format(tiny).split()
    assert main([*words, *(["--set", "tracked.by=simulated"] if words[0] == "run" else ())]) == 1
    assert f"did you mean {meant}?" in capsys.readouterr().err


@pytest.mark.parametrize("name", sorted(NAMES))
def test_every_option_is_proposed_for_itself_with_a_letter_too_many(capsys, name):
    (group,) = (
        one for one in command_parser()._actions if isinstance(one, argparse._SubParsersAction)
    )
    command = group.choices[name]
    options = [one for one in command._option_string_actions if one.startswith("--")]
    positional = ["1" for one in command._actions if not one.option_strings and one.nargs != "?"]
    for option in options:
        # Choices of a positional and options that are required are told of first.
        line = told(capsys, name, *positional, option + "q")
        if "unrecognized" in line:
            assert line.endswith(f"did you mean {option}?"), line


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "tcsh"])
def test_the_script_of_a_shell_names_every_command(capsys, shell):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert not [name for name in NAMES if name not in script]
    if shell in ("bash", "zsh", "fish") and shutil.which(shell):
        checked = subprocess.run([shell, "-n"], input=script, text=True, capture_output=True)
        assert (checked.returncode, checked.stderr) == (0, "")


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_completes_commands_options_and_choices(capsys, tmp_path):
    main(["completion", "bash"])
    (tmp_path / "script").write_text(capsys.readouterr().out)

    def completed(*words):
        line = " ".join(words)
        asked = (
            f"source {tmp_path}/script; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; "
            f"_shtab_motorcade motorcade {words[-1]!r} {words[-2]!r}; "
            'printf "%s\\n" "${COMPREPLY[@]}"'
        )
        found = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, check=False)
        return {one.strip() for one in found.stdout.split()}

    assert completed("motorcade", "eva") == {"evaluate"}
    assert completed("motorcade", "run", "--man") == {"--manifest"}
    assert completed("motorcade", "evaluate", "--align", "si") == {"sim3"}
