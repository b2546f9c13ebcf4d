"""Robots shown live to Foxglove, over a WebSocket of its protocol: read-only, by the same keys.

Foxglove cannot show a key in a header, so it may stand in the address: ``/foxglove?key=rosic_...``.
Whoever shows one so is known by it alone, wherever their page comes from; a cookie counts for a
page of ours alone.
"""

from __future__ import annotations

import asyncio
import contextlib
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from litestar import WebSocket, websocket
from litestar.di import NamedDependency
from litestar.exceptions import WebSocketDisconnect
from litestar.params import SkipValidation

from rosic.core.robot.observation import recorded_robot
from rosic.errors import Unrecognised
from rosic.gateway.observation import RobotObserver, observation_rights
from rosic.gateway.observation_feed import ObservationFeed
from rosic.gateway.send_queue import SLOW, SlowConsumer

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.contracts.recording import Frame, Recorder

PATH: Final = "/foxglove"
KEY: Final = "key"
CONNECTIONS_AT_MOST: Final = 50
EACH_AT_MOST: Final = 4
CHECK_EVERY_S: Final = 1.0
PROTOCOL_ERROR: Final = 1002
OVERRUN: Final = 1008
ENDED: Final = 4401
NO_PROTOCOL: Final = "This speaks the WebSocket protocol of Foxglove."
MISSING: Final = "This gateway shows nothing to Foxglove: rosic[foxglove] is not installed."
MANY: Final = "Too many connections look already. Close one first."
NOTHING: Final = "There is no robot here that you may see."
TOO_MUCH: Final = "You say more than is read here."


class _Closed(Exception):
    """Our side ends a connection: with a code, and why."""


class FoxgloveConnections:
    """Everybody who looks."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context
        self._whose: list[str] = []
        self._observers: list[RobotObserver] = []
        context.kernel.shared.alarm_news.connect(self._alarm)

    async def serve(self, connection: WebSocket[Any, Any, Any]) -> None:
        """Serve one connection until either side leaves.

        Raises:
            Unrecognised: Nobody is known by what it shows; it was not accepted.
        """
        callers, kernel = self._context.callers, self._context.kernel
        key, headers = connection.query_params.get(KEY, ""), connection.headers
        caller = (
            callers.identify("", "", key)
            if key
            else callers.identify(headers.get("authorization", ""), headers.get("cookie", ""))
        )
        offered = connection.scope["subprotocols"]
        spoken = () if kernel.recorder is None else kernel.recorder.subprotocols
        chosen = next((each for each in spoken if each in offered), None)
        await connection.accept(subprotocols=chosen)
        try:
            await self._show(connection, caller, self._admitted(caller, chosen))
        except* _Closed as closed:
            code, why = _first(closed).args
            with contextlib.suppress(Exception):
                await connection.close(code, why)

    def _admitted(self, caller: ApiCaller, chosen: str | None) -> Recorder:
        """Return who makes the frames of one more connection."""
        recorder = self._context.kernel.recorder
        if recorder is None:
            raise _Closed(PROTOCOL_ERROR, MISSING)
        if chosen is None:
            raise _Closed(PROTOCOL_ERROR, NO_PROTOCOL)
        own = self._whose.count(caller.principal)
        if len(self._whose) >= CONNECTIONS_AT_MOST or own >= EACH_AT_MOST:
            raise _Closed(SLOW, MANY)
        return recorder

    async def _show(
        self, connection: WebSocket[Any, Any, Any], caller: ApiCaller, recorder: Recorder
    ) -> None:
        kernel = self._context.kernel
        rights = observation_rights(kernel.rooms.organiser, kernel.containers, caller.principal)
        robots = [p for robot, p in kernel.rooms.profiles.items() if rights.sees(robot)]
        session = recorder.session([recorded_robot(each) for each in robots], kernel.site.name)
        feed = ObservationFeed(session, kernel.machine_clock)
        executor = kernel.pipeline.executor
        observer = RobotObserver(
            kernel.rooms, executor, kernel.clock, rights, feed.take, kernel.renderer
        )
        self._whose.append(caller.principal)
        self._observers.append(observer)
        try:
            async with asyncio.TaskGroup() as group:
                hearing = group.create_task(_hear(connection, feed))
                checking = group.create_task(self._check(caller))

                async def show() -> None:
                    ids = [each.id for each in robots]
                    try:
                        await feed.run(observer, ids, partial(_send, connection))
                    except SlowConsumer as slow:
                        raise _Closed(SLOW, str(slow)) from None

                showing = group.create_task(show())
                await asyncio.wait((hearing, showing), return_when=asyncio.FIRST_COMPLETED)
                if feed.overflowed:
                    await connection.close(OVERRUN, TOO_MUCH)
                elif showing.done():
                    await connection.close(ENDED, NOTHING)
                for task in (hearing, checking, showing):
                    task.cancel()
        finally:
            self._whose.remove(caller.principal)
            self._observers.remove(observer)

    async def _check(self, caller: ApiCaller) -> None:
        """End a connection whose key or session is not good any more."""
        callers = self._context.callers
        while True:
            await asyncio.sleep(CHECK_EVERY_S)
            try:
                callers.known_by(caller.secret, by_cookie=caller.by_cookie)
            except Unrecognised as why:
                raise _Closed(ENDED, callers.read_by(why.sentence, caller)) from None

    def _alarm(self, robot: str, text: str, begins: bool) -> None:
        for observer in self._observers:
            observer.notice(robot, text, grave=begins)


async def _hear(connection: WebSocket[Any, Any, Any], feed: ObservationFeed) -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            message = await connection.receive()
            if message["type"] == "websocket.disconnect":
                return
            text, content = message.get("text"), message.get("bytes")
            feed.hear(text if isinstance(text, str) else bytes(content or b""))  # type: ignore[call-overload]


async def _send(connection: WebSocket[Any, Any, Any], frame: Frame) -> None:
    with contextlib.suppress(WebSocketDisconnect):  # it has left, which is heard, too
        await connection.send_data(frame, "text" if isinstance(frame, str) else "binary")


def _first(group: BaseExceptionGroup[Any]) -> BaseException:
    found: BaseException = group
    while isinstance(found, BaseExceptionGroup):
        found = found.exceptions[0]
    return found


Connections = NamedDependency[SkipValidation[FoxgloveConnections]]


@websocket(PATH)
async def foxglove(socket: WebSocket[Any, Any, Any], connections: Connections) -> None:
    """Show robots live to Foxglove; see `FoxgloveConnections`."""
    await connections.serve(socket)
