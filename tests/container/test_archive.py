from __future__ import annotations

import random

import msgspec
import pytest

from rosic.container import archive_records
from rosic.container.archive import LONGEST_TEXT, Archive, ArchiveQuota, MessageAuthor
from rosic.container.export import archive_as_text, rows
from rosic.core.i18n import titled
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Inbound, MessageValidity, Outbound
from rosic.core.records import Fact
from rosic.errors import Refusal
from rosic.testing.clock import ManualClock

ADA, BO = MessageAuthor("p-ada", "Ada"), MessageAuthor("p-bo", "Bo")
GROUP = Chat("memory", "g", ChatKind.GROUP)
DAY_S = 86_400
HOUR_NS = 3_600 * 10**9


class Chronicle:
    """An archive of one chat and the facts it has on disk."""

    def __init__(self, quota: ArchiveQuota | None = None, *, days: int = 90) -> None:
        self.clock = ManualClock()
        self.quota = quota
        self.disk: dict[tuple[str, str], Fact] = {}
        self.archive = Archive(self.clock, quota)
        self.since_ns = self.clock.wall_ns()
        self.so(self.archive.begin("memory", GROUP, "p-ada", days=days))

    def so(self, records: object) -> None:
        """Write down and apply."""
        for record in records:  # type: ignore[attr-defined]
            if isinstance(record, Fact):
                self.keep((record,))
                self.archive.apply(record)

    def keep(self, facts: tuple[Fact, ...]) -> tuple[Fact, ...]:
        """Write down what is in the index already."""
        for fact in facts:
            self.disk[fact.kind, fact.key] = fact
            if not fact.body:
                del self.disk[fact.kind, fact.key]
        return facts

    async def hear(self, text: str, message: str, author: MessageAuthor = BO, **how: object) -> int:
        await self.clock.advance(1)
        inbound = Inbound(
            sender=Address("memory", author.name or "99"),
            chat=GROUP,
            message=message,
            text=text,
            sent_ns=self.clock.wall_ns(),
            received_ns=self.clock.wall_ns(),
            listening_since_ns=self.since_ns,
        )
        inbound = msgspec.structs.replace(inbound, **how)
        return len(self.keep(self.archive.hear(inbound, author)))

    def restart(self) -> None:
        self.archive = Archive(self.clock, self.quota)
        facts = list(self.disk.values())
        random.Random(1).shuffle(facts)  # noqa: S311 - a repeatable order, not a secret
        entries = [f for f in facts if f.kind == archive_records.ENTRY]
        self.archive.restore([f for f in facts if f.kind == archive_records.SWITCH], entries)

    def lines(self) -> list[str]:
        return archive_as_text(rows(self.disk.values())).splitlines()


def said(name: str, text: str) -> str:
    return f"Sender ID: {name}, Sender Username: {name}, Message: {text}"


async def test_a_name_that_reads_differently_by_language_is_kept_as_it_stands() -> None:
    chronicle = Chronicle()
    you = MessageAuthor("p-you", titled("you", {"de": "Gast"}))
    await chronicle.hear("hello", "1", you, sender=Address("memory", "0"))

    [letter] = [
        fact.letter for fact in chronicle.disk.values() if fact.kind == archive_records.ENTRY
    ]
    assert letter is not None
    assert msgspec.msgpack.decode(letter.content)[1] == "you"


async def test_messages_are_kept_in_order_as_the_paper_writes_them() -> None:
    book = Chronicle()
    await book.hear("hello", "1", ADA)
    await book.hear("omni wave", "2")
    book.keep(
        book.archive.say(
            "3", Outbound(chat=GROUP, text="omni: done", reply_to="2"), MessageAuthor()
        )
    )
    await book.hear("who am I", "4", MessageAuthor())
    assert book.lines() == [
        said("Ada", "hello"),
        said("Bo", "omni wave"),
        "Sender ID: rosic, Sender Username: ROSIC, Message: omni: done",
        "Sender ID: 99, Sender Username: None, Message: who am I",
    ]


async def test_the_words_are_sealed_with_the_key_of_whoever_wrote_or_was_answered() -> None:
    book = Chronicle()
    await book.hear("omni wave", "2")
    book.keep(
        book.archive.say("3", Outbound(chat=GROUP, text="done", reply_to="2"), MessageAuthor())
    )
    book.keep(book.archive.say("4", Outbound(chat=GROUP, text="good morning"), MessageAuthor()))
    await book.hear("hello", "5", MessageAuthor())
    own = archive_records.container_of(archive_records.chat_key(GROUP))
    letters = [f.letter for f in book.disk.values() if f.kind == archive_records.ENTRY]
    assert [letter and letter.container for letter in letters] == ["p-bo", "p-bo", own, own]
    for fact in book.disk.values():
        assert b"Bo" not in fact.body
        assert b"wave" not in fact.body


