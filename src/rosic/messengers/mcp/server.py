"""An MCP server, as the official SDK makes one: what a client may list and call, and over lines."""

from __future__ import annotations

import logging
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import anyio
from mcp.server.lowlevel import Server
from mcp.shared.exceptions import MCPError
from mcp.shared.message import SessionMessage
from mcp_types import (
    INVALID_REQUEST,
    CallToolRequestParams,
    CallToolResult,
    ListToolsResult,
    PaginatedRequestParams,
    TextContent,
    jsonrpc_message_adapter,
)

from rosic import __version__
from rosic.core.language.stop_detection import LONGEST_SHOUT
from rosic.errors import NotUnderstood, RosicError
from rosic.messengers.mcp.tools import (
    CANCEL,
    LIST_ROBOTS,
    STATUS,
    STOP,
    robot_and_skill,
    tools_of,
)
from rosic.messengers.program.calls import Answer

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Awaitable, Callable, Mapping
    from typing import TypeAlias

    from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream
    from mcp.server.context import ServerRequestContext

    from rosic.contracts.programs import Programs
    from rosic.core.identity import Address
    from rosic.core.secret import Secret

    Context: TypeAlias = ServerRequestContext[Any, Any]
    Told: TypeAlias = Callable[[str], Awaitable[None]]

INSTRUCTIONS = (
    "Robots, moved by ROSIC. Each order is checked, recorded and bounded like a person's; what has "
    "to be confirmed is asked of a person, and a call waits for that. Progress tells how an order "
    "goes; cancelling a call cancels its order. stop is always there."
)
FAULT = "Something went wrong here. It is not known what was done; please look."

log = logging.getLogger("rosic.mcp")


class ProgramCaller(NamedTuple):
    """A program that has shown a good secret: where it speaks from, and what it showed."""

    address: Address
    secret: Secret


class LineSpeaker(Protocol):
    """Says lines for programs; see `rosic.messengers.mcp.messenger.McpMessenger`."""

    @property
    def programs(self) -> Programs:
        """Who knows programs."""

    async def say(self, address: Address, text: str, told: Told, *, robot: str = "") -> Answer:
        """Say a line; return how it was answered."""

    async def stop(self, address: Address, robots: tuple[str, ...], told: Told) -> Answer:
        """Stop robots, or all."""


def server_of(speaker: LineSpeaker, caller_of: Callable[[Context], ProgramCaller]) -> Server[Any]:
    """Return a server for whoever a request comes from.

    Args:
        speaker: Says what they call.
        caller_of: Returns who asks.
    """

    async def list_tools(ctx: Context, _: PaginatedRequestParams | None) -> ListToolsResult:
        try:
            address = speaker.programs.identify(caller_of(ctx).secret)
            tools = tools_of(speaker.programs.robots(address), speaker.programs.skills(address))
        except RosicError as why:
            raise MCPError(INVALID_REQUEST, str(why)) from None
        return ListToolsResult(tools=tools, cache_scope="private")

    async def call_tool(ctx: Context, params: CallToolRequestParams) -> CallToolResult:
        steps = count(1)

        async def told(text: str) -> None:
            await ctx.session.report_progress(float(next(steps)), None, text)

        try:
            called = ToolDispatch(speaker, caller_of(ctx), told)
            answer = await called.call(params.name, params.arguments or {})
        except RosicError as why:
            answer = Answer(str(why), good=False)
        except Exception:
            log.exception("a call could not be followed")
            answer = Answer(FAULT, good=False)
        texts = (answer.text, *answer.besides)
        content = [TextContent(type="text", text=text) for text in texts]
        return CallToolResult(content=list(content), is_error=not answer.good)

    return Server(
        "rosic",
        version=__version__,
        title="ROSIC",
        instructions=INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


class ToolDispatch:
    """One call of a program: from a tool and its arguments to a line."""

    def __init__(self, speaker: LineSpeaker, caller: ProgramCaller, told: Told) -> None:
        self._speaker, self._caller, self._told = speaker, caller, told

    async def call(self, tool: str, values: Mapping[str, object]) -> Answer:
        """Follow it, and return how it was answered.

        Raises:
            RosicError: Why not; nothing was done.
        """
        if tool == STOP:
            return await self._stop(values)
        address = self._speaker.programs.identify(self._caller.secret)  # it may have ended
        order = robot_and_skill(tool)
        if order is not None:
            line = self._speaker.programs.line(address, *order, values)
            return await self._speaker.say(address, line, self._told, robot=order[0])
        if tool not in {CANCEL, STATUS, LIST_ROBOTS}:
            raise NotUnderstood(f"There is no tool {tool[:64]!r} here. Nothing was done.")
        robots = self._robots(address, {} if tool == LIST_ROBOTS else values)
        line = " ".join(("robots",) if tool == LIST_ROBOTS else (tool, *robots))
        return await self._speaker.say(address, line, self._told)

    def _robots(self, address: Address, values: Mapping[str, object]) -> tuple[str, ...]:
        robot = values.get("robot")
        if robot is None:
            return ()
        known = self._speaker.programs.robots(address)
        if not isinstance(robot, str) or robot not in known:
            names = ", ".join(known) or "none"
            raise NotUnderstood(f"There is no robot {str(robot)[:64]!r} here. There are: {names}.")
        return (robot,)

    async def _stop(self, values: Mapping[str, object]) -> Answer:
        """Stop what is named, and everything if anything of that is not known: as in a chat.

        So it does if more are named than a line that stops is read for.
        """
        address = self._caller.address
        named = values.get("robots")
        names = [named] if isinstance(named, str) else named if isinstance(named, list) else []
        try:
            known = self._speaker.programs.robots(address)
        except RosicError:
            known = {}
        robots = tuple(dict.fromkeys(name for name in names if isinstance(name, str)))
        read = len(" ".join((STOP, *robots))) <= LONGEST_SHOUT
        all_known = all(isinstance(name, str) and name in known for name in names)
        return await self._speaker.stop(address, robots if read and all_known else (), self._told)


# ---- one connection, a message a line ----


async def serve_lines(
    server: Server[Any], reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Serve one client over a connection until it leaves, or says what is no line of JSON-RPC."""
    incoming, read = anyio.create_memory_object_stream[SessionMessage | Exception](0)
    write, outgoing = anyio.create_memory_object_stream[SessionMessage](0)
    async with anyio.create_task_group() as group:
        group.start_soon(_read, reader, incoming)
        group.start_soon(_write, writer, outgoing)
        async with read, write:
            await server.run(read, write, server.create_initialization_options())
        group.cancel_scope.cancel()


async def _read(
    reader: asyncio.StreamReader, incoming: MemoryObjectSendStream[SessionMessage | Exception]
) -> None:
    async with incoming:
        while line := await _line(reader):
            message: SessionMessage | Exception
            try:
                message = SessionMessage(jsonrpc_message_adapter.validate_json(line, by_name=False))
            except ValueError as wrong:
                message = wrong
            await incoming.send(message)


async def _line(reader: asyncio.StreamReader) -> bytes:
    try:
        return await reader.readline()
    except (OSError, ValueError):
        return b""  # gone, or a line without end


async def _write(
    writer: asyncio.StreamWriter, outgoing: MemoryObjectReceiveStream[SessionMessage]
) -> None:
    async with outgoing:
        async for one in outgoing:
            line = one.message.model_dump_json(by_alias=True, exclude_unset=True)
            writer.write(f"{line}\n".encode())
            await writer.drain()
