"""How fast we may speak, and who speaks first.

Telegram allows about one message a second in a chat, 20 a minute in a group and 30 a second in
all; edits count (https://core.telegram.org/bots/faq#my-bot-is-hitting-limits-how-do-i-avoid-this).
The limits are elastic, so ``retry_after`` is obeyed whatever was counted here.
"""

from __future__ import annotations

import asyncio
import enum
import itertools
from bisect import insort
from typing import TYPE_CHECKING, NamedTuple

from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock

SECOND_NS = 1_000_000_000
CHATS_REMEMBERED = 4_096
WAITING_AT_MOST = 1_000


class Rank(enum.IntEnum):
    """Who goes first."""

    URGENT = 0
    MESSAGE = 1
    EDIT = 2


class Rate(NamedTuple):
    """One every ``interval_s`` in the long run, so many at once after a rest, by rank.

    An urgent one may run up a debt that the others then pay off.
    """

    interval_s: float
    at_once: tuple[int, int, int]


CHAT = Rate(1.0, (10, 3, 2))
GROUP = Rate(5.0, (12, 8, 6))
"""8 at once and then one every 5 s: never more than 20 in any minute, except for what is urgent."""
OVERALL = Rate(1 / 28, (40, 24, 16))


class Pace:
    """One limit's memory: the time at which everything said so far is paid for."""

    __slots__ = ("_interval_ns", "_paid_ns", "_rate")

    def __init__(self, rate: Rate) -> None:
        self._rate = rate
        self._interval_ns = int(rate.interval_s * SECOND_NS)
        self._paid_ns = 0

    def ready_ns(self, rank: Rank) -> int:
        """Return when one more of this rank may be said; in the past when it may now."""
        return self._paid_ns - (self._rate.at_once[rank] - 1) * self._interval_ns

    def spend(self, now_ns: int) -> None:
        """Count one."""
        self._paid_ns = max(self._paid_ns, now_ns) + self._interval_ns

    def rested(self, now_ns: int) -> bool:
        """Nothing is owed: forgetting it changes nothing."""
        return self._paid_ns <= now_ns


class _Waiting(NamedTuple):
    """In the order in which they are served."""

    rank: Rank
    number: int
    chat: str
    group: bool
    give_up_ns: int
    turn: asyncio.Future[None]


class Limiter:
    """Gives turns. Nothing runs while nobody waits."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._overall = Pace(OVERALL)
        self._paces: dict[str, tuple[Pace, ...]] = {}
        self._held_ns: dict[str, int] = {}
        self._all_held_ns = 0
        self._waiting: list[_Waiting] = []
        self._numbers = itertools.count()
        self._alarm: asyncio.Task[None] | None = None

    async def turn(self, chat: str, rank: Rank, *, within_s: float) -> None:
        """Wait for a turn in this chat.

        Raises:
            MessengerFault: There was none in time, or too much waits already. Nothing was sent.
        """
        if len(self._waiting) >= WAITING_AT_MOST * (3 - rank):
            raise MessengerFault("Too much is waiting to be said. This was not sent.")
        give_up_ns = self._clock.monotonic_ns() + int(within_s * SECOND_NS)
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        mine = _Waiting(rank, next(self._numbers), chat, chat.startswith("-"), give_up_ns, turn)
        insort(self._waiting, mine)
        self._serve()
        try:
            await turn
        finally:
            if mine in self._waiting:
                self._waiting.remove(mine)
            if not self._waiting:
                self._rest()

    def hold(self, chat: str, seconds: float) -> None:
        """Obey ``retry_after``, which does not say what it is for.

        It is taken to be for the chat, until a second chat is told to wait as well.
        """
        now_ns = self._clock.monotonic_ns()
        until_ns = now_ns + int(seconds * SECOND_NS)
        self._held_ns = {one: held for one, held in self._held_ns.items() if held > now_ns}
        if self._held_ns.keys() - {chat}:
            self._all_held_ns = max(self._all_held_ns, until_ns)
        self._held_ns[chat] = max(until_ns, self._held_ns.get(chat, 0))

    def _serve(self) -> None:
        """Give every turn that is due, then set the alarm for the next."""
        self._rest()
        now_ns = self._clock.monotonic_ns()
        wakes: list[int] = []
        for one in list(self._waiting):
            due_ns = self._due_ns(one)
            if due_ns <= now_ns:
                self._spend(one, now_ns)
                self._settle(one, None)
            elif one.give_up_ns <= now_ns:
                self._settle(one, MessengerFault("Telegram's limits left no room. Not sent."))
            else:
                wakes.append(min(due_ns, one.give_up_ns))
        if wakes:
            self._alarm = asyncio.create_task(self._ring((min(wakes) - now_ns) / SECOND_NS))

    def _settle(self, one: _Waiting, fault: MessengerFault | None) -> None:
        self._waiting.remove(one)
        if one.turn.done():
            return
        if fault is None:
            one.turn.set_result(None)
        else:
            one.turn.set_exception(fault)

    def _due_ns(self, one: _Waiting) -> int:
        limits = [pace.ready_ns(one.rank) for pace in (self._overall, *self._of(one))]
        return max(*limits, self._all_held_ns, self._held_ns.get(one.chat, 0))

    def _spend(self, one: _Waiting, now_ns: int) -> None:
        for pace in (self._overall, *self._of(one)):
            pace.spend(now_ns)

    def _of(self, one: _Waiting) -> tuple[Pace, ...]:
        paces = self._paces.get(one.chat)
        if paces is None:
            if len(self._paces) >= CHATS_REMEMBERED:
                self._forget()
            paces = (Pace(CHAT), Pace(GROUP)) if one.group else (Pace(CHAT),)
            self._paces[one.chat] = paces
        return paces

    def _forget(self) -> None:
        now_ns = self._clock.monotonic_ns()
        self._paces = {
            chat: paces
            for chat, paces in self._paces.items()
            if not all(pace.rested(now_ns) for pace in paces)
        }

    async def _ring(self, after_s: float) -> None:
        await self._clock.sleep(after_s)
        self._alarm = None
        self._serve()

    def _rest(self) -> None:
        if self._alarm is not None:
            self._alarm.cancel()
            self._alarm = None
