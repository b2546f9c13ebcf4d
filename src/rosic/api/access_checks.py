"""What stands before every route: which host was meant, which page asks, how much is sent.

Plain ASGI, so that it holds for whatever is mounted behind it: REST, WebSockets, files.
"""

from __future__ import annotations

from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from urllib.parse import parse_qs, urlsplit

import msgspec

from rosic.api.body_limits import bounded
from rosic.api.problems import PROBLEM, problem
from rosic.api.read_rates import headers_of
from rosic.api.rosbridge.endpoint import PATHS as ROSBRIDGE_PATHS
from rosic.api.settings import hostname
from rosic.core.i18n import plain, said

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping
    from typing import TypeAlias

    from rosic.api.read_rates import ReadQuota
    from rosic.api.schemas import Problem
    from rosic.api.settings import ApiSettings

    Scope: TypeAlias = MutableMapping[str, Any]
    Receive: TypeAlias = Callable[[], Awaitable[MutableMapping[str, Any]]]
    Send: TypeAlias = Callable[[MutableMapping[str, Any]], Awaitable[None]]
    Headers: TypeAlias = tuple[tuple[bytes, bytes], ...]
    App: TypeAlias = Callable[[Any, Any, Any], Awaitable[None]]

BODY_BYTES: Final = 262_144
OPEN_BYTES: Final = 16_384
"""Of a body to what is open to everybody: signing in."""
FILE_BYTES: Final = 25_000_000
FILES_PATH: Final = "/v1/files"
OPEN_PATH: Final = "/v1/sessions"
STOP_PATH: Final = "/v1/stop"
"""What is announced of its body is no reason to refuse it; no more of it than of others is read."""
KEYED_PATHS: Final = frozenset({"/foxglove"})
"""What shows and changes nothing, to programs that can show a key in an address alone."""
SAFE: Final = frozenset({"GET", "HEAD", "OPTIONS"})
SITES: Final = frozenset({"same-origin", "none"})
POLICY_VIOLATION: Final = 1008
ALLOWANCE: Final = "rosic-allowance"
"""Under which a request's state holds what its caller may still read."""

WRONG_HOST: Final = said("This gateway is not reached by that name.")
WRONG_ORIGIN: Final = said("A page of another site may not ask this. Nothing was done.")
NO_ORIGIN: Final = said("A browser has to say which page asks. Nothing was done.")
TOO_SLOW: Final = said("That came too slowly. Nothing was done.")
TOO_LARGE: Final = said("That is more than is taken here. Nothing was done.")

CONTENT_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; manifest-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
HEADERS: Final = (
    (b"content-security-policy", CONTENT_POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"permissions-policy", b"camera=(), microphone=(), geolocation=()"),
)
TLS_HEADER: Final = (b"strict-transport-security", b"max-age=31536000")


class _Refusal(NamedTuple):
    """Why something is not let through."""

    code: str
    sentence: str
    status: HTTPStatus