async def test_a_message_received_again_is_kept_once_also_after_a_restart() -> None:
    book = Chronicle()
    for message in "1234":
        await book.hear("hello", message)
    assert await book.hear("hello", "2") == 0
    book.restart()
    for message in "1234":
        assert await book.hear("hello", message) == 0
    assert await book.hear("hello", "5") == 1
    assert len(book.lines()) == 5


async def test_an_edit_is_an_entry_and_a_button_is_one_but_a_redelivered_one_is_not() -> None:
    book = Chronicle()
    await book.hear("left", "1")
    assert await book.hear("right", "1", standing=MessageValidity.EDITED) == 1
    assert await book.hear("right", "1", standing=MessageValidity.EDITED) == 0
    assert await book.hear("", "x", nonce="n1", tap="t1") == 1
    assert await book.hear("", "x", nonce="n1", tap="t1") == 0
    assert await book.hear("", "x", nonce="n1", tap="t2") == 1
    assert [row.note for row in rows(book.disk.values())] == ["", "edited", "button", "button"]


async def test_what_was_sent_and_changed_is_kept_as_it_looks_now() -> None:
    book = Chronicle()
    book.keep(book.archive.say("3", Outbound(chat=GROUP, text="moving 10 %"), BO))
    await book.hear("wait", "4")
    book.keep(book.archive.say("3", Outbound(chat=GROUP, text="done"), BO))
    assert [row.text for row in rows(book.disk.values())] == ["done", "wait"]


async def test_what_two_bots_said_under_one_number_are_two_entries() -> None:
    book = Chronicle()
    book.keep(book.archive.say("3", Outbound(chat=GROUP, text="first"), BO, "4242"))
    book.keep(book.archive.say("3", Outbound(chat=GROUP, text="second"), BO, "2323"))
    book.keep(book.archive.say("3", Outbound(chat=GROUP, text="second, done"), BO, "2323"))
    assert [row.text for row in rows(book.disk.values())] == ["first", "second, done"]


async def test_an_interruption_is_a_gap_before_the_message_that_shows_it() -> None:
    book = Chronicle()
    await book.hear("before", "1")
    await book.clock.advance(30 * DAY_S)
    book.since_ns = book.clock.wall_ns()
    assert await book.hear("after", "2") == 2
    assert await book.hear("and on", "3") == 1
    assert [row.way for row in rows(book.disk.values())] == ["in", "gap", "in", "in"]
    line = book.lines()[1]
    assert line == (
        "(not listening from 2023-11-14T22:13:21.000Z to 2023-12-14T22:13:21.000Z: "
        "messages may be missing here)"
    )


async def test_a_backlog_marks_its_gap_once_however_many_messages_it_has() -> None:
    book = Chronicle()
    await book.hear("before", "1")
    await book.clock.advance(100)
    for message in "234":
        late = book.clock.wall_ns() + 10**9 + 1  # one above the time of receiving
        await book.hear("late", message, listening_since_ns=late)
    book.since_ns = book.clock.wall_ns()
    await book.hear("fresh", "5")
    ways = [row.way for row in rows(book.disk.values())]
    assert ways == ["in", "gap", "in", "in", "in", "in"]
    await book.clock.advance(100)
    book.since_ns = book.clock.wall_ns()
    await book.hear("later", "6")
    assert [row.way for row in rows(book.disk.values())] == [*ways, "gap", "in"]


async def test_a_second_interruption_right_after_a_backlog_is_marked_too() -> None:
    book = Chronicle()
    await book.hear("before", "1")
    await book.clock.advance(100)
    await book.hear("late", "2", listening_since_ns=book.clock.wall_ns() + 10**9 + 1)
    await book.clock.advance(DAY_S)
    book.since_ns = book.clock.wall_ns()
    await book.hear("fresh", "3")
    assert [row.way for row in rows(book.disk.values())] == ["in", "gap", "in", "gap", "in"]


async def test_a_restart_is_a_gap_and_a_time_switched_off_is_none() -> None:
    book = Chronicle()
    await book.hear("before", "1")
    book.restart()
    book.since_ns = book.clock.wall_ns()
    await book.hear("after", "2")
    book.so(book.archive.end(GROUP, "p-ada"))
    assert await book.hear("unkept", "3") == 0
    assert not book.archive.keeps(GROUP)
    await book.clock.advance(10)
    book.so(book.archive.begin("memory", GROUP, "p-ada"))
    book.since_ns = book.clock.wall_ns()
    await book.hear("kept", "4")
    assert [row.text for row in rows(book.disk.values()) if row.way != "gap"] == [
        "before",
        "after",
        "kept",
    ]
    assert [row.way for row in rows(book.disk.values())] == ["in", "gap", "in", "in"]


