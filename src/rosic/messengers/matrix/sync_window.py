"""What was received and is not settled yet: one lane a room, and stops beside all lanes."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core.message import MessageValidity
from rosic.core.policy.roles import Assurance

if TYPE_CHECKING:
    from asyncio import TaskGroup
    from collections import Counter
    from collections.abc import Awaitable, Callable

    from rosic.contracts.messenger import Receive
    from rosic.core.message import Inbound
    from rosic.messengers.matrix.reading import ReadEvent

MOST_WAITING: Final = 2_000
"""Of what strangers send no more than this waits; what is over it is passed over, and counted."""


class SyncBatch:
    """What one answer to a sync brought.

    Attributes:
        token: Where the next sync goes on.
        left: How much of it is not received to the end.
    """

    def __init__(self, token: str) -> None:
        self.token = token
        self.left = 0


class SyncWindow:
    """Hands over, in order within each room, and knows how far everything was received.

    Args:
        group: Its tasks end with it.
        receive: Takes each message.
        weigh: Returns a message as it counts; asked in the message's turn, and of no stop.
        counts: ``given-up``: strangers' messages that were too many.
    """

    def __init__(
        self,
        group: TaskGroup,
        receive: Receive,
        weigh: Callable[[ReadEvent], Awaitable[Inbound]],
        counts: Counter[str],
    ) -> None:
        self._group = group
        self._receive = receive
        self._weigh = weigh
        self._counts = counts
        self._batches: deque[SyncBatch] = deque()
        self._lanes: dict[str, deque[tuple[ReadEvent, SyncBatch]]] = {}
        self._waiting = 0
        self.moved = asyncio.Event()
        """Set when more may be confirmed than before."""

    @property
    def busy(self) -> bool:
        """Whether anything is not received to the end."""
        return bool(self._waiting)

    def begin(self, token: str) -> SyncBatch:
        """Begin what one answer brought; `close` it when all of it was admitted."""
        batch = SyncBatch(token)
        batch.left = 1
        self._batches.append(batch)
        return batch

    def hold(self, batch: SyncBatch) -> None:
        """Say that more of a batch comes later; `close` it once more then."""
        batch.left += 1

    def close(self, batch: SyncBatch) -> None:
        """Say that nothing more of a batch comes."""
        self._done(batch)

    def admit(self, one: ReadEvent, batch: SyncBatch) -> None:
        """Hand a message over: at once if it is urgent, otherwise after those before it there."""
        if not one.urgent and not one.known and self._waiting >= MOST_WAITING:
            self._counts["given-up"] += 1
            return
        batch.left += 1
        self._waiting += 1
        if one.urgent:
            self._group.create_task(self._hand_over(one, batch))
            return
        room = one.inbound.chat.id
        lane = self._lanes.get(room)
        if lane is not None:
            lane.append((one, batch))
            return
        self._lanes[room] = deque([(one, batch)])
        self._group.create_task(self._drain(room))

    def confirmable(self) -> str:
        """Return up to where everything was received to the end; empty: nothing new."""
        token = ""
        while self._batches and not self._batches[0].left:
            token = self._batches.popleft().token
        return token

    async def _drain(self, room: str) -> None:
        lane = self._lanes[room]
        while lane:
            await self._hand_over(*lane.popleft())
        del self._lanes[room]

    async def _hand_over(self, one: ReadEvent, batch: SyncBatch) -> None:
        await self._receive(_stop_alone(one.inbound) if one.urgent else await self._weigh(one))
        self._waiting -= 1
        self._done(batch)

    def _done(self, batch: SyncBatch) -> None:
        batch.left -= 1
        if not batch.left and self._batches and self._batches[0] is batch:
            self.moved.set()


def _stop_alone(inbound: Inbound) -> Inbound:
    """Return a message with a stop in it, which waits for no look at keys.

    So nobody knows yet who sent it: of what stands beside the stop nothing counts, and what turns
    out to be no stop may only look.
    """
    if inbound.standing is not MessageValidity.FRESH:
        return inbound
    alone = len(inbound.text.splitlines()) <= 1
    standing = MessageValidity.UNVERIFIED if alone else MessageValidity.ANONYMOUS
    return replace(inbound, standing=standing, assurance=Assurance.PROVIDER_READABLE)
