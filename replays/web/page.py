"""The page of a run, or of two beside each other: one HTML file that asks for nothing."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorcade.ga.files import read_bounded
from motorcade.replays.web.pages import page_environment

WEB = Path(__file__).with_name("modules")
TEMPLATE = Path(__file__).with_name("view.html")
FILM_LIMIT = 64 * 2**20
MODULE_LIMIT = 4 * 2**20


@dataclass(frozen=True)
class InnerFilm:
    """A film inside a page: the id that its look names, and its bytes in base64."""

    id: str
    data: str


def inner_film(name: str, path: Path) -> InnerFilm:
    """A film of up to `FILM_LIMIT` bytes, to be put into a page."""
    data = read_bounded(path, FILM_LIMIT)
    return InnerFilm(name, base64.b64encode(data).decode("ascii"))


def view_page(looks: list[dict[str, Any]], films: list[InnerFilm]) -> str:
    """The page's HTML.

    Args:
        looks: documents of `look_of`, one or two.
        films: those that the looks name by "#id".
    """
    template = page_environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    names = [look["name"] for look in looks]
    return template.render(
        title=" and ".join(dict.fromkeys(names)),
        headline=looks[0]["headline"],
        style=_module("vendor.css") + _module("studio.css"),
        films=films,
        looks=[_inside_html(look) for look in looks],
        modules=_inside_html({"imports": _addresses()}),
    )


def _addresses() -> dict[str, str]:
    """Every module of the viewer as a data address, by the bare name that others import it by."""
    names = sorted(path.name for path in WEB.glob("*.js"))
    return {
        f"studio/{name}": "data:text/javascript;charset=utf-8," + _in_address(_module(name))
        for name in names
        if name != "eslint.config.js" and not name.startswith(("editor", "live"))
    }


def _in_address(text: str) -> str:
    """Text as it is, but for what an address would lose or end at, which is written as %XX."""
    for letter in "%#\n\r\t":
        text = text.replace(letter, f"%{ord(letter):02X}")
    return text


def _module(name: str) -> str:
    return read_bounded(WEB / name, MODULE_LIMIT).decode("utf-8")


def _inside_html(tree: dict[str, Any]) -> str:
    """JSON that no browser takes for markup."""
    text = json.dumps(tree, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
