"""How fast we may speak, and who speaks first.

Telegram allows about one message a second in a chat, 20 a minute in a group and 30 a second in
all; edits count (https://core.telegram.org/bots/faq#my-bot-is-hitting-limits-how-do-i-avoid-this).
The limits are elastic, so ``retry_after`` is obeyed whatever was counted here.
"""

from __future__ import annotations

import asyncio
import itertools
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.message import Weight
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock

SECOND_NS = 1_000_000_000
CHATS_REMEMBERED = 4_096
WAITING_AT_MOST = 1_000
WAITING_IN_A_CHAT = 100
"""Not counting what is urgent. So a chat that is spoken to too much keeps nobody else out."""


class Rate(NamedTuple):
    """One every ``interval_s`` in the long run, so many at once after a rest, by weight.

    An urgent one may run up a debt that the others then pay off.
    """

    interval_s: float
    at_once: tuple[int, int, int, int, int, int]


CHAT = Rate(1.0, (5, 5, 3, 3, 2, 1))
"""Where people are answered all the time there is still room for a stop's two calls at once."""
GROUP = Rate(5.0, (12, 12, 8, 8, 6, 2))
"""8 at once and then one every 5 s: never more than 20 in any minute, except for what is urgent."""
OVERALL = Rate(1 / 29, (30, 30, 24, 24, 16, 8))


class Rates(NamedTuple):
    """The three limits under which one bot speaks."""

    chat: Rate = CHAT
    group: Rate = GROUP
    overall: Rate = OVERALL

    def times(self, factor: float) -> Rates:
        """Return limits under which everything goes so many times as fast."""
        return Rates(*(Rate(rate.interval_s / factor, rate.at_once) for rate in self))


PUBLISHED = Rates()


class Pace:
    """One limit's memory: the time at which everything said so far is paid for."""

    __slots__ = ("_interval_ns", "_paid_ns", "_rate")

    def __init__(self, rate: Rate) -> None:
        self._rate = rate
        self._interval_ns = int(rate.interval_s * SECOND_NS)
        self._paid_ns = 0

    def ready_ns(self, weight: Weight) -> int:
        """Return when one more of this weight may be said; in the past when it may now."""
        return self._paid_ns - (self._rate.at_once[weight] - 1) * self._interval_ns

    @property
    def paid_ns(self) -> int:
        """When everything said so far is paid for."""
        return self._paid_ns

    def spend(self, now_ns: int) -> None:
        """Count one."""
        self._paid_ns = max(self._paid_ns, now_ns) + self._interval_ns

    def rested(self, now_ns: int) -> bool:
        """Nothing is owed: forgetting it changes nothing."""
        return self._paid_ns <= now_ns


class _Waiting(NamedTuple):
    """Somebody who wants to say something."""

    weight: Weight
    number: int
    chat: str
    group: bool
    give_up_ns: int
    turn: asyncio.Future[None]


class Limiter:
    """Gives turns. Nothing runs while nobody waits."""

    def __init__(self, clock: Clock, rates: Rates = PUBLISHED) -> None:
        self._clock = clock
        self._rates = rates
        self._overall = Pace(rates.overall)
        self._paces: dict[str, tuple[Pace, ...]] = {}
        self._held_ns: dict[str, int] = {}
        self._all_held_ns = 0
        self._waiting: list[_Waiting] = []
        self._in_chat: Counter[str] = Counter()
        self._numbers = itertools.count()
        self._alarm: asyncio.Task[None] | None = None
        self._alarm_ns = 0

    async def turn(self, chat: str, weight: Weight, *, within_s: float) -> None:
        """Wait for a turn in this chat.

        Raises:
            MessengerFault: There was none in time, or too much waits already. Nothing was sent.
        """
        if self._is_full(chat, weight):
            raise MessengerFault("Too much is waiting to be said. This was not sent.")
        give_up_ns = self._clock.monotonic_ns() + int(within_s * SECOND_NS)
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        mine = _Waiting(weight, next(self._numbers), chat, chat.startswith("-"), give_up_ns, turn)
        self._waiting.append(mine)
        self._in_chat[chat] += 1
        self._arrive(mine)
        try:
            await turn
        finally:
            if mine in self._waiting:
                self._leave(mine)
            if not self._waiting:
                self._rest()

    def _is_full(self, chat: str, weight: Weight) -> bool:
        if len(self._waiting) >= WAITING_AT_MOST * max(1, Weight.IDLE - weight):
            return True
        return weight > Weight.ALARM and self._in_chat[chat] >= WAITING_IN_A_CHAT

    def _leave(self, one: _Waiting) -> None:
        self._waiting.remove(one)
        self._in_chat[one.chat] -= 1
        if not self._in_chat[one.chat]:
            del self._in_chat[one.chat]

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

    def _arrive(self, mine: _Waiting) -> None:
        """Serve whoever has come, or let them wait: a thousand that wait are not looked at."""
        now_ns, due_ns = self._clock.monotonic_ns(), self._due_ns(mine)
        if due_ns <= now_ns or self._alarm is None:
            self._serve()
            return
        wake_ns = min(due_ns, mine.give_up_ns)
        if wake_ns < self._alarm_ns:
            self._rest()
            self._wake_at(wake_ns, now_ns)

    def _wake_at(self, wake_ns: int, now_ns: int) -> None:
        self._alarm_ns = wake_ns
        self._alarm = asyncio.create_task(self._ring((wake_ns - now_ns) / SECOND_NS))

    def _serve(self) -> None:
        """Give every turn that is due, then set the alarm for the next."""
        now_ns = self._clock.monotonic_ns()
        self._rest()
        wakes: list[int] = []
        for one in sorted(self._waiting, key=self._place):
            due_ns = self._due_ns(one)
            if due_ns <= now_ns:
                self._spend(one, now_ns)
                self._settle(one, None)
            elif one.give_up_ns <= now_ns:
                self._settle(one, MessengerFault("Telegram's limits left no room. Not sent."))
            else:
                wakes.append(min(due_ns, one.give_up_ns))
        if wakes:
            self._wake_at(min(wakes), now_ns)

    def _place(self, one: _Waiting) -> tuple[int, int, int]:
        """Return what orders those who wait: of the same weight, the chat that had least is first.

        So whoever has much to say in one chat keeps nobody waiting in another.
        """
        return one.weight, self._of(one)[0].paid_ns, one.number

    def _settle(self, one: _Waiting, fault: MessengerFault | None) -> None:
        self._leave(one)
        if one.turn.done():
            return
        if fault is None:
            one.turn.set_result(None)
        else:
            one.turn.set_exception(fault)

    def _due_ns(self, one: _Waiting) -> int:
        limits = [pace.ready_ns(one.weight) for pace in (self._overall, *self._of(one))]
        return max(*limits, self._all_held_ns, self._held_ns.get(one.chat, 0))

    def _spend(self, one: _Waiting, now_ns: int) -> None:
        for pace in (self._overall, *self._of(one)):
            pace.spend(now_ns)

    def _of(self, one: _Waiting) -> tuple[Pace, ...]:
        paces = self._paces.get(one.chat)
        if paces is None:
            if len(self._paces) >= CHATS_REMEMBERED:
                self._forget()
            rates = self._rates
            own = (rates.chat, rates.group) if one.group else (rates.chat,)
            paces = tuple(map(Pace, own))
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
