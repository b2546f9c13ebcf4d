"""What happens, as it happens, over a WebSocket: robots, orders, one's own conversation.

Of everything the newest value counts: what waits for a slow client is replaced, not queued up. A
client that takes nothing for some seconds is told so and dropped; nobody else waits for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from functools import partial
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import msgspec
from litestar.exceptions import WebSocketDisconnect

from rosic.api import event_schemas
from rosic.api.connections import StepLimit
from rosic.api.event_schemas import (
    ENDED,
    TOPICS,
    Hello,
    MessageEvent,
    OrderEvent,
    Ping,
    Pong,
    ProblemEvent,
    RobotEvent,
    RobotGone,
    StopEvent,
    StopRequest,
    Subscribe,
)
from rosic.api.jog import Jog, JogEvent, JogSessions
from rosic.api.live_orders import LiveOrders
from rosic.api.order_feed import order_id
from rosic.api.problems import problem, problem_of
from rosic.api.rate_feed import RateFeed, of_visible
from rosic.api.recorded_orders import recorded_order
from rosic.api.robot_monitor import RobotMonitor
from rosic.api.schemas import StopIn
from rosic.api.stop_reading import mentions_stop
from rosic.core.i18n import plain, said
from rosic.core.identity import PAGE
from rosic.errors import RosicError, Unrecognised
from rosic.gateway.send_queue import SLOW, SendQueue, SlowConsumer

if TYPE_CHECKING:
    from collections.abc import Callable

    from litestar import WebSocket

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.order_feed import OrderEntry
    from rosic.api.ordering import CallerRequests
    from rosic.api.schemas import PageMessage, RobotOut
    from rosic.core.robot.profile import RobotId

LOOK_S: Final = 0.2
"""So often robots are looked at while anybody listens."""
CHUNK: Final = 50
"""Robots that are looked at in one step."""
ORDERS_AT_FIRST: Final = 50
"""Orders of which whoever subscribes is told how they are."""
STOPS_AT_MOST: Final = 32
"""Stops of one connection whose answers are waited for; more are given all the same."""
LISTENERS_AT_MOST: Final = 200
EACH_AT_MOST: Final = 16
"""Connections of one caller."""
MESSAGE_BYTES: Final = 65_536
ID_AT_MOST: Final = 128
"""Letters of what comes back as the id of an answer: all of them wait for a slow client."""
MANY: Final = said("Too many connections listen already. Close one first.")
NOT_READ: Final = said("That is no message of this protocol.")
TOO_MANY_STOPS: Final = said("It was given; so many were that this one has no answer of its own.")

Said: TypeAlias = Subscribe | StopRequest | Ping | Jog
_read: Callable[[str], Said] = msgspec.json.Decoder(Said).decode

Event: TypeAlias = event_schemas.Event | JogEvent
_encode = msgspec.json.Encoder(enc_hook=plain).encode

log = logging.getLogger("rosic.api")


class Listener:
    """One connection: what it wants to hear, and what it has not been told yet.

    Attributes:
        caller: Who listens.
        topics: Of what.
        queue: What it is yet to be told.
    """

    def __init__(self, caller: ApiCaller) -> None:
        self.caller = caller
        self.topics: frozenset[str] = frozenset()
        self.queue: SendQueue[bytes] = SendQueue()
        self.seen: dict[RobotId, RobotOut] = {}
        self._knows_doubt = False
        self._stops = 0

    def wants(self, topics: frozenset[str]) -> None:
        """Hear of these, and of nothing else."""
        self.topics = topics
        self.seen.clear()

    def begin_doubt(self) -> bool:
        """Return whether it was not told yet what the last run left: that is read once for each."""
        knows, self._knows_doubt = self._knows_doubt, True
        return not knows

    def begin_stop(self) -> bool:
        """Count a stop whose answer is waited for; return False where there are too many."""
        counts = self._stops < STOPS_AT_MOST
        self._stops += counts
        return counts

    def end_stop(self) -> None:
        """Count one less."""
        self._stops -= 1

    def put(self, key: str, event: Event) -> None:
        """Have something told; in place of what is older under the same key, and untold."""
        self.show(key, _written(event))

    def show(self, key: str, told: bytes | None) -> None:
        """Do the same with an event as it is sent."""
        if told is not None:
            self.queue.show(key, told, len(told))


class EventStream:
    """Tells everybody who listens, and looks at robots for them.

    Attributes:
        listeners: Who listens.
    """

    def __init__(self, context: ApiContext, speech: CallerRequests) -> None:
        self._context, self._speech = context, speech
        self._live = LiveOrders(context)
        self._rates = RateFeed(context.kernel)
        clock = context.kernel.machine_clock
        self._looks = RobotMonitor(context.robot, context.held, clock.monotonic_ns)
        self.listeners: set[Listener] = set()
        self._looking: asyncio.Task[None] | None = None
        self._run = f"{clock.wall_ns():x}"
        context.feed.changed.connect(self._order_changed)
        context.page.news.connect(self._said)

    async def close(self) -> None:
        """Look at nothing any more."""
        if self._looking is not None:
            self._looking.cancel()
            await asyncio.gather(self._looking, return_exceptions=True)

    # ---- one connection ----

    async def serve(self, connection: WebSocket[Any, Any, Any], caller: ApiCaller) -> None:
        """Serve one connection until either side leaves."""
        own = sum(other.caller.principal == caller.principal for other in self.listeners)
        await connection.accept()
        if len(self.listeners) >= LISTENERS_AT_MOST or own >= EACH_AT_MOST:
            await connection.close(SLOW, self._context.callers.read_by(MANY, caller))
            return
        listener = Listener(caller)
        listener.put("hello", Hello(self._context.me(caller), self._run))
        self.listeners.add(listener)
        self._look_on()
        try:
            async with asyncio.TaskGroup() as group:
                telling = group.create_task(self._tell(connection, listener))
                checking = group.create_task(self._check(listener))
                jogs = JogSessions(
                    self._context, self._live, caller, partial(_tell_of_jog, listener), group
                )
                try:
                    await self._hear(connection, listener, group, jogs)
                finally:
                    jogs.close()
                    telling.cancel()
                    checking.cancel()
        except* _Left as left:
            code, why = left.exceptions[0].args
            with contextlib.suppress(Exception):
                await connection.close(code, why)
        finally:
            self.listeners.discard(listener)

    async def _hear(
        self,
        connection: WebSocket[Any, Any, Any],
        listener: Listener,
        group: asyncio.TaskGroup,
        jogs: JogSessions,
    ) -> None:
        step = StepLimit()
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                text = await _next_of(connection)
                await step.rest()
                heard = _said_in(text)
                if isinstance(heard, Jog):
                    jogs.take(heard)
                else:
                    self._heard(heard, listener, group)

    def _heard(self, heard: Said | None, listener: Listener, group: asyncio.TaskGroup) -> None:
        if isinstance(heard, StopRequest) and listener.begin_stop():
            group.create_task(self._stop(listener, heard))
        elif isinstance(heard, StopRequest):
            self._speech.give_stop(listener.caller, heard.robots)
            detail = self._context.callers.read_by(TOO_MANY_STOPS, listener.caller)
            asked = heard.id[:ID_AT_MOST]
            listener.put(f"stop {asked}", ProblemEvent(problem("busy", detail), asked))
        elif isinstance(heard, Subscribe):
            self._subscribe(listener, frozenset(heard.topics), group)
        elif isinstance(heard, Ping):
            asked = heard.id[:ID_AT_MOST]
            listener.put(f"pong {asked}", Pong(asked))
        else:
            self._refuse(listener, "problem", "not-understood", NOT_READ)

    def _refuse(self, listener: Listener, key: str, code: str, sentence: str) -> None:
        detail = self._context.callers.read_by(sentence, listener.caller)
        listener.put(key, ProblemEvent(problem(code, detail)))

    async def _stop(self, listener: Listener, heard: StopRequest) -> None:
        asked = heard.id[:ID_AT_MOST]
        try:
            result = await self._speech.stop(listener.caller, StopIn(robots=heard.robots))
        except RosicError as why:
            sentence = self._context.callers.read_by(why.sentence, listener.caller)
            listener.put(f"stop {asked}", ProblemEvent(problem_of(why, sentence), asked))
        else:
            listener.put(f"stop {asked}", StopEvent(asked, result))
        finally:
            listener.end_stop()

    async def _tell(self, connection: WebSocket[Any, Any, Any], listener: Listener) -> None:
        async def tell(told: bytes) -> None:
            await connection.send_data(told.decode(), "text")

        try:
            await listener.queue.tell(tell)
        except SlowConsumer as slow:
            raise _Left(SLOW, str(slow)) from None

    async def _check(self, listener: Listener) -> None:
        """End a connection whose key or session is not good any more."""
        caller = listener.caller
        while True:
            await asyncio.sleep(1.0)
            try:
                self._context.callers.known_by(caller.secret, by_cookie=caller.by_cookie)
            except Unrecognised as why:
                raise _Left(ENDED, self._context.callers.read_by(why.sentence, caller)) from None

    # ---- what happens ----

    def _subscribe(
        self, listener: Listener, topics: frozenset[str], group: asyncio.TaskGroup
    ) -> None:
        if unknown := sorted(topics.difference(TOPICS)):
            self._refuse(listener, "problem", "not-found", no_topic(unknown[0]))
            return
        listener.wants(topics)
        context, caller = self._context, listener.caller
        if "orders" in topics:
            if listener.begin_doubt():
                group.create_task(self._tell_in_doubt(listener))
            for order in reversed(context.orders(caller, "", ORDERS_AT_FIRST)):
                listener.put(f"order {order.id}", OrderEvent(order))
        if "chat" in topics and caller.address.platform == PAGE:
            for message in context.page.conversation(caller.address.account).all():
                listener.put(f"message {message.id}", MessageEvent(message))

    async def _tell_in_doubt(self, listener: Listener) -> None:
        """Tell of orders of the last run that ended unseen: their followers wait for that."""
        context = self._context
        in_doubt = context.kernel.shared.in_doubt.find() or ()
        for order in in_doubt[-ORDERS_AT_FIRST:]:
            found = await recorded_order(context, listener.caller, order_id(order.cid))
            if found is not None and "orders" in listener.topics:
                listener.put(f"order {found.id}", OrderEvent(found))

    def _order_changed(self, entry: OrderEntry) -> None:
        context, written = self._context, dict[tuple[bool, int], bytes | None]()
        self._looks.wake(entry.robot)
        for listener in self.listeners:
            caller = listener.caller
            if "orders" in listener.topics and entry.robot in context.visible(caller):
                read_as = context.read_as(entry, caller)
                if read_as not in written:  # once for all who read the same
                    written[read_as] = _written(OrderEvent(context.shown(entry, caller)))
                listener.show(f"order {entry.id}", written[read_as])

    def _said(self, account: str, message: PageMessage) -> None:
        for listener in self.listeners:
            address = listener.caller.address
            if "chat" in listener.topics and (address.platform, address.account) == (PAGE, account):
                listener.put(f"message {message.id}", MessageEvent(message))

    def _look_on(self) -> None:
        if self._looking is None or self._looking.done():
            self._looking = asyncio.create_task(self._look())

    async def _look(self) -> None:
        """Look at robots while anybody listens, a few in each step."""
        while self.listeners:
            listening = [each for each in self.listeners if "robots" in each.topics]
            if listening:
                await self._look_at_all(listening)
            self._tell_rates()
            await asyncio.sleep(LOOK_S)

    def _tell_rates(self) -> None:
        listening = [each for each in self.listeners if "rates" in each.topics]
        found = self._rates.look() if listening else None
        if found is not None:
            for each in listening:
                each.put("rates", of_visible(found, self._context.visible(each.caller)))

    async def _look_at_all(self, listening: list[Listener]) -> None:
        profiles = self._context.kernel.rooms.profiles
        visible = {id(each): self._context.visible(each.caller) for each in listening}
        for number, (robot, profile) in enumerate(tuple(profiles.items())):
            if number % CHUNK == CHUNK - 1:
                await asyncio.sleep(0)
            seeing = [each for each in listening if robot in visible[id(each)]]
            if seeing:
                anew = any(robot not in each.seen for each in seeing)
                shown = self._looks.look(profile, anew=anew)
                for each in seeing:
                    _tell_of(each, shown)
        self._looks.keep(profiles)
        for each in listening:
            for robot in [r for r in each.seen if r not in visible[id(each)]]:
                del each.seen[robot]
                each.put(f"robot {robot}", RobotGone(robot))


def no_topic(topic: str) -> str:
    """Return what is said to whoever subscribes to what there is not."""
    return said(
        "There is no topic {topic!r}. There are {topics}. You are told what you were told before.",
        topic=topic,
        topics=", ".join(TOPICS),
    )


class _Left(Exception):
    """A connection ends: its code, and why."""


async def _next_of(connection: WebSocket[Any, Any, Any]) -> str:
    """Return the next message, whether it comes as text or as bytes."""
    event = await connection.receive()
    if event["type"] != "websocket.receive":
        raise WebSocketDisconnect(detail="gone")
    data = event.get("bytes")
    return event.get("text") or "" if data is None else data.decode(errors="replace")


def _said_in(text: str) -> Said | None:
    """Return what a client says; None where it cannot be read.

    What cannot be read and speaks of a stop is one, of everything: whoever sends it means it.
    """
    try:
        if len(text) <= MESSAGE_BYTES:
            return _read(text)
    except (msgspec.MsgspecError, UnicodeError, RecursionError):
        pass
    return StopRequest() if mentions_stop(text[:MESSAGE_BYTES]) else None


def _written(event: Event) -> bytes | None:
    """Return an event as it is sent; None where it cannot be written: the others go on."""
    try:
        return _encode(event)
    except Exception:
        log.exception("an event of %s cannot be written", type(event).__name__)
        return None


def _tell_of_jog(listener: Listener, event: JogEvent) -> None:
    listener.put(f"jog {event.robot}", event)


def _tell_of(listener: Listener, shown: RobotOut) -> None:
    """Tell a listener of a robot, if there is news of it."""
    if listener.seen.get(shown.id) is not shown:
        listener.seen[shown.id] = shown
        listener.put(f"robot {shown.id}", RobotEvent(shown))
