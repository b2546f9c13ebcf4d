"""Commands: what is asked of ROSIC itself (`/me`, `/invite`, `/book`). A handler for each."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.contracts.messenger import Messenger
from rosic.core.i18n import said
from rosic.core.identity import Caller, CommandId
from rosic.core.message import AnswerState, Attachment, Button, Chat, ChatKind, Inbound
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from rosic.core.language import CommandLine
    from rosic.core.language.command import CommandTable

ONLY_IN_PRIVATE = said("Ask me that in a private chat with me, please.")


class Reply(msgspec.Struct, frozen=True):
    """A text and its buttons, not bound to anybody yet.

    Attributes:
        attachment: A file that goes with it, for a messenger that sends files of its size.
        about: The robot that it speaks of, for whoever replies to it; empty for none.
        anew: It is said in a message of its own: what was tapped is about to go.
        landed: Hears through which messenger, in which chat, which message says it.
        state: What it comes to, for a program.
    """

    text: str
    buttons: tuple[tuple[Button, ...], ...] = ()
    attachment: Attachment | None = None
    about: str = ""
    landed: Callable[[Messenger, Chat, str], None] | None = None
    anew: bool = False
    state: AnswerState = AnswerState.FINAL


def asks_first(text: str, buttons: tuple[tuple[Button, ...], ...]) -> Reply:
    """Return a question to whoever said something: nothing is done before they tap a button."""
    return Reply(text, buttons, state=AnswerState.ASKED)


def is_question(reply: Reply) -> bool:
    """Whether a reply asks whoever reads it, and not somebody else on their behalf."""
    return reply.state is AnswerState.ASKED and bool(reply.buttons)


class CommandContext(msgspec.Struct, frozen=True):
    """One command, and who asked for it, where.

    Attributes:
        rest: The line after the verb, as typed.
        cid: Identity of the line, for what must not happen twice.
        act: Digest of what the tap that said it agrees to. Whatever was typed agrees to nothing.
    """

    messenger: Messenger
    inbound: Inbound
    caller: Caller
    rest: str
    cid: CommandId
    act: bytes = b""

    @property
    def private(self) -> bool:
        """Whether nobody else can read along."""
        return self.inbound.chat.kind is ChatKind.PRIVATE


CommandHandler: TypeAlias = Callable[[CommandContext], Awaitable[Reply]]


class CommandRegistry:
    """Brings a command to whoever does it.

    Args:
        declared: What can be asked of ROSIC.
    """

    def __init__(self, declared: CommandTable) -> None:
        self._declared = declared
        self._handlers: dict[str, CommandHandler] = {}
        self._offered: dict[str, Callable[[], bool]] = {}

    def register(
        self, name: str, handler: CommandHandler, *, offered: Callable[[], bool] | None = None
    ) -> None:
        """Say who does a command.

        Args:
            name: Of a command that is declared.
            handler: Does it, and returns what to say.
            offered: Whether ``help`` names it now; left out: always.

        Raises:
            ValueError: It is not declared.
        """
        if self._declared.find(name) is None:
            raise ValueError(f"the command {name} is not declared")
        self._handlers[name] = handler
        if offered is not None:
            self._offered[name] = offered

    def is_offered(self, name: str) -> bool:
        """Whether ``help`` names a command now, to whoever can use it."""
        return name not in self._offered or self._offered[name]()

    @property
    def undone(self) -> frozenset[str]:
        """Commands that are declared, and that nobody does here."""
        return self._declared.words - self._handlers.keys()

    async def do(self, command: CommandLine, asked: CommandContext) -> Reply:
        """Do a command, and return what to say.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        handler = self._handlers.get(command.verb)
        if handler is None:
            raise NotUnderstood(
                said("I cannot do {verb} here.", verb=command.verb), offers=("help",)
            )
        return await handler(asked)


def check_length(line: str, most: int) -> None:
    """See that a line is read to its end: what would be cut off may be what makes it safe.

    Raises:
        OutOfBounds: It is longer than that many characters.
    """
    if len(line) > most:
        raise OutOfBounds(
            said(
                "That line has {length} characters; I read at most {most}. Nothing was done.",
                length=len(line),
                most=most,
            )
        )


def check_private(asked: CommandContext) -> None:
    """See that nobody else reads along.

    Raises:
        NotPermitted: Others do.
    """
    if not asked.private:
        raise NotPermitted(ONLY_IN_PRIVATE)
