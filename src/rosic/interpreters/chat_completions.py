"""Asks any server that speaks OpenAI's chat completions: on this machine or elsewhere."""

from __future__ import annotations

import asyncio
import socket
import ssl
import threading
from typing import Annotated, Final, TypeAlias

import msgspec

from rosic.contracts.interpreter import AnswerKind, InterpreterAnswer
from rosic.core.secret import Secret
from rosic.interpreters.endpoint import Endpoint
from rosic.interpreters.http_answer import FailedResponse, HttpAnswer

ANSWER_TOKENS: Final = 200
TIMEOUT_S: Final = 5.0
ADDRESSES_AT_MOST: Final = 4
Addresses: TypeAlias = tuple[str, ...]


# ---- what is sent, and what comes back ----


class ChatMessage(msgspec.Struct, frozen=True):
    """One message of a conversation with a model."""

    role: str
    content: str


class CompletionRequest(msgspec.Struct, frozen=True, kw_only=True):
    """The body of a call: two messages, and that the answer shall be short."""

    model: str
    messages: tuple[ChatMessage, ...]
    temperature: float = 0.0
    max_tokens: int = ANSWER_TOKENS
    stream: bool = False


class AnswerMessage(msgspec.Struct, frozen=True):
    """What a model says."""

    content: str


class CompletionChoice(msgspec.Struct, frozen=True):
    """One of the answers of a model; the first counts."""

    message: AnswerMessage


class CompletionResponse(msgspec.Struct, frozen=True):
    """What is read of the body of an answer."""

    choices: Annotated[tuple[CompletionChoice, ...], msgspec.Meta(min_length=1)]


_encode = msgspec.json.Encoder().encode
_decode = msgspec.json.Decoder(CompletionResponse).decode


def read_completion(body: bytes) -> InterpreterAnswer:
    """Return what a model says in the body of an answer. Total."""
    try:
        return InterpreterAnswer(AnswerKind.ANSWERED, _decode(body).choices[0].message.content)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return InterpreterAnswer(AnswerKind.UNREADABLE)


# ---- the call ----


class InterpreterSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Which model is asked, where.

    Attributes:
        key: Of an account there; None: it wants none.
        timeout_s: How long one call may take from beginning to end.
    """

    endpoint: Endpoint
    model: str
    key: Secret | None = None
    timeout_s: float = TIMEOUT_S


class ChatCompletions:
    """One model behind one endpoint; see `Interpreter`. A connection for each call.

    Nothing of the environment is taken: no proxy, no credentials of a user.
    """

    def __init__(self, settings: InterpreterSettings) -> None:
        endpoint = settings.endpoint
        self._settings = settings
        self.where = "" if endpoint.is_loopback else endpoint.authority
        self._tls = ssl.create_default_context() if endpoint.tls else None
        self._resolver = AddressResolver(endpoint.host, endpoint.port)

    async def ask(self, instructions: str, text: str) -> InterpreterAnswer:
        """Ask once, within the time that was set."""
        try:
            async with asyncio.timeout(self._settings.timeout_s):
                return read_completion(await self._exchange(self._request(instructions, text)))
        except TimeoutError:
            return InterpreterAnswer(AnswerKind.LATE)
        except FailedResponse as failure:
            return InterpreterAnswer(failure.kind)
        except (OSError, UnicodeError):
            return InterpreterAnswer(AnswerKind.UNREACHABLE)

    def _request(self, instructions: str, text: str) -> bytes:
        endpoint, key = self._settings.endpoint, self._settings.key
        messages = (ChatMessage("system", instructions), ChatMessage("user", text))
        body = _encode(CompletionRequest(model=self._settings.model, messages=messages))
        head = (
            f"POST {endpoint.path} HTTP/1.1",
            f"Host: {endpoint.authority}",
            "Content-Type: application/json",
            f"Content-Length: {len(body)}",
            "Accept: application/json",
            "Accept-Encoding: identity",
            "Connection: close",
            *(() if key is None else (f"Authorization: Bearer {key.reveal()}",)),
        )
        return "\r\n".join((*head, "", "")).encode() + body

    async def _exchange(self, request: bytes) -> bytes:
        """Send a request over a connection of its own, and return the body of the answer.

        Raises:
            FailedResponse, OSError: There is none.
        """
        transport, answer = await self._connect()
        try:
            transport.write(request)
            return await answer.body
        finally:
            answer.cut_off()

    async def _connect(self) -> tuple[asyncio.WriteTransport, HttpAnswer]:
        """Connect to the first address that takes it: a name may have one that nobody listens at.

        Raises:
            OSError: None does.
        """
        loop, endpoint = asyncio.get_running_loop(), self._settings.endpoint
        refused: OSError | None = None
        for address in await self._resolver.addresses():
            try:
                if self._tls is None:
                    return await loop.create_connection(HttpAnswer, address, endpoint.port)
                return await loop.create_connection(
                    HttpAnswer,
                    address,
                    endpoint.port,
                    ssl=self._tls,
                    server_hostname=endpoint.host,
                )
            except OSError as failure:
                refused = failure
        raise refused or OSError("no address")


class AddressResolver:
    """Looks a name up without taking a thread from others, however long that hangs.

    The event loop's own threads are few and serve everything: ten names that nobody answers for
    would hold up whoever else needs one. Here one thread looks, for all who ask meanwhile.
    """

    def __init__(self, host: str, port: int) -> None:
        self._host, self._port = host, port
        self._looking: asyncio.Future[Addresses] | None = None

    async def addresses(self) -> Addresses:
        """Return literal addresses, a few at most.

        Raises:
            OSError: There is none.
        """
        if self._looking is None:
            loop = asyncio.get_running_loop()
            looking: asyncio.Future[Addresses] = loop.create_future()
            looking.add_done_callback(self._looked)
            self._looking = looking
            given = (loop, looking)
            threading.Thread(target=self._look, args=given, name="resolver", daemon=True).start()
        return await asyncio.shield(self._looking)

    def _looked(self, looking: asyncio.Future[Addresses]) -> None:
        self._looking = None
        if not looking.cancelled():
            looking.exception()  # whoever asked may have gone

    def _look(self, loop: asyncio.AbstractEventLoop, looking: asyncio.Future[Addresses]) -> None:
        found: Addresses | OSError
        try:
            each = socket.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)
            found = tuple(dict.fromkeys(str(one[-1][0]) for one in each))[:ADDRESSES_AT_MOST]
        except (OSError, UnicodeError) as failure:
            found = OSError(type(failure).__name__)
        try:
            loop.call_soon_threadsafe(_settle, looking, found)
        except RuntimeError:
            return  # the loop is closed: nobody waits any more


def _settle(looking: asyncio.Future[Addresses], found: Addresses | OSError) -> None:
    if looking.done():
        return
    if isinstance(found, OSError):
        looking.set_exception(found)
    else:
        looking.set_result(found)
