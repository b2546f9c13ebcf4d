"""How fast we may speak, and who speaks first.

Telegram allows about one message a second in a chat, 20 a minute in a group and 30 a second in
all; edits count (https://core.telegram.org/bots/faq#my-bot-is-hitting-limits-how-do-i-avoid-this).
The limits are elastic, so ``retry_after`` is obeyed whatever was counted here.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
from collections import Counter, deque
from contextlib import contextmanager
from hashlib import blake2b
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.core.identity import DIGEST_BYTES
from rosic.core.message import SendPriority
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Keep


# ---- lately ----

# What was said in groups in the last minute, over a restart: Telegram counts on meanwhile.
#
# Kept in the record, by a digest of the group, at most as many times as its limit has messages.

_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(tuple[int, ...]).decode

log = logging.getLogger("rosic.messengers.telegram")


class RecentGroupMessages:
    """When something was said in each group, as far as it still counts.

    Args:
        clock: The monotonic one measures; the wall clock runs on over a restart.
        span_s: So long it counts.
    """

    def __init__(self, clock: Clock, span_s: float) -> None:
        self._clock = clock
        self._span_ns = int(span_s * SECOND_NS)
        self._before: dict[str, tuple[int, ...]] = {}
        self._keep: Keep | None = None

    def restore(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Take over what an earlier run kept, and have kept what is said from now on."""
        self._keep = keep
        now_ns = self._clock.wall_ns()
        for digest, body in kept.items():
            try:
                said_ns = _decode(body)
            except msgspec.MsgspecError:
                log.warning("what was said in a group lately cannot be read, and counts as nothing")
                said_ns = ()
            # By a clock that was set back, what was said is still to come: it counts from now.
            counts = tuple(min(at, now_ns) for at in said_ns if at + self._span_ns > now_ns)
            if counts:
                self._before[digest] = counts
            else:
                keep(digest, b"")

    def take(self, group: str) -> Iterable[int]:
        """Return when an earlier run said something in a group, on the monotonic clock; once."""
        apart_ns = self._clock.wall_ns() - self._clock.monotonic_ns()
        return [at - apart_ns for at in self._before.pop(_digest(group), ())]

    def note(self, group: str, said_ns: Iterable[int]) -> None:
        """Keep when something was said in a group, on the monotonic clock."""
        if self._keep is not None:
            apart_ns = self._clock.wall_ns() - self._clock.monotonic_ns()
            self._keep(_digest(group), _encode([at + apart_ns for at in said_ns]))


def _digest(group: str) -> str:
    return blake2b(group.encode(), digest_size=DIGEST_BYTES).hexdigest()


# ---- rate limiter ----

NOT_YET_NS = 2**62
"""Nobody knows when: it depends on others' answers."""
CHATS_REMEMBERED = 4_096
FIRST_OWED = 2
HOLD_MORE_S = 0.1
"""So much longer than Telegram asks we wait: it counts from when it answered, in whole seconds."""
ALL_HOLD_AT_FIRST_S = 30.0
"""So long all chats wait at most when two were told to; twice as long for each further one."""
DOUBLED_AT_MOST = 20
WAITING_AT_MOST = 1_000
WAITING_IN_A_CHAT = 100
"""Not counting what is urgent. So a chat that is spoken to too much keeps nobody else out."""


class Rate(NamedTuple):
    """One every ``interval_s`` in the long run, so many at once after a rest, by weight.

    An urgent one may run up a debt that the others then pay off.

    Attributes:
        span_s: In no time as long as this there are more than ``within``, by weight: as Telegram
            counts. It does so when a call arrives, some time between our sending it and its answer;
            so what is under way counts, and what was answered so lately. 0: it counts nothing.
    """

    interval_s: float
    at_once: tuple[int, int, int, int, int, int]
    span_s: float = 0.0
    within: tuple[int, int, int, int, int, int] = (0, 0, 0, 0, 0, 0)


CHAT = Rate(1.0, (5, 5, 3, 3, 2, 1))
"""Where people are answered all the time there is still room for a stop's two calls at once."""
GROUP = Rate(4.0, (12, 12, 8, 8, 6, 2), 60.5, (20, 20, 16, 16, 16, 16))
"""Of the 20 in any minute the last four are for what is urgent."""
OVERALL = Rate(1 / 27, (28, 28, 22, 22, 16, 8), 1.05, (28, 28, 24, 24, 24, 24))
"""Of the 30 in any second two are left to clocks and networks, four more to what is urgent."""


