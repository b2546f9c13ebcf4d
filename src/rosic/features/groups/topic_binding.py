"""What a topic of a group is about: there, a command that names no robot means that one."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from rosic.container.container import chat_digest
from rosic.core.i18n import said
from rosic.core.language.sanitise import echo
from rosic.core.policy.scope import FLEET
from rosic.core.records import Decided, Fact
from rosic.errors import NotPermitted, NotUnderstood, TooManyRequests
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.organiser import Organiser

KIND: Final = "topic"
AT_MOST: Final = 1_000
NOTHING: Final = frozenset({"nothing", "none", "nobody"})

log = logging.getLogger("rosic.pipeline")


class TopicBindings:
    """Every topic that is about a robot or a group. It gives nobody a right to that robot."""

    def __init__(
        self,
        organiser: Organiser,
        changes: Transactions,
        members: Callable[[str], tuple[RobotId, ...]],
    ) -> None:
        self._organiser = organiser
        self._changes = changes
        self._members = members
        self._about: dict[str, str] = {}
        changes.keep(KIND, self.apply)

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what was said before the start."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """It was written down what a topic is about; an empty body: nothing any more."""
        try:
            name = bytes(fact.body).decode()
        except UnicodeDecodeError:
            log.warning("what a topic is about cannot be read")
            return
        if name:
            self._about[fact.key] = name
        else:
            self._about.pop(fact.key, None)

    def of(self, chat: Chat) -> str:
        """Return the robot or group that a topic is about; empty for none that there still is."""
        name = self._about.get(chat_digest(chat).hex(), "")
        return name if name and self._members(name) else ""

    async def topic(self, asked: CommandContext) -> Reply:
        """Do ``/topic omni``: say what this topic is about; ``/topic nothing`` undoes it.

        Raises:
            NotUnderstood: Not in a topic, or no such robot.
            NotPermitted: They look after no robots here.
            TooManyRequests: There are very many already.
            RecordUnavailable: Not written; nothing was changed.
        """
        chat, name = asked.inbound.chat, asked.rest.strip().casefold()
        if not chat.topic:
            raise NotUnderstood(said("Say that in a topic of a group that has topics."))
        about = self.of(chat)
        if not name:
            return Reply(_about(about))
        organiser, who = self._organiser, asked.caller.principal
        if not organiser.rights.holds(who, FLEET, "assign", organiser.wall_ns()):
            raise NotPermitted(said("Only an admin of the robots says what a topic is about."))
        if name in NOTHING:
            name = ""
        elif not organiser.visible(who).intersection(self._members(name)):
            raise NotUnderstood(
                said("I know no robot {name}.", name=echo(name)), offers=("robots",)
            )
        elif len(self._about) >= AT_MOST and not about:
            raise TooManyRequests(
                said("Too many topics are about a robot already."), retry_after_s=0.0
            )
        key = chat_digest(chat).hex()
        async with self._changes.turn() as turn:
            await turn.write(
                (
                    Decided(
                        act=KIND,
                        by=who,
                        about=key,
                        at_ns=organiser.wall_ns(),
                        digest=name.encode(),
                    ),
                    Fact(kind=KIND, key=key, body=name.encode()),
                )
            )
        return Reply(_about(name))


def _about(name: str) -> str:
    if not name:
        return said("This topic is about no robot. An admin may say: /topic omni")
    return said("This topic is about {name}: here its name may be left out.", name=name)
