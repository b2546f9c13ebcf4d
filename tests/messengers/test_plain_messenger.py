"""What messengers without buttons share: lanes, numbers, and what is said of ourselves."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec
import pytest
from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.message import Button, Chat, Inbound, MessageValidity, Outbound
from rosic.core.secret import Secret
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.errors import ConfigurationError, MessageGone, MessengerFault
from rosic.messengers.chat_lanes import ChatLanes
from rosic.messengers.numbered_buttons import NumberedButtons, tapped
from rosic.messengers.plain_messenger import PlainMessenger, read_settings
from rosic.testing.clock import ManualClock, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

CHAT = Chat("plain", "1")
GO, STOP = Button("Go", "omni move 1 m", "nonce-go"), Button("Stop", "stop", "nonce-stop")


def inbound(text: str, *, account: str = "ada", chat: Chat = CHAT, message: str = "m") -> Inbound:
    return Inbound(
        sender=Address("plain", account),
        chat=chat,
        message=message,
        text=text,
        sent_ns=10 * SECOND_NS,
        received_ns=10 * SECOND_NS,
    )


def nothing() -> None:
    pass


# ---- lanes ----


async def test_strangers_take_no_place_from_people_who_are_known() -> None:
    gate, heard = asyncio.Event(), []

    async def receive(one: Inbound) -> None:
        heard.append(one.text)
        await gate.wait()

    async with asyncio.TaskGroup() as tasks:
        lanes = ChatLanes(receive, tasks, at_most=8)
        for number in range(20):
            chat = Chat("plain", f"stranger {number}")
            taken = lanes.hand_over(inbound("hello", chat=chat), nothing, known=False, urgent=True)
            assert taken is (number < 4)
        assert [lanes.hand_over(inbound("a"), nothing, known=True) for _ in range(6)] == [
            *[True] * 4,
            False,
            False,
        ]
        assert lanes.hand_over(inbound("stop"), nothing, known=True, urgent=True)
        await settle()
        assert heard.count("stop") == 1
        gate.set()
    assert heard.count("a") == 4
    assert lanes.hand_over.__self__._waiting == {}  # type: ignore[attr-defined]


# ---- numbers ----


def offer(*buttons: Button) -> Outbound:
    return Outbound(chat=CHAT, text="omni?", buttons=(buttons,))


async def test_a_number_is_never_that_of_another_button_soon() -> None:
    """What is typed twice, or while a new question comes, chooses nothing in that."""
    clock = ManualClock()
    numbers = NumberedButtons(clock)
    assert numbers.label("a", offer(GO, STOP)) == "omni?\n\n1. Go   2. Stop"
    assert numbers.label("a", Outbound(chat=CHAT, text="omni: done")) == "omni: done"
    assert numbers.chosen("1", ["1"]) is None
    other = Button("Go on", "omni move 9 m", "nonce-other")
    assert numbers.label("b", offer(other)) == "omni?\n\n3. Go on"
    assert numbers.chosen("1", ["1"]) is None
    assert numbers.chosen("1", ["3"]) == ("b", "nonce-other", False)
    await clock.advance(6 * 60)
    assert numbers.label("c", offer(GO)) == "omni?\n\n1. Go"


def test_a_message_that_is_shown_again_keeps_its_numbers() -> None:
    numbers = NumberedButtons(ManualClock())
    numbers.label("a", offer(GO, STOP))
    assert numbers.label("a", offer(STOP, GO)) == "omni?\n\n2. Stop   1. Go"
    stop = numbers.chosen("1", ["2"])
    assert stop is not None
    assert stop.urgent


@pytest.mark.parametrize("sign", ["1", " 1 ", "1️⃣", "1⃣", "01"])
def test_signs_that_are_numbers(sign: str) -> None:
    numbers = NumberedButtons(ManualClock())
    numbers.label("a", offer(GO))
    assert numbers.chosen("1", [sign]) is not None
    assert numbers.chosen("1", [sign], "another message") is None
    assert numbers.chosen("another chat", [sign]) is None


@pytest.mark.parametrize("sign", ["", "0", "-1", "1.0", "\u0661", "1" * 5_000, "one", "🤖", "2"])
def test_signs_that_are_none(sign: str) -> None:
    numbers = NumberedButtons(ManualClock())
    numbers.label("a", offer(GO))
    assert numbers.chosen("1", [sign]) is None


def test_two_numbers_at_once_choose_nothing() -> None:
    numbers = NumberedButtons(ManualClock())
    numbers.label("a", offer(GO, STOP))
    assert numbers.chosen("1", ["1️⃣", "2️⃣"]) is None


def test_what_is_remembered_of_numbers_is_bounded() -> None:
    numbers = NumberedButtons(ManualClock())
    for number in range(10_000):
        numbers.label("a", replace(offer(GO), chat=Chat("plain", str(number))))
    assert len(numbers._chats) == 4_096
    many = [replace(GO, nonce=str(number)) for number in range(250)]
    text = numbers.label("b", offer(*many))
    assert text.count("Go") == 99


def test_a_number_that_was_late_is_backlog() -> None:
    late = replace(inbound("1"), sent_ns=0)
    numbers = NumberedButtons(ManualClock())
    numbers.label("a", offer(GO))
    chosen = numbers.chosen("1", ["1"])
    assert chosen is not None
    tap = tapped(late, chosen)
    assert tap.sent_ns == tap.received_ns < tap.listening_since_ns
    assert tapped(inbound("1"), chosen).listening_since_ns == 0


# ---- the messenger ----


class SayingMessenger(PlainMessenger):
    """Says everything to a list, and is ready at once."""

    platform = "plain"
    edits = True
    text_bytes = 20
    nick = "robots"

    def __init__(self) -> None:
        super().__init__("plain", ManualClock())
        self.said: list[tuple[str, str]] = []
        self.began()
        self.know_with(lambda _: True)

    async def deliver(self, outbound: Outbound, texts: Sequence[str], *, replaces: str = "") -> str:
        assert outbound.chat == CHAT
        self.said += [(replaces, text) for text in texts]
        return f"said-{len(self.said)}"


async def hear(messenger: PlainMessenger, *heard: Inbound) -> list[Inbound]:
    """Return what is handed over of what is heard."""
    done: list[Inbound] = []

    async def receive(one: Inbound) -> None:
        done.append(one)

    async with messenger.listening(receive):
        for one in heard:
            messenger.take(one, nothing)
        await settle()
    return done


async def test_our_name_is_taken_off_where_a_text_begins_with_it() -> None:
    messenger = SayingMessenger()
    texts = ("robots: stop", "Robots, status", "robots", "robotsare", "hello")
    done = await hear(messenger, *(inbound(text, message=text) for text in texts))
    read = sorted((one.text, one.addressed) for one in done)
    assert read == [
        ("hello", False),
        ("robots", False),
        ("robotsare", False),
        ("status", True),
        ("stop", True),
    ]


async def test_a_message_that_comes_again_was_sent_when_it_was_the_first_time() -> None:
    again = replace(inbound("status"), sent_ns=9 * SECOND_NS)
    later = replace(inbound("status"), sent_ns=11 * SECOND_NS, received_ns=MINUTE_NS)
    done = await hear(SayingMessenger(), inbound("status"), again, later)
    assert [one.sent_ns for one in done] == [10 * SECOND_NS, 9 * SECOND_NS, 9 * SECOND_NS]


async def test_an_edit_to_a_number_chooses_nothing() -> None:
    messenger = SayingMessenger()
    await messenger.send(offer(GO))
    edited = replace(inbound("1"), standing=MessageValidity.EDITED)
    [one] = await hear(messenger, edited)
    assert (one.nonce, one.text) == (None, "1")


async def test_a_stop_by_number_overtakes() -> None:
    messenger = SayingMessenger()
    message = await messenger.send(offer(STOP))
    gate, heard = asyncio.Event(), []

    async def receive(one: Inbound) -> None:
        heard.append((one.nonce, one.under))
        await gate.wait()

    async with messenger.listening(receive):
        messenger.take(inbound("status"), nothing)
        messenger.take(inbound("1", message="n"), nothing)
        await settle()
        assert (STOP.nonce, message) in heard
        gate.set()


async def test_what_is_too_long_for_one_message_is_said_in_several_and_not_changed() -> None:
    messenger = SayingMessenger()
    message = await messenger.send(Outbound(chat=CHAT, text="one two three four five six seven"))
    assert messenger.said == [("", "one two three four"), ("", "five six seven")]
    with pytest.raises(MessageGone):
        await messenger.edit(message, Outbound(chat=CHAT, text="x" * 21))
    await messenger.edit(message, Outbound(chat=CHAT, text="short"))
    assert messenger.said[-1] == (message, "short")
    with pytest.raises(MessageGone):
        await messenger.edit("another", Outbound(chat=CHAT, text="short"))


async def test_it_listens_once_at_a_time() -> None:
    messenger = SayingMessenger()

    async def receive(_: Inbound) -> None:
        raise AssertionError

    async with messenger.listening(receive):
        with pytest.raises(MessengerFault):
            async with messenger.listening(receive):
                raise AssertionError


# ---- its table ----


class SomeSettings(msgspec.Struct):
    port: int
    password: Secret


@pytest.mark.parametrize(
    ("table", "wrong"),
    [
        ({"password": "x"}, "port"),
        ({"port": "x", "password": "x"}, "port"),
        ({"port": 1, "password": "x", "colour": "red"}, "colour"),
        ({"port": 1, "password": 5}, "password"),
    ],
)
def test_a_wrong_table_is_refused_with_what_is_wrong(table: dict[str, object], wrong: str) -> None:
    with pytest.raises(ConfigurationError, match=wrong):
        read_settings("lab", table, SomeSettings)


def test_a_password_becomes_a_secret() -> None:
    table = {"kind": "plain", "name": "lab", "port": 1, "password": "x"}
    assert read_settings("lab", table, SomeSettings).password.reveal() == "x"
