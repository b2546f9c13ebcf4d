"""What a homeserver has left out of a sync: asked for by the room, beside everything else.

While it is fetched, what comes later in that room waits behind it, as it was written behind it; a
stop does not, and no other room does.
"""

from __future__ import annotations

import logging
from collections import deque
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind
from rosic.messengers.matrix.reading import ReceivedEvent
from rosic.messengers.matrix.room_calls import RoomCalls
from rosic.messengers.matrix.rooms import entered_at

if TYPE_CHECKING:
    from asyncio import TaskGroup
    from collections import Counter
    from collections.abc import Awaitable, Callable, Sequence

    from rosic.contracts.clock import Clock
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.incoming import ReceivedMoment
    from rosic.messengers.matrix.sync_window import SyncBatch, SyncWindow

PAGE: Final = 100
MISSED_AT_MOST: Final = 1_000
"""Events of one room that are asked for after a gap; what is older is given up, and counted."""
WAITING_AT_MOST: Final = 2_000
"""Events of one room that wait behind what is asked for."""
WAITS_S: Final = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""After each of them it is asked for once more; then it is given up."""

log = logging.getLogger("rosic.messengers.matrix")


class RoomGap(NamedTuple):
    """What is missing in a room.

    Attributes:
        before: From where it is asked for, backwards; empty: it cannot be.
        since: Where it ends; empty: where we entered.
        received: Everything that is found is backlog.
    """

    before: str
    since: str
    received: ReceivedMoment


class PendingRoomPart(NamedTuple):
    """What one sync brought of a room.

    Attributes:
        batch: Of that sync; open until this is handed over.
        gap: What is missing before it; None for nothing.
        events: In order.
    """

    batch: SyncBatch
    gap: RoomGap | None
    events: Sequence[ReceivedEvent]


class RoomDelivery(NamedTuple):
    """Where what was found goes.

    Attributes:
        window: What is handed over is admitted there.
        deliver: Reads events and has them handed over.
        stops: Hands over stops among events, at once.
    """

    window: SyncWindow
    deliver: Callable[[Sequence[ReceivedEvent], SyncBatch], Awaitable[None]]
    stops: Callable[[Sequence[ReceivedEvent], SyncBatch], Awaitable[None]]


class RoomBacklog:
    """Fetches for one run.

    Args:
        group: Its tasks end with it.
        client: Of the account.
        delivery: Where what was found goes.
        counts: ``missed``: gaps that were not filled; ``given-up``: messages that were too many.
    """

    def __init__(
        self,
        group: TaskGroup,
        client: MatrixClient,
        clock: Clock,
        delivery: RoomDelivery,
        counts: Counter[str],
    ) -> None:
        self._group = group
        self._client = client
        self._calls = RoomCalls(client)
        self._clock = clock
        self._window, self._deliver, self._stops = delivery
        self._counts = counts
        self._waiting: dict[str, deque[PendingRoomPart]] = {}

    def holds(self, room: str) -> bool:
        """Whether what comes in a room waits."""
        return room in self._waiting

    def wait_behind(self, room: str, came: PendingRoomPart) -> None:
        """Hand over what came in a room when what is missing before it was found, or given up."""
        waiting = self._waiting.get(room)
        if waiting is not None:
            if sum(len(one.events) for one in waiting) > WAITING_AT_MOST:
                self._counts["given-up"] += len(came.events)
                return
            self._window.hold(came.batch)
            waiting.append(came)
            return
        self._window.hold(came.batch)
        self._waiting[room] = deque([came])
        self._group.create_task(self._catch_up(room))

    async def _catch_up(self, room: str) -> None:
        waiting = self._waiting[room]
        while waiting:
            came = waiting[0]
            missed = [] if came.gap is None else await self._fill(room, came.gap, came.batch)
            await self._deliver([*missed, *came.events], came.batch)
            self._window.close(came.batch)
            waiting.popleft()
        del self._waiting[room]

    async def _fill(self, room: str, gap: RoomGap, batch: SyncBatch) -> list[ReceivedEvent]:
        """Return what is missing, oldest first; nothing of what cannot be had."""
        found: list[dict[str, Any]] = []
        before = gap.before
        while before:
            page = await self._page(room, before, gap.since)
            if page is None:
                self._counts["missed"] += 1
                break
            chunk, before = page
            await self._stops([ReceivedEvent(room, one, gap.received) for one in chunk], batch)
            found += chunk
            if not chunk or entered_at(chunk, self._client.user):
                break
            if len(found) >= MISSED_AT_MOST:
                self._counts["missed"] += 1
                log.warning("more was said in a room than can be caught up with")
                break
        found.reverse()
        begin = entered_at(found, self._client.user)
        return [ReceivedEvent(room, one, gap.received) for one in found[begin:]]

    async def _page(
        self, room: str, before: str, since: str
    ) -> tuple[list[dict[str, Any]], str] | None:
        failures, limit = 0, PAGE
        while True:
            try:
                return await self._calls.earlier(room, before, since, limit)
            except MatrixError as error:
                if error.kind is MatrixErrorKind.TOO_LARGE and limit > 1:
                    limit //= 10
                    continue
                passing = error.kind in {
                    MatrixErrorKind.LOST,
                    MatrixErrorKind.TOO_FAST,
                    MatrixErrorKind.SIGNED_OUT,
                }
                if not passing or failures >= len(WAITS_S):
                    log.warning("what was missed in a room cannot be had: %s", error.reason)
                    return None
                await self._clock.sleep(max(WAITS_S[failures], min(error.wait_s, WAITS_S[-1])))
                failures += 1
