"""The messenger by which programs speak over MCP.

A tool call becomes one line of the grammar, and goes the way of every line: the same rights, rates,
lifetimes, claims and stops. What is said because of it comes back as progress, and as its result.
"""

from __future__ import annotations

import asyncio
import logging
import os
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import PROGRAM
from rosic.core.language import is_urgent
from rosic.core.message import AnswerState, Chat, Inbound, Outbound
from rosic.errors import ConfigurationError, MessengerFault, TooManyRequests
from rosic.messengers.mcp.calls import Answer, OpenCalls, ToolCall, UnsolicitedMessages
from rosic.messengers.mcp.http import HttpEndpoint
from rosic.messengers.mcp.server import ProgramCaller, serve_lines, server_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.contracts.programs import Programs, ServeConnection
    from rosic.core.identity import Address
    from rosic.core.message import IncomingFile
    from rosic.core.secret import Secret

    Told: TypeAlias = Callable[[str], Awaitable[None]]

CALLS_AT_MOST: Final = 32
"""Of one program at a time. A stop is not counted."""
WAIT_S: Final = 300.0
WAIT_MAX_S: Final = 3_600.0
STOP_WAIT_S: Final = 15.0
NOT_RUNNING: Final = "The gateway does not listen yet, or not any more. Nothing was done."
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


class McpMessenger:
    """Each program is one conversation.

    Nobody reads what is said here, so nobody confirms here: what has to be confirmed is asked of a
    person elsewhere, and begun once they have agreed.
    """

    platform = PROGRAM
    assurance = "local"
    edits = True
    pins = False
    file_bytes = fetch_bytes = 0

    def __init__(self, name: str, settings: McpSettings, clock: Clock) -> None:
        self.name = name
        self._settings = settings
        self._clock = clock
        self._calls = OpenCalls()
        self._unsolicited = UnsolicitedMessages()
        self._programs: Programs | None = None
        self._receive: Receive | None = None
        self._handing_over: asyncio.TaskGroup | None = None
        self._serial = count(1)
        # Ids must not come again in another run: the record remembers them (I1).
        self._run_id = f"{clock.wall_ns():x}-{os.getpid()}"
        self._since_ns = 0

    # ---- what programs say ----

    def serve_programs(self, programs: Programs) -> None:
        """Ask this who they are, and what they may say."""
        self._programs = programs

    @property
    def programs(self) -> Programs:
        """Who knows programs.

        Raises:
            MessengerFault: Nobody yet.
        """
        if self._programs is None:
            raise MessengerFault(NOT_RUNNING)
        return self._programs

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
        if self._calls.count(address) >= CALLS_AT_MOST:
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
        call = ToolCall(address, robot)
        inbound = self._inbound(address, text)
        self._calls.open(inbound.message, call)
        try:
            self._hand_over(inbound)
            async with asyncio.timeout(within_s):
                answer = await self._answered(call, told)
            return answer._replace(besides=self._unsolicited.take(address.account))
        except TimeoutError:
            return self._unanswered(call, within_s, stops=is_urgent(text))
        except asyncio.CancelledError:
            self._cancel(call)
            raise
        finally:
            self._calls.close(call)

    async def _answered(self, call: ToolCall, told: Told) -> Answer:
        while True:
            message, outbound = await call.news()
            state = outbound.state
            if state is AnswerState.AGREED:
                self._begin_agreed(call, message, outbound)
            elif state not in (AnswerState.GOES_ON, AnswerState.ASKED):
                return Answer(outbound.text, good=state is not AnswerState.NOT_DONE)
            await told(outbound.text)

    def _begin_agreed(self, call: ToolCall, message: str, outbound: Outbound) -> None:
        """Begin what a person has agreed to: that alone is ever tapped here."""
        button = outbound.buttons[0][0]
        inbound = self._inbound(call.address, "")
        tapped = msgspec.structs.replace(
            inbound, nonce=button.nonce, tap=inbound.message, under=message
        )
        self._calls.open(tapped.message, call)
        self._hand_over(tapped)

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
        if call.robot and self._handing_over is not None:
            self._hand_over(self._inbound(call.address, f"cancel {call.robot}"))

    def _inbound(self, address: Address, text: str) -> Inbound:
        now_ns = self._clock.wall_ns()
        return Inbound(
            sender=address,
            chat=Chat(self.platform, address.account),
            message=self._next_id(),
            text=text,
            sent_ns=now_ns,
            received_ns=now_ns,
            listening_since_ns=self._since_ns,
        )

    def _hand_over(self, inbound: Inbound) -> None:
        """Hand a message over; one after another of a conversation is the pipeline's business.

        Raises:
            MessengerFault: Nobody listens.
        """
        if self._handing_over is None or self._receive is None:
            raise MessengerFault(NOT_RUNNING)
        self._handing_over.create_task(_received(self._receive, inbound))

    def _next_id(self) -> str:
        return f"{self._run_id}-{next(self._serial)}"

    # ---- the gateway's side: contracts.messenger.Messenger ----

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled. See the contract."""
        self._since_ns = self._clock.wall_ns()
        try:
            async with asyncio.TaskGroup() as group:
                self._receive, self._handing_over = receive, group
                if self._settings.port:
                    await HttpEndpoint(self, self._settings.port).serve()
                await asyncio.Event().wait()
        except ExceptionGroup as several:
            raise several.exceptions[0] from None
        finally:
            self._receive = self._handing_over = None

    async def send(self, outbound: Outbound) -> str:
        """Tell the call because of which it is said; what no call waits for, the next one."""
        if outbound.attachment is not None:
            raise MessengerFault("A program is sent no files.")
        message = self._next_id()
        if not self._tell(message, outbound):
            self._unsolicited.put(outbound.chat.id, outbound.text)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Tell how it is now, likewise."""
        self._tell(message, outbound)

    def _tell(self, message: str, outbound: Outbound) -> bool:
        call = self._calls[outbound.cause] if outbound.cause else None
        if call is None or call.address.account != outbound.chat.id:
            return False
        call.told(message, outbound)
        return True

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:  # noqa: ARG002
        """Refuse: a program keeps nothing in sight.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault("A program keeps no message in sight.")

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Tell the call for which it was tapped why that is void; an empty text says nothing."""
        call = self._calls[inbound.message]
        if text and call is not None:
            void = Outbound(chat=inbound.chat, text=text, state=AnswerState.NOT_DONE)
            call.told(inbound.message, void)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:  # noqa: ARG002 - the contract
        """Refuse: a program sends no files.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault("A program sends no files.")


async def _received(receive: Receive, inbound: Inbound) -> None:
    await receive(inbound)


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
