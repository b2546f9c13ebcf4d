"""The files of the page, as a browser gets them: compressed, named by their hash, kept for ever.

They lie in ``static`` as they were written; there is no build. All of them together have one hash,
which is a part of their addresses, so that a browser may keep what it has, and has all of it anew
when one of them is another.
"""

from __future__ import annotations

import gzip
import json
from hashlib import sha256
from http import HTTPStatus
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.console.texts import TEXTS

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator, Mapping, MutableMapping
    from importlib.resources.abc import Traversable

    from rosic.core.i18n import Catalogue

    Scope = MutableMapping[str, Any]
    Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
    Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
    App = Callable[[Any, Any, Any], Awaitable[None]]

ROOT: Final = "/console"
INDEX: Final = "index.html"
ALWAYS_ASKED: Final = "no-cache"
KEPT_FOR_EVER: Final = "public, max-age=31536000, immutable"
MEDIA_TYPES: Final[Mapping[str, str]] = {
    "css": "text/css; charset=utf-8",
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "json": "application/json",
    "mjs": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}
BARE_NAMES: Final[Mapping[str, tuple[bytes, bytes]]] = {
    # A browser finds a library by its address alone; an import map would be a script in the page.
    "vendor/hooks.mjs": (b'from"preact"', b'from"./preact.mjs"'),
}


class ConsoleFile(NamedTuple):
    """One file.

    Attributes:
        body, packed: As it is, and compressed.
        etag: Changes with it.
        kept: What a browser is told of how long it may keep it.
    """

    body: bytes
    packed: bytes
    media_type: str
    etag: bytes
    kept: str

    @classmethod
    def of(cls, name: str, body: bytes, kept: str) -> ConsoleFile:
        """Make one of its name and its content."""
        etag = f'"{sha256(body).hexdigest()[:20]}"'.encode()
        packed = gzip.compress(body, 9, mtime=0)
        return cls(body, packed, MEDIA_TYPES[name.rpartition(".")[2]], etag, kept)


class ConsolePages:
    """Answers with the files of the page, and passes on everything else.

    Args:
        app: What is behind.
        catalogues: What the page may be read in besides English, by code.
    """

    def __init__(self, app: App, catalogues: Mapping[str, Catalogue]) -> None:
        self._app = app
        self._files = page_files(catalogues)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        found = self._files.get(scope["path"]) if scope["type"] == "http" else None
        if found is None or scope["method"] not in {"GET", "HEAD"}:
            await self._app(scope, receive, send)
            return
        asked = {name: value for name, value in scope["headers"] if name in _READ}
        headers = [(b"etag", found.etag), (b"cache-control", found.kept.encode())]
        if found.etag in asked.get(b"if-none-match", b""):
            await _answer(send, HTTPStatus.NOT_MODIFIED, headers)
            return
        body = found.body
        if b"gzip" in asked.get(b"accept-encoding", b""):
            body = found.packed
            headers.append((b"content-encoding", b"gzip"))
        headers += [
            (b"vary", b"accept-encoding"),
            (b"content-type", found.media_type.encode()),
            (b"content-length", str(len(body)).encode()),
        ]
        await _answer(send, HTTPStatus.OK, headers, b"" if scope["method"] == "HEAD" else body)


_READ: Final = frozenset({b"if-none-match", b"accept-encoding"})


async def _answer(
    send: Send, status: HTTPStatus, headers: list[tuple[bytes, bytes]], body: bytes = b""
) -> None:
    await send({"type": "http.response.start", "status": int(status), "headers": headers})
    await send({"type": "http.response.body", "body": body})


def page_files(catalogues: Mapping[str, Catalogue]) -> dict[str, ConsoleFile]:
    """Return every file by the path of its address.

    Args:
        catalogues: What the page may be read in besides English, by code.
    """
    bodies = dict(_static(files("rosic.console") / "static", ""))
    for name, (bare, address) in BARE_NAMES.items():
        bodies[name] = bodies[name].replace(bare, address)
    index = bodies.pop(INDEX)
    every = b"".join(name.encode() + body for name, body in sorted(bodies.items()))
    bundle = f"{ROOT}/{sha256(every).hexdigest()[:16]}"
    page = ConsoleFile.of(INDEX, index.replace(b"{bundle}", bundle.encode()), ALWAYS_ASKED)
    found = {
        f"{bundle}/{name}": ConsoleFile.of(name, body, KEPT_FOR_EVER)
        for name, body in bodies.items()
    }
    for code, catalogue in catalogues.items():
        words = {text: catalogue.gettext(text) for text in TEXTS}
        body = json.dumps(words, ensure_ascii=False, separators=(",", ":")).encode()
        found[f"{ROOT}/texts/{code}.json"] = ConsoleFile.of("words.json", body, ALWAYS_ASKED)
    return {"/": page, **found}


def _static(folder: Traversable, before: str) -> Iterator[tuple[str, bytes]]:
    for each in folder.iterdir():
        name = before + each.name
        if each.is_dir():
            yield from _static(each, f"{name}/")
        elif name.rpartition(".")[2] in MEDIA_TYPES:
            yield name, each.read_bytes()
