"""The terminal messenger: lines in, texts and numbered choices out."""

from __future__ import annotations

import asyncio
import io
import os
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Self

import pytest

from rosic.app.features import command_table
from rosic.core.identity import Address
from rosic.core.message import Button, Chat, Inbound, Outbound
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.terminal import TerminalMessenger, terminal_messenger
from rosic.messengers.terminal.completion import Completer
from rosic.messengers.terminal.messenger import (
    OVER,
    RESERVED_NS,
    TYPED_WITHIN_NS,
    WAITING_AT_MOST,
    Choices,
)
from rosic.messengers.terminal.prompt import wrapped
from rosic.messengers.terminal.screen import LONGEST_LINE_BYTES, PlainScreen, harmless, painted
from rosic.system import SystemClock
from rosic.testing.clock import ManualClock
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

CHAT = Chat("terminal", "1000")
YES, NO = Button("Do it", "omni move 1 m", "nonce-yes"), Button("Leave it", "leave it", "nonce-no")
QUESTION = Outbound(chat=CHAT, text="omni: move 1 m?", buttons=((YES, NO),))


class Script:
    """A screen that reads given lines and remembers what it showed."""

    def __init__(self, *lines: str) -> None:
        self.lines = list(lines)
        self.shown: list[str] = []

    async def read(self) -> str | None:
        return self.lines.pop(0) if self.lines else None

    def show(self, text: str) -> None:
        self.shown.append(text)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        pass


async def heard(messenger: TerminalMessenger) -> list[Inbound]:
    """Return what the messenger hands over until its input ends."""
    found: list[Inbound] = []

    async def receive(inbound: Inbound) -> None:
        found.append(inbound)

    running = asyncio.create_task(messenger.run(receive))
    await asyncio.wait_for(messenger.ended.wait(), 60 * pace())
    for _ in range(WAITING_AT_MOST):
        await asyncio.sleep(0)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    return found


def terminal(*lines: str) -> tuple[TerminalMessenger, Script]:
    script = Script(*lines)
    clock = ManualClock()
    return TerminalMessenger(clock=clock, screen=script, account="1000"), script


# ---- who, where, when ----


async def test_its_person_is_the_local_user_by_number() -> None:
    messenger = TerminalMessenger(clock=ManualClock(), screen=Script("status"))

    [inbound] = await heard(messenger)

    assert str(inbound.sender) == f"terminal:{os.getuid()}"
    assert inbound.sent_ns == inbound.received_ns >= inbound.listening_since_ns > 0


async def test_a_line_of_another_run_is_another_message() -> None:
    clock = ManualClock()
    first = TerminalMessenger(clock=clock, screen=Script("omni move 1 m"))
    await clock.advance(0.001)
    second = TerminalMessenger(clock=clock, screen=Script("omni move 1 m"))

    [one], [other] = await heard(first), await heard(second)

    assert one.message != other.message


async def test_when_input_ends_it_goes_on_being_there() -> None:
    messenger, script = terminal()
    running = asyncio.create_task(messenger.run(lambda _inbound: asyncio.sleep(0)))
    await asyncio.wait_for(messenger.ended.wait(), 60 * pace())

    await messenger.send(Outbound(chat=CHAT, text="omni: done"))

    assert not running.done()
    assert script.shown == ["omni: done"]
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


async def test_empty_lines_are_no_messages() -> None:
    messenger, _ = terminal("", "   ", "status")

    assert [inbound.text for inbound in await heard(messenger)] == ["status"]


# ---- order ----


async def test_more_lines_than_can_wait_are_refused_and_a_stop_is_not() -> None:
    messenger, script = terminal(*["omni move 1 m"] * (WAITING_AT_MOST + 3), "stop")
    received: list[str] = []
    blocked = asyncio.Event()

    async def receive(inbound: Inbound) -> None:
        received.append(inbound.text)
        if inbound.text != "stop":
            await blocked.wait()

    running = asyncio.create_task(messenger.run(receive))
    await asyncio.wait_for(messenger.ended.wait(), 60 * pace())
    await asyncio.sleep(0)

    assert "stop" in received
    assert "Too many lines at once. Wait a moment." in script.shown
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


async def ignore(_inbound: Inbound) -> None:
    pass


async def test_a_pipe_that_breaks_while_it_listens_stays_the_cause() -> None:
    class Broken(Script):
        async def read(self) -> str | None:
            raise MessengerFault("The terminal is gone.") from BrokenPipeError()

    messenger = TerminalMessenger(clock=ManualClock(), screen=Broken(), account="1000")

    with pytest.raises(MessengerFault) as gone:
        await asyncio.wait_for(messenger.run(ignore), 60 * pace())

    assert isinstance(gone.value.__cause__, BrokenPipeError)


