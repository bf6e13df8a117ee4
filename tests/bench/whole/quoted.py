"""Keeps the README's table of figures as the page of benchmarks has them, row by row."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["HEAD", "quoted_rows", "with_figures_of"]

HEAD = "| what | here | beside it | times ours | command |"
"""How the table of main figures begins, in the page and wherever it is quoted."""


def rows_of(text: str) -> list[str]:
    """The rows of the table of main figures.

    Raises:
        ValueError: a text without that table.
    """
    _, found, rest = text.partition(HEAD + "\n")
    if not found:
        raise ValueError(f"text: expected a table that begins {HEAD}, got none")
    return [row for row in rest.partition("\n\n")[0].splitlines()[1:] if row.startswith("|")]


def quoted_rows(readme: str, page: str) -> Iterator[tuple[str, str | None]]:
    """Each row of the README with the page's row on the same, None where it has none."""
    known = {_what(row): row for row in rows_of(page)}
    for row in rows_of(readme):
        yield row, known.get(_what(row))


def with_figures_of(readme: str, page: str) -> str:
    """The README with the page's figures in those rows that the page has."""
    for row, newer in quoted_rows(readme, page):
        readme = readme.replace(row, newer or row)
    return readme


def _what(row: str) -> str:
    return row.split("|")[1].strip()