class AccessChecks:
    """Lets through what names us, comes from our own page or from a program, and is not too much.

    Args:
        app: What is behind.
        settings: By which names we are reached, and whether by TLS.
        cookie: Name of the cookie by which browsers show a session.
        read_policy: How often a caller may read, as its header says it.
        read: Returns a sentence in the language that an ``Accept-Language`` wants.
    """

    def __init__(
        self,
        app: App,
        settings: ApiSettings,
        cookie: str,
        read_policy: bytes,
        read: Callable[[str, str], str],
    ) -> None:
        self._app, self._cookie, self._read = app, cookie.encode(), read
        self._read_policy, self._limits = read_policy, settings.limits
        named = urlsplit(settings.url).hostname
        self._origins = frozenset(each.encode() for each in settings.origins)
        self._hosts = settings.listen.names | {*settings.hosts, *((named,) if named else ())}
        self._headers = (*HEADERS, TLS_HEADER) if settings.is_tls else HEADERS

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        headers = {name: value for name, value in scope["headers"] if name in _READ}
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            accepted = headers.get(b"accept-language", b"").decode("latin-1")
            detail = plain(self._read(refusal.sentence, accepted))
            why = problem(refusal.code, detail, status=refusal.status)
            await _refuse(scope, send, why, self._headers)
            return
        if scope["type"] == "websocket":
            if self._is_named_page(scope, headers) or _is_keyed(scope):
                scope["headers"] = [pair for pair in scope["headers"] if pair[0] != b"cookie"]
            await self._app(scope, receive, send)
            return
        is_file = scope["path"].startswith(FILES_PATH)
        within_s = self._limits.file_s if is_file else self._limits.body_s
        limited = bounded(receive, _bytes_at_most(scope["path"]), within_s)
        await self._app(scope, limited, self._dressed(scope, send))

    def _refusal(self, scope: Scope, headers: dict[bytes, bytes]) -> _Refusal | None:
        host = headers.get(b"host", b"").decode("latin-1")
        if hostname(host) not in self._hosts:
            return _Refusal("wrong-host", WRONG_HOST, HTTPStatus.MISDIRECTED_REQUEST)
        safe = scope["type"] == "http" and scope["method"] in SAFE
        safe = safe or _is_keyed(scope) or self._is_named_page(scope, headers)
        if not safe and (why := self._foreign(headers, host)):
            return _Refusal("wrong-origin", why, HTTPStatus.FORBIDDEN)
        length = headers.get(b"content-length", b"0")
        announced = int(length[:12]) if length.isdigit() else FILE_BYTES + 1
        if announced > _bytes_at_most(scope["path"]) and not _stops(scope):
            return _Refusal("too-large", TOO_LARGE, HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        return None

    def _is_named_page(self, scope: Scope, headers: dict[bytes, bytes]) -> bool:
        """Whether a page elsewhere that the configuration names comes as a client of rosbridge.

        It shows a key or a ticket: what its browser shows by itself does not count.
        """
        return (
            scope["type"] == "websocket"
            and scope["path"].rstrip("/") in ROSBRIDGE_PATHS
            and headers.get(b"origin") in self._origins
        )

    def _foreign(self, headers: dict[bytes, bytes], host: str) -> str:
        """Return why a page may not ask for something; empty: it may, or it is no page."""
        origin, site = headers.get(b"origin"), headers.get(b"sec-fetch-site")
        if site is not None and site.decode("latin-1") not in SITES:
            return WRONG_ORIGIN
        if origin is not None and _site(origin) != host:
            return WRONG_ORIGIN
        by_cookie = self._cookie in headers.get(b"cookie", b"")
        shown = headers.get(b"authorization")
        if by_cookie and shown is None and origin is None:
            return NO_ORIGIN
        return ""

    def _dressed(self, scope: Scope, send: Send) -> Send:
        async def dressed(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                allowance: ReadQuota | None = scope["state"].get(ALLOWANCE)
                told = () if allowance is None else headers_of(allowance, self._read_policy)
                message["headers"] = [*message.get("headers", ()), *self._headers, *told]
            await send(message)

        return dressed


_READ: Final = frozenset(
    {
        *(b"host", b"origin", b"sec-fetch-site", b"cookie", b"authorization", b"content-length"),
        b"accept-language",
    }
)


def _is_keyed(scope: Scope) -> bool:
    """Whether the address itself holds the key that counts, and no cookie does: whatever page asks.

    No page has such a key by itself, as it has a cookie.
    """
    if scope["type"] != "websocket" or scope["path"] not in KEYED_PATHS:
        return False
    try:
        query = parse_qs(scope["query_string"].decode("latin-1"), True, max_num_fields=8)
    except ValueError:
        return False
    return len(query.get("key", ())) == 1 and query["key"] != [""]


def _stops(scope: Scope) -> bool:
    path: str = scope["path"].rstrip("/")
    return path == STOP_PATH or (path.startswith("/v1/robots/") and path.endswith("/stop"))


def _bytes_at_most(path: str) -> int:
    if path.startswith(FILES_PATH):
        return FILE_BYTES
    return OPEN_BYTES if path.startswith(OPEN_PATH) else BODY_BYTES


def _site(origin: bytes) -> str:
    """Return host and port of a page; empty where that cannot be read, which is nobody's."""
    try:
        return urlsplit(origin.decode("latin-1")).netloc
    except ValueError:
        return ""


async def _refuse(scope: Scope, send: Send, why: Problem, headers: Headers) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": POLICY_VIOLATION, "reason": why.detail})
        return
    body = msgspec.json.encode(why)
    start = [(b"content-type", PROBLEM.encode()), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": why.status, "headers": [*start, *headers]})
    await send({"type": "http.response.body", "body": body})