async def test_a_script_is_read_at_the_pace_it_is_carried_out() -> None:
    messenger, script = terminal("omni move 1 m", "omni move 2 m")
    order: list[str] = []

    async def receive(inbound: Inbound) -> None:
        order.append(inbound.text)

    async def wait() -> None:
        order.append(f"waited, {len(script.lines)} to come")

    messenger.pace_by(wait)
    running = asyncio.create_task(messenger.run(receive))
    await asyncio.wait_for(messenger.ended.wait(), 60 * pace())

    assert order == ["omni move 1 m", "waited, 1 to come", "omni move 2 m", "waited, 0 to come"]
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


# ---- choices ----


async def test_a_number_taps_the_button_it_was_shown_with() -> None:
    messenger, script = terminal("2")
    message = await messenger.send(QUESTION)

    [tap] = await heard(messenger)

    assert script.shown == ["omni: move 1 m?\n  [1] Do it  [2] Leave it"]
    assert (tap.nonce, tap.text, tap.under) == ("nonce-no", "", message)


async def test_a_number_that_is_no_choice_is_a_text() -> None:
    messenger, _ = terminal("3", "1.0", "²")
    await messenger.send(QUESTION)

    assert [inbound.text for inbound in await heard(messenger)] == ["3", "1.0", "²"]


async def test_a_question_is_answered_once() -> None:
    messenger, _ = terminal("1", "1", "2")
    await messenger.send(QUESTION)

    # What is typed then is a tap too late, and no word that nobody knows.
    assert [inbound.nonce for inbound in await heard(messenger)] == ["nonce-yes", OVER, OVER]


def test_a_number_means_nothing_else_while_somebody_may_be_typing_it() -> None:
    choices = Choices()
    choices.show("a", QUESTION, 0)

    assert "[3]" in choices.show("b", QUESTION, RESERVED_NS)
    assert "[5]" in choices.show("c", QUESTION, RESERVED_NS + 1)

    taken = choices.take("3")
    assert taken is not None
    assert taken.message == "b"


def test_numbers_begin_again_when_nothing_is_open() -> None:
    choices = Choices()
    choices.show("a", QUESTION, 0)
    choices.take("1")

    assert "[1] Do it  [2] Leave it" in choices.show("b", QUESTION, 1)


def test_numbers_begin_again_with_what_is_said_next() -> None:
    choices = Choices()
    assert "[1]" in choices.show("a", QUESTION, 0)
    choices.retire(TYPED_WITHIN_NS)
    assert "[3]" in choices.show("b", QUESTION, 1), "it appeared while that was being typed"
    choices.retire(2 * TYPED_WITHIN_NS)
    assert choices.take("1") is None, "somebody said something else since"
    assert "[1]" in choices.show("b", QUESTION, 2 * TYPED_WITHIN_NS)
    taken = choices.take("1")
    assert taken is not None
    assert taken.message == "b"


def test_numbers_stay_bounded() -> None:
    choices = Choices()
    shown = [choices.show(str(count), QUESTION, 0) for count in range(200)]

    assert "[99]" in shown[49]
    assert shown[50].startswith("  [2]")


# ---- what is shown ----


def test_no_text_can_speak_to_the_terminal() -> None:
    spiteful = "omni: \x1b[2J\x1b]0;title\x07 done\r\x9b1A"

    assert harmless(spiteful).isprintable()
    assert harmless("two\nlines\tand a tab · °") == "two\nlines\tand a tab · °"


def test_colours_change_no_word() -> None:
    text = "STOP: omni at rest (0.08 s).\nomni: done 14:02:07: moved\nomni: failed\n  [1] Do it"
    coloured = painted(text)

    assert coloured != text
    bare = coloured
    for code in ("1;31", "1", "32", "33", "36", "0"):
        bare = bare.replace(f"\x1b[{code}m", "")
    assert bare == text


def test_long_lines_are_broken_between_words() -> None:
    lines = wrapped("STOP: " + "omni at rest (0.00 s). " * 8, 60).split("\n")

    assert all(len(line) < 60 for line in lines)
    assert all(line.startswith("  ") for line in lines[1:])
    assert wrapped("short", 60) == "short"
    assert wrapped("  " + "x" * 90, 60).strip() == "x" * 90


