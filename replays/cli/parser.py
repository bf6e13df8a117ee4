"""A parser that proposes the nearest option, command or value for one that it does not know."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Iterable, Sequence
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """argparse's parser; those of its commands are of this kind too.

    Fields:
        _given: the words that are being parsed.

    >>> parser = Parser(prog="motorcade")
    >>> _ = parser.add_argument("--out")
    >>> parser.parse_args(["--outt", "x"])
    Traceback (most recent call last):
    SystemExit: 2
    """

    _given: tuple[str, ...] = ()

    def parse_known_args(  # type: ignore[override]  # a command's own parser is asked by this name
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse; what is not known is an error of the command whose options it is not among."""
        self._given = tuple(sys.argv[1:] if args is None else args)
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._proposed(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """Leave with usage and message; of what is missing, also the word that may be meant for it.

        An option with a slip in its name counts as missing, which argparse tells of first.
        """
        if message.startswith("the following arguments are required"):
            options = self._option_string_actions
            slips = [one.partition("=")[0] for one in self._given if one.startswith("--")]
            unknown = [one for one in slips if not any(name.startswith(one) for name in options)]
            message += "".join(f"; no option {one}{self._proposed([one])}" for one in unknown[:1])
        super().error(message)

    def _proposed(self, unknown: Iterable[str]) -> str:
        options = [name for name in self._option_string_actions if name.startswith("--")]
        for one in unknown:
            if one.startswith("-"):
                return f"; {_nearest(one.partition('=')[0], options)}"
        return ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is none of the choices, with the nearest of them."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            if not isinstance(value, str) or action.choices is None:
                raise
            told = f"expected one of {', '.join(map(str, action.choices))}, got {value!r}"
            raise argparse.ArgumentError(
                action, f"{told}; {_nearest(value, [str(one) for one in action.choices])}"
            ) from error


def _nearest(name: str, known: Collection[str]) -> str:
    # Not at the top: commands such as doctor run where kernels do not load.
    from motorcade.ga.names import did_you_mean

    return did_you_mean(name, known)