async def test_what_could_not_be_written_is_said_to_be_missing() -> None:
    book = Chronicle()
    await book.hear("before", "1")
    await book.clock.advance(1)
    disk = dict(book.disk)
    await book.hear("unwritten", "2")
    failed = tuple(f for place, f in book.disk.items() if place not in disk)
    book.disk = disk
    book.archive.unwritten(failed)
    await book.hear("after", "3")
    assert [row.way for row in rows(book.disk.values())] == ["in", "lost", "in"]
    assert "messages are missing here" in book.lines()[1]
    assert await book.hear("unwritten", "2") == 1  # it comes again, and then it is kept


async def test_the_oldest_make_way_and_the_export_says_so() -> None:
    book = Chronicle(ArchiveQuota(entries=3))
    for n in range(5):
        await book.hear(f"message {n}", str(n))
    assert book.lines() == [
        "(2 older entries are no longer kept)",
        *(said("Bo", f"message {n}") for n in (2, 3, 4)),
    ]
    small = Chronicle(ArchiveQuota(most_bytes=400))
    for n in range(50):
        await small.hear("x" * 50, str(n))
    known = small.archive.state(GROUP)
    assert known is not None
    assert known.size <= 400
    small.restart()
    again = small.archive.state(GROUP)
    assert again is not None
    assert (again.size, len(again.entries)) == (known.size, len(known.entries))


async def test_retention() -> None:
    book = Chronicle(days=2)
    await book.hear("old", "1")
    await book.clock.advance(DAY_S)
    await book.hear("young", "2")
    await book.clock.advance(1.5 * DAY_S)
    book.so(book.archive.outdated())
    assert book.lines() == ["(1 older entry is no longer kept)", said("Bo", "young")]
    book.so(book.archive.end(GROUP, "p-ada"))
    await book.clock.advance(3 * DAY_S)
    while facts := book.archive.outdated():
        book.so(facts)
    assert book.disk == {}


async def test_an_archive_is_dropped_whole_even_what_came_meanwhile() -> None:
    book = Chronicle()
    await book.hear("one", "1")
    ends = book.archive.drop(archive_records.chat_key(GROUP))
    await book.hear("meanwhile", "2")
    book.so(ends)
    assert book.archive.state(GROUP) is None
    book.so(book.archive.outdated())
    assert book.disk == {}
    assert book.archive.outdated() == ()
    assert book.archive.drop(archive_records.chat_key(GROUP)) == ()


def refusal(call: object, *args: object, **how: object) -> str:
    with pytest.raises(Refusal) as refused:
        call(*args, **how)  # type: ignore[operator]
    return str(refused.value)


async def test_sentences_of_the_switch() -> None:
    book = Chronicle(ArchiveQuota(chats=1))
    begin, end = book.archive.begin, book.archive.end
    other = Chat("memory", "h", ChatKind.GROUP)
    assert refusal(begin, "memory", GROUP, "p-ada") == (
        "The messages of this chat are being kept already."
    )
    assert refusal(begin, "memory", GROUP, "p-ada", days=0) == (
        "Messages can be kept from 1 to 3650 days. Nothing has changed."
    )
    assert refusal(end, other, "p-ada") == "The messages of this chat are not being kept."
    assert refusal(begin, "memory", other, "p-ada").startswith("As many chats as possible")
    before = book.archive.state(GROUP)
    assert before is not None
    since_ns = before.switch.at_ns
    await book.clock.advance(5)
    book.so(begin("memory", GROUP, "p-bo", days=7))
    assert before.switch.days == 7
    assert before.switch.at_ns == since_ns  # it has been on without a break


async def test_private_chats_of_whoever_is_erased_end_and_groups_do_not() -> None:
    book = Chronicle()
    private = Chat("memory", "2")
    book.so(book.archive.begin("memory", private, "p-ada"))
    await book.hear("hello", "1")
    book.so(book.archive.end_private(lambda chat: chat.id in {"2", "g"}))
    assert not book.archive.keeps(private)
    assert book.archive.keeps(GROUP)


async def test_bad_text_and_endless_text_can_be_kept() -> None:
    book = Chronicle()
    await book.hear("lone \ud800 surrogate\x00", "1")
    await book.hear("y" * (LONGEST_TEXT + 5), "2")
    first, second = rows(book.disk.values())
    assert first.text == "lone ? surrogate\x00"
    assert second.text.endswith("y… (cut)")


def test_what_cannot_be_read_is_left_out(caplog: pytest.LogCaptureFixture) -> None:
    book = Chronicle()
    key = archive_records.chat_key(GROUP)
    book.archive.apply(Fact(kind=archive_records.ENTRY, key=f"{key}.1", body=b"\xc1"))
    book.archive.apply(Fact(kind=archive_records.ENTRY, key="nonsense", body=b"\xc1"))
    book.archive.apply(Fact(kind=archive_records.SWITCH, key=key, body=b"\xc1"))
    assert book.archive.keeps(GROUP)
    assert caplog.text.count("cannot be read") == 3
