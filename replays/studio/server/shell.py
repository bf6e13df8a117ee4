"""The pages' frames in HTML, and the modules and styles that they load, read once."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Template

    from motorcade.replays.studio.server.offers import Offer

_WEB = Path(__file__).parents[1] / "web"
_TYPES = {".js": "text/javascript", ".css": "text/css", ".png": "image/png"}


@dataclass(frozen=True)
class PageFile:
    """A file of the page: its bytes and what they are."""

    content: bytes
    media_type: str


class Shell:
    """What frames the pages. Reads the page's files when it is made."""

    def __init__(self) -> None:
        from jinja2 import Environment, FileSystemLoader, StrictUndefined

        templates = Environment(
            loader=FileSystemLoader(Path(__file__).parent),
            autoescape=True,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
        self._start: Template = templates.get_template("start.html")
        self._editor: Template = templates.get_template("editor.html")
        self.files: Mapping[str, PageFile] = {
            path.name: PageFile(path.read_bytes(), _TYPES[path.suffix])
            for path in sorted(_WEB.iterdir())
            if path.suffix in _TYPES
        }

    def start(self, offers: Sequence[Offer], base: str, nonce: str) -> str:
        """The list of runs."""
        return self._start.render(offers=offers, base=base, nonce=nonce)

    def editor(self, offers: Sequence[Offer], run: int, base: str, nonce: str) -> str:
        """The editor of one run; its modules go by bare names (`studio/camera.js`).

        A way back to the list is there where the list has others.
        """
        modules = {
            f"studio/{file}": f"{base}/studio/{file}" for file in self.files if file.endswith(".js")
        }
        # "<" cannot stand in a name of a file of ours, but a script must not be ended by one.
        imports = json.dumps({"imports": modules}).replace("<", "\\u003c")
        home = f"{base}/" if len(offers) > 1 else ""
        name = offers[run].name
        return self._editor.render(
            name=name, run=run, base=base, home=home, nonce=nonce, imports=imports
        )

    @staticmethod
    def installation(base: str) -> dict[str, Any]:
        """A web app manifest."""
        sizes = ((192, "any"), (512, "any"), (512, "maskable"))
        return {
            "name": "Motorcade scenes",
            "short_name": "Motorcade",
            "start_url": f"{base}/",
            "scope": f"{base}/",
            "display": "standalone",
            "background_color": "#15181c",
            "theme_color": "#15181c",
            "icons": [
                {
                    "src": f"{base}/studio/icon-{size}.png",
                    "sizes": f"{size}x{size}",
                    "type": "image/png",
                    "purpose": purpose,
                }
                for size, purpose in sizes
            ],
        }
