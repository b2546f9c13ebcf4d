"""The terminal under the rules: a real pipe for what is typed, a list for what is shown."""

from __future__ import annotations

import os
import re
from contextlib import asynccontextmanager
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Chat, MessageValidity, Outbound
from rosic.errors import MessengerFault
from rosic.messengers.terminal import TerminalMessenger
from rosic.messengers.terminal.screen import GONE, PlainScreen
from rosic.system import SystemClock
from rosic.testing.messenger_files import FILE
from rosic.testing.messengers import MessengerConformance, SeenMessage

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator


class Paper(PlainScreen):
    """Shows on paper, which may run out."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor, echo=False, colour=False)
        self.lines: list[str] = []
        self.out_of_paper = False

    def show(self, text: str) -> None:
        if self.out_of_paper:
            raise MessengerFault(GONE)
        self.lines.append(text)


class Noted(TerminalMessenger):
    """Notes which text was shown under which id."""

    def __init__(self, paper: Paper) -> None:
        super().__init__(clock=SystemClock(), screen=paper, account="1000")
        self.seen: list[SeenMessage] = []
        self._paper = paper

    async def send(self, outbound: Outbound) -> str:
        before = len(self._paper.lines)
        message = await super().send(outbound)
        self.seen.append(SeenMessage(message, "\n".join(self._paper.lines[before:])))
        return message


class TerminalStage:
    people: tuple[str, ...] = ("me",)
    patience_s = 30.0
    keeps = False  # a terminal does not say a line twice
    taps = True
    unusual: tuple[MessageValidity, ...] = ()  # what was typed stays as it was

    def __init__(self, reading: int, writing: int) -> None:
        self.paper = Paper(reading)
        self.messenger: Noted = Noted(self.paper)
        self._writing = writing

    def chat(self, _person: str) -> Chat:
        return Chat("terminal", "1000")

    async def write(self, _person: str, text: str) -> None:
        os.write(self._writing, f"{text}\n".encode())

    async def tap(self, person: str, message: str, label: str) -> None:
        shown = next(seen.text for seen in self.messenger.seen if seen.message == message)
        number = re.search(rf"\[(\d+)\] {label}", shown)
        assert number is not None, f"no button {label} is shown"
        await self.write(person, number[1])

    async def screen(self, _person: str) -> list[SeenMessage]:
        return [
            SeenMessage(seen.message, re.sub(r"\nIt lies in .*", "", seen.text))
            for seen in self.messenger.seen
        ]

    async def files(self, _person: str) -> list[tuple[str, bytes]]:
        lies = (re.search(r"It lies in (.*): only", seen.text) for seen in self.messenger.seen)
        paths = [Path(found[1]) for found in lies if found is not None]
        assert all(path.stat().st_mode & 0o777 == 0o600 for path in paths)
        assert len(set(paths)) == len(paths), "a file was written over another"
        return [(FILE.name, path.read_bytes()) for path in paths]

    async def pinned(self, _person: str) -> list[str]:
        return []

    async def unconfirmed(self) -> int:
        return 0

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        self.paper.out_of_paper = True
        yield
        self.paper.out_of_paper = False


class TestTerminal(MessengerConformance):
    @pytest.fixture
    def stage(self) -> Iterator[TerminalStage]:
        reading, writing = os.pipe()
        stage = TerminalStage(reading, writing)
        yield stage
        if stage.messenger.downloads.folder is not None:
            rmtree(stage.messenger.downloads.folder)
        os.close(reading)
        os.close(writing)
