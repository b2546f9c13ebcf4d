"""A person at a terminal types whenever they like, also while no prompt is there."""

from __future__ import annotations

import asyncio
import os
import pty
import select
import termios
from typing import TYPE_CHECKING

import pytest
from prompt_toolkit.application import create_app_session
from prompt_toolkit.input import create_input
from prompt_toolkit.output import DummyOutput

from rosic.messengers.terminal.completion import Completer
from rosic.messengers.terminal.prompt import PromptScreen
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

LOCAL_FLAGS = 3
CONTROL_CHARACTERS = 6


class TypedTerminal:
    """A terminal: what is typed goes in at one end and is read at the other."""

    def __init__(self) -> None:
        self._hand, self._slave = pty.openpty()
        self.file = os.fdopen(self._slave, closefd=False)

    def type(self, text: str) -> None:
        os.write(self._hand, text.encode())

    def see(self, text: bytes) -> None:
        """Read what was drawn until a text was there."""
        drawn = b""
        while text not in drawn:
            assert select.select([self._hand], [], [], 60 * pace())[0], drawn
            drawn += os.read(self._hand, 4096)

    @property
    def makes_signals(self) -> bool:
        """Whether a Ctrl-C would be a signal now."""
        return bool(termios.tcgetattr(self._slave)[LOCAL_FLAGS] & termios.ISIG)

    @property
    def ends_at_ctrl_d(self) -> bool:
        """Whether a Ctrl-D would be the end of the input now, were it in its usual mode."""
        return bool(termios.tcgetattr(self._slave)[CONTROL_CHARACTERS][termios.VEOF] == b"\x04")

    def close(self) -> None:
        self.file.close()
        os.close(self._hand)
        os.close(self._slave)


@pytest.fixture
def terminal() -> Iterator[TypedTerminal]:
    terminal = TypedTerminal()
    yield terminal
    terminal.close()


async def test_a_key_between_two_lines_is_not_lost(terminal: TypedTerminal) -> None:
    with (
        create_app_session(input=create_input(terminal.file), output=DummyOutput()),
        PromptScreen(Completer(), colour=False) as screen,
    ):
        terminal.type("status\r")
        assert await asyncio.wait_for(screen.read(), 60 * pace()) == "status"
        terminal.type("\x04")
        assert await asyncio.wait_for(screen.read(), 60 * pace()) is None
        assert terminal.makes_signals, "while it leaves, a Ctrl-C is a signal again"


async def test_a_terminal_is_left_as_it_was(terminal: TypedTerminal) -> None:
    with create_app_session(input=create_input(terminal.file), output=DummyOutput()):
        with PromptScreen(Completer(), colour=False) as screen:
            terminal.type("status\r")
            await asyncio.wait_for(screen.read(), 60 * pace())
            assert not terminal.makes_signals
        assert terminal.makes_signals


async def test_a_key_while_something_is_printed_is_not_lost(terminal: TypedTerminal) -> None:
    keyboard = create_input(terminal.file)
    with (
        create_app_session(input=keyboard, output=DummyOutput()),
        PromptScreen(Completer(), colour=False) as screen,
    ):
        terminal.type("status\r")
        assert await asyncio.wait_for(screen.read(), 60 * pace()) == "status"
        with keyboard.cooked_mode():  # as the toolkit does while it prints above the prompt
            terminal.type("\x04")
            await asyncio.to_thread(terminal.see, b"^D")  # taken by the terminal, and echoed
        assert await asyncio.wait_for(screen.read(), 60 * pace()) is None
        assert terminal.ends_at_ctrl_d, "while it leaves, a Ctrl-D is the end of the input again"