async def test_a_closed_output_is_a_fault_and_no_crash() -> None:
    messenger = TerminalMessenger(clock=ManualClock(), account="1000")
    closed = io.StringIO()
    closed.close()

    with redirect_stdout(closed), pytest.raises(MessengerFault):
        await messenger.send(QUESTION)
    with redirect_stdout(closed):
        await messenger.answer_tap(
            Inbound(
                sender=messenger_address(),
                chat=CHAT,
                message="1",
                text="",
                sent_ns=0,
                received_ns=0,
            ),
            "Too late.",
        )
    assert messenger.ended.is_set()


def messenger_address() -> Address:
    return Address("terminal", "1000")


# ---- where lines come from ----


async def lines_of(descriptor: int | None) -> list[str]:
    screen = PlainScreen(descriptor, echo=False, colour=False)
    found = []
    while (line := await asyncio.wait_for(screen.read(), 60 * pace())) is not None:
        found.append(line)
    return found


async def test_lines_come_from_a_pipe_a_file_and_from_nothing(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.write(writing, b"status\r\nomni mo")
    asyncio.get_running_loop().call_later(0.05, os.write, writing, "ve 1 m\nstopp\xe9".encode())
    asyncio.get_running_loop().call_later(0.1, os.close, writing)
    assert await lines_of(reading) == ["status", "omni move 1 m", "stoppé"]
    os.close(reading)

    path = tmp_path / "script"
    path.write_bytes(b"status\n\xff\xfe\nstop")
    with path.open("rb") as file:
        assert await lines_of(file.fileno()) == ["status", "\ufffd\ufffd", "stop"]
    nothing = os.open(os.devnull, os.O_RDONLY)
    assert await lines_of(nothing) == []
    os.close(nothing)
    assert await lines_of(None) == []


async def test_an_endless_line_is_cut_and_the_next_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "script"
    path.write_bytes(b"x" * (LONGEST_LINE_BYTES * 3) + b"\nstop\n")

    with path.open("rb") as file:
        first, *rest = await lines_of(file.fileno())

    assert len(first) == LONGEST_LINE_BYTES
    assert rest == ["stop"]


# ---- completion ----

MOVE = Skill(
    id="move",
    title="Move",
    parameters={
        "direction": Parameter(choices={"forward": (), "left": ()}, default="forward"),
        "distance": Parameter(unit="m", min=0.01, max=5),
    },
)
JOINT = Skill(id="move_joint", title="Move a joint")
FLEET = [
    Profile(id="omni", link=Link(kind="memory"), skills={"move": MOVE}),
    Profile(id="kuka1", link=Link(kind="memory"), skills={"move_joint": JOINT}),
    Profile(id="cf1", link=Link(kind="memory"), groups=("crazyflies",)),
]


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (
            "",
            {
                "omni",
                "kuka1",
                "cf1",
                "crazyflies",
                "status",
                "stop",
                "resume",
                "use",
                "help",
                "cancel",
                "robots",
            },
        ),
        ("cr", {"crazyflies"}),
        ("OM", {"omni"}),
        ("st", {"status", "stop"}),
        ("stop o", {"omni"}),
        ("/stop o", {"omni"}),
        ("omni ", {"move", "stop"}),
        ("kuka1 mo", {"move joint"}),
        ("omni move ", {"forward", "left", "distance="}),
        ("omni move l", {"left"}),
        ("omni move left ", {"distance="}),
        ("omni move left 50 ", {"m", "distance="}),
        ("omni move distance=2 ", {"m", "forward", "left"}),
        ("nobody ", set()),
        ("", None),
    ],
)
def test_what_could_come_next(typed: str, offered: set[str] | None) -> None:
    if offered is None:
        assert Completer().complete("omni ") == ()
        return
    assert {found.text for found in Completer(FLEET, command_table()).complete(typed)} == offered


def test_a_completion_replaces_what_was_begun() -> None:
    [found] = Completer(FLEET, command_table()).complete("kuka1 move j")

    assert (found.text, found.replaces) == ("move joint", len("move j"))


# ---- made from its table ----


def test_its_table_is_checked() -> None:
    clock = SystemClock()
    assert terminal_messenger("here", {"plain": True}, clock).name == "here"
    with pytest.raises(ConfigurationError, match="does not know the setting colour"):
        terminal_messenger("here", {"colour": True}, clock)
    with pytest.raises(ConfigurationError, match="must be true or false"):
        terminal_messenger("here", {"plain": "yes"}, clock)
