"""What happens, as it happens: one connection to the gateway's events."""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, WebSocketException

from rosic.api.event_schemas import ENDED, Event, Hello, Subscribe
from rosic.api.schemas import IdentityOut, Problem
from rosic.client.errors import NotAnswered, NotRecognised, NotTrusted

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable

    from rosic.client.connection import GatewayAddress

OPEN_WITHIN_S: Final = 5.0
PING_EVERY_S: Final = 5.0
PING_WITHIN_S: Final = 5.0
MESSAGE_BYTES: Final = 4 << 20
NOT_RECOGNISED: Final = 401
LOST: Final = "The connection to {url} is lost. It is made again by itself."


class Connected(msgspec.Struct, frozen=True):
    """The connection stands; how things are now follows.

    Attributes:
        me: Who the gateway takes us for.
        run: Another one after the gateway was restarted.
    """

    me: IdentityOut
    run: str


class Disconnected(msgspec.Struct, frozen=True):
    """The connection does not stand: what is known of robots and orders is of before.

    Attributes:
        why: One sentence.
    """

    why: str


Happening: TypeAlias = Event | Connected | Disconnected
_read = msgspec.json.Decoder(Event).decode
_encode = msgspec.json.Encoder().encode


class EventConnection:
    """Listens to a gateway.

    Args:
        address: Where it is.
        who: Asks who we are over HTTP: a connection that is refused does not say why.
    """

    def __init__(self, address: GatewayAddress, who: Callable[[], Awaitable[object]]) -> None:
        self._address, self._who = address, who

    async def once(self, topics: tuple[str, ...]) -> AsyncGenerator[Happening, None]:
        """Yield what happens, until the connection is lost; a `Disconnected` is the last of it.

        Raises:
            ApiProblem: The key is none, or not good any more.
            NotTrusted, NotAGateway: It cannot be known who answers there.
        """
        address = self._address
        lost = LOST.format(url=address.url)
        try:
            async with connect(
                address.events_url,
                additional_headers=address.headers,
                ssl=address.context,
                open_timeout=OPEN_WITHIN_S,
                close_timeout=1,
                ping_interval=PING_EVERY_S,
                ping_timeout=PING_WITHIN_S,
                max_size=MESSAGE_BYTES,
            ) as connection:
                await connection.send(_encode(Subscribe(topics)).decode())
                async for text in connection:
                    event = _event(text)
                    if event is not None:
                        yield event
        except ConnectionClosed as closed:
            if closed.rcvd is not None and closed.rcvd.code == ENDED:
                raise NotRecognised(_ended(closed.rcvd.reason)) from None
        except ssl.SSLCertVerificationError as wrong:
            why = wrong.verify_message.rstrip(".")
            raise NotTrusted(
                f"The certificate of {address.url} is not trusted here: {why}.", url=address.url
            ) from wrong
        except (InvalidHandshake, WebSocketException):
            await self._refused()
        except (OSError, TimeoutError):
            pass
        yield Disconnected(lost)

    async def _refused(self) -> None:
        """Say why a connection is refused, if it is for good."""
        try:
            await self._who()
        except NotTrusted:
            raise
        except NotAnswered as none:
            if none.code == "not-a-gateway":
                raise


def _event(text: str | bytes) -> Event | Connected | None:
    """Return what is told; None: a newer gateway tells what is not known here."""
    try:
        event = _read(text)
    except msgspec.MsgspecError:
        return None
    return Connected(event.me, event.run) if isinstance(event, Hello) else event


def _ended(sentence: str) -> Problem:
    return Problem(
        "/problems/unrecognised", "Unrecognised", NOT_RECOGNISED, sentence, "unrecognised"
    )
