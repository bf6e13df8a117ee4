"""Draws the images of `docs/drawing.md`, from the code and the scripts that the page shows.

    python docs/making/drawn_objects.py

writes `docs/images/drawn_*.svg`; a test holds them current.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from motorcade.ga.drawing import Drawing, draw_script
from motorcade.ga.script import parse

DOCS = Path(__file__).resolve().parents[1]
_FENCE = re.compile(r'^```(python|clu title="(\w+)\.clu")\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_DRAWN = re.compile(r"^motorcade draw (\w+)\.clu(.*?) -o (\w+)\.svg$", re.MULTILINE)


def images() -> dict[str, str]:
    """The images by their files' names: each ``drawn_…`` of the page's Python, each script."""
    text = (DOCS / "drawing.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    scripts = {}
    for language, name, block in _FENCE.findall(text):
        if language == "python":
            exec(compile(block, "drawing.md", "exec"), names)
        else:
            scripts[name] = block
    made = {name: value for name, value in names.items() if isinstance(value, Drawing)}
    for name, values, output in _DRAWN.findall(text):
        given = dict(pair.split("=") for pair in values.split())
        numbers = {key: _numbers(value) for key, value in given.items()}
        made[output] = draw_script(parse(scripts[name]), title=name, **numbers)
    return {f"{name}.svg": image.svg() for name, image in made.items() if "drawn_" in name}


def _numbers(text: str) -> Any:
    import numpy as np

    values = [float(part) for part in text.split(",")]
    return np.array(values) if len(values) > 1 else values[0]


def main() -> None:
    """Write the images."""
    for name, text in images().items():
        (DOCS / "images" / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
