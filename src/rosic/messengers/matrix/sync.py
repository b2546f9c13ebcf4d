"""The loop: asks for what is new, hands it over, and confirms what was received to the end.

Matrix gives out again whatever came after a token. The next sync goes on soon where the last
one ended, so that a stop is seen behind whatever is being received; the token that is kept on disk,
from which another run begins, follows only when everything before it is settled.
"""

from __future__ import annotations

import asyncio
import logging
from asyncio import TaskGroup
from collections import Counter
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind
from rosic.messengers.matrix.incoming import ReceivedMoment
from rosic.messengers.matrix.reading import ReceivedEvent
from rosic.messengers.matrix.room_backlog import (
    PendingRoomPart,
    RoomBacklog,
    RoomDelivery,
    RoomGap,
)
from rosic.messengers.matrix.rooms import entered_at
from rosic.messengers.matrix.sync_answer import event_of, invite_state, room_part
from rosic.messengers.matrix.sync_gap import SyncGap, SyncMoment
from rosic.messengers.matrix.sync_window import SyncWindow

if TYPE_CHECKING:
    from asyncio import Task
    from collections.abc import Awaitable, Callable, Coroutine, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive, Settle
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.device_trust import DeviceTrust
    from rosic.messengers.matrix.reading import EventReader
    from rosic.messengers.matrix.rooms import Rooms
    from rosic.messengers.matrix.sync_answer import RoomPart, SyncAnswer
    from rosic.messengers.matrix.sync_window import SyncBatch

POSITION_FILE: Final = "sync.sealed"
TIMELINE: Final = 100
"""Events of one room in one sync. Where there are more, those between are asked for."""
POLL_MS: Final = 3_000
"""A tap carries no time that could be trusted: a sync that is answered late may bring an old one,
so an answer must come within the 5 s after which a pause counts as a gap."""
WAITS_S: Final = (0.2, 0.5, 1.0, 2.0, 5.0)
SETTLES_WITHIN_S: Final = 1.0
LONGEST_WAIT_S: Final = 60.0
ANSWERS_FIRST_S: Final = 0.015
"""A homeserver does one thing of an account after another: asked for more at once, it looks for
that before it takes the answer to what it has just brought. A stop may come so much later."""

log = logging.getLogger("rosic.messengers.matrix")


class SyncParts(NamedTuple):
    """What a run listens with.

    Attributes:
        trust: Whose devices what comes is from.
    """

    client: MatrixClient
    rooms: Rooms
    reader: EventReader
    trust: DeviceTrust


class SyncRun(NamedTuple):
    """One run of the loop.

    Attributes:
        group: Its tasks end with it.
        window: What is not settled yet.
        settle: Asked before anything is confirmed.
        missed: Fetches what the homeserver has left out.
    """

    group: TaskGroup
    window: SyncWindow
    settle: Settle
    missed: RoomBacklog


