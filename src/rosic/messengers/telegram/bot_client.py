"""The line to the Bot API: python-telegram-bot's Bot, time-bounded, and silent about its token."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from contextlib import aclosing
from http import HTTPStatus
from importlib.util import find_spec
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar, cast

import httpx
import msgspec
from telegram import Bot
from telegram.error import NetworkError, TelegramError
from telegram.request import HTTPXRequest

from rosic.core.traffic import TrafficCounter
from rosic.errors import ConfigurationError, RosicError
from rosic.messengers.telegram import updates as wire
from rosic.messengers.telegram.errors import DEFAULT_WAIT_S, FloodControl, trouble
from rosic.messengers.telegram.settings import API_BASE
from rosic.messengers.telegram.upload_stream import ChangedUpload, UploadStream

if TYPE_CHECKING:
    import ssl
    from collections.abc import (
        AsyncGenerator,
        AsyncIterator,
        Awaitable,
        Callable,
        Mapping,
        Sequence,
    )

    from telegram.request import RequestData

    from rosic.core.message import Attachment
    from rosic.messengers.telegram.settings import TelegramSettings

# httpcore asks for it several times a request, and Python looks through every folder each time,
# unless it is said so: that it is not there.
if find_spec("sniffio") is None:
    sys.modules["sniffio"] = None  # type: ignore[assignment]

T = TypeVar("T")

CONNECT_S = 5.0
ANSWER_S = 10.0
CALL_S = 20.0
POLL_GRACE_S = 5.0
"""How much longer than asked for a poll may take before the connection counts as dead."""
SIDE_BY_SIDE = 32
DENIED = frozenset({401, 404})
"""How the Bot API answers to a token that it does not know."""


class _Request(HTTPXRequest):
    """Differs in what it does with answers that are no JSON, and with 429."""

    @staticmethod
    def parse_json_payload(payload: bytes) -> dict[str, Any]:
        """Parse without logging what people wrote, which the original does when it fails."""
        try:
            answer = json.loads(payload)
        except (ValueError, RecursionError):
            answer = None
        if not isinstance(answer, dict):
            raise TelegramError("the answer is not what Telegram says")
        return answer

    async def do_request(self, *args: Any, **kwargs: Any) -> tuple[int, bytes]:  # noqa: ANN401
        """Ask, and recognise 429 whoever says it, and 401 and 404 from the Bot API alone.

        A proxy, or a server of one's own that starts again, answers 404 with a page of its own:
        that says nothing of the token.

        Raises:
            FloodControl: The call has taken no effect.
            ChangedUpload: Likewise; the file is not what was promised.
            NetworkError: Somebody else than the Bot API answered.
        """
        if isinstance(kwargs.get("request_data"), UploadStream):
            code, payload = await self._upload(**kwargs)
        else:
            code, payload = await super().do_request(*args, **kwargs)
        if code == HTTPStatus.TOO_MANY_REQUESTS:
            raise FloodControl(_retry_after_s(payload))
        if code in DENIED and not _says(code, payload):
            raise NetworkError(f"the answer {code} is not what Telegram says")
        return code, payload

    async def _upload(
        self, url: str, request_data: UploadStream, read_timeout: float, **_more: object
    ) -> tuple[int, bytes]:
        """Send a file while it is read."""
        try:
            async with aclosing(request_data.body()) as body:
                answer = await self._client.post(
                    url,
                    content=body,
                    headers={"User-Agent": self.USER_AGENT, **request_data.headers},
                    timeout=(CONNECT_S, read_timeout, read_timeout, CONNECT_S),
                )
        except RosicError as error:
            raise ChangedUpload(error.sentence) from None
        except Exception as error:
            raise NetworkError("the file did not go through") from error
        return answer.status_code, answer.content

    async def pieces(self, url: str, size: int) -> AsyncGenerator[bytes]:
        """Read what is at an address, piece by piece; what it is called says whose it is.

        Raises:
            TelegramError: There is nothing to be had.
        """
        async with self._client.stream("GET", url) as answer:
            if answer.status_code != HTTPStatus.OK:
                raise TelegramError(f"the file is not there: {answer.status_code}")
            async for piece in answer.aiter_raw(size):
                yield piece


class _Polling(_Request):
    """Leaves updates as they came: each is taken apart by itself, and one seen before never."""

    @staticmethod
    def parse_json_payload(payload: bytes) -> dict[str, Any]:
        """Find where each update begins and ends."""
        try:
            answer = msgspec.json.decode(payload, type=wire.ApiAnswer)
        except (msgspec.DecodeError, RecursionError):  # halves of characters, or no JSON
            return _Request.parse_json_payload(payload)
        if answer.result is not None:
            return {"ok": answer.ok, "result": answer.result}
        return _Request.parse_json_payload(payload)  # an error, which is short


class ApiBot(Bot):
    """Gives updates as they are on the wire, so that one malformed update spoils no other."""

    def __repr__(self) -> str:
        return "Bot(***)"

    async def raw_updates(
        self, offset: int | None, timeout_s: int, kinds: Sequence[str], limit: int
    ) -> list[Any]:
        """Call getUpdates. An offset of None confirms nothing."""
        data = {
            "offset": offset,
            "limit": limit,
            "timeout": timeout_s,
            "allowed_updates": list(kinds),
        }
        updates = await self._post("getUpdates", data, read_timeout=timeout_s + POLL_GRACE_S)
        if not isinstance(updates, list):
            raise TelegramError("the answer to getUpdates is not a list")
        return updates

    async def raw_file(self, file_id: str) -> dict[str, Any]:
        """Call getFile. The original makes an address out of whatever path it is told."""
        found = await self._post("getFile", {"file_id": file_id})
        if not isinstance(found, dict):
            raise TelegramError("the answer to getFile is no file")
        return found

    async def raw_document(
        self, fields: Mapping[str, object], attachment: Attachment, within_s: float
    ) -> str:
        """Call sendDocument with a file that is read while it goes; return the message's id."""
        upload = UploadStream(fields, "document", attachment)
        sent = await self.request.post(
            f"{self.base_url}/sendDocument",
            request_data=cast("RequestData", upload),  # it is only handed on, to _Request
            read_timeout=within_s,
            write_timeout=within_s,
        )
        if not isinstance(sent, dict) or type(sent.get("message_id")) is not int:
            raise TelegramError("the answer to sendDocument is no message")
        return str(sent["message_id"])

    def raw_content(self, path: str, size: int) -> AsyncGenerator[bytes]:
        """Read a file, piece by piece, at a path that is quoted already."""
        request = self.request
        assert isinstance(request, _Request)  # noqa: S101 - made below
        return request.pieces(f"{self.base_file_url}/{path}", size)


