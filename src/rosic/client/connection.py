"""How a gateway is reached: where, with which key, and whom its certificate has to be signed by."""

from __future__ import annotations

import ssl
from http import HTTPStatus
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar
from urllib.parse import urlsplit

import httpx
import msgspec

from rosic.api.schemas import Problem
from rosic.client.errors import (
    SERVER_FAULTS,
    ApiProblem,
    GatewayUnreachable,
    NotAGateway,
    NotAnswered,
    NotKnown,
    NotTrusted,
    raised_for,
)
from rosic.core.hosts import is_this_machine
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

T = TypeVar("T")

CONNECT_S: Final = 5.0
ANSWER_S: Final = 15.0
PROBLEM: Final = "application/problem+json"
JSON: Final = "application/json"
BYTES: Final = "application/octet-stream"
ANOTHER: Final = "What answers at {url} speaks another version of this protocol, or is no ROSIC."
DEFAULT_PORTS: Final = {"http": "ws", "https": "wss"}
IN_CLEAR: Final = (
    "{url} is not encrypted, and the key would be read on the way. Use https, or say that it may "
    "be so (unencrypted)."
)
NO_URL: Final = "{url!r} is no address of a gateway. Write it as https://robots.example.org"
NO_KEY: Final = "That is no key of a gateway: one begins with rosic_ and holds no blank."


class GatewayAddress:
    """Where a gateway is, and how it is spoken to.

    Args:
        url: ``https://robots.example.org``, perhaps with the path of a proxy.
        key: As ``rosic key create`` shows it.
        ca: File of the certificates that are trusted, in PEM; empty: those of this machine.
        unencrypted: Other machines may be asked without TLS: whoever listens reads the key.

    Raises:
        ConfigurationError: It is no address or no key, or the file cannot be used. Nothing was
            sent.
    """

    def __init__(
        self, url: str, key: Secret | str, *, ca: str | Path = "", unencrypted: bool = False
    ) -> None:
        self.url = _checked_url(url)
        parts = urlsplit(self.url)
        self.is_tls = parts.scheme == "https"
        if not (self.is_tls or unencrypted or is_this_machine(parts.hostname or "")):
            raise ConfigurationError(IN_CLEAR.format(url=self.url))
        shown = key.reveal() if isinstance(key, Secret) else key.strip()
        if not _is_key(shown):
            raise ConfigurationError(NO_KEY)
        self._key = Secret(shown)
        self.context = _trusting(ca) if self.is_tls else None

    @property
    def headers(self) -> dict[str, str]:
        """Return what shows the key."""
        return {"Authorization": f"Bearer {self._key.reveal()}"}

    @property
    def events_url(self) -> str:
        """Where what happens is told, as it happens."""
        scheme, _, rest = self.url.partition("://")
        return f"{DEFAULT_PORTS[scheme]}://{rest}/v1/events"

    def http(self) -> httpx.AsyncClient:
        """Return what asks there, and nowhere else: a redirect is not followed."""
        return httpx.AsyncClient(
            base_url=f"{self.url}/v1/",
            headers={**self.headers, "Accept": f"{JSON}, {PROBLEM}"},
            verify=self.context or True,
            timeout=httpx.Timeout(ANSWER_S, connect=CONNECT_S),
            follow_redirects=False,
        )


def _checked_url(url: str) -> str:
    whole = url.strip().rstrip("/")
    try:
        parts = urlsplit(whole)
        besides = parts.query or parts.fragment or parts.username
        good = parts.scheme in DEFAULT_PORTS and parts.hostname and parts.port != 0 and not besides
    except ValueError:
        good = False
    if not good:
        raise ConfigurationError(NO_URL.format(url=url[:200]))
    return whole


def _is_key(text: str) -> bool:
    return text.startswith("rosic_") and text.isascii() and text.isprintable() and " " not in text


def _trusting(ca: str | Path) -> ssl.SSLContext:
    try:
        return ssl.create_default_context(cafile=str(ca) if ca else None)
    except OSError as error:  # as are those of TLS
        why = error.strerror or "no certificates"
        raise ConfigurationError(
            f"{ca} cannot be used to know the gateway by ({why}).",
            hint="Name a file of certificates in PEM.",
        ) from error


# ---- asking once ----


class ApiCall(NamedTuple):
    """What is asked, below ``/v1/``.

    Attributes:
        body: A struct of `rosic.api.schemas`, or bytes as they are; None: nothing.
        within_s: So long it waits for an answer.
    """

    method: str
    path: str
    body: object = None
    headers: Mapping[str, str] | None = None
    params: Mapping[str, str | float] | None = None
    within_s: float = ANSWER_S


class MediaContent(NamedTuple):
    """An answer that is no JSON."""

    content: bytes
    media_type: str
    headers: Mapping[str, str]


