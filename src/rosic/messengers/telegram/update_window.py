"""Updates that Telegram has given out and that are not confirmed yet, and their handing over.

Telegram forgets an update as soon as a poll carries a higher offset, and gives out at most 100 that
it has not forgotten. The offset therefore follows what has been received to the end, and never more
than 100 messages are under way.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from hashlib import blake2b
from operator import itemgetter
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.identity import DIGEST_BYTES
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.core.message import Inbound

ATTEMPTS = 3
FIRST_WAIT_S = 0.2
HELD_NS: Final = SECOND_NS
"""If more than so many are overdue, what has waited for longer than this is given up."""
OVERDUE_AT_MOST: Final = 1_000
WAITING_AT_MOST: Final = 200
"""While so many wait to be handed over, nothing more is read that strangers sent."""
SECONDS_KEPT: Final = 1_000
"""For so many seconds in which somebody said something, the lines that were alike are counted."""
MOST_ALIKE: Final = 100
"""So many lines that are alike in a second are told apart; of more, each bot counts its own."""

log = logging.getLogger("rosic.messengers.telegram")


class AdmittedUpdate(NamedTuple):
    """One update to hand over.

    Attributes:
        inbound: None when there is nothing to hand over, only to confirm.
        stop: It is handed over at once; everything else keeps to the order of its chat.
    """

    update_id: int
    inbound: Inbound | None
    stop: bool = False


class WaitingUpdate(NamedTuple):
    """One update in its chat's lane.

    Attributes:
        since_ns: When it was put there, by the monotonic clock.
    """

    update_id: int
    inbound: Inbound
    since_ns: int


class UpdateWindow:
    """Hands over stops first, then each chat in order and the chats side by side.

    Args:
        group: In which it runs what is under way.
        receive: Takes what is handed over.
        clock: Waits.
        counts: Where ``received``, ``passed-over`` and ``given-up`` are counted.
        on_room: Called while no more wait to be handed over than may.
    """

    def __init__(
        self,
        group: asyncio.TaskGroup,
        receive: Receive,
        clock: Clock,
        counts: Counter[str],
        on_room: Callable[[], None],
    ) -> None:
        self._group = group
        self._receive = receive
        self._clock = clock
        self._open: set[int] = set()
        self._expected: set[int] = set()
        self._light: set[int] = set()
        self._overdue: set[int] = set()
        self._relieved: set[int] = set()
        self._done: set[int] = set()
        self._admitted: list[tuple[int, Inbound]] = []
        self._lanes: dict[str, deque[WaitingUpdate]] = {}
        self._idle = asyncio.Event()
        self._idle.set()
        self._waiting = 0
        self._on_room = on_room
        self._counts = counts

    @property
    def busy(self) -> bool:
        """Something has not been received to the end."""
        return bool(self._open)

    @property
    def offset(self) -> int | None:
        """What the next poll confirms; None when there is nothing to confirm.

        An offset is never repeated once Telegram has taken it: after a quiet week Telegram goes on
        with lower numbers, and an old offset would confirm messages that nobody has seen.
        """
        if not self._done:
            return None
        if not self._open:
            return max(self._done) + 1
        lowest = min(self._open)
        return lowest if min(self._done) < lowest else None

    def confirmed(self, offset: int | None) -> None:
        """Forget what Telegram has forgotten."""
        if offset is not None:
            self._done = {number for number in self._done if number >= offset}

    def confirmed_early(self, offset: int | None, *, settled: bool) -> int:
        """Return how many an offset confirms that whoever is killed now has lost.

        Args:
            offset: What a poll is about to confirm.
            settled: What is received to the end is on disk.
        """
        confirmed = {number for number in self._done if offset is not None and number < offset}
        return len(confirmed & self._relieved if settled else confirmed)

    def knows(self, update_id: int) -> bool:
        """Whether an update was given out before, so that nothing of it need be read again."""
        return update_id in self._open or update_id in self._done

    def expect(self, update_id: int, *, light: bool = False) -> None:
        """Keep unconfirmed what came and is still to be read; `admit` follows.

        Args:
            update_id: Which.
            light: Nobody known here sent it, so that it may be confirmed where it is in the way.
        """
        self._expected.add(update_id)
        if light:
            self._light.add(update_id)
        self._open.add(update_id)
        self._idle.clear()

    def admit(self, one: AdmittedUpdate) -> bool:
        """Take what a poll brought: a stop is handed over now, anything else by `release`.

        Returns:
            Whether it had not been given out before; else nothing is done.
        """
        unnamed = one.update_id in self._expected
        if unnamed:
            self._expected.discard(one.update_id)
        elif self.knows(one.update_id):
            return False
        if one.inbound is None:
            self._counts["passed-over"] += 1
            self._ended(one.update_id)
            return True
        if one.update_id not in self._overdue:
            self._open.add(one.update_id)
            self._idle.clear()
        if one.stop:
            self._group.create_task(self._hand_over(one.update_id, one.inbound))
        else:
            self._admitted.append((one.update_id, one.inbound))
            if unnamed:
                self._light.add(one.update_id)
        return True

    def release(self, before: int | None = None) -> None:
        """Begin to hand over what was admitted, in the order of its numbers; or the first of it."""
        admitted, self._admitted = sorted(self._admitted, key=itemgetter(0)), []
        for update_id, inbound in admitted:
            if before is None or update_id < before:
                self._queue(update_id, inbound)
            else:
                self._admitted.append((update_id, inbound))

    def clear_the_way(self) -> None:
        """Confirm what nobody known here sent, though it is not received to the end.

        It fills what Telegram gives out, and a stop may be behind it. It is followed all the same,
        unless this process ends before.
        """
        for update_id in self._light & self._open:
            self._overdue.add(update_id)
            self._end(update_id)

    @property
    def has_room(self) -> bool:
        """Whether no more wait to be handed over than may."""
        return self._waiting < WAITING_AT_MOST

    async def idle(self, at_most_s: float) -> None:
        """Wait until everything has been received, but not for long: a stop may come meanwhile."""
        await asyncio.sleep(0)
        await asyncio.sleep(0)  # what a message has begun has its turn before the next poll
        if self._idle.is_set():
            return
        waits = [
            asyncio.ensure_future(self._idle.wait()),
            asyncio.ensure_future(self._clock.sleep(at_most_s)),
        ]
        try:
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for wait in waits:
                wait.cancel()

    def _queue(self, update_id: int, inbound: Inbound) -> None:
        chat = inbound.chat.id
        lane = self._lanes.get(chat)
        if lane is None:
            lane = self._lanes[chat] = deque()
            self._group.create_task(self._follow(chat, lane))
        lane.append(WaitingUpdate(update_id, inbound, self._clock.monotonic_ns()))
        self._waiting += 1

    async def _follow(self, chat: str, lane: deque[WaitingUpdate]) -> None:
        while lane:
            await self._hand_over(lane[0].update_id, lane[0].inbound)
            lane.popleft()
            self._leaves_lane()
            await asyncio.sleep(0)  # a message is a step: what is refused at once never waited
        del self._lanes[chat]

    def _leaves_lane(self) -> None:
        self._waiting -= 1
        if self.has_room:
            self._on_room()

    async def _hand_over(self, update_id: int, inbound: Inbound) -> None:
        """Hand over once; again if that broke, but not for ever: a stop may wait behind it."""
        wait_s = FIRST_WAIT_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                await self._receive(inbound)
            except Exception:
                log.exception("a message could not be received (attempt %d)", attempt)
            else:
                self._counts["received"] += 1
                break
            if attempt < ATTEMPTS:
                await self._clock.sleep(wait_s)
                wait_s *= 2
        else:
            log.error("a message was given up after %d attempts; nothing was done", ATTEMPTS)
            self._counts["given-up"] += 1
        self._ended(update_id)

    def relieve(self) -> None:
        """Let what is under way be confirmed: it hides what is behind it, a stop perhaps.

        It is followed all the same, as soon as it can be, unless this process ends before. Of more
        than so many, those that were not begun and have waited for long are given up, and whoever
        sent them is told; while there are none, nothing is confirmed. What waits for something to
        be read is not under way: that ends.
        """
        held = self._open - self._expected - {number for number, _ in self._admitted}
        if len(self._overdue) + len(held) > OVERDUE_AT_MOST:
            self._give_up_waiting()
            held &= self._open
            if len(self._overdue) + len(held) > OVERDUE_AT_MOST:
                return
        self._overdue |= held
        self._relieved |= held
        for update_id in held:
            self._end(update_id)

    def _give_up_waiting(self) -> None:
        late_ns = self._clock.monotonic_ns() - HELD_NS
        given_up = 0
        for lane in self._lanes.values():
            kept: list[WaitingUpdate] = []
            waiting: list[WaitingUpdate] = []
            for at, each in enumerate(lane):
                (waiting if at > 0 and each.since_ns <= late_ns else kept).append(each)
            if not waiting:
                continue
            lane.clear()
            lane.extend(kept)
            for each in waiting:
                self._leaves_lane()
                self._counts["given-up"] += 1
                self._ended(each.update_id)
            given_up += len(waiting)
            self._group.create_task(self._tell([each.inbound for each in waiting]))
        if given_up:
            log.error("messages were given up because they cannot be followed: %d", given_up)

    async def _tell(self, given_up: list[Inbound]) -> None:
        """Hand over once more, to be told of, what is not followed."""
        for inbound in given_up:
            if inbound.standing is MessageValidity.FRESH:
                dropped = msgspec.structs.replace(inbound, standing=MessageValidity.DROPPED)
                try:
                    await self._receive(dropped)
                except Exception:
                    log.exception("of a message that was given up nobody was told")
            await asyncio.sleep(0)

    def _ended(self, update_id: int) -> None:
        self._light.discard(update_id)
        self._relieved.discard(update_id)
        if update_id in self._overdue:
            self._overdue.discard(update_id)
        else:
            self._end(update_id)

    def _end(self, update_id: int) -> None:
        self._open.discard(update_id)
        self._done.add(update_id)
        if not self._open:
            self._idle.set()


class AlikeLines:
    """What a line of a small group is known by to every bot that hears it.

    There each bot counts messages by itself. Who said a line, in which second, and its text as it
    was written, every bot's name in it, are what all of them know; and as all of them hear a chat
    in the same order, the second line of a kind is the second for each. Nothing of it is kept over
    a restart: where somebody says the same twice in one second and we begin anew between the two,
    the later one is taken for the earlier.
    """

    def __init__(self) -> None:
        self._numbers: dict[bytes, list[str]] = {}

    def named(self, inbound: Inbound, date_s: int, written: str) -> Inbound:
        """Return a message with what is shared of it, if its number is one bot's own.

        Args:
            inbound: As this bot reads it.
            date_s: When it was sent, as the platform says.
            written: Its text before any bot's name was taken out.
        """
        if (
            inbound.chat.kind is not ChatKind.GROUP
            or not inbound.account
            or inbound.standing is MessageValidity.EDITED
        ):
            return inbound
        of = (inbound.chat.id, inbound.sender.account, str(date_s), written)
        kind = blake2b("\0".join(of).encode(), digest_size=DIGEST_BYTES).digest()
        numbers = self._numbers.setdefault(kind, [])
        if inbound.message not in numbers:
            if len(numbers) == MOST_ALIKE:
                return inbound
            numbers.append(inbound.message)
            if len(self._numbers) > SECONDS_KEPT:
                del self._numbers[next(iter(self._numbers))]
        return msgspec.structs.replace(
            inbound, shared=f"{kind.hex()} {numbers.index(inbound.message)}"
        )
