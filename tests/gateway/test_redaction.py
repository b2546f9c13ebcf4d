"""What holds a secret goes: in time, tried again, and never for ever."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.message import Chat
from rosic.core.records import Fact
from rosic.errors import MessageGone, MessengerFault
from rosic.gateway.delivery.redaction import KEPT_AT_MOST, KIND, LONGEST_NS, SecretRedaction
from rosic.messengers.memory import MemoryMessenger
from rosic.testing.clock import ManualClock, SeededEntropy, settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

CHAT = Chat("memory", "1")
MINUTE_NS = 60_000_000_000


class Forgetful(MemoryMessenger):
    """A messenger out of whose chats messages are taken; the first tries may fail."""

    def prepare(self, *failures: Exception) -> None:
        self.tried: list[str] = []
        self._failures = list(failures)

    async def retract(self, chat: Chat, message: str) -> None:
        assert chat == CHAT
        self.tried.append(message)
        if self._failures:
            raise self._failures.pop(0)


class Place:
    def __init__(self, *failures: Exception, facts: Iterable[Fact] = ()) -> None:
        self.clock = ManualClock()
        self.messenger = Forgetful("memory", clock=self.clock)
        self.messenger.prepare(*failures)
        self.written: list[Fact] = []
        self.is_good: dict[str, Callable[[str], bool]] = {}
        self.retracting = SecretRedaction(
            self.clock, SeededEntropy(), self.written.append, self.is_good
        )
        self.retracting.begin((self.messenger,), {KIND: facts})

    def keep(self, message: str, *, whose: str = "ada", for_ns: int = 10 * MINUTE_NS) -> None:
        at_ns = self.clock.wall_ns() + for_ns
        self.retracting.keep("code x", whose, at_ns, self.messenger, CHAT, message)

    async def pass_s(self, seconds: int) -> None:
        for _ in range(seconds // 5):
            await self.clock.advance(5.0)
            await settle()


async def test_it_goes_when_its_time_is_over_and_not_before() -> None:
    place = Place()
    place.keep("7")
    await place.pass_s(590)
    assert place.messenger.tried == []
    await place.pass_s(20)
    assert place.messenger.tried == ["7"]
    assert [bool(fact.body) for fact in place.written] == [True, False]
    await place.pass_s(120)
    assert place.messenger.tried == ["7"]


async def test_what_fails_for_now_is_tried_again_and_what_can_never_be_is_not() -> None:
    place = Place(MessengerFault("no network"), MessageGone("too old"))
    place.keep("7", for_ns=0)
    await place.pass_s(10)
    assert place.messenger.tried == ["7"]
    await place.pass_s(300)
    assert place.messenger.tried == ["7", "7"]
    assert not place.written[-1].body


async def test_a_later_run_goes_on_with_it_and_reads_over_what_is_damaged() -> None:
    first = Place()
    first.keep("7")
    first.keep("8", whose="")
    [fact] = first.written
    damaged = Fact(kind=KIND, key="x", body=b"\xff", letter=fact.letter)
    second = Place(facts=(damaged, fact))
    await second.pass_s(610)
    assert second.messenger.tried == ["7"], "a stranger's is forgotten"


async def test_it_is_bounded_in_number_and_in_time_and_asks_for_what_there_is() -> None:
    place = Place()
    place.keep("7", for_ns=1_000 * LONGEST_NS)
    await place.clock.advance(LONGEST_NS / 1e9 + 10)
    await settle()
    assert place.messenger.tried == ["7"], "before the platform keeps it for ever"
    for number in range(KEPT_AT_MOST + 10):
        place.keep(str(number))
    assert len(place.written) == 2 + KEPT_AT_MOST
    plain = MemoryMessenger("plain", clock=place.clock)
    place.retracting.keep("code x", "ada", 0, plain, CHAT, "7")
    assert len(place.written) == 2 + KEPT_AT_MOST, "this one takes nothing away"


async def test_it_goes_at_once_when_it_is_worth_nothing() -> None:
    place, good = Place(), {"x"}
    place.is_good["code"] = good.__contains__
    place.keep("7")
    place.retracting.look()
    await settle()
    assert place.messenger.tried == []
    good.clear()
    place.retracting.look()
    await settle()
    assert place.messenger.tried == ["7"]