async def ask(http: httpx.AsyncClient, call: ApiCall, type_: type[T]) -> T:
    """Ask once, and return the answer.

    Raises:
        ApiProblem: The gateway says no.
        GatewayUnreachable, NotTrusted, NotAGateway: Nothing was done by a gateway.
        NotKnown: It was asked, and the connection broke before it had answered.
    """
    return _read(await _asked(http, call), type_, _shown(http))


async def fetch(http: httpx.AsyncClient, call: ApiCall, kind: str) -> MediaContent:
    """Ask once, and return the content of the answer.

    Args:
        http: Asks.
        call: What.
        kind: How its media type begins: ``image/``.

    Raises:
        ApiProblem, GatewayUnreachable, NotTrusted, NotAGateway, NotKnown: See `ask`.
    """
    answer = await _asked(http, call)
    found = _media_type(answer)
    if answer.is_success and found.startswith(kind):
        return MediaContent(answer.content, found, answer.headers)
    raise _refused(answer, _shown(http))


async def _asked(http: httpx.AsyncClient, call: ApiCall) -> httpx.Response:
    body, kind = call.body, JSON
    if isinstance(body, bytes):
        kind = BYTES
    elif body is not None:
        body = msgspec.json.encode(body)
    sent = {"Content-Type": kind} if body is not None else {}
    try:
        return await http.request(
            call.method,
            call.path,
            content=body,
            params=call.params,
            headers={**sent, **(call.headers or {})},
            timeout=httpx.Timeout(call.within_s, connect=CONNECT_S),
        )
    except httpx.TransportError as error:
        raise _broken(error, _shown(http)) from error


def _read(answer: httpx.Response, type_: type[T], url: str) -> T:
    try:
        if answer.is_success and _media_type(answer) == JSON:
            found: T = msgspec.json.decode(answer.content, type=type_)
            return found
        if answer.status_code == HTTPStatus.NO_CONTENT:
            return msgspec.convert(None, type_)
    except msgspec.MsgspecError as error:
        raise NotAGateway(ANOTHER.format(url=url), url=url) from error
    raise _refused(answer, url)


def _media_type(answer: httpx.Response) -> str:
    kind: str = answer.headers.get("content-type", "").partition(";")[0].strip()
    return kind


def _refused(answer: httpx.Response, url: str) -> ApiProblem | NotAnswered:
    """Return what it means that a request was not answered with what was asked for."""
    if _media_type(answer) == PROBLEM:
        try:
            found = msgspec.json.decode(answer.content, type=Problem)
        except msgspec.MsgspecError:
            return NotAGateway(ANOTHER.format(url=url), url=url)
        late = found.status == HTTPStatus.GATEWAY_TIMEOUT
        return NotKnown(found.detail, url=url) if late else raised_for(found)
    if answer.status_code >= SERVER_FAULTS:
        return NotKnown(
            f"{url} is answered by something before the gateway, which says {answer.status_code}: "
            "the gateway is away, or late.",
            url=url,
        )
    if answer.is_redirect:
        where = answer.headers.get("location", "elsewhere")[:200]
        return NotAGateway(
            f"{url} sends on to {where}, and a key is not taken there. Name that address.", url=url
        )
    return NotAGateway(
        f"Something answers at {url}, and it is no ROSIC gateway ({answer.status_code}).", url=url
    )


def _broken(error: httpx.TransportError, url: str) -> GatewayUnreachable | NotTrusted | NotKnown:
    """Return what it means that a request was not answered."""
    found = _cause(error, ssl.SSLCertVerificationError)
    if found is not None:
        why = found.verify_message.rstrip(".")
        return NotTrusted(f"The certificate of {url} is not trusted here: {why}.", url=url)
    if _cause(error, ssl.SSLError) is not None:
        return NotTrusted(f"What listens at {url} does not speak TLS as it should.", url=url)
    if isinstance(error, httpx.ConnectTimeout):
        return GatewayUnreachable(f"Nothing answers at {url}.", url=url)
    if isinstance(error, httpx.ConnectError | httpx.PoolTimeout):
        return GatewayUnreachable(f"No gateway can be reached at {url}{_why(error)}.", url=url)
    if isinstance(error, httpx.RemoteProtocolError) and "illegal" in str(error).lower():
        return NotTrusted(f"What listens at {url} does not speak HTTP.", url=url)
    return NotKnown(f"{url} was asked, and has not answered. It may have been done.", url=url)


def _why(error: Exception) -> str:
    found = _cause(error, OSError)
    said = "" if found is None else (found.strerror or "")
    return f" ({said})" if said and "connection attempts failed" not in said else ""


E_ = TypeVar("E_", bound=BaseException)


def _cause(error: BaseException | None, kind: type[E_]) -> E_ | None:
    """Return the first of a kind among an error and what has led to it."""
    seen = 0
    while error is not None and seen < 10:  # noqa: PLR2004 - a circle ends
        if isinstance(error, kind):
            return error
        error, seen = error.__cause__ or error.__context__, seen + 1
    return None


def _shown(http: httpx.AsyncClient) -> str:
    return str(http.base_url).removesuffix("/v1/")
