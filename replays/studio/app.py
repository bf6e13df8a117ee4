"""The routes: a start page, the page's own modules, and of each run what an editor needs of it.

Every path is fixed; numbers and names in it are looked up among what there is, and none becomes a
part of a file's name. All of it lies behind the `Doorkeeper`.

The pages' frames in HTML, and the modules and styles that they load, read once.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.convertors import Convertor, register_url_convertor
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from motorcade.replays.studio.access import MAX_EDITORS, Access, Doorkeeper
from motorcade.replays.studio.desk import Offer
from motorcade.replays.studio.visitors import OpenedOffers, Visitors
from motorcade.replays.web.page import WEB
from motorcade.replays.web.pages import page_environment

if TYPE_CHECKING:
    from starlette.types import ASGIApp


KEPT = {"cache-control": "private, max-age=86400, immutable"}
"""Of answers that never change while the server runs."""


def studio_app(offers: Sequence[Offer], access: Access) -> ASGIApp:
    """What is served of some runs to those whom `access` admits; one alone has no list before."""
    site = _Site(offers)
    register_url_convertor("number", _Number())
    routes = [
        Route("/", site.start),
        Route("/app.webmanifest", site.installation),
        Route("/studio/{name}", site.shell.module),
        Route("/run/{run:number}/", site.editor),
        Route("/run/{run:number}/about.json", site.about),
        Route("/run/{run:number}/frame/{frame:number}.jpg", site.frame),
        Route("/run/{run:number}/figure/{figure:number}.glb", site.figure),
        Route("/run/{run:number}/motion/{motion:number}.json", site.motion),
        Route("/run/{run:number}/film.json", site.film_state),
        Route("/run/{run:number}/film.mp4", site.film),
        WebSocketRoute("/run/{run:number}/edit", site.edit),
    ]
    return Doorkeeper(Starlette(routes=routes, lifespan=site.lifespan), access)


class _Number(Convertor[int]):
    """A number in a path; longer ones name nothing, and cost nothing to read."""

    regex = "[0-9]{1,9}"

    def convert(self, value: str) -> int:
        """Of its digits."""
        return int(value)

    def to_string(self, value: int) -> str:
        """Its digits."""
        return str(value)


class _Site:
    """What answers; one for all visitors."""

    def __init__(self, offers: Sequence[Offer]) -> None:
        self.shell, self._opened = Shell(), OpenedOffers(offers)
        self._visitors = [Visitors() for _ in offers]

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """While the server runs; at its end what was opened is closed."""
        yield
        for visitors in self._visitors:
            await run_in_threadpool(visitors.close)
        await self._opened.close()

    async def start(self, request: Request) -> Response:
        """The list of runs, or the one run."""
        offers = self._opened.offers
        if len(offers) == 1:
            return self._page(request, 0)
        nonce, base = request.scope["nonce"], request.scope["root_path"]
        return html(self.shell.page("start.html", base, nonce, offers=offers))

    async def installation(self, request: Request) -> Response:
        """What a phone asks for that keeps the page as an app."""
        text = self.shell.page("app.webmanifest", request.scope["root_path"], "")
        return Response(text, media_type="application/manifest+json")

    async def editor(self, request: Request) -> Response:
        """The page on which a run's scene is edited."""
        run = request.path_params["run"]
        if run >= len(self._opened.offers):
            raise HTTPException(404)
        return self._page(request, run)

    async def about(self, request: Request) -> Response:
        """What there is in a run: camera, path, anchors, what can be put into the scene."""
        desk = await self._opened.desk(request.path_params["run"])
        return JSONResponse(await run_in_threadpool(desk.about))

    async def frame(self, request: Request) -> Response:
        """An image of the footage."""
        desk = await self._opened.desk(request.path_params["run"])
        index = request.path_params["frame"]
        if index >= desk.frames:
            raise HTTPException(404)
        jpeg = await run_in_threadpool(desk.frame, index)
        return Response(jpeg, media_type="image/jpeg", headers=KEPT)

    async def figure(self, request: Request) -> Response:
        """What a character or a prop looks like and how it moves, as glTF."""
        desk = await self._opened.desk(request.path_params["run"])
        glb = await run_in_threadpool(desk.figure, request.path_params["figure"])
        if glb is None:
            raise HTTPException(404)
        return Response(glb, media_type="model/gltf-binary", headers=KEPT)

    async def motion(self, request: Request) -> Response:
        """What the joints of an object do, frame by frame."""
        desk = await self._opened.desk(request.path_params["run"])
        motion = await run_in_threadpool(desk.motion, request.path_params["motion"])
        if motion is None:
            raise HTTPException(404)
        return JSONResponse(motion, headers=KEPT)

    async def film_state(self, request: Request) -> Response:
        """How far the film of the scene is."""
        desk = await self._opened.desk(request.path_params["run"])
        return JSONResponse(await run_in_threadpool(desk.film_state))

    async def film(self, request: Request) -> Response:
        """The film of the scene that was drawn last."""
        desk = await self._opened.desk(request.path_params["run"])
        path = await run_in_threadpool(desk.film)
        if path is None:
            raise HTTPException(404)
        return FileResponse(path, media_type="video/mp4", headers={"cache-control": "no-store"})

    async def edit(self, socket: WebSocket) -> None:
        """One browser's messages, from when it comes until it goes."""
        run = socket.path_params["run"]
        with contextlib.suppress(HTTPException):
            desk = await self._opened.desk(run)
            visitors = self._visitors[run]
            if len(visitors) >= MAX_EDITORS:
                await socket.accept()
                await socket.close(1013, f"{MAX_EDITORS} browsers are in this scene already")
                return
            await socket.accept()
            await visitors.serve(socket, desk)
            return
        await socket.close(1008)

    def _page(self, request: Request, run: int) -> Response:
        nonce, base = request.scope["nonce"], request.scope["root_path"]
        offers = self._opened.offers
        home = f"{base}/" if len(offers) > 1 else ""  # a way back where the list has others
        name = offers[run].name
        return html(self.shell.page("editor.html", base, nonce, name=name, run=run, home=home))


def html(text: str) -> Response:
    """A page."""
    return Response(text, media_type="text/html; charset=utf-8")


_TYPES = {".js": "text/javascript", ".css": "text/css", ".png": "image/png"}


@dataclass(frozen=True)
class PageFile:
    """A file of the page: its bytes and what they are."""

    content: bytes
    media_type: str


class Shell:
    """What frames the pages: templates of a folder. Reads the pages' files when it is made."""

    def __init__(self, folder: Path = Path(__file__).parent) -> None:
        self._templates = page_environment(folder)
        self.files: Mapping[str, PageFile] = {
            path.name: PageFile(path.read_bytes(), _TYPES[path.suffix])
            for path in sorted(WEB.iterdir())
            if path.suffix in _TYPES
        }

    async def module(self, request: Request) -> Response:
        """A module or style sheet of the pages, by its name."""
        file = self.files.get(request.path_params["name"])
        if file is None:
            raise HTTPException(404)
        return Response(file.content, media_type=file.media_type, headers=KEPT)

    def page(self, template: str, base: str, nonce: str, **values: object) -> str:
        """A page; its modules go by bare names (`studio/camera.js`)."""
        modules = {
            f"studio/{file}": f"{base}/studio/{file}" for file in self.files if file.endswith(".js")
        }
        # "<" cannot stand in a name of a file of ours, but a script must not be ended by one.
        imports = json.dumps({"imports": modules}).replace("<", "\\u003c")
        page = self._templates.get_template(template)
        return page.render(base=base, nonce=nonce, imports=imports, **values)
