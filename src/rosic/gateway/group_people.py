"""Whose robots a stop means that carries nobody's id: an anonymous admin's, a channel's (I17).

Those of the people recognised in that chat, in whatever run, or who brought us there. Where nobody
is, one of the chat's admins must have written it: the messenger is asked who they are. That holds
for stops alone and is soon forgotten: anybody can make somebody an admin of a chat of theirs, so it
is no sign that somebody known has ever been there.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.contracts.messenger import admins_of
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat, Inbound
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components

log = logging.getLogger(__name__)

ASKED_AGAIN_NS: Final = 30 * SECOND_NS
"""So long an answer about a chat holds: anybody may put a bot anywhere, and say stop as nobody."""
CHATS_AT_MOST: Final = 1_000
AT_ONCE: Final = 8
WAITING_AT_MOST: Final = 200
"""Two whole answers of a platform, each message of a chat of its own."""
WITHIN_S: Final = 5.0


class AdminsAnswer(NamedTuple):
    """Who of a chat's admins is known here, until it may be asked anew."""

    until_ns: int
    known: frozenset[PrincipalId]


class GroupChatPeople:
    """Knows who is in chats of many, as far as a stop needs it."""

    def __init__(self, rooms: Components, clock: Clock) -> None:
        self._authoriser = rooms.authoriser
        self._organiser = rooms.organiser
        self._container = rooms.container
        self._clock = clock
        self._answers: OrderedDict[tuple[str, str], AdminsAnswer] = OrderedDict()
        self._asking = asyncio.Semaphore(AT_ONCE)
        self._open: dict[tuple[str, str], asyncio.Future[frozenset[RobotId]]] = {}

    def hears(self, inbound: Inbound) -> bool:
        """Say whether a stop could be in a message at all: in a stranger's words none is sought.

        Nobody stops what they may not see. Whoever has no name (I17) is no stranger.
        """
        found = self._authoriser.directory.at(inbound.sender)
        if found is None:
            return is_unnamed(inbound)
        if inbound.chat.kind is not ChatKind.PRIVATE:
            self._container.meet(found[0].id, inbound.chat)
        return True

    def visible(self, chat: Chat) -> frozenset[RobotId]:
        """Return what those may see who are known to be in a chat."""
        return self._seen_by(self._authoriser.company(chat) | self._container.company(chat))

    def _seen_by(self, people: frozenset[PrincipalId]) -> frozenset[RobotId]:
        there = filter(self._authoriser.has_access, people)
        return frozenset().union(*map(self._organiser.visible, there))

    async def ask(self, messenger: Messenger, inbound: Inbound) -> frozenset[RobotId]:
        """Return what those of its admins may see who are known; ask the messenger who they are.

        A chat is asked about once at a time: who says stop there meanwhile waits for that answer.
        Chats of strangers wait in the same line, so that none keeps another from being asked about.
        """
        chat, ask = inbound.chat, admins_of(messenger)
        if ask is None or not is_unnamed(inbound):
            return frozenset()
        where = (messenger.name, chat.id)
        if where in self._open:
            return await asyncio.shield(self._open[where])
        answer = self._answers.get(where)
        if answer is not None and self._clock.monotonic_ns() < answer.until_ns:
            return self._seen_by(answer.known)
        if len(self._open) >= WAITING_AT_MOST:
            return frozenset()
        waiting = self._open[where] = asyncio.get_running_loop().create_future()
        found: frozenset[RobotId] = frozenset()
        try:
            async with asyncio.timeout(WITHIN_S), self._asking:
                admins = await ask(chat)
            known = filter(None, map(self._authoriser.directory.at, admins))
            found = self._seen_by(self._keep(where, frozenset(one[0].id for one in known)))
        except (MessengerFault, TimeoutError):
            log.info("who the admins of a chat are was not told: a stop of nobody's stops nothing")
        finally:
            del self._open[where]
            waiting.set_result(found)
        return found

    def _keep(
        self, where: tuple[str, str], known: frozenset[PrincipalId]
    ) -> frozenset[PrincipalId]:
        until_ns = self._clock.monotonic_ns() + ASKED_AGAIN_NS
        self._answers[where] = AdminsAnswer(until_ns, known)
        self._answers.move_to_end(where)
        if len(self._answers) > CHATS_AT_MOST:
            self._answers.popitem(last=False)
        return known


def is_unnamed(inbound: Inbound) -> bool:
    """Whether the platform does not tell who wrote it."""
    return (
        inbound.standing is MessageValidity.ANONYMOUS or inbound.standing is MessageValidity.CHANNEL
    )
