"""Arguments and habits that several commands share."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motorcade.replays.studio.serving import Listening

Command = Callable[[argparse.Namespace], None]
Options = argparse._ActionsContainer  # a parser, or a group of its options


@dataclass(frozen=True)
class Commands:
    """The program's commands so far, and the parser of the options that all of them share."""

    subparsers: Any
    shared: argparse.ArgumentParser

    def add(
        self, command: Command, name: str, summary: str, example: str
    ) -> argparse.ArgumentParser:
        """A command whose help closes with an example; `command` is called with its arguments."""
        parser: argparse.ArgumentParser = self.subparsers.add_parser(
            name,
            parents=[self.shared],
            help=summary,
            description=summary[0].upper() + summary[1:] + ".",
            epilog=f"example:\n  {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        parser.set_defaults(command=command)
        return parser


def add_flag(parser: Options, name: str, what: str) -> None:
    """An option that is there or not."""
    parser.add_argument(name, action="store_true", help=what)


def add_file(parser: Options, name: str, what: str, metavar: str = "FILE", **options: Any) -> None:
    """A file or a folder: an option where the name begins with dashes, else a positional word."""
    parser.add_argument(name, type=Path, metavar=metavar, help=what, **options)


def add_number(
    parser: Options, name: str, what: str, default: object = None, **options: Any
) -> None:
    """A number with its usual value."""
    parser.add_argument(name, type=float, default=default, help=what, **options)


def add_choice(
    parser: Options, name: str, choices: Sequence[str], what: str, default: str | None = None
) -> None:
    """One of some words."""
    parser.add_argument(name, choices=choices, default=default, help=what)


def add_output(parser: Options, metavar: str = "FILE", what: str | None = None) -> None:
    """The required `-o`, `--output`."""
    parser.add_argument("-o", "--output", type=Path, required=True, metavar=metavar, help=what)


def add_axes(parser: argparse.ArgumentParser) -> None:
    """Add `--up` and `--front`, for characters whose files and limbs do not tell them."""
    for option, what in (("up", "is up"), ("front", "the figure faces at rest")):
        parser.add_argument(
            f"--{option}", metavar="AXIS", help=f"axis of the file that {what}, as --{option}=-z"
        )


def add_stamps(parser: argparse.ArgumentParser) -> None:
    """Add `--rate-hz` and `--times`: one of them gives poses of KITTI files their stamps."""
    add_number(parser, "--rate-hz", "rate of KITTI files, which have no stamps", metavar="HZ")
    add_file(parser, "--times", "or their stamps, one a row, s")


def add_executor(parser: argparse.ArgumentParser, default: str, where: str = "") -> None:
    """The option that says where many jobs run."""
    parser.add_argument(
        "--executor",
        default=default,
        metavar="E",
        help=f"{where}local, processes (one a core), processes:4, or the address of a Dask "
        f"scheduler such as tcp://host:8786 ({default})",
    )


def add_server(parser: argparse.ArgumentParser) -> None:
    """What is said of the server of a page."""
    add_flag(parser, "--lan", "let the network in, by a link")
    parser.add_argument("--port", type=int, default=0, metavar="N", help="listen there (any free)")
    parser.add_argument(
        "--tls", type=Path, nargs=2, metavar=("CERT", "KEY"), help="serve by https, with these"
    )
    add_flag(parser, "--no-open", "print the link, open no browser")


def listening_of(arguments: argparse.Namespace) -> Listening:
    """Where `add_server`'s options say to listen. Raises ModuleNotFoundError without `[studio]`."""
    from motorcade.replays.studio.serving import Listening

    tls = None if arguments.tls is None else (arguments.tls[0], arguments.tls[1])
    return Listening(arguments.lan, arguments.port, tls)


def add_seed(parser: argparse.ArgumentParser, default: int | None, what: str) -> None:
    """The option that says which random numbers are drawn; bad usage where it is negative."""
    parser.add_argument(
        "--seed", type=_whole_number, default=default, metavar="N", help=f"of {what} (0)"
    )


def _whole_number(text: str) -> int:
    if not text.isdecimal() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 on, got {text[:40]!r}")
    return int(text)


def chosen(arguments: argparse.Namespace, *names: str) -> dict[str, Any]:
    """The options of these names, for what takes them by the same names."""
    return {name: getattr(arguments, name) for name in names}


def check_known(option: str, names: Iterable[str], known: Collection[str]) -> None:
    """ValueError with the nearest known name where one of the names of an option is unknown."""
    for name in names:
        if name not in known:
            # Not at the top: commands such as doctor run where kernels do not load.
            from motorcade.ga.names import did_you_mean

            raise ValueError(f"{option}: unknown {name!r}; {did_you_mean(name, known)}")


def print_json(values: Mapping[str, Any]) -> None:
    """Machine-readable results on standard output; keys carry units."""
    print(json.dumps(values, indent=2))


def write_json(path: Path | None, values: object) -> None:
    """The same into a file, where one is named."""
    from motorcade.replays.io.files import write_bytes

    if path is not None:
        write_bytes(path, (json.dumps(values, indent=2) + "\n").encode())


def shown(value: object) -> str:
    """A value as a person reads it: five digits of a number, those of a list beside each other.

    What is below a millionth of a millionth is rounding: 0. Files and `--json` keep every digit.

    >>> shown(507.8105312240405), shown(1.9666666669999997), shown(30.0000003), shown(470581.6)
    ('507.81', '1.9667', '30', '470582')
    >>> shown([5.6e-17, -0.00034903212, None, 12])
    '0 -0.00034903 – 12'
    """
    if isinstance(value, list | tuple):
        return " ".join(map(shown, value))
    if isinstance(value, float):
        small, large = abs(value) < 1e-12, 1e5 <= abs(value) < 1e15
        return "0" if small else f"{value:.0f}" if large else f"{value:.5g}"
    return "–" if value is None else str(value)


def one_line(error: BaseException) -> str:
    """What went wrong as one line: what, where, and what to do."""
    if isinstance(error, ModuleNotFoundError) and error.name is not None:
        from motorcade.replays.tasks.doctor import how_to_install

        package = error.name.partition(".")[0]
        return (
            f"this command needs the Python package {package!r}, which is not installed; "
            f"{how_to_install(package)} brings it"
        )
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    text = " ".join(str(error).split())
    if isinstance(error, (ValueError, OSError, RuntimeError)) and text:
        return text
    return f"unexpected {type(error).__name__}: {text or 'no message'}; -vv shows where"
