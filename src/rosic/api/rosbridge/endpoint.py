"""Where clients of rosbridge come in: plain ASGI, as every message counts."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import parse_qs

from rosic.api.connections import StepLimit
from rosic.api.read_rates import asking_from
from rosic.api.rosbridge.calls import FollowedGoals
from rosic.api.rosbridge.connection import RosbridgeConnection
from rosic.api.rosbridge.drive import LiveTopics
from rosic.api.rosbridge.introspection import GraphIntrospection
from rosic.api.rosbridge.orders import OrderBindings
from rosic.api.rosbridge.shared import RefusalNotes, RosbridgeParts
from rosic.api.rosbridge.topics import TopicDirectory, TopicHub
from rosic.core.i18n import said
from rosic.errors import Fault, Unrecognised
from rosic.gateway.send_queue import SLOW, SlowConsumer

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.ordering import CallerRequests
    from rosic.api.tickets import TicketBook

    Event = MutableMapping[str, Any]
    Receive = Callable[[], Awaitable[Event]]
    Send = Callable[[Event], Awaitable[None]]

PATH: Final = "/rosbridge"
PATHS: Final = frozenset({PATH, ""})
"""Where clients come in; on a port of their own without any path."""
CLIENTS_AT_MOST: Final = 200
EACH_AT_MOST: Final = 128
"""Connections of one caller."""
UNKNOWN_AT_MOST: Final = 16
"""Connections from one place of whoever has yet to say who they are."""
KNOWN_WITHIN_S: Final = 10.0
LOOK_S: Final = 0.25
CHECK_S: Final = 1.0
ENDED: Final = 4401
MANY: Final = "Too many connections are open already. Close one first."
SOCKETS: Final = "Clients of rosbridge come in here, by a WebSocket."
UNREAD: Final = said("That address cannot be read. Name a ticket in it, or nothing.")
NOBODY: Final = "No key was shown in time. Show one by the op auth, in a header, or by a ticket."
NO_KEYS: Final = "Too many keys were shown that are not known here, or not any more."

log = logging.getLogger("rosic.api")


class RosbridgeEndpoint:
    """Serves clients of rosbridge; ASGI.

    Args:
        context: The rooms.
        speech: Places orders, and stops.
        tickets: That may stand in a URL.
    """

    def __init__(self, context: ApiContext, speech: CallerRequests, tickets: TicketBook) -> None:
        directory = TopicDirectory(context, context.settings.topics)
        introspection = GraphIntrospection(context, directory, OrderBindings(context))
        self._context, self._tickets = context, tickets
        self._parts = RosbridgeParts(
            context,
            speech,
            directory,
            TopicHub(directory),
            LiveTopics(context),
            introspection,
            FollowedGoals(context),
            RefusalNotes(context),
        )
        self._clients: dict[RosbridgeConnection, str] = {}

    async def __call__(self, scope: Event, receive: Receive, send: Send) -> None:
        """Serve one client until either side leaves."""
        await receive()
        await send({"type": "websocket.accept"})
        try:
            caller = self._identified(scope)
        except Unrecognised as why:
            await _closed(send, ENDED, self._context.callers.read_by(why.sentence, None))
            return
        place = asking_from(scope["client"][0] if scope.get("client") else "")
        client = RosbridgeConnection(self._parts, caller)
        if not self._has_room(client, place):
            await _closed(send, SLOW, MANY)
            return
        self._clients[client] = place
        try:
            await self._serve(client, receive, send)
        finally:
            del self._clients[client]
            await client.close()

    def _identified(self, scope: Event) -> ApiCaller | None:
        """Return who comes; None: it is yet to be said.

        Raises:
            Unrecognised: What was shown is no key.
        """
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        shown, cookies = headers.get(b"authorization", ""), headers.get(b"cookie", "")
        try:
            query = parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=8)
        except ValueError:
            raise Unrecognised(UNREAD) from None
        ticket = query.get("ticket", [""])[0]
        if ticket:
            return self._tickets.redeem(ticket)
        callers = self._context.callers
        if shown or callers.cookie in cookies:
            return callers.identify(shown, cookies)
        return None

    def _has_room(self, client: RosbridgeConnection, place: str) -> bool:
        """Whether there is room for one more: of its caller, or of whom nothing is known yet."""
        if len(self._clients) >= CLIENTS_AT_MOST:
            return False
        if client.caller is None:
            unknown = [p for other, p in self._clients.items() if other.caller is None]
            return unknown.count(place) < UNKNOWN_AT_MOST
        return self._own(client.caller) < EACH_AT_MOST

    def _own(self, caller: ApiCaller) -> int:
        return sum(
            other.caller is not None and other.caller.principal == caller.principal
            for other in self._clients
        )

    async def _serve(self, client: RosbridgeConnection, receive: Receive, send: Send) -> None:
        try:
            async with asyncio.TaskGroup() as group:
                telling = group.create_task(_tell(client, send))
                checking = group.create_task(self._check(client))
                try:
                    await _hear(client, receive)
                finally:
                    telling.cancel()
                    checking.cancel()
        except* _Left as left:
            code, why = left.exceptions[0].args
            log.info("a client of rosbridge was dropped: %s", why)
            await _closed(send, code, why)
        except* OSError:
            log.info("a client of rosbridge is gone")

    async def _check(self, client: RosbridgeConnection) -> None:
        """End the connection of whoever is not known any more."""
        loop = asyncio.get_running_loop()
        begun_s = looked_s = loop.time()
        unknown = client.caller is None
        while True:
            await asyncio.sleep(LOOK_S)
            caller, now_s = client.caller, loop.time()
            if client.rejected:
                raise _Left(ENDED, NO_KEYS)
            if caller is None and now_s - begun_s > KNOWN_WITHIN_S:
                raise _Left(ENDED, NOBODY)
            if unknown and caller is not None:
                unknown = False
                if self._own(caller) > EACH_AT_MOST:
                    raise _Left(SLOW, MANY)
            if caller is None or now_s - looked_s < CHECK_S:
                continue
            looked_s = now_s
            try:
                self._context.callers.known_by(caller.secret, by_cookie=caller.by_cookie)
            except Unrecognised as why:
                raise _Left(ENDED, self._context.callers.read_by(why.sentence, caller)) from None
            client.check_sight()


class _Left(Exception):
    """A connection ends: its code, and why."""


async def _hear(client: RosbridgeConnection, receive: Receive) -> None:
    step = StepLimit()
    while True:
        message = await receive()
        if message["type"] == "websocket.disconnect":
            return
        await client.hear(message.get("text"))
        await step.rest()


async def _tell(client: RosbridgeConnection, send: Send) -> None:
    step = StepLimit()

    async def tell(frame_of: Callable[[], bytes]) -> None:
        try:
            frame = frame_of()
        except Fault as why:
            log.warning("a message for a client of rosbridge cannot be read: %s", why)
            return
        await send({"type": "websocket.send", "frame": frame})
        await step.rest()

    try:
        await client.queue.tell(tell)
    except SlowConsumer as slow:
        raise _Left(SLOW, str(slow)) from None


async def _closed(send: Send, code: int, why: str) -> None:
    """Close a connection, and say why; one that takes nothing is not waited for."""
    cut = why.encode()[:120].decode("utf-8", "ignore")
    with contextlib.suppress(Exception):
        async with asyncio.timeout(1.0):
            await send({"type": "websocket.close", "code": code, "reason": cut})


class RosbridgeRouter:
    """Sends WebSockets of rosbridge to its endpoint, and everything else on.

    Args:
        app: What is behind.
        endpoint: Of rosbridge.
    """

    def __init__(
        self,
        app: Callable[[Any, Any, Any], Awaitable[None]],
        endpoint: RosbridgeEndpoint,
    ) -> None:
        self._app, self._endpoint = app, endpoint

    async def __call__(self, scope: Event, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        path = scope.get("path", "").rstrip("/")
        if scope["type"] == "websocket" and path == PATH:
            await self._endpoint(scope, receive, send)
        else:
            await self._app(scope, receive, send)


class RosbridgePort:
    """Serves clients of rosbridge on a port of their own, where most of them name no path.

    Args:
        endpoint: Of rosbridge.
    """

    def __init__(self, endpoint: RosbridgeEndpoint) -> None:
        self._endpoint = endpoint

    async def __call__(self, scope: Event, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] == "websocket" and scope["path"].rstrip("/") in PATHS:
            await self._endpoint(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": ENDED, "reason": SOCKETS})
        else:
            headers = [(b"content-type", b"text/plain"), (b"content-length", b"%d" % len(SOCKETS))]
            await send({"type": "http.response.start", "status": 426, "headers": headers})
            await send({"type": "http.response.body", "body": SOCKETS.encode()})