class BotRates(NamedTuple):
    """The three limits under which one bot speaks."""

    chat: Rate = CHAT
    group: Rate = GROUP
    overall: Rate = OVERALL

    def times(self, factor: float) -> BotRates:
        """Return limits under which everything goes so many times as fast."""
        return BotRates(
            *(
                rate._replace(interval_s=rate.interval_s / factor, span_s=rate.span_s / factor)
                for rate in self
            )
        )


PUBLISHED = BotRates()


class LimitMemory:
    """One limit's memory: the time at which everything said so far is paid for."""

    __slots__ = ("_interval_ns", "_paid_ns", "_rate", "_said_ns", "_span_ns", "_under_way")

    def __init__(self, rate: Rate) -> None:
        self._rate = rate
        self._interval_ns = int(rate.interval_s * SECOND_NS)
        self._span_ns = int(rate.span_s * SECOND_NS)
        self._paid_ns = 0
        self._under_way = 0
        self._said_ns: deque[int] = deque(maxlen=max(rate.within) if rate.span_s else 0)

    def ready_ns(self, weight: SendPriority) -> int:
        """Return when one more of this weight may be said; in the past when it may now."""
        paced_ns = self._paid_ns - (self._rate.at_once[weight] - 1) * self._interval_ns
        if not self._span_ns:
            return paced_ns
        most = self._rate.within[weight] - self._under_way
        if most <= 0:
            return NOT_YET_NS
        if len(self._said_ns) < most:
            return paced_ns
        return max(paced_ns, self._said_ns[-most] + self._span_ns)

    def begin(self) -> None:
        """What a turn was given for is sent now: it counts until it is answered."""
        self._under_way += 1
        if self._said_ns:
            self._said_ns.pop()

    def end(self, now_ns: int) -> None:
        """It was answered, or is not waited for any more: it counts from now."""
        self._under_way -= 1
        self._said_ns.append(now_ns)

    def used_up(self, now_ns: int) -> None:
        """Count as if everything had just been said: what an earlier run said, nobody knows."""
        self._said_ns.extend([now_ns] * (self._said_ns.maxlen or 0))

    def said_ns(self, now_ns: int) -> tuple[int, ...]:
        """Return when what counts in a span was said; what is under way, now."""
        return (*self._said_ns, *[now_ns] * self._under_way)

    def go_on(self, said_ns: Iterable[int]) -> None:
        """Count what an earlier run has said, the oldest first."""
        for at_ns in said_ns:
            self.spend(at_ns)

    def used(self, count: int, now_ns: int) -> None:
        """Count so many as said just now, for the pace alone."""
        self._paid_ns = max(self._paid_ns, now_ns + count * self._interval_ns)

    @property
    def paid_ns(self) -> int:
        """When everything said so far is paid for."""
        return self._paid_ns

    def spend(self, now_ns: int) -> None:
        """Count one."""
        self._paid_ns = max(self._paid_ns, now_ns) + self._interval_ns
        if self._span_ns:
            self._said_ns.append(now_ns)

    def rested(self, now_ns: int) -> bool:
        """Nothing is owed: forgetting it changes nothing."""
        recent = bool(self._said_ns) and self._said_ns[-1] + self._span_ns > now_ns
        return self._paid_ns <= now_ns and not recent and not self._under_way


class _Waiting(NamedTuple):
    """Somebody who wants to say something."""

    weight: SendPriority
    number: int
    chat: str
    give_up_ns: int
    turn: asyncio.Future[None]


