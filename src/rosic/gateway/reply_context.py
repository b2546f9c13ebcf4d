"""Of whom a message speaks: whom a reply means, whom somebody talks to, and who hears a robot."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.contracts.messenger import Messenger
from rosic.core.identity import PrincipalId
from rosic.core.message import Chat
from rosic.core.time_units import MINUTE_NS

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.container.container import Containers
    from rosic.contracts.clock import Clock
    from rosic.core.message import Inbound
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.message_context import MessageContext
    from rosic.organiser.organiser import Organiser


# ---- which robot a message speaks of ----

# Messages, at least; at most twice as many.
REMEMBERED = 4_096


class ReplyTargets:
    """Bounded, in memory: of what is forgotten, a robot has to be named again.

    So a reply to a message of ours never falls to the robot that was chosen last: whoever replies
    reads one robot's name there, and would move another.
    """

    def __init__(self) -> None:
        # Two generations: the older one is dropped whole, so that no message costs a search.
        self._about: dict[tuple[str, str, str], str] = {}
        self._older: dict[tuple[str, str, str], str] = {}

    def note(self, messenger: str, chat: Chat, message: str, about: str) -> None:
        """Remember of whom a message speaks; empty: of nobody."""
        if not about:
            return
        if len(self._about) >= REMEMBERED:
            self._older, self._about = self._about, {}
        self._about[messenger, chat.id, message] = about

    def of(self, message: MessageContext) -> str:
        """Return whom the message speaks of that somebody replies to; empty: nobody known."""
        return self.answered(message.messenger.name, message.inbound)

    def answered(self, messenger: str, inbound: Inbound) -> str:
        """Return the same of what is no command, such as a place that is sent in reply."""
        where = (messenger, inbound.chat.id, inbound.answers)
        return self._about.get(where) or self._older.get(where, "")


def meant(
    message: MessageContext,
    reply_targets: ReplyTargets,
    container: Containers,
    visible: frozenset[RobotId],
    members: Callable[[str], tuple[RobotId, ...]],
) -> str:
    """Return who is meant where a message names nobody: whom it replies to, else who was chosen.

    Empty where neither is known, and in reply to a message of ours of which nobody knows any more
    of whom it speaks: then it is asked. Nobody learns by it of a robot that they may not see.
    """
    about = reply_targets.of(message) if message.inbound.answers else ""
    if about and visible.intersection(members(about)):
        return about
    if message.inbound.answers_us:
        return ""
    return container.selected(message.caller.principal, message.inbound.chat)


# ---- who speaks to which robot in a chat of many ----

GOES_ON_NS: Final = 5 * MINUTE_NS
CONVERSATIONS_KEPT: Final = 8_192


class GroupConversations:
    """Which robot or group somebody named lately in a chat that others read along.

    For `GOES_ON_NS` what they say there without a name is meant for that one; later it may be meant
    for somebody else in the chat. In memory, bounded: what is forgotten is asked about.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._named_ns: OrderedDict[tuple[PrincipalId, Chat, str], int] = OrderedDict()

    def note(self, who: PrincipalId, chat: Chat, name: str) -> None:
        """Remember that somebody has just named a robot or a group in a chat."""
        key = (who, chat, name)
        self._named_ns[key] = self._clock.monotonic_ns()
        self._named_ns.move_to_end(key)
        if len(self._named_ns) > CONVERSATIONS_KEPT:
            self._named_ns.popitem(last=False)

    def goes_on(self, who: PrincipalId, chat: Chat, name: str) -> bool:
        """Whether somebody has named that robot or group lately in that chat, topic by topic."""
        named_ns = self._named_ns.get((who, chat, name))
        return named_ns is not None and self._clock.monotonic_ns() - named_ns < GOES_ON_NS


# ---- who hears a robot (Algorithm 8) ----

CHATS_AT_MOST = 8

Subscriber: TypeAlias = tuple[Messenger, Chat]
_Spoken: TypeAlias = tuple[Messenger, Chat, PrincipalId]


class RobotFollowers:
    """Per robot, the chats that used or commanded it last. In memory, bounded."""

    def __init__(self, organiser: Organiser) -> None:
        self._organiser = organiser
        self._chats: dict[RobotId, OrderedDict[tuple[str, str], _Spoken]] = {}

    def note(self, robot: RobotId, messenger: Messenger, chat: Chat, who: PrincipalId) -> None:
        """Remember that somebody spoke to a robot from a chat."""
        chats = self._chats.get(robot)
        if chats is None:
            chats = self._chats[robot] = OrderedDict()
        where = (messenger.name, chat.id)
        chats[where] = (messenger, chat, who)
        chats.move_to_end(where)
        if len(chats) > CHATS_AT_MOST:
            chats.popitem(last=False)

    def leave(self, messenger: str, chat: str, who: PrincipalId | None = None) -> None:
        """Tell a chat nothing more: we were put out of it, or they left who had spoken there."""
        where = (messenger, chat)
        for chats in self._chats.values():
            if where in chats and who in (None, chats[where][2]):
                del chats[where]

    def of(self, robot: RobotId) -> tuple[Subscriber, ...]:
        """Return the chats to tell, leaving out people who may not see the robot any more."""
        return tuple(
            (messenger, chat)
            for messenger, chat, who in self._chats.get(robot, OrderedDict()).values()
            if robot in self._organiser.visible(who)
        )
