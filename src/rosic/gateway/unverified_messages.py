"""What is done of a message whose sender nobody can be sure of: it may look, and no more (I17).

A messenger says of such a message that it is `MessageValidity.UNVERIFIED`: it names somebody who is
known, but whoever runs the platform could have written it. A stop in it was obeyed before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.language import Answered, CommandLine, Do, Halt, Misunderstood, Start
from rosic.core.language.ast import Help, Robots, Status
from rosic.core.message import ChatKind
from rosic.core.robot.skill import SkillClass
from rosic.errors import Refusal, Unverified
from rosic.gateway.replies import MARKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, CommandId
    from rosic.core.language import LanguageReader, Line
    from rosic.core.message import Inbound
    from rosic.gateway.chat_handler import ChatHandler
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext
    from rosic.gateway.replies import Replies

MAY_LOOK: Final = said(
    "Nothing was done: I cannot be sure that this is from you, so it may look and stop, "
    "and no more."
)
APART: Final = " unverified"
"""No id of anybody ends so: whoever writes in their name spends nothing of theirs."""
_SHOWN: Final = (Status, Help, Robots, Answered, Misunderstood, Halt)


class UnverifiedMessages:
    """Stands before a chat handler where a message may look and change nothing.

    What is not known to show only is refused. Nothing counts as misuse by whoever is named, as they
    may not have written it.

    Args:
        chat: Does what is left.
        rooms: Who counts requests, and what buttons say.
        reader: What a text says.
        replies: Says why not.
    """

    def __init__(
        self, chat: ChatHandler, rooms: Components, reader: LanguageReader, replies: Replies
    ) -> None:
        self._chat = chat
        self._rooms = rooms
        self._reader = reader
        self._replies = replies
        self.brought_a_code = chat.brought_a_code
        self.answer = chat.answer
        self.not_followed = chat.not_followed

    def met(
        self, messenger: Messenger, inbound: Inbound, caller: Caller, arrived_ns: int
    ) -> MessageContext:
        """Return a message of somebody known; see `ChatHandler.met`.

        Raises:
            Refusal: They are locked out, or something came with it; nothing of it is taken.
        """
        caller = replace(caller, counted_as=f"{caller.principal}{APART}")
        private = inbound.chat.kind is ChatKind.PRIVATE  # in a group nobody meant it for ROSIC
        if private and (inbound.enclosed is not None or inbound.place is not None):
            self._rooms.organiser.check_unlocked(caller)
            self._refuse(caller, inbound)
        return self._chat.met(messenger, inbound, caller, arrived_ns)

    async def lines(self, message: MessageContext) -> Sequence[Line]:
        """Return what a message says, if all of it only shows something.

        Raises:
            Refusal: It says more than that; nothing of it is followed, and a button that was tapped
                is as good as before.
        """
        caller, inbound = message.caller, message.inbound
        if inbound.nonce is not None:
            command = self._rooms.authoriser.buttons.says(inbound.nonce)
            if command is not None and not self._only_shows(caller, command):
                self._refuse(caller, inbound)
        lines = await self._chat.lines(message)
        if not all(map(self._looks, lines)):
            self._refuse(caller, inbound)
        return lines

    def _only_shows(self, caller: Caller, command: str) -> bool:
        if command.startswith(MARKS):
            return False
        visible = self._rooms.organiser.visible(caller.principal)
        return all(map(self._looks, self._reader.lines(command, "", visible)))

    def _looks(self, line: Line) -> bool:
        """Whether a line shows something and changes nothing, not even what is chosen."""
        if isinstance(line, Do):
            return all(skill.kind is SkillClass.OBSERVE for skill in line.skills)
        if isinstance(line, CommandLine):
            command = self._reader.vocabulary.commands.find(line.verb)
            return command is not None and command.observes
        return isinstance(line, _SHOWN) or (isinstance(line, Start) and not line.payload)

    def _refuse(self, caller: Caller, inbound: Inbound) -> None:
        """Count a message, and refuse it.

        Raises:
            Unverified: What it asks for is not done; says what its author can do.
            Refusal: There are too many of them.
        """
        self._rooms.organiser.charge(caller)
        raise Unverified(joined(" ", filter(None, (MAY_LOOK, inbound.remedy))))

    async def not_done(
        self, message: MessageContext, line: Line, cid: CommandId, why: BaseException
    ) -> None:
        """Say why a line is not done, and offer nothing; see `ChatHandler.not_done`.

        Raises:
            BaseException: What is no fault of the line, as it came.
        """
        if not isinstance(why, Refusal):
            await self._chat.not_done(message, line, cid, why)
        elif not why.silent:
            self._replies.reject(message.messenger, message.inbound, why)
