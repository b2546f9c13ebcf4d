"""The official MCP client over `rosic mcp` in a process of its own, and what the gateway says."""

from __future__ import annotations

import json
import re
import sys
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import anyio
from mcp import ClientSession, StdioServerParameters, stdio_client

from tests.cli.running import environment, rosic
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from mcp_types import CallToolResult

    from tests.cli.running import Gateway


def key_of(name: str, config: Path, *more: str, role: str = "operator") -> str:
    """Make a program known, and return its secret."""
    made = rosic("key", "create", name, "--role", role, *more, "-c", config)
    assert (made.status, made.err) == (0, "")
    first, secret = made.out.splitlines()
    assert first.startswith(f"{name} is known now, a program: {role}")
    return secret


def served_by(key: str, config: Path) -> StdioServerParameters:
    """Return how a client starts `rosic mcp`."""
    return StdioServerParameters(
        command=sys.executable,
        args=["-m", "rosic", "mcp", "-c", str(config)],
        env=environment({"ROSIC_KEY": key}),
    )


@asynccontextmanager
async def client(key: str, config: Path) -> AsyncIterator[ClientSession]:
    """Run `rosic mcp` under the official client."""
    async with (
        stdio_client(served_by(key, config)) as (read, write),
        ClientSession(read, write) as session,
    ):
        await session.initialize()
        yield session


class Progress:
    """What a client is told while it waits."""

    def __init__(self) -> None:
        self.steps: list[float] = []
        self.texts: list[str] = []
        self._told = anyio.Event()

    async def __call__(
        self,
        progress: float,
        total: float | None,  # noqa: ARG002 - nobody knows how much there is
        message: str | None,
    ) -> None:
        self.steps.append(progress)
        self.texts.append(message or "")
        self._told.set()

    async def hears(self, text: str) -> None:
        with anyio.fail_after(60 * pace()):
            while not any(text in said for said in self.texts):
                self._told = anyio.Event()
                await self._told.wait()


def said(result: CallToolResult) -> str:
    return "\n".join(part.text for part in result.content if part.type == "text")


def state(robot: str, config: Path) -> dict[str, object]:
    [found] = json.loads(rosic("status", robot, "--json", "-c", config).out)
    assert isinstance(found, dict)
    return found


def at_rest(robot: str, config: Path) -> dict[str, object]:
    """Return how a robot is once it rests."""
    end_s = time.monotonic() + 60 * pace()
    while True:
        found = state(robot, config)
        if found["at_rest"] and not found["doing"]:
            return found
        assert time.monotonic() < end_s, found


def resumed(running: Gateway, robot: str, config: Path) -> None:
    """Have the person at the terminal resume a robot."""
    running.say(f"resume {robot}")
    end_s = time.monotonic() + 60 * pace()
    while state(robot, config)["stopped"]:
        assert time.monotonic() < end_s, running.out()


def free(robot: str, config: Path) -> None:
    """Wait until nobody has a robot."""
    end_s = time.monotonic() + 60 * pace()
    while state(robot, config)["holder"]:
        assert time.monotonic() < end_s


def number_of(button: str, shown: str) -> str:
    """Return what is typed at a terminal to tap a button."""
    return str(re.findall(rf"\[(\d+)\] {button}", shown)[-1])