class RateLimiter:
    """Gives turns. Nothing runs while nobody waits.

    Args:
        clock: Measures.
        rates: The limits.
        spoke_before: An earlier run may have said something until just now, nobody knows how much:
            for a second nothing is said, and in the first seconds a chat has room for one at once.
    """

    def __init__(
        self, clock: Clock, rates: BotRates = PUBLISHED, *, spoke_before: bool = False
    ) -> None:
        self._clock = clock
        self._rates = rates
        self._overall = LimitMemory(rates.overall)
        self._begun_ns, self._spoke_before = clock.monotonic_ns(), spoke_before
        if spoke_before:
            self._overall.used_up(self._begun_ns)
        self._paces: dict[str, tuple[LimitMemory, ...]] = {}
        self._lately = RecentGroupMessages(clock, rates.group.span_s)
        self._held_ns: dict[str, int] = {}
        self._all_held_ns = 0
        self._waiting: list[_Waiting] = []
        self._in_chat: Counter[str] = Counter()
        self._numbers = itertools.count()
        self._alarm: asyncio.Task[None] | None = None
        self._alarm_ns = 0

    def keep_pace(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Go on with what an earlier run said in groups; see ``contracts.messenger``."""
        self._lately.restore(kept, keep)

    async def turn(self, chat: str, weight: SendPriority, *, within_s: float) -> None:
        """Wait for a turn in this chat.

        Raises:
            MessengerFault: There was none in time, or too much waits already. Nothing was sent.
        """
        if self._is_full(chat, weight):
            raise MessengerFault("Too much is waiting to be said. This was not sent.")
        give_up_ns = self._clock.monotonic_ns() + int(within_s * SECOND_NS)
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        mine = _Waiting(weight, next(self._numbers), chat, give_up_ns, turn)
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

    def _is_full(self, chat: str, weight: SendPriority) -> bool:
        if len(self._waiting) >= WAITING_AT_MOST * max(1, SendPriority.IDLE - weight):
            return True
        return weight > SendPriority.ALARM and self._in_chat[chat] >= WAITING_IN_A_CHAT

    def _leave(self, one: _Waiting) -> None:
        self._waiting.remove(one)
        self._in_chat[one.chat] -= 1
        if not self._in_chat[one.chat]:
            del self._in_chat[one.chat]

    def hold(self, chat: str, seconds: float) -> None:
        """Obey ``retry_after``, which does not say what it is for.

        It is taken to be for the chat, until a second chat is told to wait as well. Then every chat
        waits while at least two must, but not long before others are tried: two chats in which
        somebody has us say too much mute no other for hours.
        """
        now_ns = self._clock.monotonic_ns()
        until_ns = now_ns + int((seconds + HOLD_MORE_S) * SECOND_NS)
        self._held_ns = {one: held for one, held in self._held_ns.items() if held > now_ns}
        self._held_ns[chat] = max(until_ns, self._held_ns.get(chat, 0))
        others = len(self._held_ns) - 1
        if others:
            *_, second_ns, _ = sorted(self._held_ns.values())
            tried_s = ALL_HOLD_AT_FIRST_S * 2 ** min(others - 1, DOUBLED_AT_MOST)
            most_ns = now_ns + int((tried_s + HOLD_MORE_S) * SECOND_NS)
            self._all_held_ns = max(self._all_held_ns, min(second_ns, most_ns))

    @contextmanager
    def under_way(self, chat: str) -> Iterator[None]:
        """Make a call inside for which a turn in a chat was given."""
        paces = (self._overall, *self._paces_of(chat))
        for pace in paces:
            pace.begin()
        self._note(chat, *paces[2:])
        try:
            yield
        finally:
            now_ns = self._clock.monotonic_ns()
            for pace in paces:
                pace.end(now_ns)
            self._note(chat, *paces[2:])
            if self._waiting:
                self._serve()

    def _note(self, chat: str, *group: LimitMemory) -> None:
        """Have it kept what was said in a group lately; a chat of two has no such limit."""
        now_ns = self._clock.monotonic_ns()
        for pace in group:
            self._lately.note(chat, pace.said_ns(now_ns))

    async def obey(self, chat: str) -> None:
        """Wait until a chat is not held any more, for what takes no turn. Never raises."""
        while (left_ns := self._held_until_ns(chat) - self._clock.monotonic_ns()) > 0:
            await self._clock.sleep(left_ns / SECOND_NS)

    def _held_until_ns(self, chat: str) -> int:
        return max(self._all_held_ns, self._held_ns.get(chat, 0))

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
        return max(*limits, self._held_until_ns(one.chat))

    def _spend(self, one: _Waiting, now_ns: int) -> None:
        for pace in (self._overall, *self._of(one)):
            pace.spend(now_ns)

    def _of(self, one: _Waiting) -> tuple[LimitMemory, ...]:
        return self._paces_of(one.chat)

    def _paces_of(self, chat: str) -> tuple[LimitMemory, ...]:
        paces = self._paces.get(chat)
        if paces is None:
            if len(self._paces) >= CHATS_REMEMBERED:
                self._forget()
            rates = self._rates
            own = (rates.chat, rates.group) if chat.startswith("-") else (rates.chat,)
            paces = tuple(map(LimitMemory, own))
            if self._spoke_before:
                paces[0].used(FIRST_OWED, self._begun_ns)
            for pace in paces[1:]:
                pace.go_on(self._lately.take(chat))
            self._paces[chat] = paces
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
