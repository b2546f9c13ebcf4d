"""Commands without a running gateway, in this process: they open the data themselves."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

from rosic.cli.main import main
from rosic.stores.database import DatabaseStore
from rosic.system import SystemClock
from tests.cli.running import CONFIG, write_config

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

MEMORY = CONFIG.replace('"simulated"', '"memory"')


class Said(NamedTuple):
    status: int
    out: str
    err: str


class Place:
    """A folder with a configuration, and what commands say there."""

    def __init__(
        self, folder: Path, capsys: pytest.CaptureFixture[str], text: str = MEMORY
    ) -> None:
        self.folder = folder
        self.config = write_config(folder, text)
        self._capsys = capsys

    def begun(self) -> Place:
        """Make the record that a first start makes; nobody of the file is on it yet."""

        async def begin() -> None:
            store = DatabaseStore(self.folder / "rosic-data", clock=SystemClock())
            await store.open()
            await store.close()

        asyncio.run(begin())
        return self

    def rosic(self, command: str, *arguments: str) -> Said:
        """Run a command to its end."""
        self._capsys.readouterr()
        status = main([*command.split(), *arguments, "-c", str(self.config)])
        return Said(status, *self._capsys.readouterr())

    def good(self, command: str, *arguments: str) -> str:
        """Return what a command prints that works."""
        said = self.rosic(command, *arguments)
        assert (said.status, said.err) == (0, "")
        return said.out

    def wrong(self, command: str, *arguments: str) -> str:
        """Return the one sentence of a command that does not."""
        said = self.rosic(command, *arguments)
        assert said.status in {1, 2}
        assert said.out == ""
        [line] = said.err.splitlines()
        assert line.startswith("rosic: ")
        assert line.endswith((".", "?"))
        return line.removeprefix("rosic: ")
