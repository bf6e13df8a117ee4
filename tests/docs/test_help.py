"""The help of every command closes with an example that its own parser takes."""

import argparse
import re
import shlex

import pytest

from motorcade.replays.cli.main import NAMES, command_parser

(GROUP,) = (a for a in command_parser()._actions if isinstance(a, argparse._SubParsersAction))


def examples(help_text: str) -> list[list[str]]:
    """The command lines below "example:", as words; continued lines are one."""
    below = help_text.partition("\nexample:\n")[2].replace("\\\n", " ")
    return [shlex.split(line) for line in below.splitlines() if line.startswith("  motorcade ")]


@pytest.mark.parametrize("name", GROUP.choices)
def test_every_help_has_an_example_that_parses(name: str) -> None:
    parser = GROUP.choices[name]
    found = examples(parser.format_help())
    assert found, "no example"
    for words in found:
        assert words[:2] == ["motorcade", name]
        parser.parse_args(words[2:])


@pytest.mark.parametrize("name", GROUP.choices)
def test_every_option_is_explained(name: str) -> None:
    for action in GROUP.choices[name]._actions:
        if action.option_strings and action.help is None:
            assert action.option_strings[0] == "-o", action.option_strings


def test_every_command_is_in_the_help_of_all_with_a_summary() -> None:
    told = re.sub(r"\s+", " ", command_parser().format_help())
    for action in GROUP._choices_actions:
        assert action.help is not None
        assert " ".join(action.help.split()) in told
    assert {action.dest for action in GROUP._choices_actions} == set(GROUP.choices)
    assert tuple(GROUP.choices) == tuple(NAMES)


def test_an_example_that_no_longer_parses_is_noticed() -> None:
    parser = argparse.ArgumentParser(prog="motorcade nothing")
    with pytest.raises(SystemExit):
        parser.parse_args(examples("\nexample:\n  motorcade nothing --gone 3\n")[0][2:])