class BotClient:
    """Open while anybody uses it: the listener for as long as it runs, or a single call.

    Args:
        settings: Where the Bot API is.
        answer_s: How long an answer to a call may take.

    Attributes:
        traffic: Counts calls as sent, updates as received, and the bytes of all bodies.
    """

    def __init__(self, settings: TelegramSettings, *, answer_s: float = ANSWER_S) -> None:
        self._settings = settings
        self._answer_s = answer_s
        self.traffic = TrafficCounter()
        self._users = 0
        self._bot: ApiBot | None = None
        self._context: ssl.SSLContext | None = None
        self._requests: tuple[_Request, ...] = ()

    @property
    def account(self) -> str:
        """The bot's id, which its token begins with; it is no secret."""
        return self._settings.token.reveal().partition(":")[0]

    @property
    def to_telegram(self) -> bool:
        """Whether it leads to Telegram itself, and to no server of somebody's own."""
        return self._settings.api_base == API_BASE

    @contextlib.asynccontextmanager
    async def held(self) -> AsyncIterator[ApiBot]:
        """Keep the connections while inside; the last one out closes them."""
        self._users += 1
        try:
            if self._bot is None:
                self._open()
            assert self._bot is not None  # noqa: S101  (for the type checker)
            yield self._bot
        finally:
            self._users -= 1
            if not self._users:
                requests, self._requests, self._bot = self._requests, (), None
                for request in requests:
                    await request.shutdown()

    async def ask(self, act: Callable[[ApiBot], Awaitable[T]], *, within_s: float = CALL_S) -> T:
        """Make one call.

        Raises:
            TelegramError: Ours: it did not succeed; nothing foreign hangs on to it.
        """
        try:
            async with asyncio.timeout(within_s), self.held() as bot:
                return await act(bot)
        except Exception as error:  # noqa: BLE001  (whatever a library raises is trouble)
            found = trouble(error)
        raise found

    async def updates(
        self, offset: int | None, timeout_s: int, kinds: Sequence[str], limit: int
    ) -> list[Any]:
        """Return the updates that are not confirmed, waiting up to ``timeout_s`` for the first.

        Each is as it came over the wire (``msgspec.Raw``), or taken apart already; `wire` reads
        either.

        Raises:
            TelegramError: Ours: nothing was received. What the offset confirms may be confirmed.
        """
        found = await self.ask(
            lambda bot: bot.raw_updates(offset, timeout_s, kinds, limit),
            within_s=polled_within_s(timeout_s),
        )
        self.traffic.came(messages=len(found))
        return found

    def _open(self) -> None:
        """Make the client; no connection yet.

        Raises:
            ConfigurationError: The proxy cannot be used.
        """
        settings, bot = self._settings, None
        # What a library says about a proxy may hold its password, so nothing of it is chained.
        with contextlib.suppress(Exception):
            self._requests = (self._request(_Polling, 1), self._request(_Request, SIDE_BY_SIDE))
            bot = ApiBot(
                settings.token.reveal(),
                base_url=settings.api_base,
                base_file_url=settings.file_base,
                get_updates_request=self._requests[0],
                request=self._requests[1],
            )
        if bot is None:
            raise ConfigurationError(
                "The way to Telegram cannot be prepared; the proxy cannot be used.",
                hint='For socks5, install it with: pip install "python-telegram-bot[socks]".',
            )
        self._bot = bot

    def _tls(self) -> ssl.SSLContext:
        """Return what certificates are checked with: to read it takes many steps' time, once."""
        if self._context is None:
            own = self.to_telegram
            self._context = httpx.create_ssl_context(trust_env=own)
        return self._context

    def _request(self, kind: type[_Request], connections: int) -> _Request:
        settings, calls = self._settings, 0 if kind is _Polling else 1

        async def goes(request: httpx.Request) -> None:
            self.traffic.went(_length(request.headers), calls)

        async def comes(answer: httpx.Response) -> None:
            self.traffic.came(_length(answer.headers), 0)

        return kind(
            connection_pool_size=connections,
            connect_timeout=CONNECT_S,
            pool_timeout=CONNECT_S,
            read_timeout=self._answer_s,
            write_timeout=ANSWER_S,
            proxy=settings.proxy.reveal() if settings.proxy is not None else None,
            # A proxy of the environment is for the way to Telegram, not for a server next door.
            httpx_kwargs={
                "trust_env": settings.api_base == API_BASE,
                "verify": self._tls(),
                "event_hooks": {"request": [goes], "response": [comes]},
            },
        )


def polled_within_s(timeout_s: int) -> float:
    """Return how long a poll may take that stays open for so long."""
    return CONNECT_S + timeout_s + 2 * POLL_GRACE_S


def _length(headers: httpx.Headers) -> int:
    """Return how long a body is said to be; 0 where it is not."""
    length = headers.get("content-length", "")
    return int(length) if length.isdecimal() else 0


def _says(code: int, payload: bytes) -> bool:
    """Whether an answer is the Bot API's own, and gives that code."""
    try:
        said = json.loads(payload)
    except (ValueError, RecursionError):
        return False
    return isinstance(said, dict) and said.get("error_code") == code


def _retry_after_s(payload: bytes) -> float:
    try:
        wait_s = float(json.loads(payload)["parameters"]["retry_after"])
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return DEFAULT_WAIT_S
    return wait_s if isfinite(wait_s) else DEFAULT_WAIT_S
