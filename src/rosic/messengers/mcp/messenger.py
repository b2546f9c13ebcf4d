"""The messenger by which programs speak over MCP.

A tool call becomes one line of the grammar, and goes the way of every line: the same rights, rates,
lifetimes, claims and stops. What is said because of it comes back as progress, and as its result.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.language import is_urgent
from rosic.core.message import AnswerState
from rosic.errors import ConfigurationError, TooManyRequests
from rosic.messengers.mcp.http import HttpEndpoint
from rosic.messengers.mcp.server import ProgramCaller, serve_lines, server_of
from rosic.messengers.program.calls import Answer
from rosic.messengers.program.messenger import ProgramMessenger

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.programs import ServeConnection
    from rosic.core.identity import Address
    from rosic.core.secret import Secret
    from rosic.messengers.program.calls import ToolCall

    Told: TypeAlias = Callable[[str], Awaitable[None]]

CALLS_AT_MOST: Final = 32
"""Of one program at a time. A stop is not counted."""
WAIT_S: Final = 300.0
WAIT_MAX_S: Final = 3_600.0
STOP_WAIT_S: Final = 15.0
STOPPING: Final = (
    "The stop was given. Whether everything is at rest is not known here; please look."
)

log = logging.getLogger("rosic.mcp")


class McpSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What its table in the configuration may say.

    Attributes:
        port: Of this machine alone, for streamable HTTP; 0: standard input and output alone.
        wait_s: How long a call waits for its order to end, or for a person to agree.
    """

    port: int = 0
    wait_s: float = WAIT_S

    def __post_init__(self) -> None:
        if not 0 <= self.port <= 65_535:  # noqa: PLR2004 - what a port is
            raise ValueError("port must be from 1 to 65535, or left out")
        if not 1 <= self.wait_s <= WAIT_MAX_S:
            raise ValueError(f"wait_s must be from 1 to {WAIT_MAX_S:.0f}")


class McpMessenger(ProgramMessenger):
    """What programs say over MCP, and how it is answered there."""

    def __init__(self, name: str, settings: McpSettings, clock: Clock) -> None:
        super().__init__(name, clock)
        self._settings = settings

    def attach(self, secret: Secret) -> ServeConnection:
        """Return what serves the program that shows a secret; see the contract."""
        caller = ProgramCaller(self.programs.identify(secret), secret)
        return partial(serve_lines, server_of(self, lambda _: caller))

    async def say(self, address: Address, text: str, told: Told, *, robot: str = "") -> Answer:
        """Say a line for a program; return how it was answered, or how far it is by then.

        Args:
            address: Of the program.
            text: A line of the grammar.
            told: Is told how it goes.
            robot: Whose order it is. If whoever waits gives up, it is cancelled.

        Raises:
            TooManyRequests: It has said too much that is not answered yet. Nothing was said.
            MessengerFault: Nobody listens. Nothing was said.
        """
        if self.calls.count(address) >= CALLS_AT_MOST:
            sentence = said("Too many calls at once. Wait for an answer first. Nothing was done.")
            raise TooManyRequests(sentence, retry_after_s=1.0)
        return await self._say(address, text, told, robot, self._settings.wait_s)

    async def stop(self, address: Address, robots: tuple[str, ...], told: Told) -> Answer:
        """Stop robots, or all that a program may see; whatever else it has said.

        Raises:
            MessengerFault: Nobody listens.
        """
        return await self._say(address, " ".join(("stop", *robots)), told, "", STOP_WAIT_S)

    async def _say(
        self, address: Address, text: str, told: Told, robot: str, within_s: float
    ) -> Answer:
        call = self.begin(self.inbound(address, text), robot)
        try:
            async with asyncio.timeout(within_s):
                answer = await self._answered(call, told)
            return answer._replace(besides=self.unsolicited.take(address.account))
        except TimeoutError:
            return self._unanswered(call, within_s, stops=is_urgent(text))
        except asyncio.CancelledError:
            self._cancel(call)
            raise
        finally:
            self.calls.close(call)

    async def _answered(self, call: ToolCall, told: Told) -> Answer:
        while True:
            message, outbound = await call.news()
            state = outbound.state
            if state is AnswerState.AGREED:
                self.begin_agreed(call, message, outbound)
            elif state not in (AnswerState.GOES_ON, AnswerState.ASKED):
                return Answer(outbound.text, good=state is not AnswerState.NOT_DONE)
            await told(outbound.text)

    def _unanswered(self, call: ToolCall, within_s: float, *, stops: bool) -> Answer:
        """Return how far a call has come in its time."""
        if stops:
            return Answer(STOPPING, good=False)
        if call.asked or not call.last:
            self._cancel(call)
            return Answer(
                f"{call.last} Nobody has answered within {within_s:.0f} s. Nothing was done, and "
                "nobody is asked any more.".strip(),
                good=False,
            )
        return Answer(
            f"{call.last}\nIt goes on, and I wait no longer ({within_s:.0f} s). Ask for its "
            "status, or cancel it."
        )

    def _cancel(self, call: ToolCall) -> None:
        """End what a call has ordered, as its program would by saying so."""
        if call.robot and self.listens:
            self.hand_over(self.inbound(call.address, f"cancel {call.robot}"))

    async def _listen(self) -> None:
        """Serve HTTP, where a port was named; a program that is attached needs nothing."""
        if self._settings.port:
            await HttpEndpoint(self, self._settings.port).serve()
        await super()._listen()


def mcp_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> McpMessenger:
    """Make it from its table in the configuration.

    Raises:
        ConfigurationError: A setting is unknown or wrong; the sentence names it.
    """
    own = {key: value for key, value in settings.items() if key not in {"kind", "name"}}
    try:
        read = msgspec.convert(own, McpSettings)
    except msgspec.ValidationError as wrong:
        raise ConfigurationError(
            f"The messenger {name}: {wrong}.", hint="It knows: port, wait_s."
        ) from None
    return McpMessenger(name, read, clock)
