"""The built site: every link leads somewhere, nothing is fetched, every public name is told."""

import importlib
import inspect
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
DOCS = REPOSITORY / "docs"
FETCHED = {
    ("script", "src"),
    ("link", "href"),
    ("img", "src"),
    ("iframe", "src"),
    ("source", "src"),
}
# The theme's own links for search engines, which no browser follows.
NOT_FETCHED = {"canonical", "prev", "next", "alternate", "edit"}

if not DOCS.exists():
    pytest.skip("no pages here: an installed wheel is tested", allow_module_level=True)

pytestmark = pytest.mark.slow


class Page(HTMLParser):
    """What a page links to, what it fetches, and which places in it have a name."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = {name: value or "" for name, value in attrs}
        self.anchors |= {told[name] for name in ("id", "name") if name in told}
        if tag == "a" and "href" in told:
            self.links.append(told["href"])
        for name, value in told.items():
            if (tag, name) in FETCHED and told.get("rel") not in NOT_FETCHED:
                self.fetched.append(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, Page]:
    pytest.importorskip("mkdocs", reason="the site's tools are missing: pip install .[docs]")
    folder = tmp_path_factory.mktemp("site")
    subprocess.run(["make", "names"], cwd=REPOSITORY, check=True, capture_output=True)
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return {path: Page(path.read_text(encoding="utf-8")) for path in folder.rglob("*.html")}


def test_a_clone_named_as_the_package_is_not_taken_for_a_part_of_it(tmp_path: Path) -> None:
    """An editable install has the clone's parent folder on the path."""
    griffe = pytest.importorskip("griffe", reason="the site's tools are missing")
    subprocess.run(["make", "names"], cwd=REPOSITORY, check=True, capture_output=True)
    (tmp_path / "motorcade" / "tests").mkdir(parents=True)
    names = REPOSITORY / "build" / "names"
    found = griffe.ModuleFinder([names, tmp_path]).find_package("motorcade")
    assert found.path == names / "motorcade" / "__init__.py"


@pytest.mark.parametrize("page", sorted(DOCS.rglob("*.md")), ids=lambda page: page.stem)
def test_links_lead_to_files_where_a_page_is_read_as_it_is(page: Path) -> None:
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if not urlsplit(link).scheme and urlsplit(link).path:
            assert (page.parent / unquote(urlsplit(link).path)).exists(), f"{page.name}: {link}"


def test_every_link_and_anchor_leads_somewhere(site: dict[Path, Page]) -> None:
    broken = []
    for path, page in site.items():
        if path.name == "404.html":
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchors = site[target].anchors if target in site else set()
            if not target.exists() or (parts.fragment and unquote(parts.fragment) not in anchors):
                broken.append(f"{path.name}: {link}")
    assert not broken


def test_nothing_is_fetched_from_elsewhere(site: dict[Path, Page]) -> None:
    for path, page in site.items():
        for address in page.fetched:
            assert not urlsplit(address).netloc, f"{path.name} fetches {address}"
    for style in next(iter(site)).parent.rglob("*.css"):
        text = style.read_text(encoding="utf-8")
        assert not re.search(r"url\(['\"]?(https?:)?//", text), style


def public_names() -> list[tuple[str, str]]:
    """Page and name of every function and class that a module of the reference exports."""
    found = []
    for page in sorted((DOCS / "reference").glob("*.md")):
        for name in re.findall(r"^::: (motorcade[\w.]*)", page.read_text(), re.MULTILINE):
            try:
                module = importlib.import_module(name)
            except ModuleNotFoundError:
                continue  # a function that is told by itself
            for public in getattr(module, "__all__", ()):
                thing = getattr(module, public)
                if inspect.isclass(thing) or inspect.isfunction(thing):
                    found.append((page.stem, public))
    return found


def test_every_public_name_is_in_the_reference(site: dict[Path, Page]) -> None:
    (folder,) = {path.parent for path in site if path.parent.name == "reference"}
    missing = {
        (room, name)
        for room, name in public_names()
        if not any(
            anchor.rpartition(".")[2] == name for anchor in site[folder / f"{room}.html"].anchors
        )
    }
    assert not missing


def test_every_room_exports_what_the_reference_tells() -> None:
    told = "\n".join(page.read_text() for page in (DOCS / "reference").glob("*.md"))
    for room in ("ga", "tracking", "fusion", "animation", "render", "replays"):
        assert f"::: motorcade.{room}" in told