class SyncLoop:
    """Receives for one account.

    Args:
        name: Of the messenger, for the log.
        parts: What it listens with.
        beside: What goes on for as long as it runs.
        prepared: Called once a run, when the rooms are known and before anybody may speak.
        alarm: Told that the account can be used no longer, before the run ends.

    Attributes:
        ready: Set while the rooms are known, so that something can be said in them.
        counts: ``given-up`` messages, and gaps in which some were ``missed``.
    """

    def __init__(
        self,
        name: str,
        parts: SyncParts,
        clock: Clock,
        *,
        beside: Sequence[Callable[[], Coroutine[Any, Any, None]]],
        prepared: Callable[[], Awaitable[None]],
        alarm: Callable[[MessengerFault], None],
    ) -> None:
        self.ready = asyncio.Event()
        self.counts: Counter[str] = Counter()
        self._name = name
        self._client, self._rooms, self._reader, self._trust = parts
        self._clock = clock
        self._beside = beside
        self._prepared = prepared
        self._alarm = alarm
        self._listening = SyncGap()
        self._since = ""
        self._full = True
        self._timeline = TIMELINE
        self._failures = 0
        self._upkeep: Task[None] | None = None

    @property
    def catching_up(self) -> bool:
        """Whether what was sent while nobody listened may still come."""
        return self._listening.frozen

    @property
    def is_connected(self) -> bool:
        """Whether the last sync was answered."""
        return self.ready.is_set() and not self._failures

    async def run(self, receive: Receive, settle: Settle) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: The homeserver does not let us in. Nothing was received.
            MessengerFault: It does not any more. What was not settled is given out again.
        """
        self._listening, self._full, self._failures = SyncGap(), True, 0
        self._upkeep = None
        try:
            while not await self._attempt(receive, settle):
                pass
        finally:
            self.ready.clear()

    async def _attempt(self, receive: Receive, settle: Settle) -> bool:
        """Sign in and listen; False where the homeserver was away before we were in."""
        entered = False
        try:
            async with self._client.held():
                self._client.remember_rooms()
                await self._trust.start()
                entered = True
                kept = await asyncio.to_thread(self._client.folder.read, POSITION_FILE)
                self._since = (kept or b"").decode()
                async with TaskGroup() as group:
                    window = SyncWindow(group, receive, self._trust.weigh, self.counts)
                    syncing = self._begin(group, window, settle)
                    for follow in self._beside:
                        group.create_task(follow())
                    group.create_task(self._confirm(syncing))
                    while True:
                        await self._sync(syncing)
                        if window.busy:
                            await asyncio.sleep(ANSWERS_FIRST_S)
        except ExceptionGroup as several:
            raise several.exceptions[0] from None
        except MessengerFault as error:
            if entered:
                raise
            await self._wait_out(error)
            return False

    def _begin(self, group: TaskGroup, window: SyncWindow, settle: Settle) -> SyncRun:
        async def deliver(arrivals: Sequence[ReceivedEvent], batch: SyncBatch) -> None:
            await self._deliver(arrivals, batch, run)

        async def stops(arrivals: Sequence[ReceivedEvent], batch: SyncBatch) -> None:
            await self._stops(arrivals, batch, run)

        delivery = RoomDelivery(window, deliver, stops)
        missed = RoomBacklog(group, self._client, self._clock, delivery, self.counts)
        run = SyncRun(group, window, settle, missed)
        return run

    # ---- one sync ----

    async def _sync(self, syncing: SyncRun) -> None:
        asked = self._now()
        at_once = self._full or self._listening.frozen
        try:
            answer = await self._client.sync(
                self._since,
                timeout_ms=0 if at_once else POLL_MS,
                full=self._full,
                shape=_shape(self._timeline),
            )
        except MatrixError as error:
            if error.kind is MatrixErrorKind.TOO_LARGE and self._timeline > 1:
                log.warning("%s: asks for less at once (%s)", self._name, error.reason)
                self._timeline = max(1, self._timeline // 10)
            else:
                await self._cope(error)
            return
        now = self._now()
        self._timeline = TIMELINE
        self._listening.answered(now)
        self._recovered()
        received = ReceivedMoment(now.wall_ns, self._listening.stamp(now.wall_ns))
        batch = syncing.window.begin(answer.next_batch)
        quiet = await self._take(answer, received, batch, syncing)
        syncing.window.close(batch)
        self._since, first, self._full = answer.next_batch, self._full, False
        await self._follow_up(syncing, first=first)
        if self._listening.drained(asked, empty=quiet):
            log.info("%s: listening", self._name)

    async def _take(
        self, answer: SyncAnswer, received: ReceivedMoment, batch: SyncBatch, syncing: SyncRun
    ) -> bool:
        """Take an answer apart: stops of all rooms first, then keys, then everything else.

        Returns:
            Whether nothing was said in any room.
        """
        parts = {}
        for room, piece in answer.joined.items():
            parts[room] = room_part(piece)
            await self._client.steps.give_way()
        for room, part in parts.items():
            if room in self._client.rooms and self._since:
                came = [event_of(piece) for piece in part.timeline]
                sources = [one for one in came if one is not None]
                await self._stops(
                    [ReceivedEvent(room, one, received) for one in sources], batch, syncing
                )
        await self._invitations(answer)
        self._trust.devices_changed(answer.changed)
        async for source in self._client.take_to_device(answer):
            self._trust.heard("", source)
        arrivals: list[ReceivedEvent] = []
        for room, part in parts.items():
            arrivals += await self._room(room, part, received, batch, syncing)
        await self._deliver(arrivals, batch, syncing)
        return not any(part.timeline for part in parts.values())

    async def _invitations(self, answer: SyncAnswer) -> None:
        for room, piece in answer.invited.items():
            sources = [event_of(one) for one in invite_state(piece)]
            self._rooms.invited(room, [one for one in sources if one is not None])
            await self._client.steps.give_way()
        if not self._full:
            self._rooms.left(answer.left)
        for room in answer.left:
            self._client.rooms.left(room)

    async def _room(
        self,
        room: str,
        part: RoomPart,
        received: ReceivedMoment,
        batch: SyncBatch,
        syncing: SyncRun,
    ) -> list[ReceivedEvent]:
        """Return what was said in a room; nothing, where it waits for what is missing before it."""
        timeline = [source async for source in self._client.take_state(room, part)]
        begin = entered_at(timeline, self._client.user)
        if not self._since and not begin:
            return []  # what was said before this account was ever ours
        for source in timeline:
            self._rooms.happened(room, source)
        gap = None
        if part.limited and self._since and not begin:
            received = received._replace(listening_since_ns=received.received_ns + 1)
            gap = RoomGap(part.before, self._since, received)
        came = [ReceivedEvent(room, source, received) for source in timeline[begin:]]
        if gap is None and not syncing.missed.holds(room):
            return came
        syncing.missed.wait_behind(room, PendingRoomPart(batch, gap, came))
        return []

    async def _stops(
        self, arrivals: Sequence[ReceivedEvent], batch: SyncBatch, syncing: SyncRun
    ) -> None:
        for arrival in arrivals:
            one = self._reader.urgent(arrival)
            if one is not None:
                syncing.window.admit(one, batch)
                await asyncio.sleep(0)
            await self._client.steps.give_way()

    async def _deliver(
        self, arrivals: Sequence[ReceivedEvent], batch: SyncBatch, syncing: SyncRun
    ) -> None:
        for one in await self._reader.read(arrivals):
            syncing.window.admit(one, batch)

    async def _follow_up(self, syncing: SyncRun, *, first: bool) -> None:
        """Look after keys and rooms: at first before anybody speaks, then beside the loop."""
        if first:
            await self._client.upkeep()
            try:
                await self._prepared()
            except MessengerFault as fault:
                log.warning("%s: %s", self._name, fault)
            self.ready.set()
        if self._upkeep is None or self._upkeep.done():
            self._upkeep = syncing.group.create_task(self._look_after())

    async def _look_after(self) -> None:
        await self._client.upkeep()
        await self._trust.look_after()
        if self._rooms.has_work:
            await self._rooms.follow()
        await self._reader.tell_unreadable()

    # ---- confirming ----

    async def _confirm(self, syncing: SyncRun) -> None:
        """Keep on disk up to where everything is settled."""
        window, token = syncing.window, ""
        while True:
            await window.moved.wait()
            window.moved.clear()
            token = window.confirmable() or token
            while token and not await syncing.settle(SETTLES_WITHIN_S):
                token = window.confirmable() or token
            if token:
                await self._keep(token)
            token = ""

    async def _keep(self, token: str) -> None:
        try:
            await asyncio.to_thread(self._client.folder.write, POSITION_FILE, token.encode())
        except OSError as error:
            log.error("%s: how far it has read was not kept: %s", self._name, error)  # noqa: TRY400

    # ---- trouble ----

    async def _cope(self, error: MatrixError) -> None:
        """Wait and let the loop go on.

        Raises:
            MessengerFault: The account cannot be used any more.
        """
        fault: MessengerFault = error
        if error.kind is MatrixErrorKind.SIGNED_OUT:
            try:
                await self._client.sign_in_again(error)
                await self._trust.start()  # the homeserver may have forgotten this device's keys
            except MatrixError as refused:
                if refused.kind in {MatrixErrorKind.LOST, MatrixErrorKind.TOO_FAST}:
                    await self._wait_out(refused)
                    return
                fault = refused
            except MessengerFault as refused:
                await self._wait_out(refused)
                return
            except ConfigurationError as refused:
                fault = MessengerFault(str(refused))
            else:
                return
        elif error.kind is not MatrixErrorKind.UNUSABLE:
            await self._wait_out(error)
            return
        told = MessengerFault(f"The homeserver no longer lets the messenger {self._name} in.")
        self._alarm(told)
        raise told from fault

    async def _wait_out(self, error: MessengerFault) -> None:
        asked_s, reason = 0.0, ""
        if isinstance(error, MatrixError):
            asked_s, reason = error.wait_s, error.reason
        if not self._failures:
            log.warning("%s: %s (%s)", self._name, error, reason)
        wait_s = WAITS_S[min(self._failures, len(WAITS_S) - 1)]
        self._failures += 1
        await self._clock.sleep(min(max(wait_s, asked_s), LONGEST_WAIT_S))

    def _recovered(self) -> None:
        if self._failures:
            log.info("%s: the homeserver answers again", self._name)
            self._failures = 0

    def _now(self) -> SyncMoment:
        return SyncMoment(self._clock.wall_ns(), self._clock.monotonic_ns())


def _shape(limit: int) -> dict[str, Any]:
    """Return what is asked for, with so many events of a room at the most."""
    nothing: dict[str, Any] = {"types": []}
    return {
        "presence": nothing,
        "account_data": nothing,
        "room": {
            "timeline": {"limit": limit},
            "state": {"lazy_load_members": False},
            "ephemeral": nothing,
            "account_data": nothing,
        },
    }
