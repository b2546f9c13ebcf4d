"""The loop: asks for what is new, hands it over, and confirms what was received to the end.

Matrix gives out again whatever came after a token. The next sync goes on at once where the last
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
from rosic.messengers.matrix.room_calls import RoomCalls
from rosic.messengers.matrix.rooms import entered_at, has_entered
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

POSITION_FILE: Final = "sync.sealed"
TIMELINE: Final = 100
"""Events of one room in one sync. Where there are more, those between are asked for."""
MISSED_AT_MOST: Final = 1_000
"""Events of one room that are asked for after a gap; what is older is given up, and counted."""
POLL_MS: Final = 3_000
"""A tap carries no time that could be trusted: a sync that is answered late may bring an old one,
so an answer must come within the 5 s after which a pause counts as a gap."""
WAITS_S: Final = (0.2, 0.5, 1.0, 2.0, 5.0)
SETTLES_WITHIN_S: Final = 1.0
LONGEST_WAIT_S: Final = 60.0
SHAPE: Final = {
    "presence": {"types": []},
    "account_data": {"types": []},
    "room": {
        "timeline": {"limit": TIMELINE},
        "state": {"lazy_load_members": False},
        "ephemeral": {"types": []},
        "account_data": {"types": []},
    },
}

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
    """

    group: TaskGroup
    window: SyncWindow
    settle: Settle


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
                await self._trust.start()
                entered = True
                kept = await asyncio.to_thread(self._client.folder.read, POSITION_FILE)
                self._since = (kept or b"").decode()
                async with TaskGroup() as group:
                    window = SyncWindow(group, receive, self._trust.weigh, self.counts)
                    syncing = SyncRun(group, window, settle)
                    for follow in self._beside:
                        group.create_task(follow())
                    group.create_task(self._confirm(syncing))
                    while True:
                        await self._sync(syncing)
        except ExceptionGroup as several:
            raise several.exceptions[0] from None
        except MessengerFault as error:
            if entered:
                raise
            await self._wait_out(error)
            return False

    # ---- one sync ----

    async def _sync(self, syncing: SyncRun) -> None:
        asked = self._now()
        at_once = self._full or self._listening.frozen
        try:
            answer = await self._client.sync(
                self._since,
                timeout_ms=0 if at_once else POLL_MS,
                full=self._full,
                shape=SHAPE,
            )
            limited = {} if not self._since else await self._missed(answer)
        except MatrixError as error:
            await self._cope(error)
            return
        now = self._now()
        self._listening.answered(now, limited=bool(limited))
        self._recovered()
        received = ReceivedMoment(now.wall_ns, self._listening.stamp(now.wall_ns))
        batch = syncing.window.begin(answer.next_batch)
        events = self._events(answer, limited)
        self._reader.keys_came(bool(answer.to_device_events))
        self._trust.devices_changed([*answer.device_list.changed, *answer.device_list.left])
        for event in answer.to_device_events:
            if event is not None and isinstance(event.source, dict):  # None: it is like no other
                self._trust.heard("", event.source)
        came = self._reader.read(events, received)
        for one in came:
            syncing.window.admit(one, batch)
        syncing.window.close(batch)
        self._since, first, self._full = answer.next_batch, self._full, False
        await self._follow_up(syncing, first=first)
        if self._listening.drained(asked, empty=not events, limited=bool(limited)):
            log.info("%s: listening", self._name)

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

    def _events(self, answer: Any, missed: dict[str, list[Any]]) -> list[tuple[str, Any]]:  # noqa: ANN401
        """Return the events of all rooms, each with its room, in order within each room."""
        self._rooms.invited(answer.rooms.invite)
        if not self._full:
            self._rooms.left(answer.rooms.leave)
        found: list[tuple[str, Any]] = []
        for room, info in answer.rooms.join.items():
            timeline = info.timeline.events
            if not self._since and not has_entered(timeline, self._client.user):
                continue  # what was said before this account was ever ours
            begin = entered_at(timeline, self._client.user)
            events = timeline[begin:] if begin else [*missed.get(room, ()), *timeline]
            for event in timeline:
                if not event.decrypted:  # a room's own events are never encrypted
                    self._rooms.happened(room, event.source)
            found += [(room, event) for event in events]
        return found

    async def _missed(self, answer: Any) -> dict[str, list[Any]]:  # noqa: ANN401 - no types
        """Return what the homeserver has left out of rooms that we were in before, oldest first.

        Raises:
            MatrixError: It cannot be had now: the same sync is asked for again.
        """
        found: dict[str, list[Any]] = {}
        for room, info in answer.rooms.join.items():
            timeline = info.timeline
            if not timeline.limited or has_entered(timeline.events, self._client.user):
                continue
            found[room] = await self._between(room, timeline.prev_batch or "")
        return found

    async def _between(self, room: str, before: str) -> list[Any]:
        events: list[Any] = []
        while before:
            chunk, before = await RoomCalls(self._client).earlier(
                room, before, self._since, TIMELINE
            )
            events += chunk
            if not chunk or has_entered(chunk, self._client.user):
                break
            if len(events) >= MISSED_AT_MOST:
                self.counts["missed"] += 1
                log.warning("%s: more was said in a room than can be caught up with", self._name)
                break
        events.reverse()
        return events[entered_at(events, self._client.user) :]

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
